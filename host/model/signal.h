// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <memory>

namespace dttmm {

/// A scalar against time, e.g. the magnitude of a load [N or N m] against t [s]. Immutable and cheap to copy.
class Signal {
public:
    class Shape {
    public:
        virtual ~Shape() = default;
        virtual double value(double time) const = 0;
        /// The shortest wave or pulse in it [s]; infinite where nothing repeats or returns.
        virtual double shortest_time() const { return std::numeric_limits<double>::infinity(); }
    };

    explicit Signal(std::shared_ptr<const Shape> shape = nullptr) : shape_(std::move(shape)) {}

    /// Value at `time` [s]; zero where no shape was given. Never allocates. May be non-finite only for an expression.
    double value(double time) const { return shape_ ? shape_->value(time) : 0.0; }

    double shortest_time() const { return shape_ ? shape_->shortest_time() : std::numeric_limits<double>::infinity(); }

private:
    std::shared_ptr<const Shape> shape_;
};

}  // namespace dttmm
