# gnuplot -c histories.gp TIGHT LOOSE PICTURE
# Pin force and bolt forces of the pendulum on a bolted bracket from two results folders: all bolts tight, and bolt 1 loose.
# Points are the closed forms of README.md, taken at the angle of the row. Writes PICTURE (png).
tight = ARG1."/history.csv"
loose = ARG2."/history.csv"

theta0 = pi/3
M = 10*9.81                                   # m g
A = 10*0.3*(M*0.3/(10*0.3**2 + 10*(0.6**2 + 0.04**2)/12))      # m d W^2
bracket = 8*9.81
Fx(q) = A*sin(q)*(3*cos(q) - 2*cos(theta0))
Fz(q) = M + A*(3*cos(q)**2 - 1 - 2*cos(q)*cos(theta0))
bolt(q, side) = (bracket + Fz(q))/4 - side*0.15*Fx(q)/(4*0.08)       # side +1: bolts 1 and 4, -1: bolts 2 and 3
shift = -(1 - 0.1)/(1 + 3*0.1)                # of the force of bolt 1 were it tight, loose = 0.1

set datafile separator ","
set key autotitle columnhead
q(angle) = theta0 + angle
set terminal pngcairo size 1100,1000 font "sans,11"
set output ARG3
set multiplot layout 3,1 margins 0.08,0.80,0.06,0.96 spacing 0.08
set grid
set xrange [0:3]
set key outside right top
set ylabel "force [N]"

set title "Pull of the pendulum on the pin, let go at 60 degrees"
plot tight using "time":"pin.force.z" every ::1 with lines lw 2 lc rgb "#0071bc" title "downwards", \
     tight using "time":"pin.force.x" every ::1 with lines lw 2 lc rgb "#e8862e" title "sideways", \
     tight using "time":(Fz(q(column("pin.angle")))) every 40::1 with points pt 6 ps 0.9 lc rgb "black" title "closed form", \
     tight using "time":(Fx(q(column("pin.angle")))) every 40::1 with points pt 6 ps 0.9 lc rgb "black" notitle

set title "Bolts, all tight"
plot tight using "time":"bolt1.force.z" every ::1 with lines lw 2 lc rgb "#c1272d" title "bolts 1, 4", \
     tight using "time":"bolt2.force.z" every ::1 with lines lw 2 lc rgb "#0071bc" title "bolts 2, 3", \
     tight using "time":(bolt(q(column("pin.angle")), 1)) every 40::1 with points pt 6 ps 0.9 lc rgb "black" title "closed form", \
     tight using "time":(bolt(q(column("pin.angle")), -1)) every 40::1 with points pt 6 ps 0.9 lc rgb "black" notitle

set title "Bolts, bolt 1 at a tenth of its stiffness"
set xlabel "time [s]"
s(angle) = shift*bolt(q(angle), 1)
plot loose using "time":"bolt1.force.z" every ::1 with lines lw 2 lc rgb "#c1272d" title "bolt 1, loose", \
     loose using "time":"bolt2.force.z" every ::1 with lines lw 2 lc rgb "#0071bc" title "bolt 2, next to it", \
     loose using "time":"bolt3.force.z" every ::1 with lines lw 2 lc rgb "#e8862e" title "bolt 3, across", \
     loose using "time":"bolt4.force.z" every ::1 with lines lw 2 lc rgb "#2e8b57" title "bolt 4, next to it", \
     loose using "time":(bolt(q(column("pin.angle")), 1) + s(column("pin.angle"))) every 40::1 with points pt 6 ps 0.9 lc rgb "black" title "closed form", \
     loose using "time":(bolt(q(column("pin.angle")), -1) - s(column("pin.angle"))) every 40::1 with points pt 6 ps 0.9 lc rgb "black" notitle, \
     loose using "time":(bolt(q(column("pin.angle")), -1) + s(column("pin.angle"))) every 40::1 with points pt 6 ps 0.9 lc rgb "black" notitle, \
     loose using "time":(bolt(q(column("pin.angle")), 1) - s(column("pin.angle"))) every 40::1 with points pt 6 ps 0.9 lc rgb "black" notitle
unset multiplot
