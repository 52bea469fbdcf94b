#!/usr/bin/env python3
"""check.py [ROOT]: checks rules for the source tree that compilers do not check (see RULES at the end).

Prints every breach, and the number of lines of each folder; exit code 1 if a rule is broken.
check.py --planted: tests that each rule finds a breach in a small tree made for this."""
import os
import re
import sys
import tempfile

# Layers from top to bottom: a file may include headers of its own layer and of those that follow here.
LAYERS = ["app", "app/study", "app/bench", "app/plan", "app/run", "app/output", "app/simulation",
          "app/initial", "app/scene", "app/cli", "validation", "integrator", "physics", "boundaries",
          "lib/domain", "lib/connectivity", "lib/neighbor", "lib/io", "lib/nodes", "lib/comm", "lib/core"]
PRODUCTION = ["app", "boundaries", "integrator", "lib", "physics", "validation"]
# The files that readers of the numerics need; their lines are counted together.
CORE_PATH = ["lib/nodes", "lib/neighbor", "lib/connectivity", "boundaries", "integrator", "physics/passes",
             "physics/sph"]
FILES, COLUMNS, FUNCTION, COMMENTS = 20, 110, 80, 0.12

# Beginnings of the lines of known breaches; should be empty.
ALLOWED = """
"""


def sources(root):
    """Source files of the tree by path, without generated files."""
    found = {}
    for folder, folders, names in os.walk(root):
        made = ("build", ".git", "out") if folder == root else ("__pycache__",)
        folders[:] = sorted(f for f in folders if f not in made)
        for name in sorted(names):
            path = os.path.relpath(os.path.join(folder, name), root)
            if name.endswith((".c", ".h", ".sh", ".py", ".cmake", "CMakeLists.txt")) or path == "kith":
                with open(os.path.join(folder, name), encoding="utf-8") as file:
                    found[path] = file.read()
    return found


def split_comments(text):
    """The code with blanks for comments and literals, and for each line whether a comment is on it."""
    code, commented, kind = [], [False] * (text.count("\n") + 2), ""
    line = k = 0
    while k < len(text):
        two = text[k:k + 2]
        if kind == "" and two in ("/*", "//"):
            kind = two
        if kind in ("/*", "//"):
            commented[line] = True
        if kind == "/*" and two == "*/":
            kind = ""
            code.append("  ")
            k += 2
            continue
        if kind == "//" and text[k] == "\n":
            kind = ""
        if text[k] == "\n":
            line += 1
            code.append("\n")
        elif kind in ("\"", "'"):
            if text[k] == "\\":
                k += 1
            elif text[k] == kind:
                kind = ""
            code.append(" ")
        elif kind == "" and text[k] in "\"'":
            kind = text[k]
            code.append(" ")
        else:
            code.append(text[k] if kind == "" else " ")
        k += 1
    return "".join(code), commented


def is_production(path):
    return path.split("/")[0] in PRODUCTION and path.endswith((".c", ".h"))


def layer(path):
    """Index in LAYERS, of the longest name that the path begins with."""
    return max((k for k, r in enumerate(LAYERS) if path.startswith(r + "/")), key=lambda k: len(LAYERS[k]))


def unit(path):
    return path[:-2]


def includes(text):
    return re.findall(r'^#include "([^"]+)"', text, re.M)


DEFINITION = re.compile(r"^(?!static|KITH_INLINE)[A-Za-z_][^;{}()#\n]*?\b(kith_\w+)\([^;{}]*\)\s*\{$", re.M)
FUNCTION_BODY = re.compile(r"^[A-Za-z_][^;{}\n]*?(\w+)\([^;{}]*\)\s*\{\n(.*?)^\}", re.M | re.S)


def cycles(graph):
    """Strongly connected components of more than one unit (Tarjan 1972, SIAM J. Comput. 1, 146)."""
    number, low, stack, on, found = {}, {}, [], set(), []

    def visit(node):
        number[node] = low[node] = len(number)
        stack.append(node)
        on.add(node)
        for other in sorted(graph.get(node, ())):
            if other not in number:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in on:
                low[node] = min(low[node], number[other])
        if low[node] == number[node]:
            component = []
            while not component or component[-1] != node:
                component.append(stack.pop())
                on.discard(component[-1])
            if len(component) > 1:
                found.append(sorted(component))

    sys.setrecursionlimit(10000)
    for node in sorted(graph):
        if node not in number:
            visit(node)
    return found


