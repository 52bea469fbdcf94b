"""The run that sweep.py and kills.py make, a short shock tube with checkpoints on one thread, and how its
files are compared."""
import os
try: import h5py
except ImportError: h5py = None

SCENE = '''scene: tiny
dimension: 1
resolution: %d
domain: {lower: [-1, 0, 0], upper: [1, 1, 1]}
boundaries: {x: reflecting, y: periodic, z: periodic}
materials: {gas: {eos: ideal, gamma: 1.4}, air: {eos: ideal, gamma: 1.4}}
regions:
  - {material: gas, where: {x: [-1, 0]}, density: 1.0, pressure: 1.0}
  - {material: air, where: {x: [0, 1]}, density: 0.125, pressure: 0.1}
probes: [{name: line, at: [-0.5, 0, 0], along: [1, 0, 0], spacing: 0.1, every: 3}]
connectivity: {contacts: [{of: gas, with: air}]}
until: %g
scheme: {%s}
output: {plot: false, checkpoint: 5, checkpoint_at_end: true, every: %g}
'''
ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS='1', OMPI_ALLOW_RUN_AS_ROOT='1',
                   OMPI_ALLOW_RUN_AS_ROOT_CONFIRM='1', OMPI_MCA_mpi_yield_when_idle='1', OMPI_MCA_pml='ob1')


def content(path):
    """What must not differ between runs: rows of history.csv without seconds, those of contacts.csv without
    builds and why; samples of probes.h5 (with h5py), as their place in the file may differ after restarts."""
    data = open(path, 'rb').read()
    if path.endswith('.h5'):
        found = {}
        if h5py is None: return found
        with h5py.File(path) as file:
            file.visititems(lambda name, item: found.update({name: item[()].tobytes()})
                            if isinstance(item, h5py.Dataset) else None)
        return found
    if not path.endswith('.csv'): return data
    rows = data.split(b'\n')
    last = rows[0].split(b',')[-1]
    return b'\n'.join(row.rsplit(b',', 2 if last == b'why' else 1)[0] for row in rows)
