// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "modal/frequency_model.h"
#include "modal/resting_parts.h"

namespace dttmm::plugin {

/// Makes a FrequencyModel of what the host describes.
class FrequencyAssembly {
public:
    /// model: has its directions and mask, else empty. rest: the machine at rest; null: none. Keeps all three.
    FrequencyAssembly(FrequencyModel& model, const dttmm_modal_model& description, const AtRest* rest);
    void run();

private:
    void add_bodies();
    void add_inner_frames(const Assembly& assembly);
    void add_nodes(const Assembly& assembly);
    void refer_masses(const Assembly& assembly);
    void add_joints(const Assembly& assembly, const std::vector<Joint>& joints,
                    const std::vector<const AtRest::Link*>& links);
    void add_constraints();
    void add_joint(int element, int from, int to, const JointLaw& law, const Pose& pose);
    void add_lines(const std::vector<LineSpec>& specs);
    void add_line(const LineSpec& spec, LineWaves::Axial axial, const Matrix3& falling);
    void add_resting_line(const LineSpec& spec);
    void add_piece(const LineSpec& spec, int index, int count, const Vector3& start, const Vector3& finish,
                   const Matrix3& axes, double length, LineWaves::Axial axial, const Matrix3& falling);
    size_t find_kind(const LineSpec& spec, double length, LineWaves::Axial axial, const Matrix3& falling);
    Directions active_axes(const LineSpec& spec) const;
    void add_pin(const LineModel& line);

    FrequencyModel& model_;
    const dttmm_modal_model& description_;
    std::optional<RestingParts> resting_;
    std::vector<int> frame_of_;  ///< in the model of the assembly's frames; −1: the ground

    /// What lines of one kind share, to the bit: section, length, whether it is a rod, active directions, axial force,
    /// what its weight does.
    using Key = std::tuple<std::array<uint64_t, sizeof(Section) / sizeof(double)>, double, bool, unsigned long,
                           LineWaves::Axial, std::array<double, 9>>;
    std::map<Key, size_t> known_kinds_;
    struct Shapes {
        size_t kind;
        LineShapes at_rest;
    };
    std::optional<Shapes> shapes_;  ///< of the last kind: pieces of a line in a row are often alike
};

}  // namespace dttmm::plugin
