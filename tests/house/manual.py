#!/usr/bin/env python3
"""manual.py ROOT BIN [--write | --pictures]: README and manual agree with the programs in BIN.

  blocks     text between `<!-- begin COMMAND -->` and `<!-- end -->` is what the command prints, or, for
             `figures PREFIX...`, the rows of inputs/validation with such names and a printed value; with
             `begin COMMAND until LINE` the output ends before that line
  links      to files and headings of this tree exist, and so do files in backquotes
  lines      of code are as many as check.py counts
  commands   in fenced blocks and tables, and scenes, are read and set up with few nodes, without errors
  packaging  files of app/packaging are valid, and have the version and the packages of this tree
--write brings the blocks up to date, and README's picture. --pictures compares that, byte by byte: with other
versions of gnuplot or of fonts it differs. Prints every breach; exit code 1 if there is one."""
import ast
import glob
import os
import re
import shlex
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

ROOT, BIN = sys.argv[1], os.path.abspath(sys.argv[2])
BREACHES = []


def breach(*words):
    BREACHES.append(" ".join(map(str, words)))


def read(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


def documents():
    found = ["README.md", "CHANGELOG.md", *glob.glob("app/manual/*.md", root_dir=ROOT),
             *glob.glob("validation/results/*.md", root_dir=ROOT), *glob.glob(".github/*.md", root_dir=ROOT)]
    return {path: read(path) for path in sorted(found)}


def run(words, place):
    return subprocess.run(words, cwd=place, capture_output=True, text=True, check=False,
                          stdin=subprocess.DEVNULL)


# ---- blocks


def rows():
    """Rows with a printed value, by name; each is a flow map on one line, with quotes around commas."""
    found = {}
    for path in sorted(glob.glob("inputs/validation/*.yaml", root_dir=ROOT)):
        last = {}
        for line in read(path).split("\n"):
            if not line.startswith("  - {"):
                continue
            row = {key: (quoted or plain).strip()
                   for key, quoted, plain in re.findall(r'(\w+): (?:"([^"]*)"|([^,"}]*))[,}]', line)}
            if "scene" in row:
                last = row
            run_keys = ("scene", "dimension", "settings", "steps", "threads")
            row = {**{key: last.get(key, "") for key in run_keys}, **row}
            if "prints" in row or path.endswith(("readme.yaml", "decks.yaml")):
                found[row["name"]] = row
    return found


def command_of(row):
    words = [f"./kith run inputs/{row['scene']}.yaml", f"--set dimension={row['dimension']}"]
    words += [f"--set {setting}" for setting in row["settings"].split()]
    if row["steps"]:
        words.append(f"--steps {row['steps']}")
    if row["threads"]:
        words.append(f"--threads {row['threads']}")
    return " ".join(words)


def figures(prefixes):
    """A table with a line for each command and all values of its run. `source` of a row is WHAT: NAME."""
    lines = ["| run | figures | command |", "|---|---|---|"]
    table = {}
    for row in rows().values():
        if any(row["name"].startswith(prefix) for prefix in prefixes):
            figure = row.get("prints", f"at most {row['at_most']}" if "at_most" in row else
                             f"at least {row.get('at_least')}")
            figure += f" (± {100 * float(row['within']):g} %)" if "within" in row else ""
            what, _, name = row["source"].partition(": ")
            table.setdefault(command_of(row), [what, []])[1].append(f"{name or what} {figure}")
    lines += [f"| {what} | {'<br>'.join(read)} | `{command}` |" for command, (what, read) in table.items()]
    return lines


def wanted(command):
    command, _, last = command.partition(" until ")
    words = shlex.split(command)
    if words[0] == "figures":
        return figures(words[1:])
    done = run([os.path.join(BIN, words[0]), *words[1:]], ROOT)
    if done.returncode != 0:
        breach(f"{command}: ended with {done.returncode}: {done.stderr.strip()}")
    lines = done.stdout.rstrip("\n").split("\n")
    if last and last in lines:
        lines = "\n".join(lines[:lines.index(last)]).rstrip().split("\n")
    return ["```", *lines, "```"]


def check_blocks(path, text, write):
    def one(match):
        new = f"<!-- begin {match[1]} -->\n" + "\n".join(wanted(match[1])) + "\n<!-- end -->"
        if new != match[0] and not write:
            breach(f"{path}: not what `{match[1]}` says; tests/house/manual.py ROOT BIN --write")
        return new

    new = re.sub(r"<!-- begin (.*?) -->\n.*?<!-- end -->", one, text, flags=re.S)
    if write and new != text:
        with open(os.path.join(ROOT, path), "w", encoding="utf-8") as file:
            file.write(new)


# ---- links


def headings(text):
    plain = re.sub(r"^```.*?^```", "", text, flags=re.S | re.M)
    return {re.sub(r"[^\w\- ]", "", line.lower()).strip().replace(" ", "-")
            for line in re.findall(r"^#+ (.*)$", plain, re.M)}


def check_links(path, text, all_texts):
    for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"^```.*?^```", "", text, flags=re.S | re.M)):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        to = os.path.normpath(os.path.join(os.path.dirname(path), name)) if name else path
        if not os.path.exists(os.path.join(ROOT, to)):
            breach(f"{path}: no file {to}")
        elif anchor and anchor not in headings(all_texts.get(to, "")):
            breach(f"{path}: no heading {anchor} in {to}")
    rooms = "app|boundaries|inputs|integrator|lib|physics|tests|validation"
    for name in re.findall(rf"`((?:{rooms})/[\w./-]+)`", text):
        if "NAME" not in name and path != "CHANGELOG.md" and not os.path.exists(os.path.join(ROOT, name)):
            breach(f"{path}: no file {name}")


