#!/usr/bin/env python3
"""kills.py PROGRAMS [--kills N] [--starts N] [--ranks 1,2] [--seed S]

kills: a run is killed at random moments, and restarted at once, until it was killed N times; then it may end.
On several ranks the launcher or one of the ranks is killed. starts: two runs are started at the same time in
one directory, N times: one must run, and the other must be refused. In the end snapshots, checkpoint and
history must be those of an uninterrupted run.

A complete test, which takes an hour:
  tests/faults/kills.py build/release/bin --kills 200 --starts 100
"""
import argparse, glob, os, random, shutil, signal, subprocess, sys, tempfile, time

from common import ENVIRONMENT, SCENE, content

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
parser.add_argument('programs')
parser.add_argument('--kills', type=int, default=10)
parser.add_argument('--starts', type=int, default=5)
parser.add_argument('--ranks', default='1,2')
parser.add_argument('--seed', type=int, default=1)
args = parser.parse_args()
kith = os.path.abspath(args.programs) + '/kith'
choose = random.Random(args.seed)
place = tempfile.mkdtemp(prefix='kith-kills-')
os.chdir(place)
open('tiny.yaml', 'w').write(SCENE % (400, 0.1, 'dt: 0.0004', 0.03))


def start(ranks, directory, *words):
    command = [kith, 'run', 'tiny.yaml', '-q', '-o', directory, *words]
    if ranks > 1: command += ['--ranks', str(ranks)]
    return subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                            text=True)


def contents(directory):
    found = {}
    for path in glob.glob(directory + '/*'):
        name = os.path.basename(path)
        if name.endswith(('.json', '.partial', '.previous')): continue
        found[name] = content(path)
    return found


def goes_on(directory):
    last = directory + '/checkpoint.kith'
    return ['--restart', last] if os.path.exists(last) else ['--overwrite']


def children(pid):
    try: return list(map(int, open(f'/proc/{pid}/task/{pid}/children').read().split()))
    except OSError: return []


def victim(launcher, ranks):
    """The launcher, or a rank: a child of the mpirun that the launcher has started. Not a child of a rank,
    which writes a file: if that ends, this is an error of the run, not a kill."""
    started = [rank for mpirun in children(launcher) for rank in children(mpirun)]
    return launcher if ranks == 1 or not started or choose.random() < 0.5 else choose.choice(started)


def kill_and_restart(ranks, seconds):
    """Kills a run N times; returns how often a restart was refused because the previous run had not ended."""
    killed = refused = 0
    while killed < args.kills:
        run = start(ranks, 'parts', *goes_on('parts'))
        try:
            run.wait(timeout=choose.uniform(0, seconds))
        except subprocess.TimeoutExpired:
            try: os.kill(victim(run.pid, ranks), signal.SIGKILL)
            except ProcessLookupError: pass
            killed += 1
        code, said = run.wait(), run.stderr.read()
        if 'another run writes there' in said: refused += 1
        elif code == 0: shutil.rmtree('parts')  # the run was complete: begin another one
        elif code == 2: sys.exit(f'a restart is refused: {said}')
    while True:
        run = start(ranks, 'parts', *goes_on('parts'))
        said = run.communicate()[1]
        if run.returncode == 0: return refused
        if 'another run writes there' not in said: sys.exit(f'the last restart: {run.returncode}, {said}')
        refused += 1


failures = 0
for ranks in map(int, args.ranks.split(',')):
    for old in 'whole', 'parts': shutil.rmtree(old, ignore_errors=True)
    begun = time.time()
    if start(ranks, 'whole').wait() != 0: sys.exit('no run without a fault')
    seconds, whole = time.time() - begun, contents('whole')
    refused = kill_and_restart(ranks, seconds) if args.kills else 0
    same = not args.kills or contents('parts') == whole
    print(f'{ranks} ranks: {args.kills} kills, {refused} restarts refused while the run before was ending, '
          f'{"same bits" if same else "OTHER BITS"}', flush=True)
    mixed = 0
    for _ in range(args.starts):
        shutil.rmtree('both', ignore_errors=True)
        two = [start(ranks, 'both') for _ in range(2)]
        said = [run.communicate()[1] for run in two]
        codes = [run.returncode for run in two]
        refusals = [text for text in said if 'another run' in text or 'an earlier run' in text]
        if sorted(codes) != [0, 2] or len(refusals) != 1 or contents('both') != whole:
            mixed += 1
            print('MIXED:', codes, said)
    print(f'{ranks} ranks: {args.starts} double starts, {args.starts - mixed} with one run and one refusal',
          flush=True)
    failures += mixed + (not same)
shutil.rmtree(place)
sys.exit(failures > 0)
