# gnuplot -c histories.gp RESULTS PICTURE
# Muzzle, mount and recoil of the gun from a results folder. Grey bars are the shots. Writes PICTURE (png).
history = ARG1."/history.csv"

set datafile separator ","
set key autotitle columnhead
set terminal pngcairo size 1100,1250 font "sans,11"
set output ARG2
set multiplot layout 4,1 margins 0.08,0.82,0.05,0.97 spacing 0.06
set grid
set xrange [0:0.5]
set key outside right top
do for [shot = 0:2] {
    set object shot + 1 rectangle from 0.010 + 0.1*shot, graph 0 to 0.013 + 0.1*shot, graph 1 fc rgb "#cccccc" fs solid noborder behind
}

set title "Muzzle: displacement"
set ylabel "[mm]"
plot history using "time":(1e3*column("muzzle.position.z")) every ::1 with lines lw 2 lc rgb "#0071bc" title "upwards", \
     history using "time":(1e3*(column("muzzle.position.x") - 1.45)) every ::1 with lines lw 2 lc rgb "#e8862e" title "forwards"

set title "Muzzle: velocity upwards and elevation"
set ylabel "[m/s], [10 mrad]"
plot history using "time":"muzzle.velocity.z" every ::1 with lines lw 2 lc rgb "#0071bc" title "velocity", \
     history using "time":(-1e2*column("muzzle.rotation.y")) every ::1 with lines lw 2 lc rgb "#c1272d" title "elevation"

set title "Forces along the barrel"
set ylabel "[kN]"
plot history using "time":(1e-3*column("mount.force.x")) every ::1 with lines lw 2 lc rgb "#0071bc" title "mount", \
     history using "time":(1e-3*column("recoil_spring.force.x")) every ::1 with lines lw 2 lc rgb "#c1272d" title "recoil spring", \
     history using "time":(column("mount.moment.y")/1e3) every ::1 with lines lw 1 lc rgb "#2e8b57" title "its moment [kN m]"

set title "Travel of the breechblock"
set ylabel "[mm]"
set xlabel "time [s]"
plot history using "time":(1e3*column("slide.travel")) every ::1 with lines lw 2 lc rgb "#333333" title "travel"
unset multiplot