# ---- the rules: each yields what breaks it


def full_folders(root, files, code):
    """a folder of sources holds at most 20 files"""
    for folder in sorted({os.path.dirname(p) for p in files if p.endswith((".c", ".h"))}):
        place = os.path.join(root, folder)
        n = sum(os.path.isfile(os.path.join(place, name)) for name in os.listdir(place))
        if n > FILES:
            yield f"{folder}: {n} files"


def circular_units(root, files, code):
    """no cyclic dependency of units; a unit is a .c and its .h, and depends on what it includes or calls"""
    owner, graph = {}, {}
    for path in filter(is_production, files):
        if path.endswith(".c"):
            for name in DEFINITION.findall(code[path]):
                owner.setdefault(name, unit(path))
    for path in filter(is_production, files):
        used = {unit(header) for header in includes(files[path]) if header in files}
        if path.endswith(".c"):
            words = set(re.findall(r"(?<!struct )(?<!enum )\b(kith_\w+)", code[path]))
            used |= {owner[word] for word in words & owner.keys()}
        graph.setdefault(unit(path), set()).update(used - {unit(path)})
    for component in cycles(graph):
        edges = [f"{a} -> {b}" for a in component for b in sorted(graph[a] & set(component))]
        yield " ".join(component) + "\n      " + "\n      ".join(edges)


def upward_includes(root, files, code):
    """no file includes a header of a higher layer"""
    for path in filter(is_production, files):
        for header in includes(files[path]):
            if is_production(header) and layer(header) < layer(path):
                yield f"{path} includes {header}"


def long_lines(root, files, code):
    """no line above 110 columns"""
    for path, text in files.items():
        for n, line in enumerate(text.split("\n"), 1):
            if len(line) > COLUMNS:
                yield f"{path}:{n}: {len(line)} columns"


def unopened_sources(root, files, code):
    """every source opens with a comment that says what it is"""
    for path, text in files.items():
        if path.endswith((".c", ".h")) and not text.startswith("/*"):
            yield path


def compared_members(root, files, code):
    """no code outside a family compares addresses or names of its members"""
    members = {}  # name of each member: its family, and the folder of the family
    for path in filter(is_production, files):
        for family, name in re.findall(r"^const struct kith_(\w+)_ops (kith_\w+) =", code[path], re.M):
            members[name] = (family, os.path.dirname(path))
    homes = {}
    for family, folder in members.values():
        homes.setdefault(family, set()).add(folder)
    for path in filter(is_production, files):
        for n, line in enumerate(files[path].split("\n"), 1):
            for name in re.findall(r"[=!]=\s*&(kith_\w+)", line) + re.findall(r"&(kith_\w+)\s*[=!]=", line):
                if name in members and os.path.dirname(path) not in homes[members[name][0]]:
                    yield f"{path}:{n}: {line.strip()}"
            if re.search(r"(strn?cmp|kith_name_is|_index)\([^;]*\b(ops|scheme|member)->name\b", line) or \
               re.search(r"(strn?cmp|kith_name_is)\([^;]*->name, \"", line) or \
               re.search(r"strcmp\([^;]*connectivity\.rebuild", line):
                yield f"{path}:{n}: {line.strip()}"


def rare_comments(root, files, code):
    """at least 12 % of the production lines carry a comment"""
    lines = comments = 0
    for path in filter(is_production, files):
        text = files[path]
        commented = split_comments(text)[1]
        for n, line in enumerate(text.split("\n")):
            lines += line.strip() != ""
            comments += line.strip() != "" and commented[n]
    print(f"comments: {100 * comments / lines:.1f} % of the lines")
    if comments < COMMENTS * lines:
        yield f"{100 * comments / lines:.1f} %"


def undocumented_commands(root, files, code):
    """README mentions every verb, and no verb or option that does not exist"""
    table = files["app/cli/options.h"]
    verbs = re.findall(r'^ *X\((\w+), "', table, re.M)
    options = set(re.findall(r"^ *X\((\w+), (?:0|'\w'), ", table, re.M)) | {"help", "version"}
    with open(os.path.join(root, "README.md"), encoding="utf-8") as file:
        readme = file.read()
    for verb in verbs:
        if not re.search(rf"kith {verb}\b", readme):
            yield f"kith {verb}: not in README.md"
    for line in re.findall(r"^\./kith .*$|`(?:\./)?kith [^`]*`", readme, re.M):
        for word in re.findall(r"kith ([a-z]+)", line):
            if word not in verbs:
                yield f"README.md: kith {word}: no such verb"
        for option in re.findall(r" --([a-z-]+)", line):
            if option not in options and "test" not in line:
                yield f"README.md: --{option}: no such option"