# ---- lines


def check_lines(path, text, write):
    counted = run([sys.executable, "tests/house/check.py", "."], ROOT).stdout
    told = re.search(r"\| ([\d,]+), of which the core path has ([\d,]+) \|", text)
    lines = [int(re.search(rf"^ *(\d+) lines  {room}$", counted, re.M)[1])
             for room in ("production", "core path")]
    if all(abs(int(number.replace(",", "")) - n) <= 0.02 * n for number, n in zip(told.groups(), lines)):
        return
    now = "| {:,}, of which the core path has {:,} |".format(*(round(n, -2) for n in lines))
    if write:
        with open(os.path.join(ROOT, path), "w", encoding="utf-8") as file:
            file.write(text.replace(told[0], now))
    else:
        breach(f"{path}: {told[0]} is {now}")


# ---- commands


def commands(text):
    """Commands of kith in fenced blocks, and those in backquotes that start with ./kith."""
    found = []
    own = re.sub(r"<!-- begin (?!figures).*?<!-- end -->", "", text, flags=re.S)
    for block in re.findall(r"^```(?:sh)?\n(.*?)^```", own, re.S | re.M):
        for line in block.replace("\\\n", " ").split("\n"):
            line = re.sub(r"^(mpirun -n \d+|time|[A-Z_]+=\S+) ", "", line.strip())
            if re.match(r"(\./|build/release/bin/)?kith(-[123]d)? ", line):
                found.append(line.split(" #")[0].strip())
    return found + re.findall(r"`(\./kith [^`]+)`", re.sub(r"^```.*?^```", "", text, flags=re.S | re.M))


def names_of(folder):
    return {os.path.basename(p)[:-5] for p in glob.glob(f"inputs/{folder}/*.yaml", root_dir=ROOT)}


def try_command(line):
    """An error of the command, or nothing. Runs are set up with few nodes and make no step."""
    words = shlex.split(line)[1:]
    if words[0] in ("build", "test"):
        return ""
    if any(re.search(r"[A-Z]{3,}|^N$|\.\.\.", w) for w in words):
        return ""  # a placeholder
    if words[0] in ("validate", "chart", "stress"):
        names = {"chart": names_of("suites"), "validate": names_of("validation")}
        names["validate"] |= {"quick", "full", "readme-quick"}
        names["stress"] = set(re.findall(r"^  - name: (\S+)", read("inputs/stress/sweeps.yaml"), re.M))
        for word in words[1:2]:
            if "." not in word and word[0] != "-" and word not in names[words[0]] | {"list"}:
                return f"no {words[0]} {word}"
        words = [words[0], "--help", *words[2:]]
    elif words[0] in ("run", "plan", "bench"):
        if len(words) > 1 and words[1].endswith(".yaml") and not os.path.exists(os.path.join(ROOT, words[1])):
            return "" if words[1].startswith("my-") else f"no {words[1]}"
        if words[0] != "run" or "--restart" in words or words[1].startswith("my-"):
            words.append("--help")
        else:
            for option in ("--ranks", "--profile", "--trace", "-o", "--steps", "--until", "--walltime"):
                while option in words:
                    at = words.index(option)
                    del words[at:at + (1 if option == "--profile" else 2)]
            with tempfile.TemporaryDirectory() as place:
                small = "3" if "yee" in words[1] else "16" if "plate" in words[1] else "8"
                done = run([f"{BIN}/kith", *words, "--set", f"resolution={small}",
                            "--set", "output.plot=false", "--steps", "0", "--quiet",
                            "-o", f"{place}/out"], ROOT)
                return done.stderr.strip() if done.returncode != 0 else ""
    done = run([f"{BIN}/kith", *words], ROOT)
    return done.stderr.strip() if done.returncode != 0 else ""


