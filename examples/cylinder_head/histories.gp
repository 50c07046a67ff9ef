# gnuplot -c histories.gp TIGHT LOOSE PICTURE
# Bolt forces and tilt of the cylinder head from two results folders: all bolts tight, and bolt 1 loose. Writes PICTURE (png).
tight = ARG1."/history.csv"
loose = ARG2."/history.csv"

set datafile separator ","
set key autotitle columnhead
set terminal pngcairo size 1100,1000 font "sans,11"
set output ARG3
set multiplot layout 3,1 margins 0.08,0.80,0.06,0.96 spacing 0.08
set grid
set xrange [5:25]
set key outside right top

set title "Bolts, the first loose"
set ylabel "force [kN]"
plot tight using (1e3*column("time")):(1e-3*column("thread1.force.z")) every ::1 with lines lw 2 lc rgb "#999999" title "all tight", \
     loose using (1e3*column("time")):(1e-3*column("thread1.force.z")) every ::1 with lines lw 2 lc rgb "#c1272d" title "1, loose", \
     loose using (1e3*column("time")):(1e-3*column("thread2.force.z")) every ::1 with lines lw 2 lc rgb "#0071bc" title "2 and 8, next to it", \
     loose using (1e3*column("time")):(1e-3*column("thread3.force.z")) every ::1 with lines lw 2 lc rgb "#2e8b57" title "3 and 7", \
     loose using (1e3*column("time")):(1e-3*column("thread4.force.z")) every ::1 with lines lw 2 dt 2 lc rgb "#2e8b57" title "4 and 6", \
     loose using (1e3*column("time")):(1e-3*column("thread5.force.z")) every ::1 with lines lw 2 lc rgb "#e8862e" title "5, across"

set title "Lift of the head"
set ylabel "[um]"
plot tight using (1e3*column("time")):(1e6*(column("head.position.z") - 0.06)) every ::1 with lines lw 2 lc rgb "#999999" title "all tight", \
     loose using (1e3*column("time")):(1e6*(column("head.position.z") - 0.06)) every ::1 with lines lw 2 lc rgb "#0071bc" title "bolt 1 loose"

set title "Tilt of the head: its edge at the loose bolt is lifted"
set ylabel "[1e-6 rad]"
set xlabel "time [ms]"
plot tight using (1e3*column("time")):(-2e6*column("head.quaternion.y")) every ::1 with lines lw 2 lc rgb "#999999" title "all tight", \
     loose using (1e3*column("time")):(-2e6*column("head.quaternion.y")) every ::1 with lines lw 2 lc rgb "#0071bc" title "bolt 1 loose"
unset multiplot
