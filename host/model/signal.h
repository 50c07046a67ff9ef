// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <vector>

namespace dttmm::host {

/// A vibration that a signal contains, or that stands for its fastest change.
struct SignalPart {
    double frequency = 0;  ///< [Hz]
    double share = 0;      ///< its amplitude over the largest amplitude, or over the peak, of the signal
};

/// A scalar against time, e.g. the magnitude of a load [N or N m] against t [s]. Immutable and cheap to copy.
class Signal {
public:
    class Shape {
    public:
        virtual ~Shape() = default;
        virtual double value(double time) const = 0;
        /// Its parts, where they are known in closed form: none of a signal that does not change.
        virtual std::optional<std::vector<SignalPart>> parts() const { return std::nullopt; }
    };

    explicit Signal(std::shared_ptr<const Shape> shape = nullptr) : shape_(std::move(shape)) {}

    /// Value at `time` [s]; zero where no shape was given. Never allocates. May be non-finite only for an expression.
    double value(double time) const { return shape_ ? shape_->value(time) : 0.0; }

    std::optional<std::vector<SignalPart>> parts() const { return shape_ ? shape_->parts() : std::vector<SignalPart>(); }

    /// Its shape where that is a `Which`; null: it is another.
    template <class Which>
    const Which* as() const {
        return dynamic_cast<const Which*>(shape_.get());
    }

private:
    std::shared_ptr<const Shape> shape_;
};

}  // namespace dttmm::host
