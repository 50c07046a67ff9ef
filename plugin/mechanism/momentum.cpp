// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/momentum.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/rotation.h"
#include "core/six.h"

namespace dttmm::plugin {

namespace {

template <class Real>
using Vector6Of = Eigen::Matrix<Real, 6, 1>;

[[gnu::always_inline]] inline Vector6Of<Lanes> gather_vectors(const Vector6* v) {
    Vector6Of<Lanes> four;
    gather<6>({v[0].data(), v[1].data(), v[2].data(), v[3].data()}, four.data());
    return four;
}

template <class Real>
[[gnu::always_inline]] inline Vector6Of<Real> imbalance(double h, const Vector3& gravity, const InertiaOf<Real>& inertia,
                                                        const Vector6Of<Real>& momentum, const FrameOf<Real>& now,
                                                        const Vector6Of<Real>& wrench, const Vector6Of<Real>& u) {
    const Real step = h, half_step = 0.5 * h;
    const Vector3Of<Real> g(gravity.x(), gravity.y(), gravity.z()), v = u.template head<3>(), w = u.template tail<3>();
    const Vector3Of<Real> p = momentum.template head<3>() + step * (wrench.template head<3>() + inertia.mass * g);
    const Vector3Of<Real> L = momentum.template tail<3>() + step * wrench.template tail<3>();
    Vector6Of<Real> r;
    r.template head<3>() = now.axes().transpose() * p - inertia.mass * v;
    r.template tail<3>() = now.axes().transpose() * L - turned<Real>(half_step * w, inertia.moment * w);
    return r;
}

/// Moves the momentum on; returns the velocity, world axes.
template <class Real>
[[gnu::always_inline]] inline Vector6Of<Real> move_momentum(double h, const Vector3& gravity, const Real& mass,
                                                            const FrameOf<Real>& now, const Vector6Of<Real>& wrench,
                                                            const Vector6Of<Real>& u, Vector6Of<Real>& momentum) {
    const Real step = h;
    const Vector3Of<Real> g(gravity.x(), gravity.y(), gravity.z());
    Vector6Of<Real> velocity;
    velocity.template head<3>() = now.axes() * u.template head<3>();
    velocity.template tail<3>() = now.axes() * u.template tail<3>();
    const Vector3Of<Real> p = momentum.template head<3>() + step * (wrench.template head<3>() + mass * g);
    // The motion follows the momentum up to what the passes have left over; angular momentum does not mind
    const Vector3Of<Real> v = velocity.template head<3>();
    momentum.template tail<3>() += step * (wrench.template tail<3>() - cross<Real>(v, p));
    momentum.template head<3>() = p;
    return velocity;
}

}  // namespace

DTTMM_WIDE void find_imbalance(double h, const Vector3& gravity, std::span<const Inertia> inertias,
                               std::span<const Vector6> momenta, std::span<const Frame> now,
                               std::span<const Vector6> wrenches, std::span<const Vector6> u, std::span<Vector6> r) {
    const size_t n = inertias.size();
    assert(momenta.size() == n && now.size() == n && wrenches.size() == n && u.size() == n && r.size() == n);
    size_t i = 0;
    for (; i + Lanes::kCount <= n; i += Lanes::kCount) {
        const auto inertia = gather_records<InertiaOf>([&](size_t k) -> auto& { return inertias[i + k]; });
        const auto frame = gather_records<FrameOf>([&](size_t k) -> auto& { return now[i + k]; });
        const Vector6Of<Lanes> four = imbalance<Lanes>(h, gravity, inertia, gather_vectors(&momenta[i]), frame,
                                                       gather_vectors(&wrenches[i]), gather_vectors(&u[i]));
        scatter<6>(four.data(), {r[i].data(), r[i + 1].data(), r[i + 2].data(), r[i + 3].data()});
    }
    for (; i < n; ++i) r[i] = imbalance<double>(h, gravity, inertias[i], momenta[i], now[i], wrenches[i], u[i]);
}

DTTMM_WIDE void take_step(double h, const Vector3& gravity, std::span<const Inertia> inertias, std::span<const Frame> now,
                          std::span<const Vector6> wrenches, std::span<const Vector6> u, std::span<Vector6> momenta,
                          std::span<Twist> velocities) {
    const size_t n = inertias.size();
    assert(now.size() == n && wrenches.size() == n && u.size() == n && momenta.size() == n && velocities.size() == n);
    const auto velocity = [&](size_t i) { return reinterpret_cast<double*>(&velocities[i]); };
    size_t i = 0;
    for (; i + Lanes::kCount <= n; i += Lanes::kCount) {
        const Lanes mass(Lanes::Values{inertias[i].mass, inertias[i + 1].mass, inertias[i + 2].mass, inertias[i + 3].mass});
        const auto frame = gather_records<FrameOf>([&](size_t k) -> auto& { return now[i + k]; });
        Vector6Of<Lanes> momentum = gather_vectors(&momenta[i]);
        const Vector6Of<Lanes> four =
            move_momentum<Lanes>(h, gravity, mass, frame, gather_vectors(&wrenches[i]), gather_vectors(&u[i]), momentum);
        scatter<6>(momentum.data(),
                   {momenta[i].data(), momenta[i + 1].data(), momenta[i + 2].data(), momenta[i + 3].data()});
        scatter<6>(four.data(), {velocity(i), velocity(i + 1), velocity(i + 2), velocity(i + 3)});
    }
    for (; i < n; ++i)
        Eigen::Map<Vector6>{velocity(i)} =
            move_momentum<double>(h, gravity, inertias[i].mass, now[i], wrenches[i], u[i], momenta[i]);
}

DTTMM_WIDE double largest_size(std::span<const Vector6> vectors, std::span<const double> weights) {
    assert(weights.size() == vectors.size());
    double largest = 0, poison = 0;  // the latter 0, or not a number
    for (size_t i = 0; i < vectors.size(); ++i) {
        const Six v(vectors[i].data()), squared = v * v;
        const Lanes& a = squared.head;
        const double turning = a[3] + (squared.tail[0] + squared.tail[1]);
        const double size = a[0] + a[1] + a[2] + weights[i] * turning;
        largest = std::max(largest, size);
        poison += 0 * size;
    }
    return std::sqrt(largest + poison);
}

DTTMM_WIDE void add_changes(std::span<const Vector6> u, std::span<const Vector6> corrections,
                            std::span<const double> responses, std::span<const double> change, std::span<Vector6> sum) {
    assert(corrections.size() == u.size() && sum.size() == u.size());
    assert(change.empty() || responses.size() == 6 * change.size() * u.size());
    const double* response = responses.data();
    for (size_t i = 0; i < u.size(); ++i) {
        Six moved = Six(u[i].data()) + Six(corrections[i].data());
        for (size_t port = 0; port < change.size(); port += 6, response += 36)
            moved = moved + product(response, &change[port]);
        moved.store(sum[i].data());
    }
}

}  // namespace dttmm::plugin
