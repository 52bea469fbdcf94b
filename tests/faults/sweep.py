#!/usr/bin/env python3
"""sweep.py PROGRAMS TOOLS [--sample N] [--seed S] [--ranks 1,2] [--set KEY=VALUE]... [CLASS]...

Makes each system call on the files of a short run fail once, each allocation, and on several ranks each MPI
call; and simulates a power loss at each call. With --sample, N faults of each class, at random. After a
fault, the run must end with one line and code 1 or 2, or continue, with the results of a run without a fault;
no partial file may be left; and a restart from the last checkpoint, or a new run if there is none, must have
the results of a run without a fault. Libraries crash at some failed allocations: one line too, counted apart.

A complete sweep takes hours, most of them for the allocations of HDF5:
  tests/faults/sweep.py build/release/bin build/release/tests/faults
"""
import argparse, collections, glob, json, os, random, shutil, subprocess, sys, tempfile
from common import ENVIRONMENT, SCENE, content

MESSAGES = 'message-error message-abort message-kill'.split()
CLASSES = 'open write read map sync name size close power power-names allocate'.split() + MESSAGES
parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
parser.add_argument('programs')
parser.add_argument('tools')
parser.add_argument('--sample', type=int, default=0)
parser.add_argument('--seed', type=int, default=1)
parser.add_argument('--ranks', default='1,2')
parser.add_argument('--set', action='append', default=[])
parser.add_argument('--sanitized', action='store_true', help='sanitizers have a malloc of their own')
parser.add_argument('--keep', action='store_true', help='leave the directories of what went wrong')
parser.add_argument('classes', nargs='*', default=CLASSES, help=', '.join(CLASSES))
args = parser.parse_intermixed_args()
if args.sanitized: args.classes = [kind for kind in args.classes if kind not in ['allocate', *MESSAGES]]
kith = os.path.abspath(args.programs) + '/kith'
inject, allocate, messages = (os.path.abspath(args.tools) + '/' + name
                              for name in ('inject', 'liballocate.so', 'libmessages.so'))
place = tempfile.mkdtemp(prefix='kith-faults-')
os.chdir(place)
open('tiny.yaml', 'w').write(SCENE % (50, 0.05, '', 0.02))
environment = dict(ENVIRONMENT, ASAN_OPTIONS='detect_leaks=0', # impossible in a traced process
                   KITH_FAULT_LOG=place + '/log', KITH_FAULT_COUNT=place + '/count')


def run(ranks, directory, *words, before=(), **more):
    """Returns the exit code and the lines of standard error."""
    command = [*before, kith, 'run', 'tiny.yaml', '-q', '-o', directory, *words]
    for setting in args.set: command += ['--set', setting]
    if ranks > 1: command += ['--ranks', str(ranks)]
    try:
        done = subprocess.run(command, env=dict(environment, **more), stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True, timeout=60)
    except subprocess.TimeoutExpired:
        return None, ['not over within a minute']
    return done.returncode, done.stderr.splitlines()


def keys(report):
    return {name: keys(value) for name, value in report.items()} if isinstance(report, dict) else None


def contents(directory, loose):
    """What must be equal: all files but for clocks; after a restart (loose), without those it continues."""
    found = {}
    for path in sorted(glob.glob(directory + '/*')):
        name = os.path.basename(path)
        if loose and name.endswith(('.previous', '.csv', '.json')): continue
        data = content(path)
        if name == 'report.json': data = keys(json.loads(data))
        found[name] = data
    return found


def other(a, b):
    return sorted(name for name in a.keys() | b.keys() if a.get(name) != b.get(name))


def fault(kind, n, ranks):
    if kind == 'allocate' or kind in MESSAGES:
        more = {'KITH_FAULT_RANK': str(ranks - 1)} if ranks > 1 else {}
        return run(ranks, 'parts', LD_PRELOAD=allocate if kind == 'allocate' else messages,
                   KITH_FAULT_N=str(n), KITH_FAULT_HOW=kind.removeprefix('message-'), **more)
    below = place + '/parts' if kind.startswith('power') else place # the scene itself counts as synced
    return run(ranks, 'parts', before=[inject, kind, str(n), below])


