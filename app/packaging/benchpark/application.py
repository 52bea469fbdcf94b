# Ramble application for Benchpark: Sedov's blast, strong or weak, with the figure of merit of kith.
from ramble.appkit import *


class Kith(ExecutableApplication):
    """The lifecycle of particle connectivity in a time-stepping SPH mini-application."""

    name = "kith"
    tags = ["proxy-app", "sph", "mpi", "openmp"]

    executable(
        "blast",
        "kith-3d run {scene} --set resolution={resolution} --set output.plot=false "
        "--steps {steps} --quiet -o {experiment_run_dir}/out",
        use_mpi=True,
    )
    workload("sedov", executables=["blast"])
    workload_variable(
        "scene", default="{kith}/share/kith/inputs/sedov.yaml", description="Scene", workloads=["sedov"]
    )
    workload_variable("resolution", default="100", description="Nodes along an edge", workloads=["sedov"])
    workload_variable("steps", default="20", description="Time steps", workloads=["sedov"])

    figure_of_merit(
        "updates",
        fom_regex=r"FOM.*node-updates/s\s*=?\s*(?P<updates>[0-9.e+]+)",
        group_name="updates",
        units="1/s",
    )
    success_criteria(
        "conserves",
        mode="string",
        match=r"\s*conservation errors: energy (0\.00e\+00|\S+e-(1[3-9]|[2-9]\d))",
    )
