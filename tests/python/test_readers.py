#!/usr/bin/env python3
"""test_readers.py PROGRAMS INPUTS: units, box, time and fields that app/python/kith.py, yt and the VTK reader
(used by ParaView) find in snapshots of 1-D, 2-D and 3-D runs, against h5py and the report and history of the
run; and the example scripts end as they should. Skipped (77) without h5py and numpy; without yt, VTK or
matplotlib their parts are left out, with a message."""
import glob
import os
import subprocess
import sys
import tempfile
import warnings

try:
    import h5py
    import numpy as np
except ImportError as missing:
    debian = "/usr/bin/python3"  # the one with Debian's packages, if another one comes first in PATH
    if sys.executable != debian and os.access(debian, os.X_OK):
        os.execv(debian, [debian, *sys.argv])
    print(f"skipped: {missing}")
    sys.exit(77)

warnings.simplefilter("ignore")
sys.dont_write_bytecode = True
os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
HERE = os.path.dirname(os.path.abspath(__file__))
PYTHON = os.path.join(HERE, "..", "..", "app", "python")
sys.path.insert(0, PYTHON)
import kith  # noqa: E402

programs, inputs = (os.path.abspath(path) for path in sys.argv[1:3])
failures = 0


def check(true, what):
    global failures
    if not true:
        failures += 1
        print(f"FAILED: {what}")


def run(dimension, scene, *settings):
    directory = f"{scene}-{dimension}"
    words = [os.path.join(programs, f"kith-{dimension}d"), "run", f"{inputs}/{scene}.yaml", "--quiet", "-o",
             directory]
    for setting in (f"dimension={dimension}", "output.plot=false", *settings):
        words += ["--set", setting]
    done = subprocess.run(words, capture_output=True, text=True)
    check(done.returncode == 0, f"{words}: {done.stderr}")
    return directory


def check_kith(directory, dimension):
    """kith.py against h5py, and against sums that the run itself reports."""
    r = kith.Run(directory)
    first, last = r[0], r[-1]
    with h5py.File(f"{directory}/snapshot_0001.hdf", "r") as file:
        density, x = file["PartType0/Density"][()], file["PartType0/Coordinates"][()]
        check(file["Header"].attrs["BoxSize"] == 1 and file["Header"].attrs["Flag_DoublePrecision"] == 1,
              "the header of Gadget's layout")
    check(first.time == 0 and last.time == r.report["time"] and last.step == r.history["step"][-1], "time")
    check((last.box == [[-0.5] * dimension, [0.5] * dimension]).all() and last.periodic.all(), "box")
    check((last["Density"] == density).all() and (last["Coordinates"] == x[:, :dimension]).all(), "fields")
    check(len(last) == r.report["nodes"] == len(last.internal()), "number of nodes")
    length = "length^-%d mass" % dimension
    check(last.unit("Density") == length and last.unit("Velocities") == "length time^-1", "units")
    check(last.unit("Pressure") == ("", "length ", "", "length^-1 ")[dimension] + "mass time^-2",
          "unit of the pressure")
    total = (last["Masses"] * (last["InternalEnergy"] + 0.5 * (last["Velocities"] ** 2).sum(axis=1))).sum()
    check(abs(total / r.history["total"][-1] - 1) < 1e-12, "total energy from the nodes")
    near = last.subset(last.distance() < 0.3)
    check(0 < len(near) < len(last) and near.distance().max() < 0.3, "subset")
    check(len(near.subset(near["Density"] > 1)) == (near["Density"] > 1).sum(), "subset of a subset")
    corner = [0.5] * dimension
    check(last.distance(corner).max() <= 0.5 * dimension ** 0.5 + 1e-12, "distance through faces")
    place, mean, scatter = first.profile("Density", bins=5)
    check(np.allclose(mean, first["Density"].mean(), atol=0.02) and (np.diff(place) > 0).all(), "profile")
    _, straight, _ = last.profile(2 * last["Coordinates"][:, 0], axis=0, bins=4)
    check(np.allclose(np.diff(straight), 0.5, atol=0.12), "profile along an axis")
    if dimension > 1:
        values, extent = last.slice(last["Coordinates"][:, 0], pixels=32)
        middle = np.linspace(extent[0], extent[1], 65)[1::2]
        check(values.shape == (32, 32) and np.abs(values[16, 4:28] - middle[4:28]).max() < 0.05, "slice")


def check_yt(directory, dimension):
    yt.set_log_level(50)
    last = kith.Run(directory)[-1]
    ds = last.yt()
    data = ds.all_data()
    check(float(ds.current_time.to("code_time")) == last.time and float(ds.current_time.to("s")) == last.time,
          "yt: time")
    check((ds.domain_left_edge.to("code_length").d == -0.5).all()
          and (ds.domain_right_edge.to("cm").d == 0.5).all(), "yt: box")
    check(ds.periodicity == (True,) * 3, "yt: periodicity")
    for name, unit in (("Density", "g/cm**3"), ("InternalEnergy", "erg/g"), ("Masses", "g")):
        ours, theirs = np.sort(last[name]), np.sort(data["PartType0", name].to(unit).d)
        check(np.allclose(ours, theirs, rtol=1e-12), f"yt: {name}")
    plain = yt.load(f"{directory}/snapshot_0001.hdf")  # like any Gadget file, also in 1-D and 2-D
    check(plain.all_data()["PartType0", "Density"].size == len(last), "yt.load")
    check(np.isfinite(plain.slice(2, 0.0).to_frb(plain.domain_width[0], 8)["gas", "density"].d).any(),
          "yt.load: slice")