def check_scenes(path, text):
    """Scenes in the text are set up with few nodes."""
    for block in re.findall(r"^```yaml\n(scene: .*?)^```", text, re.S | re.M):
        with tempfile.TemporaryDirectory() as place:
            with open(f"{place}/own.yaml", "w", encoding="utf-8") as file:
                file.write(block)
            done = run([f"{BIN}/kith", "run", "own.yaml", "--set", "resolution=10",
                        "--set", "output.plot=false", "--steps", "0", "--quiet", "-o", "out"], place)
            if done.returncode != 0:
                breach(f"{path}: {block.splitlines()[0]}: {done.stderr.strip()}")


# ---- pictures


def check_picture(write):
    """The picture of README is what its first command draws."""
    path = os.path.join(ROOT, "validation/results/sod.png")
    with tempfile.TemporaryDirectory() as place:
        run([f"{BIN}/kith", "run", "inputs/sod.yaml", "--quiet", "-o", f"{place}/out"], ROOT)
        with open(f"{place}/out/plot.png", "rb") as drawn, open(path, "rb") as kept:
            new, old = drawn.read(), kept.read()
    if write:
        with open(path, "wb") as kept:
            kept.write(new)
    elif new != old:
        breach("validation/results/sod.png: not what ./kith run inputs/sod.yaml draws")


# ---- packaging


def check_packaging():
    header = read("lib/core/version.h")
    version = ".".join(re.search(rf"KITH_VERSION_{part} (\d+)", header)[1]
                       for part in ("MAJOR", "MINOR", "PATCH"))
    for path in glob.glob("app/packaging/**/*.py", root_dir=ROOT, recursive=True):
        try:
            ast.parse(read(path))
        except SyntaxError as error:
            breach(f"{path}: {error}")
    for path in ("CITATION.cff", "CHANGELOG.md"):
        if version not in read(path):
            breach(f"{path}: version {version} is not in it")
    packages = re.search(r"^packages=\((.*?)\)", read("kith"), re.S | re.M)[1].split()
    for path in ("app/packaging/Containerfile", "app/manual/install.md"):
        for package in packages:
            if not re.search(rf"\b{re.escape(package)}\b", read(path)):
                breach(f"{path}: package {package} is not in it")
    for line in read("app/packaging/Containerfile").replace("\\\n", " ").split("\n"):
        if line.strip() and not re.match(r"#|(FROM|RUN|COPY|WORKDIR|ENTRYPOINT|CMD|LABEL|ENV) ", line):
            breach(f"app/packaging/Containerfile: {line}")
    for path in ("app/packaging/reframe_kith.py", "app/packaging/benchpark/application.py"):
        criterion = re.search(r'r"(.*conservation errors: [^"]*)"', read(path))[1]  # Ramble: of a whole line
        for error, right in (("0.00e+00", True), ("2.42e-15", True), ("1.30e-12", False)):
            if bool(re.match(criterion, f"  conservation errors: energy {error} of the largest of")) != right:
                breach(f"{path}: an energy error of {error} is {'refused' if right else 'accepted'}")
    needed = {"cff-version", "message", "title", "type", "authors", "version", "license"}
    missing = needed - set(re.findall(r"^([\w-]+):", read("CITATION.cff"), re.M))
    if missing:
        breach(f"CITATION.cff: no {missing}")


def main():
    texts = documents()
    write = "--write" in sys.argv
    if write or "--pictures" in sys.argv:
        check_picture(write)
    for path, text in texts.items():
        check_blocks(path, text, write)
        check_links(path, text, texts)
        check_scenes(path, text)
    every = sorted({(line, path) for path, text in texts.items() if path != "CHANGELOG.md"
                    for line in commands(text)})
    with ThreadPoolExecutor(2) as pool:
        for (line, path), why in zip(every, pool.map(lambda pair: try_command(pair[0]), every)):
            if why:
                breach(f"{path}: {line}: {why}")
    check_lines("app/manual/proxy.md", texts["app/manual/proxy.md"], write)
    check_packaging()
    for line in BREACHES:
        print("BROKEN:", line)
    print(f"{len(texts)} documents, {len(every)} commands, {len(rows())} figures, {len(BREACHES)} breaches")
    return len(BREACHES) > 0


if __name__ == "__main__":
    sys.exit(main())
