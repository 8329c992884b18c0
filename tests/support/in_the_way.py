"""What lies in the place of a file that the program is to make: in_the_way.py RICOCHET FOLDER [pictures]

The program has to say which file it is, and to leave all that is in the folder as it was: a.ricochet, its copy c.ricochet, and more.yaml,
a study that extends both. With `pictures` also for pictures, which gnuplot draws. Prints lines `NAME<tab>WHY`, WHY empty if it holds
(`claims` of tap.sh).
"""
import os
import re
import shutil
import stat
import subprocess
import sys

KINDS = {
    "link": "a symbolic link", "nothing": "a symbolic link", "hard": "a file with a second name", "file": "a file with other contents",
    "almost": "a file with other contents", "folder": "a folder", "pipe": "a pipe", "device": "a device", "other": "a file of another user",
}


def remove(path):
    if os.path.isdir(path) and not os.path.islink(path):
        shutil.rmtree(path)
    elif os.path.lexists(path):
        os.remove(path)


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


class Folder:
    def __init__(self, ricochet, path):
        self.ricochet, self.path, self.dear = ricochet, path, os.path.join(path, "dear")

    def at(self, name):
        return os.path.join(self.path, name)

    def lay(self, kind, path):
        """Whether it can be made here: devices and files of others are root's to make."""
        remove(path)
        remove(self.dear)
        write(self.dear, "precious\n")
        try:
            if kind == "link":
                os.symlink(self.dear, path)
            elif kind == "nothing":
                os.symlink(self.at("absent"), path)
            elif kind == "hard":
                os.link(self.dear, path)
            elif kind == "file":
                shutil.copy(self.dear, path)
            elif kind == "almost":
                write(path, "process 12 on my list since 2020\n")
            elif kind == "folder":
                os.mkdir(path)
            elif kind == "pipe":
                os.mkfifo(path)
            elif kind == "device":
                os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, 3))
            elif kind == "other":
                write(path, "")
                os.chmod(path, 0o666)
                os.chown(path, 65534, -1)
        except PermissionError:
            remove(path)
            return False
        return True

    def state(self):
        found = [["dear is", open(self.dear, encoding="utf-8").read()]]
        for here, folders, files in os.walk(self.path):
            for path in (os.path.join(here, name) for name in folders + files):
                s = os.lstat(path)
                to = os.readlink(path) if stat.S_ISLNK(s.st_mode) else ""
                found.append([path, to, s.st_mode, s.st_size, s.st_uid, s.st_nlink, s.st_mtime_ns])
        return sorted(found)

    def call(self, *command):
        """Exit status, what was said, and what is no more as it was."""
        before = self.state()
        done = subprocess.run([self.ricochet, *command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300)
        after = self.state()
        changed = [row for row in before + after if row not in before or row not in after]
        return done.returncode, done.stdout.decode(errors="replace"), changed


def claim(name, *why):
    print(name, "" if not any(why) else " ".join(repr(one) for one in why), sep="\t", flush=True)


def untouched(folder, name, kind, path, *command):
    """A run, a longer run and a reader say which file it is, in one line."""
    if not folder.lay(kind, path):
        return claim(name + " # SKIP it cannot be made here")
    code, said, changed = folder.call(*command)
    remove(path)
    pattern = f"ricochet: .*{re.escape(path)}: it is {KINDS[kind]}.* nothing was changed.*\n"
    claim(name, *([] if code == 1 and re.fullmatch(pattern, said) and not changed else [code, said, changed]))


def locks_and_journals(folder):
    more, new, old = folder.at("more.yaml"), folder.at("n.ricochet"), folder.at("c.ricochet")
    for kind, what in KINDS.items():
        untouched(folder, f"a new atlas leaves {what} in the place of its lock ({kind})", kind, new + "-lock", "run", more, "-o", new)
        untouched(folder, f"an extended atlas leaves {what} in the place of its lock ({kind})", kind, old + "-lock", "run", more, "-o", old)
        for side in ("journal", "wal") if kind not in ("nothing", "other") else ():
            untouched(folder, f"a run leaves {what} in the place of its {side} ({kind})", kind, f"{new}-{side}", "run", more, "-o", new)
            untouched(folder, f"a reader leaves {what} in the place of the {side} ({kind})", kind, f"{old}-{side}", "branches", old)


def refused(folder, name, what, status, *command):
    code, said, changed = folder.call(*command)
    claim(name, *([] if code == status and what in said and not changed else [code, said, changed]))


def atlases(folder):
    more, path = folder.at("more.yaml"), folder.at("b.ricochet")
    for kind in ("link", "file", "folder", "pipe", "device"):
        if folder.lay(kind, path):
            what = "not an atlas" if kind in ("link", "file") else "not a file but"
            refused(folder, f"a run leaves a {kind} in the place of the atlas", what, 1, "run", more, "-o", path)
            refused(folder, f"a reader leaves a {kind} in the place of the atlas", what, 1, "branches", path)
    folder.lay("nothing", path)
    refused(folder, "an atlas is not made through a link to nothing", "a symbolic link to a file that is not there", 1, "run", more, "-o", path)
    remove(path)


def pictures(folder):
    """The picture that the user names may be a link to a file, and nothing else but a file."""
    path, draw = folder.at("p.svg"), ["plot", "fep", folder.at("a.ricochet"), "-o", folder.at("p.svg")]
    folder.lay("link", path)
    code, said, _ = folder.call(*draw)
    through = os.path.islink(path) and "<svg" in open(folder.dear, encoding="utf-8").read()
    claim("a picture goes through a link to a file", *([] if code == 0 and through else [code, said]))
    for kind, name, what in (
        ("nothing", "is not made through a link to nothing", "a symbolic link to nothing"),
        ("folder", "does not take the place of a folder", "a folder"), ("pipe", "does not take the place of a pipe", "no plain file"),
    ):
        folder.lay(kind, path)
        refused(folder, f"a picture {name}", what, 2, *draw)
    remove(path)


def main():
    folder = Folder(*sys.argv[1:3])
    locks_and_journals(folder)
    atlases(folder)
    if "pictures" in sys.argv[3:]:
        pictures(folder)
    remove(folder.dear)


main()
