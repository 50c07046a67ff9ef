// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/index.h"
#include "modal/frequency_model.h"
#include "solve/elimination.h"

namespace dttmm::plugin {

/// The dynamic stiffness of a machine at λ = ω²,
///     D(λ) = K − λ M + Σ lines,     J u = 0 in rigid directions.
/// It is factored by the elimination of the time solver, from the tips inwards (Riccati's form of the transfer equations),
/// which also counts the negative eigenvalues. As lines are cut into pieces that do not vibrate with their ends held, that
/// is the number of natural frequencies below ω, each with its multiplicity. Source: Wittrick and Williams (1971), Q. J.
/// Mech. Appl. Math. 24, 263–284, with J0 = 0.
///
/// Motions have 6 numbers per frame: those of the machine, then the points between the pieces of its lines.
class DynamicStiffness {
public:
    /// A piece of a line between two frames, local axes.
    struct Piece : Joined {
        size_t line;
        int index;  ///< along the line
    };
    /// Of the pieces of a kind of lines at λ: by the displacements of the ends, local axes.
    struct Waves {
        Matrix12 stiffness, mass;  ///< D and −∂D/∂λ
    };

    /// Of rigid directions in the model that say the same it keeps one. The model must live on.
    explicit DynamicStiffness(FrequencyModel& model) : model_(model) {}

    /// Cuts the lines so that frequencies below ω [rad/s] can be counted; comes before all that follows. Throws Error naming
    /// the element that would take too many pieces, or what nothing holds and has no mass.
    void cut(double omega);
    /// Cuts them as those of another machine, which has as many; throws the same, and Error(DTTMM_ERROR_ARGUMENT) where that
    /// cannot be.
    void cut_like(const DynamicStiffness& other);
    /// So often they were cut otherwise than before: motions of one count are of the same frames.
    int cuts() const { return cuts_; }
    double cut_for() const { return cut_for_; }  ///< ω of the last such cut [rad/s]

    /// Sets D(λ), λ [1/s²], for products.
    void set(double lambda) { evaluate_waves(lambda, true); }
    /// Sets D(λ) and factors it; the number of natural frequencies below ω. Nothing: λ belongs to one of them, to rounding.
    std::optional<int> factor(double lambda) { return factor(lambda, true); }
    /// That number alone. Nothing is factored where none lies below a larger λ.
    std::optional<int> count(double lambda);
    /// Factors K − λ M, in which lines have the stiffness and the mass that they have at λ = 0: for λ so far below zero that
    /// their waves would overflow. Returns whether it is regular.
    bool factor_far_below(double lambda);

    // At the λ last set:
    double lambda() const { return lambda_; }
    /// After factor(): D⁻¹ r on the motions that rigid directions allow; the result: minus the forces of these, bond by
    /// bond, then by piece.
    std::vector<double> solve(FrameVector& r) const;
    /// −∂D/∂λ u, and D u with the forces of rigid directions left out; of a motion of the ground, too, about the world's
    /// origin. on_ground: adds to the momentum there.
    FrameVector mass_times(const FrameVector& u, const Vector6& ground = Vector6::Zero(),
                           Vector6* on_ground = nullptr) const;
    FrameVector stiffness_times(const FrameVector& u, const Vector6& ground = Vector6::Zero()) const;
    /// J u, in the order of solve().
    std::vector<double> openings(const FrameVector& u) const;
    /// Which rows J has: of what joins two frames, and its number there.
    std::vector<std::pair<int, int>> rigid_rows() const;
    /// All moves as a whole in direction d about the world's origin, the ground too: the motion of the frames, the forces D
    /// r and the momenta −∂D/∂λ r on them, and twice the kinetic energy, that of clamped lines included. See dttmm_mode.
    struct Whole {
        FrameVector motion, forces, momenta;
        double mass;  ///< [kg, kg m²]
    };
    Whole move_whole(int direction) const;

