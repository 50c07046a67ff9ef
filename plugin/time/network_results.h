// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <initializer_list>
#include <memory>
#include <memory_resource>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dttmm_plugin.h"
#include "time/instant.h"
#include "time/interior.h"

namespace dttmm::plugin {

/// Where the parts of a network stand in the arrays of the host, which has all bodies and all elements.
struct Places {
    std::vector<uint32_t> bodies, nodes, elements;
    /// Of its nodes: the body of the network that moves their fixed directions; −1: the ground holds them. Empty: all of
    /// them.
    std::vector<int> supported_by = {};
};

/// The channels of a network and what is written to them; and where its lines are.
class NetworkResults {
public:
    /// interior: NULL: nothing moves inside. Keeps all but the description. Construct it before
    /// the joint specifications are dropped.
    NetworkResults(const dttmm_network& description, const Places& places, const Mechanism& mechanism,
                   const Interior* interior);

    const std::vector<dttmm_channel>& channels() const { return channels_; }
    /// In pieces: of each element, then all others; and where each begins among the outputs, at first one after the other.
    size_t piece_count() const { return piece_places_.size(); }
    std::span<const dttmm_channel> piece(size_t piece) const {
        return std::span(channels_).subspan(piece_begin_[piece], piece_begin_[piece + 1] - piece_begin_[piece]);
    }
    void place(size_t piece, size_t at) { piece_places_[piece] = at; }
    /// For another to have them; their names stay.
    std::vector<dttmm_channel> take_channels() { return std::exchange(channels_, {}); }
    /// Frees the texts that the channels point to: nobody may read a channel afterwards.
    void forget_names() { names_.reset(); }
    void write(const Instant& instant, double* values) const;
    /// Whether write() or write_lines() needs the nodes of the assembly.
    bool shows_nodes() const { return !nodes_.empty() || !reactions_.empty() || !chains_.empty(); }

    /// Its elements of several joints, which bend between their ends.
    std::vector<uint32_t> lines() const;
    /// Where `stations` equally spaced points of each are, ends included, at that instant [m, world]. Returns the end of the
    /// positions.
    double* write_lines(uint32_t stations, double* positions) const;

private:
    /// A beam or rod as results show it: its joints, its ends and its axes.
    struct ChainView {
        int from_node = 0, to_node = 0;
        Matrix3 from_axes = Matrix3::Identity();  ///< of the element in those of the frame at its `from` end
        Matrix3 to_axes = Matrix3::Identity();    ///< the same at rest in those at its `to` end
        Vector3 rest = Vector3::Zero();           ///< from end to end, axes of the element
        SectionModuli moduli;
    };
    /// A node with fixed directions as results show it.
    struct ReactionView {
        int node, frame;  ///< frame: of what holds it
        bool has_force, has_moment;
        bool has_place;  ///< nothing but its support moves it
    };

    const char* keep(std::string_view name);
    void declare(std::string_view name, const char* unit, uint32_t of, uint32_t index, uint32_t role);
    void declare_vectors(const std::string& prefix, std::initializer_list<std::pair<const char*, const char*>> vectors,
                         uint32_t of, uint32_t index, uint32_t role);
    void declare_element(const dttmm_network& description, uint32_t element);
    void declare_chain(const dttmm_network& description, uint32_t element);
    void declare_inner(const dttmm_network& description);
    void declare_reactions(const dttmm_network& description);
    bool has_limit(int joint) const { return std::isfinite(mechanism_.joints[as_size(joint)].law().most_turn); }
    /// Of an element.
    int first_joint(size_t element) const { return mechanism_.assembly.first_joint[element]; }
    int joint_count(size_t element) const { return first_joint(element + 1) - first_joint(element); }

    double* write_reaction(const Instant& instant, double* out, const ReactionView& reaction) const;
    double* write_joint(const Instant& instant, double* out, size_t joint) const;
    double* write_chain(const Instant& instant, double* out, size_t element, const ChainView& chain) const;
    Vector6 section_forces(const Instant& instant, const ChainView& chain, std::pair<int, int> joints, int j) const;
    Vector3 way_to_first_joint(const ChainView& chain, int j) const;
    double* write_node(double* out, size_t node) const;
    double* write_energies(double* out, int first, int last) const;
    Vector3 section_position(size_t element, const ChainView& chain, int section) const;

    const Places& places_;
    const Mechanism& mechanism_;
    const Interior* interior_;
    std::vector<ReactionView> reactions_;
    std::vector<ChainView> chains_;  ///< of the elements with several joints
    std::vector<int> nodes_;         ///< with channels
    std::vector<dttmm_channel> channels_;
    /// Of channels: a long beam has 10^5.
    std::unique_ptr<std::pmr::monotonic_buffer_resource> names_ = std::make_unique<std::pmr::monotonic_buffer_resource>();
    std::vector<size_t> piece_begin_, piece_places_;
};

}  // namespace dttmm::plugin