def top_level(root, files, code):
    """the top folder has only known files"""
    known = set("""CMakeLists.txt app lib physics boundaries integrator inputs tests validation README.md kith
      CMakePresets.json LICENSE CHANGELOG.md CITATION.cff build out""".split())
    for name in sorted(os.listdir(root)):
        if name not in known and not name.startswith("."):
            yield name


def long_functions(root, files, code):
    """(only a warning) a function has at most 80 lines"""
    for path in filter(is_production, files):
        for name, body in FUNCTION_BODY.findall(code[path]):
            if body.count("\n") > FUNCTION:
                print(f"warning: {path}: {name} has {body.count(chr(10))} lines")
    return ()


RULES = [full_folders, circular_units, upward_includes, long_lines, unopened_sources, compared_members,
         rare_comments, undocumented_commands, top_level, long_functions]


def print_lines(files):
    count = {}
    for path in filter(is_production, files):
        for name in (os.path.dirname(path), path.split("/")[0], "production"):
            count.setdefault(name, 0)
        for name in {os.path.dirname(path), path.split("/")[0], "production"}:
            count[name] += files[path].count("\n")
    count["core path"] = sum(text.count("\n") for path, text in files.items()
                             if is_production(path) and path.startswith(tuple(f"{p}/" for p in CORE_PATH)))
    for name, n in sorted(count.items()):
        print(f"{n:7d} lines  {name}")


def check(root, allowed):
    files = sources(root)
    code = {path: split_comments(text)[0] for path, text in files.items() if is_production(path)}
    broken, used = [], set()
    print_lines(files)
    for rule in RULES:
        for breach in rule(root, files, code):
            text = f"{rule.__name__}: {breach}"
            known = [line for line in allowed if text.startswith(line)]
            used.update(known)
            print("known:" if known else "BROKEN:", text)
            broken += [] if known else [rule.__name__]
    print(f"{len(broken)} breaches; known: {sorted(used)}; no longer: {sorted(set(allowed) - used)}")
    return broken


def planted():
    """The rules that do not find a breach in a small tree that breaks all of them."""
    tree = {f"lib/core/file{k}.c": "/* one of many */\n" for k in range(FILES + 1)}
    tree["lib/core/a.h"] = '/* a.h */\n#include "lib/core/b.h"\n'
    tree["lib/core/b.h"] = "/* b.h */\nvoid kith_b(void);\n"
    tree["lib/core/b.c"] = '/* b.c */\n#include "lib/core/b.h"\nvoid kith_b(void) {\n  kith_c();\n}\n'
    tree["lib/core/c.c"] = '/* c.c */\n#include "lib/core/a.h"\nvoid kith_c(void) {\n  kith_b();\n}\n'
    tree["lib/core/d.c"] = '#include "app/cli/options.h"\n' + "int x; " * 20 + "\n" * 2 + "int y;\n" * 200
    tree["lib/nodes/m.c"] = "/* m.c */\nconst struct kith_eos_ops kith_eos_m = {0};\n"
    tree["app/cli/n.c"] = "/* n.c */\nint n = a == &kith_eos_m;\n"
    tree["app/cli/options.h"] = '/* options.h */\n  X(run, SCENE, "")\n  X(set, 0, "")\n'
    tree["README.md"] = "`kith rum --sett x`\n"
    tree["stray"] = ""
    with tempfile.TemporaryDirectory() as root:
        for path, text in tree.items():
            os.makedirs(os.path.dirname(os.path.join(root, path)), exist_ok=True)
            with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                file.write(text)
        broken = check(root, [])
    return [rule.__name__ for rule in RULES if rule.__name__ not in broken and rule != long_functions]


if __name__ == "__main__":
    if sys.argv[1:] == ["--planted"]:
        overlooked = planted()
        print("overlooked:", overlooked)
        sys.exit(len(overlooked) > 0)
    sys.exit(len(check(sys.argv[1] if len(sys.argv) > 1 else ".", ALLOWED.split("\n")[1:-1])) > 0)
