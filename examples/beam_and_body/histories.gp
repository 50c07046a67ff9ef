# gnuplot -c histories.gp RESULTS PICTURE
# Tip of the beam from a results folder; points are the sum of the exact modes in README.md. Writes PICTURE (png).
history = ARG1."/history.csv"

# modes: w [rad/s], r [1/kg]
w1 = 111.376257;  r1 = 0.127184584
w2 = 878.918098;  r2 = 0.0285973066
w3 = 2591.35698;  r3 = 0.011010426
w4 = 5069.76993;  r4 = 0.00397087026
tip(t) = 100*(r1/w1**2*(1 - cos(w1*t)) + r2/w2**2*(1 - cos(w2*t)) + r3/w3**2*(1 - cos(w3*t)) + r4/w4**2*(1 - cos(w4*t)))

set datafile separator ","
set key autotitle columnhead
set terminal pngcairo size 1100,750 font "sans,11"
set output ARG2
set multiplot layout 2,1 margins 0.08,0.82,0.09,0.95 spacing 0.10
set grid
set xrange [0:0.2]
set key outside right top

set title "Displacement of the body, pushed by 100 N from t = 0 on"
set ylabel "[mm]"
plot history using "time":(1e3*column("body.position.z")) every ::1 with lines lw 2 lc rgb "#0071bc" title "run", \
     history using "time":(1e3*tip(column("time"))) every 10::1 with points pt 6 ps 0.9 lc rgb "black" title "exact"

set title "Moment of the beam at its root"
set ylabel "[N m]"
set xlabel "time [s]"
plot history using "time":(-column("tube.moment.y")) every ::1 with lines lw 1 lc rgb "#c1272d" title "run"
unset multiplot
