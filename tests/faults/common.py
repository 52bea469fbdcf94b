"""What sweep.py and kills.py run: a short tube with checkpoints, on one thread."""
import os

SCENE = '''scene: tiny
dimension: 1
resolution: %d
domain: {lower: [-1, 0, 0], upper: [1, 1, 1]}
boundaries: {x: reflecting, y: periodic, z: periodic}
materials: {gas: {eos: ideal, gamma: 1.4}}
regions:
  - {material: gas, where: {x: [-1, 0]}, density: 1.0, pressure: 1.0}
  - {material: gas, where: {x: [0, 1]}, density: 0.125, pressure: 0.1}
until: %g
scheme: {%s}
output: {plot: false, checkpoint: 5, checkpoint_at_end: true, every: %g}
'''
ENVIRONMENT = dict(os.environ, OMP_NUM_THREADS='1', OMPI_ALLOW_RUN_AS_ROOT='1',
                   OMPI_ALLOW_RUN_AS_ROOT_CONFIRM='1', OMPI_MCA_mpi_yield_when_idle='1', OMPI_MCA_pml='ob1')
