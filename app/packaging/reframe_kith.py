# ReFrame: reframe -c app/packaging/reframe_kith.py -r
import reframe as rfm
import reframe.utility.sanity as sn


@rfm.simple_test
class KithSedov(rfm.RunOnlyRegressionTest):
    descr = "kith, Sedov's blast in 3-D: errors and node updates per second"
    valid_systems = ["*"]
    valid_prog_environs = ["*"]
    executable = "kith-3d"
    sourcesdir = "../../inputs"
    executable_opts = ["run", "sedov.yaml", "--set", "resolution=50", "--quiet"]
    num_tasks = 2
    # Updates per second of a system: (value, -20 %, none, unit).
    reference = {"*": {"updates": (0, None, None, "1/s")}}

    @sanity_function
    def shock_and_energy(self):
        return sn.all([sn.assert_found(r"shock at 0\.35", self.stdout),
                       sn.assert_found(r"\s*conservation errors: energy (0\.00e\+00|\S+e-(1[3-9]|[2-9]\d))",
                                       self.stdout)])

    @performance_function("1/s")
    def updates(self):
        return sn.extractsingle(r"FOM.*node-updates/s\s*=?\s*([0-9.e+]+)", self.stdout, 1, float)
