"""blast.py DIR: the density of the last snapshot against the distance from the center: nodes, and their mean
in bins. kith run inputs/sedov.yaml -o DIR"""
import kith


def draw(directory):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    run = kith.Run(directory)
    last = run[-1]
    r, mean, scatter = last.profile("Density")
    plt.plot(last.distance(), last["Density"], ".", color="0.7", markersize=2, label="nodes")
    plt.errorbar(r, mean, scatter, fmt=".-", label="mean and scatter in bins")
    plt.xlabel("distance from the center (code units)")
    plt.ylabel("density (code units)")
    plt.title(f"{run.report['scene']}, t = {last.time:.4g}")
    plt.legend()
    plt.savefig(f"{run.directory}/blast.png", dpi=150)


kith.script(__doc__, draw)
