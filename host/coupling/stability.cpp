// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/stability.h"

#include <Eigen/LU>
#include <cmath>

#include "world/block_matrix.h"

namespace dttmm {

namespace {

/// y = M⁻¹ y, block by block in the matrix's order.
class InverseInertia {
public:
    InverseInertia(const Model& model, const BlockMatrix& order, const std::vector<BodyState>& at) {
        for (size_t b = 0; b < model.bodies.size(); ++b) {
            const Body& body = model.bodies[b];
            const Eigen::Matrix3d I = at[b].rotation * body.inertia * at[b].rotation.transpose();
            parts_.push_back({order.index(static_cast<int>(b)), 1 / body.mass, I.inverse()});
        }
    }
    void apply(Eigen::VectorXd& y) const {
        for (const Part& part : parts_) {
            y.segment<3>(part.index) *= part.inverse_mass;
            y.segment<3>(part.index + 3) = (part.inverse_inertia * y.segment<3>(part.index + 3)).eval();
        }
    }

private:
    struct Part {
        int index;
        double inverse_mass;
        Eigen::Matrix3d inverse_inertia;
    };
    std::vector<Part> parts_;
};

}  // namespace

FastestMode find_fastest_mode(const Model& model, Networks& networks, const std::vector<BodyState>& at) {
    BlockMatrix K(static_cast<int>(model.bodies.size()), networks.neighbours());
    std::vector<double> wrenches(6 * model.bodies.size());
    const Networks::StiffnessSink add = [&](int row, int column, const BlockMatrix::Block& S) { K.add(row, column, S); };
    networks.linearise(at, wrenches.data(), &add);
    const InverseInertia inverse_inertia(model, K, at);

    // u ← M⁻¹ K u; uᵀ K M⁻¹ K u / uᵀ K u bounds ω² from below and converges twice as fast as u
    const Eigen::Index n = K.upper().rows();
    Eigen::VectorXd u(n), Ku(n);
    for (Eigen::Index i = 0; i < n; ++i)
        u(i) = std::cos(1.0 + 0.7 * static_cast<double>(i) * static_cast<double>(i));  // no symmetry
    double omega_squared = 0;
    for (int iteration = 0; iteration < 500; ++iteration) {
        Ku = K.upper().selfadjointView<Eigen::Upper>() * u;
        const double energy = u.dot(Ku);
        if (!(energy > 0)) break;
        u = Ku;
        inverse_inertia.apply(u);
        const double next = u.dot(Ku) / energy;
        u /= u.cwiseAbs().maxCoeff();
        const bool converged = std::abs(next - omega_squared) <= 1e-7 * next;
        omega_squared = next;
        if (converged) break;
    }

    FastestMode fastest;
    fastest.omega = std::sqrt(omega_squared);
    double most = -1;
    for (size_t b = 0; b < model.bodies.size() && omega_squared > 0; ++b) {
        const auto part = u.segment<6>(K.index(static_cast<int>(b)));
        const Eigen::Vector3d w = at[b].rotation.transpose() * part.tail<3>();
        const double energy = model.bodies[b].mass * part.head<3>().squaredNorm() + w.dot(model.bodies[b].inertia * w);
        if (energy > most) {
            most = energy;
            fastest.body = model.bodies[b].name;
        }
    }
    return fastest;
}

}  // namespace dttmm
