# gnuplot -c histories.gp UNDAMPED DAMPED PICTURE
# Ends of the struck tube from two results folders: without damping, and with --set damping=0.1ms. Black: a rigid tube.
# Writes PICTURE (png).
undamped = ARG1."/history.csv"
damped = ARG2."/history.csv"

S = 0.5e3*1e-3
m = 7800*pi/4*(0.05**2 - 0.03**2)*1.2
J = m*1.2**2/12 + 7800*pi/64*(0.05**4 - 0.03**4)*1.2
end(t, side) = 1e3*(S/m*(t - 0.5e-3) + side*0.6*sin(S*0.6/J*(t - 0.5e-3)))      # [mm]; side +1: left

set datafile separator ","
set key autotitle columnhead
set terminal pngcairo size 1100,750 font "sans,11"
set output ARG3
set multiplot layout 2,1 margins 0.08,0.80,0.09,0.95 spacing 0.11
set grid
set key outside right top

set title "Ends of the tube, struck at the left one"
set ylabel "displacement [mm]"
set xrange [0:50]
plot undamped using (1e3*column("time")):(1e3*column("left.position.z")) every ::1 with lines lw 2 lc rgb "#0071bc" title "left", \
     undamped using (1e3*column("time")):(1e3*column("right.position.z")) every ::1 with lines lw 2 lc rgb "#e8862e" title "right", \
     undamped using (1e3*column("time")):(end(column("time"), 1)) every 250::250 with points pt 6 ps 0.9 lc rgb "black" title "rigid tube", \
     undamped using (1e3*column("time")):(end(column("time"), -1)) every 250::250 with points pt 6 ps 0.9 lc rgb "black" notitle

set title "Velocity of the right end"
set ylabel "[m/s]"
set xlabel "time [ms]"
set xrange [0:30]
plot undamped using (1e3*column("time")):(column("right.velocity.z")) every ::1 with lines lw 1 lc rgb "#e8862e" title "undamped", \
     damped using (1e3*column("time")):(column("right.velocity.z")) every ::1 with lines lw 2 lc rgb "#c1272d" title "damping 0.1 ms"
unset multiplot
