#!/usr/bin/env python3
"""latency.py PROGRAMS SCENE [--set KEY=VALUE]... [--ranks 1,2,8]

How long a run takes to stop. SIGINT and SIGTERM are sent to the launcher after the second step, as Ctrl-C and
schedulers do. Prints the seconds until the checkpoint is written, until the run has ended, and of a step.

With 10^6 nodes, which takes ten minutes:
  tests/faults/latency.py build/release/bin inputs/sedov.yaml --set dimension=2 --set resolution=1000
"""
import argparse, json, os, signal, subprocess, sys, tempfile, time

from common import ENVIRONMENT

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
parser.add_argument('programs')
parser.add_argument('scene')
parser.add_argument('--set', action='append', default=[])
parser.add_argument('--ranks', default='1,2,8')
args = parser.parse_args()
kith = os.path.abspath(args.programs) + '/kith'
failures = 0


def rows(directory):
    try: return [line.split(',') for line in open(directory + '/history.csv').read().splitlines()[1:]]
    except OSError: return []


def stop(ranks, number, directory):
    """Seconds from the signal to the checkpoint and to the end, the exit code, and standard error."""
    command = [kith, 'run', args.scene, '-q', '-o', directory, '--ranks', str(ranks)]
    for setting in [*args.set, 'output.plot=false']: command += ['--set', setting]
    run = subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                           text=True)
    while run.poll() is None and len(rows(directory)) < 2: time.sleep(0.05)
    sent = time.time()
    run.send_signal(number)
    said = run.communicate()[1]
    ended, saved = time.time() - sent, os.path.getmtime(directory + '/checkpoint.kith') - sent
    return saved, ended, run.returncode, said


for ranks in map(int, args.ranks.split(',')):
    for number in signal.SIGINT, signal.SIGTERM:
        with tempfile.TemporaryDirectory(prefix='kith-latency-') as directory:
            saved, ended, code, said = stop(ranks, number, directory)
            report = json.load(open(directory + '/report.json'))
            step = report['wall_seconds'] / report['steps']
            good = code == 1 and 'go on with --restart' in said and saved > 0
            failures += not good
            print(f'{ranks} ranks, {number.name}, {report["nodes"]} nodes: checkpoint after {saved:.1f} s, '
                  f'end after {ended:.1f} s; a step takes {step:.1f} s{"" if good else ": WRONG: " + said}',
                  flush=True)
sys.exit(failures > 0)
