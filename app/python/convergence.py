"""convergence.py DIR...: L1 errors of runs of one scene at several resolutions, and the order between them.
for n in 50 100 200; do kith run inputs/sod.yaml --set resolution=$n -o out/sod-$n; done
Of one method of a chart: convergence.py out/chart/sod-1d/runs/mfm-*/"""
import math

import kith


def error_of(directory):
    """Number of nodes and error of a run, and its whole report."""
    report = kith.Run(directory).report
    error = report["norms"] and report["norms"]["density"]["l1"]
    if error is None:
        raise ValueError(f"{directory}: no L1 error of the density, which is from an exact solution")
    return report["nodes"], error, report


def show(directory, *others):
    runs = sorted(map(error_of, (directory, *others)), key=lambda run: run[0])
    print(f"{'nodes':>9} {'L1 of density':>14} {'order':>6} {'CPU-s':>8}")
    for k, (nodes, error, report) in enumerate(runs):
        order, (fewer, before, _) = "", runs[max(k - 1, 0)]
        if fewer < nodes and before > 0 and error > 0:  # otherwise there is no order
            order = f"{math.log(before / error) / math.log(nodes / fewer) * report['dimension']:.2f}"
        print(f"{nodes:9d} {error:14.4e} {order:>6} {report['cpu_seconds']:8.2f}")


kith.script(__doc__, show)
