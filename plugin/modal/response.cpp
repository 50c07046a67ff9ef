// SPDX-License-Identifier: BSD-3-Clause
#include "modal/response.h"

#include <fmt/format.h>

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <cmath>

#include "core/error.h"

namespace dttmm::plugin {

namespace {

using Frequency = std::complex<double>;
using Block = Eigen::Matrix<Frequency, 6, 6>;
using Sparse = Eigen::SparseMatrix<Frequency>;

/// K + iω C − ω² M, 6 rows per frame, and the rows of rigid directions behind it, entry by entry.
class Entries {
public:
    explicit Entries(int frames) : row_(6 * frames) {}

    void add(int row, int column, const Block& block) {
        if (row < 0 || column < 0) return;
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j)
                if (block(i, j) != 0.0) entries_.emplace_back(6 * row + i, 6 * column + j, block(i, j));
    }
    void join(const Joined& at, const Block& start, const Block& across, const Block& end) {
        add(at.from, at.from, at.by_from.transpose() * start * at.by_from);
        add(at.to, at.to, at.by_to.transpose() * end * at.by_to);
        const Block between = at.by_from.transpose() * across * at.by_to;
        add(at.from, at.to, between);
        add(at.to, at.from, between.transpose());
        for (const Rigid& rigid : at.rigid) {
            for (const auto& [f, by] : {std::pair(at.from, &rigid.by_from), {at.to, &rigid.by_to}})
                for (int i = 0; f >= 0 && i < 6; ++i) {
                    if ((*by)(i) == 0) continue;
                    entries_.emplace_back(row_, 6 * f + i, (*by)(i));
                    entries_.emplace_back(6 * f + i, row_, (*by)(i));
                }
            ++row_;
        }
    }
    Sparse matrix() const {
        Sparse matrix(row_, row_);
        matrix.setFromTriplets(entries_.begin(), entries_.end());
        return matrix;
    }

private:
    std::vector<Eigen::Triplet<Frequency>> entries_;
    int row_;  ///< the next of a rigid direction
};

Sparse damped_stiffness(const DynamicStiffness& D, double omega) {
    const FrequencyModel& model = D.model();
    Entries entries(D.frame_count());
    for (const Bond& bond : model.bonds) {
        const Block K = bond.stiffness.cast<Frequency>() + Frequency(0, omega) * bond.damping.cast<Frequency>();
        entries.join(bond, K, -K, K);
        if (!bond.turning) continue;
        const int ends[2] = {bond.from, bond.to};
        for (int i : {0, 1})
            for (int k : {0, 1})
                if (ends[i] >= 0 && ends[k] >= 0) entries.add(ends[i], ends[k], bond.turning->at[i][k].cast<Frequency>());
    }
    std::vector<std::optional<LineWaves::Square<Frequency>>> known(model.kinds.size());
    for (const DynamicStiffness::Piece& piece : D.pieces()) {
        const LineModel& line = D.line(piece);
        auto& L = known[line.kind];
        if (!L) {
            const Frequency stiffening(1, omega * line.line.section.stiffness_damping);
            line.waves->evaluate<Frequency>(D.count(line), omega * omega, stiffening, L.emplace(), nullptr);
        }
        entries.join(piece, L->topLeftCorner<6, 6>(), L->topRightCorner<6, 6>(), L->bottomRightCorner<6, 6>());
    }
    for (const Pin& pin : model.pins) {
        const Block own = (-omega * omega / 3 * pin.mass).cast<Frequency>(), across = 0.5 * own;
        entries.join(pin, own, across, own);
    }
    D.for_each_mass([&](const FrequencyModel::Mass& mass) {
        entries.add(mass.frame, mass.frame, (-omega * omega * model.mask * mass.block * model.mask).cast<Frequency>());
    });
    for (const FrequencyModel::Lever& lever : model.levers)
        entries.add(lever.frame, lever.frame, lever.stiffness.cast<Frequency>());
    const Matrix6 idle = Matrix6::Identity() - model.mask;
    for (int f = 0; f < D.frame_count(); ++f) entries.add(f, f, idle.cast<Frequency>());
    return entries.matrix();
}

}  // namespace

Response respond(const DynamicStiffness& D, double omega, int frame, const Vector3& point, const Vector6& wrench) {
    const FrequencyModel& model = D.model();
    const Sparse matrix = damped_stiffness(D, omega);
    Eigen::SparseLU<Sparse> lu(matrix);
    Eigen::VectorXcd r = Eigen::VectorXcd::Zero(matrix.rows());
    if (frame >= 0)
        r.segment<6>(6 * frame) = (model.masked_at(point, model.origin(frame)).transpose() * wrench).cast<Frequency>();
    const Eigen::VectorXcd x = lu.info() == Eigen::Success ? Eigen::VectorXcd(lu.solve(r)) : r;
    if (lu.info() != Eigen::Success || !x.allFinite())
        throw Error(DTTMM_ERROR_SINGULAR,
                    fmt::format("{:.6g} Hz is a natural frequency without damping: the response there has no bound",
                                omega / (2 * M_PI)));
    Response motion;
    for (int f = 0; f < D.frame_count(); ++f) motion.push_back(model.mask * x.segment<6>(6 * f));
    return motion;
}

}  // namespace dttmm::plugin
