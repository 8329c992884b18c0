#!/usr/bin/env bash
# The JSON schema of a study is what the program makes; it takes every study that there is, and refuses what the reader refuses by its shape.
set -u
. tests/support/tap.sh

schema=docs/study.schema.json
python=python3
python3 -c 'import jsonschema, yaml' 2>/dev/null || python=/usr/bin/python3
ok 'the file is what the program makes' diff "$schema" <("$ricochet" help study --schema)
ok 'of a study only' test "$("$ricochet" help branch --schema 2>&1 | grep -c 'that of a study')" = 1

cat >"$folder/check.py" <<'P'
import glob, json, re, subprocess, sys, jsonschema, yaml
program, folder, what = sys.argv[1:4]
schema = json.load(open("docs/study.schema.json"))
jsonschema.Draft202012Validator.check_schema(schema)
judge = jsonschema.Draft202012Validator(schema)

class Loader(yaml.SafeLoader):
    "YAML 1.2: 1e-12 is a number"
Loader.yaml_implicit_resolvers = {first: [r for r in all if r[0] != "tag:yaml.org,2002:float"] for first, all in yaml.SafeLoader.yaml_implicit_resolvers.items()}
Loader.add_implicit_resolver("tag:yaml.org,2002:float", re.compile(r"^[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?$"), list("-+.0123456789"))

def passes(text):
    return not list(judge.iter_errors(yaml.load(text, Loader)))
def reads(text):
    open(f"{folder}/try.yaml", "w").write(text)
    done = subprocess.run([program, "check", f"{folder}/try.yaml"], capture_output=True, text=True)
    return done.returncode == 0, done.stderr

studies = [(name, open(name).read()) for name in sorted(glob.glob("examples/**/*.yaml", recursive=True))]
studies += [(name, text) for name, text in re.findall(r"```yaml (\S+)\n(.*?)```", open("docs/study.md").read(), re.S)]
model = "model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n"
contacts = "  contacts:\n    - "
stop = contacts + "{normal: [-1, 1], clearance: 1}\n"
whole = model + stop

if what == "studies":
    assert len(studies) > 20, len(studies)
    subprocess.run([program, "new", f"{folder}/new"], check=True, capture_output=True)
    template = open(f"{folder}/new/study.yaml").read()
    studies += [("template", template), ("template, all keys", re.sub(r"(?m)^( *)# ?([a-z_]+: )", r"\1\2", template))]
    for name, text in studies:
        try: errors = list(judge.iter_errors(yaml.load(text, Loader)))
        except yaml.YAMLError: assert name == "template, all keys", name; continue
        assert not errors, (name, errors[0].message, list(errors[0].path))
elif what == "keys":
    # of every section: those that the reader names when it finds one that is none
    def of(text):
        good, said = reads(text)
        assert not good, text
        return set(re.search(r"the keys here are (.*)$", said).group(1).split(", "))
    p = schema["properties"]
    other = "zzqqxx: 1"
    for section, text, known in (
        ("study", whole + other, p),
        ("model", model + f"  {other}\n" + stop, p["model"]["properties"]),
        ("explore", whole + f"explore: {{{other}}}", p["explore"]["properties"]),
        ("contact", model + contacts + f"{{{other}}}", schema["$defs"]["contact"]["properties"]),
        ("regions", whole + f"regions: [{{{other}}}]", p["regions"]["items"]["properties"]),
        ("names", whole + f"names: [{{{other}}}]", p["names"]["items"]["properties"]),
        ("drawing", whole + f"drawing: {{{other}}}", p["drawing"]["properties"]),
        ("forcing", whole + f"forcing: {{{other}}}", p["forcing"]["properties"]),
        ("units", whole + f"units: {{{other}}}", p["units"]["properties"]),
        ("nodes", whole + f"drawing: {{nodes: [{{{other}}}]}}", p["drawing"]["properties"]["nodes"]["items"]["properties"])):
        assert of(text) == set(known), (section, of(text) ^ set(known))
        assert not passes(text), section
