"""kith.py - reads what a run of kith leaves: needs h5py and numpy; yt and matplotlib are optional.

    import kith
    run = kith.Run("out/sod")
    last = run[-1]                                  # a snapshot; len(run), run[2:5] and `for` work
    last.time, last.box, last["Density"], last.unit("Density")
    shocked = last.subset(last["Pressure"] > 0.5)   # the same, of some nodes
    r, mean, scatter = last.profile("Density", center=[0, 0, 0])
    run.history["total"], run.report["norms"]["density"]["l1"]

All values are in code units: those of the scene, whatever they are. last.yt() is a dataset of yt."""
import inspect
import json
import os
import sys

import h5py
import numpy as np

# Units of fields, as powers of length, mass and time; in a power of length, d is the dimension.
_UNITS = {"Coordinates": (1, 0, 0), "Velocities": (1, 0, -1), "Accelerations": (1, 0, -2),
          "Masses": (0, 1, 0), "Density": ("-d", 1, 0), "Pressure": ("2-d", 1, -2),
          "InternalEnergy": (2, 0, -2), "SmoothingLength": (1, 0, 0), "SoundSpeed": (1, 0, -1),
          "VelocityDivergence": (0, 0, -1)}
INTERNAL, FROZEN, BARRIER = range(3)  # values of NodeFlags


def _told(text):
    print(text, file=sys.stderr)
    return 2


def _text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def _opened(path):
    try:
        return h5py.File(path, "r")
    except OSError as error:
        raise type(error)(f"{path}: {error}") from None  # h5py does not always name the file


class Snapshot:
    """The nodes of one file, or some of them. Fields are arrays, read when they are asked for; vectors have
    as many columns as the scene has dimensions."""

    def __init__(self, path, chosen=slice(None)):
        self.path, self._chosen, self._read = path, chosen, {}
        with _opened(path) as file:
            run = file["Run"].attrs
            self.time, self.step = float(run["Time"]), int(run["Step"])
            self.dimension = int(run["Dimension"])
            self.box = np.array([run["BoxLower"], run["BoxUpper"]])
            self.periodic = np.array(run["Periodic"], dtype=bool)
            self.materials = _text(run["MaterialNames"]).split("\n")
            self.version = _text(run["Version"])
            scene = run["Scene"] if "Scene" in run else file["Run/Scene"][0]
            self.scene = _text(scene)  # YAML, with all settings of the command line
            self._fields = {name: _text(data.attrs["Description"])
                            for name, data in file["PartType0"].items()}

    def keys(self):
        return list(self._fields)

    def __contains__(self, name):
        return name in self._fields

    def __getitem__(self, name):
        self.about(name)  # is there such a field?
        if name not in self._read:
            with h5py.File(self.path, "r") as file:
                value = file["PartType0"][name][()][self._chosen]
            if value.ndim == 2 and value.shape[1] == 3:
                value = value[:, :self.dimension]
            self._read[name] = value
        return self._read[name]

    def __len__(self):
        return len(self["ParticleIDs"])

    def about(self, name):
        """What the file says of a field."""
        if name not in self._fields:
            raise KeyError(f"{name}: {self.path} has {', '.join(self._fields)}")
        return self._fields[name]

    def unit(self, name):
        """The unit of a field, 'length^-3 mass'; '' if it has none, None if it is not known."""
        powers = _UNITS.get(name, None)
        if powers is None:
            return "" if name in ("ParticleIDs", "MaterialIDs", "NodeFlags") else None
        length = {"-d": -self.dimension, "2-d": 2 - self.dimension}.get(powers[0], powers[0])
        known = zip(("length", "mass", "time"), (length, *powers[1:]))
        return " ".join(what if power == 1 else f"{what}^{power}" for what, power in known if power != 0)

    def subset(self, chosen):
        """Some of the nodes, by a mask or by their positions in the arrays. Values are copies."""
        whole = np.arange(len(Snapshot(self.path)))
        return Snapshot(self.path, whole[self._chosen][chosen])

    def material(self, name):
        if name not in self.materials:
            raise KeyError(f"{name}: the materials of {self.path} are {', '.join(self.materials)}")
        return self.subset(self["MaterialIDs"] == self.materials.index(name))

    def internal(self):
        """The gas: neither frozen nodes, barriers, nor what is behind the faces of inflows and outflows."""
        return self.subset(self["NodeFlags"] == INTERNAL)

    def volume(self):
        return self["Masses"] / self["Density"]

    def distance(self, center=None):
        """Distances of the nodes from a point (none: the middle of the box), along the nearest way through
        periodic faces."""
        center = self.box.mean(axis=0) if center is None else np.asarray(center, float)[:self.dimension]
        d, side = self["Coordinates"] - center, self.box[1] - self.box[0]
        d = np.where(self.periodic, d - side * np.rint(d / side), d)
        return np.sqrt((d * d).sum(axis=1))

    def _values(self, field):
        value = self[field] if isinstance(field, str) else np.asarray(field)
        return np.sqrt((value * value).sum(axis=1)) if value.ndim == 2 else value

    def profile(self, field, center=None, bins=50, axis=None):
        """Means by volume, and standard deviations, in bins of the distance from a center, or along an axis
        (0, 1, 2): place, mean, scatter; bins without nodes are left out. Of vectors the length; `field` may
        be an array of values too."""
        place = self["Coordinates"][:, axis] if axis is not None else self.distance(center)
        value, weight = self._values(field).astype(float), self.volume()
        edges = np.linspace(place.min() if axis is not None else 0, place.max(), bins + 1)
        where = np.clip(np.searchsorted(edges, place, side="right") - 1, 0, bins - 1)
        sums = [np.bincount(where, weight * q, bins) for q in (1, place, value, value * value)]
        full = sums[0] > 0
        at, mean, square = (s[full] / sums[0][full] for s in sums[1:])
        return at, mean, np.sqrt(np.maximum(square - mean * mean, 0))

    def slice(self, field, at=None, axis=2, pixels=256):
        """A picture of a plane across `axis` (3-D), at a position (none: the middle), or of the whole scene
        (2-D): values on pixels [y, x], and their extent for matplotlib's imshow. Every pixel has the mean of
        the nodes nearer than two spacings, by (1 - r^2 / R^2)^3; nan where there are none."""
        x, value, volume = self["Coordinates"], self._values(field).astype(float), self.volume()
        if self.dimension == 1:
            raise ValueError("a 1-D scene has no slice: take profile(field, axis=0)")
        across = [a for a in range(self.dimension) if self.dimension == 2 or a != axis][:2]
        reach = 2 * volume ** (1 / self.dimension)
        depth = np.zeros(len(x))
        if self.dimension == 3:
            depth = x[:, axis] - (self.box[:, axis].mean() if at is None else at)
        lower, upper = self.box[0, across], self.box[1, across]
        size = (upper - lower).max() / pixels
        shape = np.maximum(np.rint((upper - lower) / size).astype(int), 1)
        size = (upper - lower) / shape
        total, weight = np.zeros(shape), np.zeros(shape)
        for i in np.flatnonzero(np.abs(depth) < reach):
            first = np.maximum(np.floor((x[i, across] - reach[i] - lower) / size), 0).astype(int)
            last = np.minimum(np.ceil((x[i, across] + reach[i] - lower) / size).astype(int) + 1, shape)
            if (first >= last).any():
                continue
            d = [lower[k] + (np.arange(first[k], last[k]) + 0.5) * size[k] - x[i, across[k]] for k in (0, 1)]
            r2 = (d[0][:, None] ** 2 + d[1][None, :] ** 2 + depth[i] ** 2) / reach[i] ** 2
            w = volume[i] * np.maximum(1 - r2, 0) ** 3
            window = (slice(first[0], last[0]), slice(first[1], last[1]))
            total[window] += w * value[i]
            weight[window] += w
        with np.errstate(invalid="ignore"):
            return (total / weight).T, (lower[0], upper[0], lower[1], upper[1])

    def yt(self):
        """A dataset of yt, with the units, box and periodicity that yt.load takes from no file of Gadget's
        layout: one code unit is one unit of cgs. The whole file, whatever nodes were chosen."""
        from yt.frontends.gadget.api import GadgetHDF5Dataset
        from yt.utilities.object_registries import output_type_registry
        box, periodic = np.full((3, 2), [-0.5, 0.5]) * (self.box[1] - self.box[0]).max(), np.ones(3, bool)
        box[:self.dimension], periodic[:self.dimension] = self.box.T, self.periodic

        class KithDataset(GadgetHDF5Dataset):
            def _parse_parameter_file(self):
                super()._parse_parameter_file()
                self._periodicity = tuple(bool(p) for p in periodic)
                self._domain_override = False  # with a box of the caller's, yt takes no axis for periodic

        output_type_registry.pop("KithDataset")  # yt.load must not choose it
        units = dict.fromkeys(("UnitLength_in_cm", "UnitMass_in_g", "UnitVelocity_in_cm_per_s",
                               "UnitEnergy_in_cgs"), 1.0)
        return KithDataset(self.path, unit_base=units, bounding_box=box)


