# gnuplot -c shapes.gp RESULTS SHAPES FREQUENCIES
# From a results folder of `dttmm modes` with its sweep over kh: the first four shapes along the blades, written to SHAPES,
# and the frequencies against the stiffness of the hydraulic spring, written to FREQUENCIES (both png).
shapes = ARG1."/shapes.csv"
places = ARG1."/modes.csv"
sweep = ARG1."/sweep.csv"

set datafile separator ","
set terminal pngcairo size 1100,800 font "sans,11"
set grid
lever = 0.2        # [m] a twist is drawn as what it moves so far from the axis
is_of(mode, part) = column(1) == mode && strstrt(stringcolumn(3), part) == 1
is_end(mode) = column(1) == mode && (stringcolumn(5) eq "tiller.left" || stringcolumn(5) eq "tiller.right")

array frequency[4]
do for [mode=1:4] {
    stats shapes using (column(1) == mode ? column(2) : NaN) every ::2 nooutput
    frequency[mode] = STATS_mean
}
array kind[4] = ["symmetric", "antisymmetric", "symmetric", "antisymmetric"]

set output ARG2
set multiplot layout 2,2 margins 0.07,0.98,0.10,0.94 spacing 0.07,0.13
set xrange [-1.45:2.35]
set yrange [-1.3:1.3]
set xlabel "x [m]"
set key bottom center samplen 2
do for [mode=1:4] {
    set title sprintf("Mode %d, %.2f Hz: %s", mode, frequency[mode], kind[mode])
    if (mode > 1) { unset key }
    plot 0 with lines lw 1 lc rgb "#999999" title "before", \
         for [side=0:1] shapes using 5:(is_of(mode, side ? "blade_right" : "blade_left") ? column(9) : NaN) every ::2 \
             with lines lw 3 lc rgb "#0071bc" title side ? "" : "deflection y of the blades", \
         for [side=0:1] shapes using 5:(is_of(mode, side ? "blade_right" : "blade_left") ? lever*column(11) : NaN) every ::2 \
             with lines lw 2 dt 2 lc rgb "#c1272d" title side ? "" : "twist rx times 0.2 m", \
         for [side=0:1] shapes using 5:(is_of(mode, side ? "shaft_right" : "shaft_left") ? column(9) : NaN) every ::2 \
             with lines lw 2 lc rgb "#333333" title side ? "" : "shafts", \
         for [side=0:1] shapes using 5:(is_of(mode, side ? "shaft_right" : "shaft_left") ? lever*column(11) : NaN) every ::2 \
             with lines lw 1 dt 2 lc rgb "#c1272d" notitle, \
         places using 6:(is_end(mode) ? column(10) : NaN) every ::2 with points pt 5 ps 1 lc rgb "#333333" title "ends of the tiller", \
         places using 6:(is_end(mode) ? lever*column(12) : NaN) every ::2 with points pt 4 ps 1 lc rgb "#c1272d" notitle
}
unset multiplot

set terminal pngcairo size 1100,600 font "sans,11"
set output ARG3
set key outside right top
set title "Natural frequencies against the stiffness of the hydraulic spring"
set xlabel "kh [MN/m]"
set ylabel "frequency [Hz]"
set xrange [0:160]
set yrange [30:175]
array colour[8] = ["#c1272d", "#0071bc", "#e8862e", "#2e8b57", "#7a4fa3", "#999999", "#c2a000", "#333333"]
plot for [k=0:7] sweep using (1e-6*column(2)):(column(10 - k)) every ::2 with linespoints lw 2 pt 7 ps 0.5 lc rgb colour[8 - k] \
    title sprintf("mode %d", 8 - k)