else:
    # one change each: the schema and the reader say the same
    explore = lambda text: whole + f"explore: {{{text}}}\n"
    contact = lambda text: model + contacts + f"{{normal: [-1, 1], {text}}}\n"
    good = [whole, "title: 3\n" + whole, model.replace("9", "9.0D+0") + stop, explore("energy: auto"), explore("energy: [0, 1.0D+1]"),
        explore("energy: {first_touch_of: 1, times: [0, 50]}"), explore("start: [1, 2]"), explore("start: modes, cascade: [2, 3]"),
        explore("depth: 0, symmetric: true"), explore("tongues: cross, tongue_width: 0.02"), explore("at_energy: [], at_frequency: [1.2]"),
        explore("at_energy: {first_touch_of: 2, times: [2, 3]}"), contact("clearance: 1, sides: upper"), contact("clearance: 1, law: bilinear, stiffness: 2"),
        contact("law: power, exponent: 5, stiffness: 2"), contact("law: power, exponent: 3, length: 1, reference: 2"),
        whole.replace("contacts", "restitution: 0.5\n  modes: 2\n  contacts"), whole.replace("contacts", "modes: {up_to: 5}\n  contacts"),
        whole + "damping: 0.01\n", whole + "damping: [0.01, 1.0D-2]\nrestitution: 0.9\n", whole + "damping: {beta: 0.1}\n",
        whole + "damping: [[1, 0], [0, 1]]\nforcing: {vector: [1, 0], amplitude: [1, 2], frequency: [1, 2], harmonic: [1, 3]}\n",
        whole + "forcing: {coordinate: 1, amplitude: 2, frequency: 1, harmonic: 2}\n",
        whole + "units: {length: mm, force: N}\n", whole + "units: {length: m, time: s, force: kN}\n",
        whole + "tolerance: 1e-10\n", whole + "regions:\n  - {energy: [1, 2], frequency: [1, 2], depth: 4}\n",
        whole + "names:\n  - {name: P, kind: grazing, energy: 1, frequency: 2}\n",
        whole + "drawing: {nodes: [{at: [0, 1], moves: [1, 0]}, {at: [1, 1]}], lines: [[1, 2]]}\n"]
    bad = [whole + "units: {length: mm}\n", whole + "units: mm\n", whole + "units: {length: mm, force: N, time: ms}\n", whole + "units: {length: 5, force: N}\n",
        whole + "units: {length: mm, force: ''}\n", whole + "damping: [0.01, -1]\n", whole + "damping: {}\n", whole + "damping: {gamma: 1}\n", whole + "restitution: -1\n", whole + "forcing: {amplitude: 1}\n",
        whole + "forcing: {vector: [1, 0], coordinate: 1}\n", whole + "forcing: {coordinate: 0}\n", whole + "forcing: {coordinate: 1, amplitude: 0}\n",
        whole + "forcing: {coordinate: 1, frequency: [1, 2, 3]}\n", whole + "forcing: {coordinate: 1, harmonic: 1.5}\n", whole + "forcing: {coordinate: 1, amplitude: []}\n",
        "title: a\n", model, model.replace("mass", "mas") + stop, whole + "damping: -1\n", explore("energy: [1]"), explore("energy: [1, 2, 3]"), explore("energy: 5"),
        explore("energy: [-1, 2]"), explore("frequency: [0, 10]"), explore("frequency: {first_touch_of: 1, times: [0, 50]}"), explore("start: all"),
        explore("start: [0]"), explore("start: []"), explore("impacts: 0"), explore("impacts: 2.5"), explore("impacts: many"), explore("depth: -1"),
        explore("depth: true"), explore("step: 0"), explore("step: 11"), explore("tongues: leap"), explore("tongue_width: 1"), explore("symmetric: maybe"),
        explore("cascade: [1]"), explore("at_energy: 3"), explore("at_energy: [0]"), explore("energy: {first_touch_of: 1}"), explore("energy: {times: [0, 1]}"),
        contact("sides: both"), contact("clearance: 0"), contact("clearance: -1"), contact("clearance: [1]"), contact("clearance: 1, sides: left"),
        contact("clearance: 1, law: cubic"), contact("clearance: 1, stiffness: 2"), contact("clearance: 1, law: bilinear"),
        contact("clearance: 1, law: power, exponent: 3, stiffness: 1"), contact("law: power, stiffness: 1"), contact("law: power, exponent: 4, stiffness: 1"),
        contact("law: power, exponent: 3"), contact("law: power, exponent: 3, length: 1"), contact("law: power, exponent: 3, stiffness: 1, length: 1, reference: 1"),
        contact("clearance: 1, gap: 1"), whole.replace("contacts", "restitution: 2\n  contacts"), whole.replace("contacts", "modes: 0\n  contacts"),
        whole.replace("contacts", "modes: {to: 5}\n  contacts"), whole.replace("[[2, 0], [0, 1]]", "2"), whole.replace("[[2, 0], [0, 1]]", "[[a, 0], [0, 1]]"),
        whole.replace("[[2, 0], [0, 1]]", "{path: M.mtx}"), whole + "tolerance: 1\n", whole + "regions:\n  - {energy: [1, 2]}\n",
        whole + "regions:\n  - {energy: auto, frequency: [1, 2]}\n", whole + "names:\n  - {name: P, kind: knot, energy: 1, frequency: 2}\n",
        whole + "names:\n  - {name: P, kind: grazing, energy: 1}\n", whole + "drawing: {lines: [[1, 2]]}\n", whole + "drawing: {nodes: [{at: []}]}\n"]
    for text in good: assert passes(text) and reads(text)[0], (text, reads(text)[1])
    for text in bad: assert not passes(text) and not reads(text)[0], (passes(text), text, reads(text)[1])
P
ok 'every study passes' "$python" "$folder/check.py" "$ricochet" "$folder" studies
ok 'its keys are those of the reader' "$python" "$folder/check.py" "$ricochet" "$folder" keys
ok 'it takes and refuses what the reader takes and refuses' "$python" "$folder/check.py" "$ricochet" "$folder" cases
finish
