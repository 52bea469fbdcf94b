"""convergence.py DIR...: L1 errors of runs of one scene at several resolutions, and the order between them.
for n in 50 100 200; do kith run inputs/sod.yaml --set resolution=$n -o out/sod-$n; done"""
import math
import sys

import kith

reports = sorted((kith.Run(directory).report for directory in sys.argv[1:]), key=lambda r: r["nodes"])
print(f"{'nodes':>9} {'L1 of density':>14} {'order':>6} {'CPU-s':>8}")
before = None
for report in reports:
    error, order = report["norms"]["density"]["l1"], ""
    if before is not None:
        finer = (report["nodes"] / before["nodes"]) ** (1 / report["dimension"])
        order = f"{math.log(before['norms']['density']['l1'] / error) / math.log(finer):.2f}"
    print(f"{report['nodes']:9d} {error:14.4e} {order:>6} {report['cpu_seconds']:8.2f}")
    before = report
