# Spack package: copy it to packages/kith of a repository of packages. kith has no public address: set `git`
# to the path of a checkout, or run `spack dev-build kith@main` in the checkout.
from spack.package import *


class Kith(CMakePackage):
    """The lifecycle of particle connectivity in a time-stepping SPH mini-application."""

    tags = ["proxy-app"]
    license("BSD-3-Clause")
    git = "file:///path/to/kith"
    version("main", branch="main")

    variant("dims", default="1,2,3", values=("1", "2", "3"), multi=True, description="Dimensions")
    variant("scotch", default=True, description="Partitioners graph and hybrid")
    variant("p4est", default=False, description="Partitioner p4est (GPL)")
    variant("gsl", default=False, description="Tests that compare with GSL")

    depends_on("c", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("mpi")
    depends_on("hdf5+mpi+hl@1.10:")
    depends_on("sundials@6.4:7+mpi+ARKODE+KINSOL")
    depends_on("libyaml")
    depends_on("muparser")
    depends_on("jansson")
    depends_on("scotch+mpi", when="+scotch")
    depends_on("p4est+mpi", when="+p4est")
    depends_on("gsl", when="+gsl", type="test")
    generator("ninja")

    def cmake_args(self):
        return [
            self.define("KITH_DIMENSIONS", ";".join(self.spec.variants["dims"].value)),
            self.define_from_variant("KITH_SCOTCH", "scotch"),
            self.define_from_variant("KITH_P4EST", "p4est"),
            self.define_from_variant("KITH_GSL", "gsl"),
        ]

    def test_sod(self):
        """A shock tube: the run ends well and its shock is where it belongs."""
        kith = which(self.prefix.bin.kith)
        scene = join_path(self.prefix.share, "kith", "inputs", "sod.yaml")
        out = kith("run", scene, "--quiet", "--threads", "1", output=str.split, error=str.split)
        check_outputs([r"shock at 0\.35", r"FOM"], out)
