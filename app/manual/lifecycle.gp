# gnuplot -e "data='FILE'" lifecycle.gp: draws what tests/examples/lifecycle.c prints, a panel for each stage.
set terminal pngcairo size 1200, 830 font "sans,12"
set output "lifecycle.png"
set multiplot layout 2, 3
set size ratio -1
set xrange [-0.25:1.25]
set yrange [-0.25:1.25]
set tics 0.5
set xlabel "x"
set ylabel "y"
unset key
set object 1 rectangle from 0, 0 to 1, 1 fillstyle empty border lc rgb "#555555" lw 1.5
title(stage) = stage eq "nodes" ? "1. nodes; black: the node whose row is built" : \
               stage eq "ghosts" ? "2. ghosts: mirrors along x, periodic along y" : \
               stage eq "neighbors" ? "3. candidates of the search" : \
               stage eq "connectivity" ? "4. its row" : \
               stage eq "cull" ? "5. ghosts that no node needs" : "6. the row, patched"
of(stage, what) = sprintf("< awk '$1 == \"%s\" && $4 == \"%s\"' %s", stage, what, data)
do for [stage in "nodes ghosts neighbors connectivity cull patch"] {
  set title title(stage)
  plot NaN, of(stage, "ghost") using 2:3 with points pt 6 ps 0.6 lc rgb "#999999", \
       of(stage, "node") using 2:3 with points pt 7 ps 0.6 lc rgb "#0072b2", \
       of(stage, "candidate") using 2:3 with points pt 6 ps 1.2 lc rgb "#e69f00", \
       of(stage, "neighbor") using 2:3 with points pt 7 ps 0.9 lc rgb "#d55e00", \
       of(stage, "culled") using 2:3 with points pt 2 ps 1 lc rgb "#d55e00", \
       of(stage, "self") using 2:3 with points pt 7 ps 1.3 lc rgb "black"
}
