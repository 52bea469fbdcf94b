#!/usr/bin/env python3
"""lives.py PROGRAMS [--kills N] [--twins N] [--ranks 1,2] [--seed S]

kills: a run is killed at random moments, and restarted at once, until it has been killed N times; then it
may end. With ranks it is the launcher or one of the ranks that is killed. twins: two runs are started at once
into one directory, N times: one runs, the other is refused. In the end snapshots, checkpoint and history are
those of a run that nothing happened to.

As measured for 200 kills and 100 twins:
  tests/faults/lives.py build/release/bin --kills 200 --twins 100
"""
import argparse, glob, os, random, shutil, signal, subprocess, sys, tempfile, time

SCENE = '''scene: tiny
dimension: 1
resolution: 400
domain: {lower: [-1, 0, 0], upper: [1, 1, 1]}
boundaries: {x: reflecting, y: periodic, z: periodic}
materials: {gas: {eos: ideal, gamma: 1.4}}
regions:
  - {material: gas, where: {x: [-1, 0]}, density: 1.0, pressure: 1.0}
  - {material: gas, where: {x: [0, 1]}, density: 0.125, pressure: 0.1}
until: 0.2
scheme: {dt: 0.0004}
output: {plot: false, checkpoint: 5, checkpoint_at_end: true, every: 0.03}
'''
parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
parser.add_argument('programs')
parser.add_argument('--kills', type=int, default=10)
parser.add_argument('--twins', type=int, default=5)
parser.add_argument('--ranks', default='1,2')
parser.add_argument('--seed', type=int, default=1)
args = parser.parse_args()
kith = os.path.abspath(args.programs) + '/kith'
choose = random.Random(args.seed)
place = tempfile.mkdtemp(prefix='kith-lives-')
os.chdir(place)
open('tiny.yaml', 'w').write(SCENE)
environment = dict(os.environ, OMP_NUM_THREADS='1', OMPI_ALLOW_RUN_AS_ROOT='1',
                   OMPI_ALLOW_RUN_AS_ROOT_CONFIRM='1', OMPI_MCA_mpi_yield_when_idle='1', OMPI_MCA_pml='ob1')


def start(ranks, directory, *words):
    command = [kith, 'run', 'tiny.yaml', '-q', '-o', directory, *words]
    if ranks > 1: command += ['--ranks', str(ranks)]
    return subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                            text=True)


def contents(directory):
    found = {}
    for path in glob.glob(directory + '/*'):
        name = os.path.basename(path)
        if name.endswith(('.json', '.partial', '.previous')): continue
        data = open(path, 'rb').read()
        if name == 'history.csv': data = b'\n'.join(row.rsplit(b',', 1)[0] for row in data.split(b'\n'))
        found[name] = data
    return found


def goes_on(directory):
    last = directory + '/checkpoint.kith'
    return ['--restart', last] if os.path.exists(last) else ['--overwrite']


def victim(launcher, ranks):
    """The launcher, or a rank that it has started."""
    if ranks == 1 or choose.random() < 0.5: return launcher
    below = [launcher]
    for pid in below:
        try: below += map(int, open(f'/proc/{pid}/task/{pid}/children').read().split())
        except OSError: pass
    return below[-1]


def die(ranks, seconds):
    """Kills of one life after the other; how often a restart met what was left of the one before."""
    killed = met = 0
    while killed < args.kills:
        run = start(ranks, 'parts', *goes_on('parts'))
        try:
            run.wait(timeout=choose.uniform(0, seconds))
        except subprocess.TimeoutExpired:
            try: os.kill(victim(run.pid, ranks), signal.SIGKILL)
            except ProcessLookupError: pass
            killed += 1
        code, said = run.wait(), run.stderr.read()
        if 'another run writes there' in said: met += 1
        elif code == 0: shutil.rmtree('parts')  # it came to its end: another one
        elif code == 2: sys.exit(f'a restart is refused: {said}')
    while True:
        run = start(ranks, 'parts', *goes_on('parts'))
        said = run.communicate()[1]
        if run.returncode == 0: return met
        if 'another run writes there' not in said: sys.exit(f'the last restart: {run.returncode}, {said}')
        met += 1


failures = 0
for ranks in map(int, args.ranks.split(',')):
    for old in 'whole', 'parts': shutil.rmtree(old, ignore_errors=True)
    begun = time.time()
    if start(ranks, 'whole').wait() != 0: sys.exit('no run without a fault')
    seconds, whole = time.time() - begun, contents('whole')
    met = die(ranks, seconds) if args.kills else 0
    same = not args.kills or contents('parts') == whole
    print(f'{ranks} ranks: {args.kills} kills, {met} restarts refused while the run before was ending, '
          f'{"same bits" if same else "OTHER BITS"}', flush=True)
    mixed = 0
    for _ in range(args.twins):
        shutil.rmtree('twins', ignore_errors=True)
        two = [start(ranks, 'twins') for _ in range(2)]
        said = [run.communicate()[1] for run in two]
        codes = [run.returncode for run in two]
        refused = [text for text in said if 'another run' in text or 'an earlier run' in text]
        if sorted(codes) != [0, 2] or len(refused) != 1 or contents('twins') != whole:
            mixed += 1
            print('MIXED:', codes, said)
    print(f'{ranks} ranks: {args.twins} twins, {args.twins - mixed} with one run and one refusal', flush=True)
    failures += mixed + (not same)
shutil.rmtree(place)
sys.exit(failures > 0)
