// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

namespace dttmm::host {

/// A list of numbers. Its copies share one memory until one of them is changed: a large machine has thousands of elements
/// with the same numbers.
class SharedNumbers {
public:
    using value_type = double;
    using const_iterator = std::vector<double>::const_iterator;

    SharedNumbers() = default;
    SharedNumbers(std::vector<double> numbers) : numbers_(std::make_shared<std::vector<double>>(std::move(numbers))) {}
    SharedNumbers(std::initializer_list<double> numbers) : SharedNumbers(std::vector<double>(numbers)) {}

    operator const std::vector<double>&() const { return all(); }
    const_iterator begin() const { return all().begin(); }
    const_iterator end() const { return all().end(); }
    const double* data() const { return all().data(); }
    std::size_t size() const { return all().size(); }
    bool empty() const { return all().empty(); }
    double front() const { return all().front(); }
    double operator[](std::size_t index) const { return all()[index]; }
    bool operator==(const SharedNumbers& other) const { return all() == other.all(); }

    /// Of this copy alone; for as long as it is not copied.
    std::vector<double>& change() {
        if (!numbers_ || numbers_.use_count() > 1) numbers_ = std::make_shared<std::vector<double>>(all());
        return *numbers_;
    }

private:
    const std::vector<double>& all() const {
        static const std::vector<double> none;
        return numbers_ ? *numbers_ : none;
    }

    std::shared_ptr<std::vector<double>> numbers_;
};

}  // namespace dttmm::host
