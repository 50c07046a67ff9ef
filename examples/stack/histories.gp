# gnuplot -c histories.gp TIGHT LOOSE PICTURE
# Bolt forces and tilt of the stack from two results folders: all bolts tight, and bolt 6_1 loose. Writes PICTURE (png).
tight = ARG1."/history.csv"
loose = ARG2."/history.csv"

set datafile separator ","
set key autotitle columnhead
set terminal pngcairo size 1100,1000 font "sans,11"
set output ARG3
set multiplot layout 3,1 margins 0.08,0.78,0.06,0.96 spacing 0.08
set grid
set xrange [0:0.06]
set key outside right top

set title "Bolts of the loose interface, between plates 5 and 6"
set ylabel "force z [N]"
plot tight using "time":"bolt6_1.force.z" every ::1 with lines lw 2 lc rgb "#999999" title "all bolts tight", \
     loose using "time":"bolt6_1.force.z" every ::1 with lines lw 2 lc rgb "#c1272d" title "6-1, loose", \
     loose using "time":"bolt6_2.force.z" every ::1 with lines lw 2 lc rgb "#0071bc" title "6-2, next to it", \
     loose using "time":"bolt6_3.force.z" every ::1 with lines lw 2 lc rgb "#e8862e" title "6-3, across", \
     loose using "time":"bolt6_4.force.z" every ::1 with lines lw 2 dt 2 lc rgb "#2e8b57" title "6-4, next to it"

set title "Bolts of the lowest interface: what bends it is the swinging of the plates above the loose one"
plot tight using "time":"bolt1_1.force.z" every ::1 with lines lw 2 lc rgb "#999999" title "all bolts tight", \
     loose using "time":"bolt1_1.force.z" every ::1 with lines lw 2 lc rgb "#c1272d" title "1-1", \
     loose using "time":"bolt1_3.force.z" every ::1 with lines lw 2 lc rgb "#e8862e" title "1-3, across"

set title "Tilt of the plates about x and y, bolt 6-1 loose"
set ylabel "tilt [1e-6 rad]"
set xlabel "time [s]"
tilt(quaternion) = 2e6*quaternion
plot loose using "time":(tilt(column("plate5.quaternion.x"))) every ::1 with lines lw 2 lc rgb "#999999" title "plate 5, about x", \
     loose using "time":(tilt(column("plate6.quaternion.x"))) every ::1 with lines lw 2 lc rgb "#c1272d" title "plate 6, about x", \
     loose using "time":(tilt(column("plate10.quaternion.x"))) every ::1 with lines lw 2 dt 2 lc rgb "#0071bc" title "plate 10, about x", \
     loose using "time":(tilt(column("plate6.quaternion.y"))) every ::1 with lines lw 2 lc rgb "#e8862e" title "plate 6, about y", \
     loose using "time":(tilt(column("plate10.quaternion.y"))) every ::1 with lines lw 2 dt 2 lc rgb "#2e8b57" title "plate 10, about y"
unset multiplot