def check_vtk(directory, dimension):
    reader = vtkHDFReader()
    reader.SetFileName(f"{directory}/snapshot_0001.hdf")
    check(reader.CanReadFile(f"{directory}/snapshot_0001.hdf"), "VTK can read it")
    reader.Update()
    grid, last = reader.GetOutput(), kith.Run(directory)[-1]
    values = grid.GetPointData()
    density = values.GetArray("Density")
    check(grid.GetNumberOfPoints() == grid.GetNumberOfCells() == len(last), "VTK: nodes")
    check([density.GetValue(i) for i in range(len(last))] == last["Density"].tolist(), "VTK: density")
    point = [grid.GetPoint(i)[:dimension] for i in range(len(last))]
    check((np.array(point) == last["Coordinates"]).all(), "VTK: coordinates")


def call(script, *words):
    return subprocess.run([sys.executable, os.path.join(PYTHON, script), *words], capture_output=True,
                          text=True)


try:
    import yt
except ImportError:
    yt = None
    print("without yt")
try:
    from vtkmodules.vtkIOHDF import vtkHDFReader
except ImportError:
    vtkHDFReader = None
    print("without VTK")
with tempfile.TemporaryDirectory() as place:
    os.chdir(place)
    dimensions = [d for d in (1, 2, 3) if os.access(os.path.join(programs, f"kith-{d}d"), os.X_OK)]
    for d in dimensions:
        name = run(d, "sedov", f"resolution={(0, 40, 16, 10)[d]}", "until=0.005")
        check_kith(name, d)
        if yt is not None:
            check_yt(name, d)
        if vtkHDFReader is not None:
            check_vtk(name, d)
    d = dimensions[-1]
    walls = kith.Run(run(d, "plate", "resolution=20", "until=0.001"))[-1]  # its plate is a barrier
    barrier = walls.subset(walls["NodeFlags"] == kith.BARRIER)
    x = barrier["Coordinates"][:, 0]
    check(len(barrier) > 1 and ((x > 0) & (x < 0.02)).all(), "barrier nodes")
    check(len(walls.internal()) + len(barrier) == len(walls), "internal nodes")
    check(not walls.periodic[0] and len(walls.material("gas")) == len(walls), "walls")
    with open("damaged.hdf", "w", encoding="utf-8") as file:
        file.write("no HDF5")
    for text, read in (("damaged.hdf: ", lambda: kith.Snapshot("damaged.hdf")),
                       ("zz: the materials of ", lambda: walls.material("zz")),
                       (f"zz: {walls.path} has ", lambda: walls.about("zz")),
                       (f"zz: {walls.path} has ", lambda: walls["zz"])):
        told = "nothing"
        try:
            read()
        except (OSError, KeyError) as error:
            told = str(error.args[0])
        check(told.startswith(text), f"'{text}...': {told}")
    try:
        import matplotlib  # noqa: F401
        examples = [("blast.py", name), ("movie.py", name, "Pressure"), ("convergence.py", name)]
    except ImportError:
        print("without matplotlib")
        examples = [("convergence.py", name)]
        done = call("movie.py", name)
        check(done.returncode == 2 and done.stderr.endswith("package is python3-matplotlib\n"),
              f"without matplotlib: {done.stderr}")
    for script, *words in examples:
        done = call(script, *words)
        check(done.returncode == 0, f"{script}: {done.stderr}")
        done = call(script)
        check(done.returncode == 2 and done.stderr.startswith(script), f"{script} alone: {done.stderr}")
        done = call(script, "--help")
        check(done.returncode == 0 and done.stdout.startswith(script), f"{script} --help: {done.stderr}")
        done = call(script, "nowhere")
        check(done.returncode == 2 and done.stderr.count("\n") == 1 and "nowhere" in done.stderr,
              f"{script} nowhere: {done.stderr}")
    done = call("convergence.py", name, name)
    check(done.returncode == 0 and done.stdout.count("\n") == 3, f"equally many nodes: {done.stderr}")
    for snapshot in glob.glob(f"{name}/snapshot_*.hdf"):
        os.remove(snapshot)
    done = call("convergence.py", name)
    check(done.returncode == 0, f"a run without snapshots, as of a chart: {done.stderr}")
    try:
        told = len(kith.Run(name))
    except FileNotFoundError as error:
        told = str(error)
    check(told == f"{name}: there is no snapshot_NNNN.hdf", f"snapshots of a run without any: {told}")
    bare = run(d, "sedov", "resolution=6", "exact=null", "until=1e-9")
    done = call("convergence.py", bare)
    check(done.returncode == 2 and done.stderr.startswith(f"convergence.py: {bare}: no L1 error"),
          f"without an exact solution: {done.stderr}")
    check(kith.Run(bare).history["step"].tolist() == [0, 1], "a history of one step")
    for number in (9999, 10000, 10001):
        os.link(f"{bare}/snapshot_0001.hdf", f"{bare}/snapshot_{number}.hdf")
    check([s.path[-9:-4] for s in kith.Run(bare)[2:]] == ["_9999", "10000", "10001"], "order of snapshots")
print(f"{failures} failures")
sys.exit(failures > 0)