def count(kind, ranks):
    shutil.rmtree('parts', ignore_errors=True)
    code, lines = fault(kind, 0, ranks)
    if code == 77: sys.exit(77)
    if code != 0: sys.exit(f'without a fault: {code} {lines}')
    counted = kind == 'allocate' or kind in MESSAGES
    return int(open('count').read()) if counted else len(open('log').readlines())


def first_checkpoint():
    """The number of the call after which the first checkpoint is certainly on the disk."""
    named = False
    for number, line in enumerate(open('log'), 1):
        named = named or line.startswith('name') and 'checkpoint.kith.partial' in line
        if named and line == f'sync {place}/parts\n': return number
    return 0


def judge(kind, n, ranks, whole, sure):
    """What is wrong after the n-th call failed, or None."""
    shutil.rmtree('parts', ignore_errors=True)
    code, lines = fault(kind, n, ranks)
    power = kind.startswith('power')
    if not power:
        changed = other(contents('parts', False), whole)
        untimed = changed == ['report.json'] and 'warning: times of some stages' in ' '.join(lines)
        if code == 0 and changed and not untimed: return f'ended with 0 and other {changed}', lines
        if code not in (0, 1, 2): return f'ended with {code}', lines
        if code != 0 and (len(lines) != 1 or not lines[0].startswith('kith: ')): return 'not one line', lines
        if code == 0 and lines and not lines[0].startswith('kith: warning: '): return 'a line, and 0', lines
        left = glob.glob('parts/*.partial')
        crashed = any(line.startswith('kith: crashed') for line in lines)
        if crashed and kind not in ['allocate', 'message-abort']: return 'crashed', lines
        if left and not crashed and kind not in ['name', *MESSAGES]: return f'half-written: {left}', lines
        tally['crashed' if crashed else f'code {code}'] += 1
    rows = open('parts/history.csv').read().count('\n') if os.path.exists('parts/history.csv') else 0
    there = os.path.exists('parts/checkpoint.kith')
    if not there and (n > sure if power else rows > 7): return 'LOST the checkpoint', lines
    words = ['--restart', 'parts/checkpoint.kith'] if there else []
    after, said = run(ranks, 'parts', *words)
    if there and after == 2 and power and n <= sure:
        return None if 'checkpoint' in said[0] else ('LOST', said)
    if after != 0: return f'LOST: {words} gives {after}', lines + said
    wrong = other(contents('parts', True), contents('whole', True))
    if wrong: return f'LOST: {wrong} differ after {words}', lines
    if 'history.csv' in other(contents('parts', False), whole): return 'LOST: rows of the history', lines
    return None


failures = tried = 0
tally = collections.Counter()
choose = random.Random(args.seed)
for ranks in map(int, args.ranks.split(',')):
    shutil.rmtree('whole', ignore_errors=True)
    if run(ranks, 'whole')[0] != 0: sys.exit('no run without a fault')
    whole = contents('whole', False)
    for kind in args.classes:
        if ranks == 1 and kind in MESSAGES: continue
        total = count(kind, ranks)
        sure = first_checkpoint() if kind.startswith('power') else 0
        numbers = range(1, total + 1)
        if args.sample: numbers = sorted(choose.sample(numbers, min(args.sample, total)))
        if kind == 'allocate' and ranks > 1: numbers = sorted({1, 2, 3, *numbers}) # as MPI starts
        bad = 0
        for n in numbers:
            wrong = judge(kind, n, ranks, whole, sure)
            if wrong is None: continue
            bad += 1
            print(f'FAILED: {ranks} ranks, {kind} {n}: {wrong[0]}: {" | ".join(wrong[1])[:400]}', flush=True)
            if args.keep: shutil.copytree('parts', f'{kind}-{n}-{ranks}', dirs_exist_ok=True)
        tried += len(numbers)
        failures += bad
        print(f'{ranks} ranks, {kind}: {len(numbers)} of {total} tried, {len(numbers) - bad} ended well',
              flush=True)
print(f'{tried} faults, {tried - failures} ended well {dict(tally)}')
if not args.keep: shutil.rmtree(place)
sys.exit(failures > 0)
