// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "model/index.h"
#include "record/channels.h"
#include "record/column.h"
#include "record/csv_writer.h"
#include "record/hdf5_writer.h"
#include "record/results_folder.h"

namespace dttmm::host {

/// What one channel did over all closed rows, in the channel's unit; all zero before the first row.
struct ChannelStatistics {
    double peak = 0;       ///< largest magnitude
    double peak_time = 0;  ///< of its first occurrence [s]
    double minimum = 0;
    double maximum = 0;
    double final = 0;  ///< in the last row
    // Of forces [N] and accelerations [m/s^2] that are recorded by default; else zero:
    /// Largest amplitude at which it alternated from row to row, as a mean over some ten rows: a vibration near half the
    /// rate of rows.
    double ripple = 0;
    double ripple_final = 0;  ///< the same at the end
    /// Second difference of the rows at the peak; zero if that is the first row or the last. A vibration whose peak stands
    /// there is larger between rows by up to an eighth of it.
    double bend = 0;
};

/// Takes one row of numbers per output time: the selected channels go to history.csv and history.h5, and of some
/// channels, selected or not, statistics are kept. Or takes rows of the selected channels alone, and perhaps an estimate of
/// the error of each value: history.h5 then has a second dataset for every channel but the time, `<channel>.error`, of the
/// same unit. Nothing is allocated per row. Destroyed without finish(), it leaves history.csv with all rows closed so far
/// and no history.h5.
class Recorder {
public:
    enum class Rows : unsigned char { plain, estimated };
    /// What statistics() tells of a channel: nothing; all but minimum and maximum, which are zero; or all.
    enum class Counts : unsigned char { nothing, peak, extremes };
    using CountsOf = Counts (*)(const Channel&);
    static Counts of_every_channel(const Channel&) { return Counts::extremes; }

    /// all: outlive the recorder; selection: indices into them as select_channels gives them; rows: which of the two ways
    /// they come. Throws Error(input_output), or Error(internal_error) for selected channels that check_columns refuses.
    Recorder(const ResultsFolder& folder, std::span<const Channel> all, std::vector<int> selection,
             const Attributes& attributes, Rows rows = Rows::plain, CountsOf counts_of = of_every_channel);
    /// Statistics only: nothing is written.
    explicit Recorder(std::span<const Channel> all, CountsOf counts_of = of_every_channel);

    /// values: one per channel of `all`; the first is the time [s]. Throws Error(internal_error) that names a channel whose
    /// value is not finite; the row is then neither written nor counted. Throws Error(input_output) when it cannot be
    /// written.
    void close_row(std::span<const double> values);
    /// A row of the selected channels, the time among them, and for estimated rows as many errors, else none. Throws as
    /// close_row does.
    void close_selected_row(std::span<const double> values, std::span<const double> errors);
    /// The statistics of all channels that are not selected, from a recorder that keeps those of the same channels.
    void adopt_unselected(const Recorder& other);
    /// Brings history.csv to the disk and publishes history.h5; the last call. Throws Error(input_output).
    void finish();

    std::span<const Channel> channels() const { return channels_; }
    /// channel: index into channels(). Throws Error(internal_error) for one of which none are kept.
    ChannelStatistics statistics(int channel) const;
    /// Number of rows closed.
    long rows() const { return rows_; }

private:
    /// One kind of number of all these channels stands together, so that a row is counted several at a time.
    struct Statistics {
        Statistics() = default;
        Statistics(Eigen::Index count, Eigen::Index extremes) {
            for (Eigen::ArrayXd* numbers : {&peak, &peak_time, &final}) numbers->setZero(count);
            for (Eigen::ArrayXd* numbers : {&minimum, &maximum}) numbers->setZero(extremes);
        }
        Eigen::ArrayXd peak, peak_time, final;
        Eigen::ArrayXd minimum, maximum;  ///< of those in extremes_
    };
    /// More of a force or acceleration. Seven digits are enough for what a warning compares with a share of the peak.
    struct Alternation {
        float ripple = 0, bend = 0;
        float change = 0;  ///< in the last row
        float mean = 0;    ///< mean amplitude at which the last rows alternated
    };

    void check_finite(int channel, double value, double time) const;
    void find_counted(CountsOf counts_of);
    int find_statistics(int channel) const;
    int find_extremes(int counted) const;
    bool alternates(int counted) const { return as_size(counted) < alternations_.size(); }
    void count_alternation(int counted, double value);
    template <class ValueOf>
    void count(int first, int end, const ValueOf& value_of, double time);

    std::span<const Channel> channels_;
    /// The channels that have statistics: first those of alternations_, then the others; both ascending.
    std::vector<int> counted_;
    std::vector<int> extremes_;  ///< indices into counted_ of those with minimum and maximum, ascending
    Statistics statistics_;
    std::vector<Alternation> alternations_;
    long rows_ = 0;

    std::vector<int> selection_;
    std::vector<int> selected_counted_;    ///< index into counted_ of each; −1: it has none
    std::vector<double> selected_values_;  ///< of a row, then their errors
    std::optional<CsvWriter> csv_;
    std::optional<Hdf5Writer> hdf5_;
};

}  // namespace dttmm::host
