# Benchpark experiment: nodes per rank, or nodes in all, held fixed.
from benchpark.directives import variant
from benchpark.experiment import Experiment


class Kith(Experiment):
    variant("workload", default="sedov", values=("sedov",), description="the scene")
    variant("scaling", default="strong", values=("strong", "weak"), description="what is held fixed")

    def compute_applications_section(self):
        ranks = [1, 2, 4, 8]
        edges = [100] * 4 if self.spec.satisfies("scaling=strong") else [64, 80, 102, 128]
        self.add_experiment_variable("n_ranks", ranks, True)
        self.add_experiment_variable("resolution", edges, True)

    def compute_package_section(self):
        self.add_package_spec(self.name, ["kith@main"])