    const FrequencyModel& model() const { return model_; }
    int frame_count() const { return as_int(model_.frames.size() + points_.size()); }
    const std::vector<Piece>& pieces() const { return pieces_; }
    const LineModel& line(const Piece& piece) const { return model_.lines[piece.line]; }
    const Waves& waves(const Piece& piece) const { return waves_[slot(piece)]; }
    /// Pieces of equal waves have one number, below slot_count().
    size_t slot(const Piece& piece) const {
        const LineModel& own = line(piece);
        return first_slot_[own.kind] + (own.waves->is_graded() ? as_size(piece.index) : 0);
    }
    size_t slot_count() const { return waves_.size(); }
    /// Of the pieces of a line, which stand in a row.
    std::vector<Piece>::const_iterator first_piece(const LineModel& line) const {
        return pieces_.begin() + first_piece_[as_size(&line - model_.lines.data())];
    }
    /// Pieces of a line, and their length [m].
    int count(const LineModel& line) const { return counts_[line.kind]; }
    double piece_length(const LineModel& line) const { return line.length() / count(line); }
    /// All masses, those of bars included.
    template <class Body>
    void for_each_mass(const Body& body) const {
        for (const FrequencyModel::Mass& mass : model_.masses) body(mass);
        for (const FrequencyModel::Mass& mass : bar_masses_) body(mass);
    }

    /// Largest stiffness over the whole mass [1/s²]; 0: nothing is stiff, or has a mass.
    double stiffest() const;

private:
    std::optional<int> factor(double lambda, bool with_mass);
    /// A point between pieces.
    struct Point {
        Vector3 position;
        size_t line;
    };

    void cut_into(const std::vector<int>& counts);
    void cut_line(size_t l);
    void add_piece(Piece piece, const Vector3& start, const Vector3& finish);
    void build();
    void evaluate_waves(double lambda, bool with_mass);
    template <class Body>
    void for_each_slot(const Body& body) const {
        for (size_t k = 0; k < model_.kinds.size(); ++k)
            for (size_t slot = first_slot_[k], end = k + 1 < first_slot_.size() ? first_slot_[k + 1] : waves_.size();
                 slot < end; ++slot)
                body(slot, *model_.kinds[k], counts_[k], as_int(slot - first_slot_[k]));
    }
    void assemble();
    void hold_idle();
    int link_count() const { return as_int(model_.bonds.size() + pieces_.size() + model_.pins.size()); }
    template <class Self>
    static auto& joined(Self& self, int link);
    Vector3 origin(int frame) const;
    /// At a frequency that moves nothing.
    std::optional<Elimination::Fault> factor_held();
    bool is_redundant(int link, int i);
    /// A motion of a frame that has no pivot.
    [[noreturn]] void refuse_loose(int frame, int direction) const;
    [[noreturn]] void refuse(dttmm_status status, int frame, const std::string& why) const;

    FrequencyModel& model_;
    std::vector<Point> points_;
    std::vector<Piece> pieces_;
    std::vector<FrequencyModel::Mass> bar_masses_;
    std::vector<std::ptrdiff_t> first_piece_;  ///< by line
    std::vector<int> counts_;                  ///< of pieces of a line of each kind
    bool is_cut_ = false;                      ///< into these
    int cuts_ = 0;
    double cut_for_ = 0;
    std::vector<Waves> waves_;                                     ///< by slot()
    std::vector<std::optional<LineWaves::Expansion>> expansions_;  ///< by slot()
    double asked_for_ = 0, expanded_to_ = 0;  ///< largest ω that these pieces serve [rad/s], |λ| of expansions [1/s²]
    int direct_ = 0;                          ///< evaluations that these could have spared
    std::vector<size_t> first_slot_;          ///< of each kind
    std::optional<Elimination> elimination_;
    double lambda_ = 0;
    double none_below_ = -std::numeric_limits<double>::infinity();  ///< the largest λ known to have no frequency below it
};

}  // namespace dttmm::plugin
