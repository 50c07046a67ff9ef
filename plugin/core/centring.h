// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <type_traits>

namespace dttmm::plugin {

/// Memory of an object as numbers; of a type with kStaysOwn, counters and scales, none.
template <class T>
auto numbers_of(std::span<T> piece) {
    using Number = std::conditional_t<std::is_const_v<T>, const double, double>;
    if constexpr (std::is_integral_v<std::remove_const_t<T>> || requires { T::kStaysOwn; })
        return std::span<Number>();
    else {
        static_assert(sizeof(T) % sizeof(double) == 0);
        return std::span<Number>(reinterpret_cast<Number*>(piece.data()), piece.size_bytes() / sizeof(double));
    }
}

/// The memory of three objects of one kind. show(visit) shows that of an object, piece by piece, as spans.
class Centring {
public:
    template <class Above, class Below, class Middle>
    Centring(const Above& show_above, const Below& show_below, const Middle& show_middle)
        : above_(show_above), below_(show_below), middle_(show_middle) {}

    /// Whether they have as many pieces, of as many numbers.
    bool is_possible() const { return above_.has_sizes_of(below_) && above_.has_sizes_of(middle_); }
    /// Sets those on either side to the middle plus and minus half of their difference: see dttmm_derivative.h. Matrices of
    /// rotations are combined like other numbers: what they then lack in length is of the second order in the difference,
    /// and alike on both sides.
    void centre() {
        for (size_t p = 0; p < middle_.count; ++p)
            for (size_t i = 0; i < middle_.pieces[p].size(); ++i) {
                const double half = 0.5 * (above_.pieces[p][i] - below_.pieces[p][i]);
                above_.pieces[p][i] = middle_.pieces[p][i] + half;
                below_.pieces[p][i] = middle_.pieces[p][i] - half;
            }
    }

private:
    template <class Number>
    struct Pieces {
        template <class Show>
        explicit Pieces(const Show& show) {
            show([&](auto piece) { pieces.at(count++) = numbers_of(piece); });
        }
        template <class Other>
        bool has_sizes_of(const Pieces<Other>& other) const {
            bool are_alike = count == other.count;
            for (size_t p = 0; are_alike && p < count; ++p) are_alike = pieces[p].size() == other.pieces[p].size();
            return are_alike;
        }
        static constexpr size_t kMost = 32;  // of a Network 22
        std::array<std::span<Number>, kMost> pieces;
        size_t count = 0;
    };
    Pieces<double> above_, below_;
    Pieces<const double> middle_;
};

}  // namespace dttmm::plugin
