// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace dttmm::host {

/// Beyond this share of half the rate of rows a vibration may be a faster one that the rows fold back: no filter stands
/// before them, and a run shows whatever the machine does.
inline constexpr double kEndOfBand = 0.9;
/// Of fewer periods in a window a lobe of Hann's window, two bins to either side, meets its image at the negative frequency.
inline constexpr double kFewPeriods = 3;

/// How the ends of a window of time are faded.
enum class Taper : unsigned char { rectangular, hann, flattop };

/// By its name. Throws Error(usage).
Taper parse_taper(const std::string& name);
const char* taper_name(Taper taper);

/// The samples of a taper, periodic in `size`: Hann 0.5 - 0.5 cos; flat top: five cosines.
/// Source: D'Antona and Ferrero (2006), Digital Signal Processing for Measurement Systems, 72-79.
std::vector<double> taper_samples(Taper taper, std::size_t size);

/// Levels of a series over its window. The deviation is the RMS about the mean.
struct Levels {
    double rms = 0, deviation = 0, mean = 0, peak = 0;
    std::size_t peak_at = 0;  ///< its index
    bool is_constant = true;
};
Levels levels_of(const std::vector<double>& x);

/// Spectra of one channel over k/(size interval), k = 0 .. size/2.
struct Spectrum {
    std::vector<double> amplitude;  ///< of a sine at the bin, in the unit of the channel
    std::vector<double> phase;      ///< [deg] of amplitude cos(2 pi f t + phase); empty where segments are averaged
    std::vector<double> density;    ///< one-sided, unit^2/Hz; its sum times the resolution is the mean square
};

/// The mean of the whole window is taken off first. Segments of `size` samples overlap by half and are averaged by power
/// (Welch 1967, IEEE Trans. Audio Electroacoust. 15(2), 70-73). start: time of the first sample [s], for the phase.
Spectrum spectrum_of(const std::vector<double>& x, double interval, double start, Taper taper, std::size_t size);

/// Samples per segment for so many of them with half overlap; and the reverse.
std::size_t segment_size(std::size_t samples, std::size_t segments);
std::size_t segment_count(std::size_t samples, std::size_t size);

/// A maximum of the amplitude, between bins.
struct Peak {
    std::size_t bin = 0;
    double frequency = 0, amplitude = 0;
};

/// The largest maxima, largest first, of those at least a share `least` of the largest. The two largest bins of a lobe give
/// the place and height of a lone sine (Grandke 1983, IEEE Trans. Instrum. Meas. 32(2), 350-355); a flat top needs no such
/// help.
std::vector<Peak> peaks_of(const std::vector<double>& amplitude, double resolution, Taper taper, std::size_t most,
                           double least);

}  // namespace dttmm::host
