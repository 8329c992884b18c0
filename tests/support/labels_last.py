"""Labels that an atlas has shown stay with the keys of their junctions while it grows.

    labels_last.py PROGRAM FOLDER SECONDS STUDY...

Each study is explored in three steps into one file, with few impacts, depth and multiplications first, and once more from nothing. No pair of key and
label changes, and no label is there twice. The last line says how many pairs were compared, and how many of the fresh run are other ones.
"""
import json
import os
import re
import subprocess
import sys


def budgets(text, part):
    """The study with this part of its impacts, its depth and its multiplications."""
    def less(match):
        return match[1] + str(max(1, int(int(match[2]) * part)))
    return re.sub(r"^(  (?:depth|impacts|multiply): *)(\d+)", less, text, flags=re.M)


def rows(program, study, atlas, seconds):
    run = subprocess.run([program, "run", study, "-o", atlas, "--quiet", "--seconds", seconds], capture_output=True, text=True)
    if run.returncode == 3:
        return None
    assert run.returncode == 0, run.stderr
    done = subprocess.run([program, "junctions", atlas, "--json"], capture_output=True, text=True, check=True)
    return {row["key"]: row["label"] for row in json.loads(done.stdout)}


def main():
    program, folder, seconds, studies = sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4:]
    compared = others = changed = 0
    for study in studies:
        with open(study) as file:
            text = re.sub(r"file: (?!/)", f"file: {os.path.abspath(os.path.dirname(study))}/", file.read())
        path, atlas, fresh = (os.path.join(folder, name) for name in ("study.yaml", "grows.ricochet", "fresh.ricochet"))
        for name in (atlas, fresh):
            if os.path.exists(name):
                os.remove(name)
        seen = {}
        for part in (0.4, 0.7, 1):
            with open(path, "w") as file:
                file.write(budgets(text, part))
            now = rows(program, path, atlas, seconds)
            if now is None:
                print(f"# {study}: not done in {seconds} s, left out")
                break
            assert len(set(now.values())) == len(now), (study, part, "a label is there twice")
            for key in now.keys() & seen.keys():
                compared += 1
                changed += now[key] != seen[key]
                if now[key] != seen[key]:
                    print(f"# {study}, part {part}: {key} was {seen[key]} and is {now[key]}")
            seen.update(now)
        else:
            anew = rows(program, path, fresh, seconds) or {}
            others += sum(anew[key] != seen[key] for key in anew.keys() & seen.keys())
    print(f"{compared} labels stayed, {changed} changed; {others} are others in a fresh run")
    sys.exit(changed > 0 or compared == 0 or others == 0)


main()
