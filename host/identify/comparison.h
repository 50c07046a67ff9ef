// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "analysis/request.h"
#include "identify/mode_pairs.h"
#include "identify/observations.h"
#include "identify/unknowns.h"
#include "loader/plugins.h"

namespace dttmm::host {

/// Data that have one noise: a channel, all frequencies, all shapes, the response of a channel to an input.
struct DataGroup {
    enum class Kind : unsigned char { history, response, frequency, shape };
    Kind kind;
    std::string name;
    Eigen::Index first = 0, count = 0;  ///< rows
    double largest = 0;                 ///< value
    double noise = 0;                   ///< standard deviation that counts; where deviations differ 1: see Comparison
    size_t noise_samples = 0;           ///< that it was estimated from; 0: it is known
    enum class NoiseFrom : unsigned char { user, data, residuals, assumed } noise_from = NoiseFrom::residuals;
};

/// Distance of the two points of a central difference from their middle, in a coordinate: noise of an iterated step ruins
/// smaller ones.
inline constexpr double kDifference = 0.01;
/// Least standard deviation of data, share of their largest value: of data that the model made itself rounding is left.
inline constexpr double kLeastNoise = 1e-9;

class Comparison;

/// A short window as long as it lives.
class ShortWindow {
public:
    ShortWindow(Comparison& comparison, double share);
    ~ShortWindow();
    ShortWindow(const ShortWindow&) = delete;
    ShortWindow& operator=(const ShortWindow&) = delete;

private:
    Comparison& comparison_;
};

/// Measured data beside what a model with given unknowns predicts of them. Rows of data: samples of histories, real and
/// imaginary parts of responses (real parts alone where the file has no other), logarithms of frequencies, components of
/// shapes.
class Comparison {
public:
    /// All must outlive it. Throws Error for a model that cannot be worked on.
    Comparison(const Request& request, const Observations& observations, const Plugins& plugins);

    Eigen::Index rows() const { return data_.size(); }
    /// Numbers that are fitted beside the unknowns: the scale of every shape, sine and cosine of the hum of every channel.
    Eigen::Index scales() const { return scales_; }
    const Eigen::VectorXd& data() const { return data_; }
    std::vector<DataGroup>& groups() { return groups_; }
    const std::vector<DataGroup>& groups() const { return groups_; }
    /// Of every row: the noise of its group, times what coherence or repeats say.
    Eigen::VectorXd deviations() const;
    /// What the model predicts where residuals (not logarithmic) are those.
    Eigen::VectorXd predicted_of(const Eigen::VectorXd& residual) const {
        return data_ + residual.cwiseProduct(deviations());
    }
    /// Of groups whose noise nobody gave: from what is left of their data. unknowns: numbers that were fitted.
    void estimate_noise(const Eigen::VectorXd& predicted, size_t unknowns);
    /// Rows that count: of histories those up to this share of their duration.
    void set_window(double share) { window_ = share; }
    double window() const { return window_; }
    /// Of the rows of a group, those within the window, which stand first.
    Eigen::Index counted(const DataGroup& group) const;

    /// What the model predicts; rows beyond the window are the data. Throws Error where the model has no answer.
    Eigen::VectorXd predict(const Unknowns& unknowns, const Eigen::VectorXd& x) const { return predict(unknowns, x, 1); }
    /// At the time step divided by `finer`.
    Eigen::VectorXd predict(const Unknowns& unknowns, const Eigen::VectorXd& x, int finer) const;
    /// (predicted − data)/deviation. are_logarithmic: of responses logarithms of the ratio, real and imaginary part, per
    /// relative deviation: from far away they lead to the minimum where the difference does not.
    Eigen::VectorXd residual(const Eigen::VectorXd& predicted, bool are_logarithmic) const;

    bool has_histories() const { return !observations_.histories.empty(); }
    bool has_responses() const { return !observations_.responses.empty(); }
    bool has_modes() const { return !observations_.modes.empty(); }
    double time_step() const { return step_; }
    /// The mode of the model that each measured one is.
    std::vector<ModePair> pairs(const Unknowns& unknowns, const Eigen::VectorXd& x) const;

private:
    Model read(const Unknowns& unknowns, const Eigen::VectorXd& x, Purpose purpose) const;
    void predict_histories(Model model, const MeasurementFactors& factors, int finer, Eigen::VectorXd& out) const;
    void predict_responses(const Model& model, const MeasurementFactors& factors, Eigen::VectorXd& out) const;
    std::vector<ModePair> predict_modes(const Model& model, const MeasurementFactors& factors, Eigen::VectorXd& out) const;
    void choose_step();

    const Request& request_;
    const Observations& observations_;
    const Plugins& plugins_;
    std::vector<DataGroup> groups_;
    Eigen::VectorXd data_, weights_;
    Eigen::Index scales_ = 0;
    double window_ = 1, step_ = 0, duration_ = 0;
};

}  // namespace dttmm::host
