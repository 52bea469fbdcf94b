#!/usr/bin/env python3
"""coverage.py BUILD [PATH]...: the shares of lines and branches that the tests of a build have run, by gcov.

PATH: folders and files of the source tree (by default lib/io, readers, lifecycle, and what ends runs). To
build and run everything takes about ten minutes:

  cmake -G Ninja -B build/coverage -DKITH_DIMENSIONS=1 -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS=--coverage
  ninja -C build/coverage && ctest --test-dir build/coverage -LE slow
  tests/house/coverage.py build/coverage
"""
import collections, json, os, subprocess, sys

PATHS = '''lib/io app/scene app/run app/cli integrator/lifecycle.c integrator/step.c integrator/integrator.c
app/output/restart.c app/output/output.c app/output/history.c app/output/contacts.c app/output/probes.c'''
root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
build = os.path.abspath(sys.argv[1])
wanted = tuple(sys.argv[2:] or PATHS.split())
lines = collections.defaultdict(dict)     # source -> {line: times}, of all dimensions and programs
branches = collections.defaultdict(dict)  # source -> {(line, k): times}

for folder, _, names in os.walk(build):
    for name in names:
        if not name.endswith('.gcda'): continue
        done = subprocess.run(['gcov', '-b', '--json-format', '--stdout', name], cwd=folder,
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        for text in done.stdout.splitlines():
            data = json.loads(text)
            for file in data['files']:
                path = os.path.join(data['current_working_directory'], file['file'])
                source = os.path.relpath(os.path.realpath(path), root)
                if not source.startswith(wanted): continue
                for line in file['lines']:
                    number = line['line_number']
                    lines[source][number] = lines[source].get(number, 0) + line['count']
                    for k, branch in enumerate(line['branches']):
                        key = number, k
                        branches[source][key] = branches[source].get(key, 0) + branch['count']


def share(times):
    run = sum(count > 0 for count in times)
    return f'{run:5d} of {len(times):5d} {100 * run / max(len(times), 1):5.1f} %'


print(f'{"":34s} {"lines":>22s} {"branches":>22s}')
for source in sorted(lines):
    print(f'{source:34s} {share(lines[source].values()):>22s} {share(branches[source].values()):>22s}')
all_lines, all_branches = ([count for times in of.values() for count in times.values()]
                           for of in (lines, branches))
print(f'{"all":34s} {share(all_lines):>22s} {share(all_branches):>22s}')