class Run:
    """The directory of a run: its snapshots in order, `history` (a numpy record array, a row a step) and
    `report` (a dict). Runs of a chart have no snapshots."""

    def __init__(self, directory):
        self.directory = directory

    @property
    def _paths(self):
        names = [n for n in os.listdir(self.directory) if n.startswith("snapshot_") and n.endswith(".hdf")]
        names.sort(key=lambda name: (len(name), name))  # number 10000 has a digit more than 9999
        if not names:
            raise FileNotFoundError(f"{self.directory}: there is no snapshot_NNNN.hdf")
        return [os.path.join(self.directory, name) for name in names]

    def __len__(self):
        return len(self._paths)

    def __getitem__(self, k):
        return [Snapshot(p) for p in self._paths[k]] if isinstance(k, slice) else Snapshot(self._paths[k])

    @property
    def history(self):
        path = os.path.join(self.directory, "history.csv")
        rows = np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8")
        return np.atleast_1d(rows)  # genfromtxt makes a scalar of a single row

    @property
    def report(self):
        with open(os.path.join(self.directory, "report.json"), encoding="utf-8") as file:
            return json.load(file)


def script(about, work):
    """Calls `work` with the words of the command line, or prints `about` if one of them is -h or --help. Ends
    with code 2 if these are not the words that it takes, and prints `about`; or if something is wrong with
    what they name, or a module is missing, which it prints in one line."""
    if {"-h", "--help"} & set(sys.argv):
        print(about)
        return
    try:
        inspect.signature(work).bind(*sys.argv[1:])
    except TypeError:
        sys.exit(_told(about))
    name = os.path.basename(sys.argv[0])
    try:
        work(*sys.argv[1:])
    except (OSError, KeyError, ValueError) as error:
        text = error.args[0] if isinstance(error, KeyError) else error
        sys.exit(_told(f"{name}: {text}"))
    except ModuleNotFoundError as error:
        sys.exit(_told(f"{name}: {error}; Debian's package is python3-{error.name}"))
