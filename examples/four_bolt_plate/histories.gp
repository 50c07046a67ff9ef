# gnuplot -c histories.gp ALIKE SOFT PICTURE
# Force and acceleration histories of the four-bolt plate from two results folders: all bolts alike, and bolt 1 softer by a
# fifth. Writes PICTURE (png) and draws the forces in the terminal.
alike = ARG1."/history.csv"
soft  = ARG2."/history.csv"

set datafile separator ","
set key autotitle columnhead
force(n) = sprintf("bolt%d.force.z", n)
acceleration(n) = sprintf("plate.corner%d.acceleration.z", n)

set terminal pngcairo size 1100,800 font "sans,11"
set output ARG3
set multiplot layout 2,1 margins 0.09,0.97,0.08,0.95 spacing 0.1
set grid
set xrange [0:0.15]
set key bottom right

set title "Force of each bolt, 1000 N on the plate"
set ylabel "force z [N]"
set yrange [0:300]
plot alike using "time":force(1) every ::1 with lines lw 2 lc rgb "#999999" title "all bolts alike", \
     soft using "time":force(1) every ::1 with lines lw 2 lc rgb "#c1272d" title "bolt 1, 20 % softer", \
     soft using "time":force(2) every ::1 with lines lw 2 lc rgb "#0071bc" title "bolt 2, next to it", \
     soft using "time":force(3) every ::1 with lines lw 2 lc rgb "#e8862e" title "bolt 3, across", \
     soft using "time":force(4) every ::1 with lines lw 2 dt 2 lc rgb "#2e8b57" title "bolt 4, next to it"

set key top right
set title "Acceleration of the plate's corners"
set xlabel "time [s]"
set ylabel "acceleration z [m/s^2]"
set autoscale y
plot alike using "time":acceleration(1) every ::1 with lines lw 2 lc rgb "#999999" title "all bolts alike", \
     soft using "time":acceleration(1) every ::1 with lines lw 1.5 lc rgb "#c1272d" title "corner 1", \
     soft using "time":acceleration(2) every ::1 with lines lw 1.5 lc rgb "#0071bc" title "corner 2", \
     soft using "time":acceleration(3) every ::1 with lines lw 1.5 lc rgb "#e8862e" title "corner 3", \
     soft using "time":acceleration(4) every ::1 with lines lw 1.5 dt 2 lc rgb "#2e8b57" title "corner 4"
unset multiplot
unset output

set terminal dumb size 100,24 noenhanced
set title "Force of the bolts [N], bolt 1 softer by 20 %"
set xlabel "time [s]"
set xrange [0:0.1]
set yrange [0:300]
unset ylabel
set key bottom right
plot soft using "time":force(1) every ::1 with lines title "bolt 1 (soft)", \
     soft using "time":force(2) every ::1 with lines title "bolt 2"
