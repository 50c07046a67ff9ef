// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

namespace dttmm {

/// A scalar against time, e.g. the magnitude of a load [N or N m] against t [s]. Immutable and cheap to copy.
class Signal {
public:
    class Shape {
    public:
        virtual ~Shape() = default;
        virtual double value(double time) const = 0;
    };

    explicit Signal(std::shared_ptr<const Shape> shape = nullptr) : shape_(std::move(shape)) {}

    /// Value at `time` [s]; zero where no shape was given. Never allocates. May be non-finite only for an expression.
    double value(double time) const { return shape_ ? shape_->value(time) : 0.0; }

private:
    std::shared_ptr<const Shape> shape_;
};

}  // namespace dttmm
