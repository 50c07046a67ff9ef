// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/assembly.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <functional>
#include <memory>
#include <numeric>
#include <unordered_set>

#include "core/error.h"
#include "core/index.h"
#include "core/rounding.h"
#include "core/state_vector.h"
#include "element/registry.h"
#include "mechanism/frame.h"

namespace dttmm::plugin {

namespace {

bool is_rotation(const Matrix3& R) {
    return R.allFinite() && (R * R.transpose() - Matrix3::Identity()).cwiseAbs().maxCoeff() < 1e-9 && R.determinant() > 0;
}

std::shared_ptr<const std::string> label(const char* kind, const char* name) {
    return std::make_shared<const std::string>(fmt::format("{} \"{}\"", kind, name));
}

/// What becomes one frame: nodes and lumps that are rigidly one.
struct Part {
    FrameSpec frame;
    Pose pose;      ///< axes and, without a mass, the origin of the frame
    int body = -1;  ///< that it is a point of
};

/// Finds laws by their values.
struct OfLaw {
    size_t operator()(const std::shared_ptr<const JointLaw>& law) const {
        size_t hash = 0;
        for (const double k : {law->stiffness.sum(), law->damping.sum()}) hash = 31 * hash + std::hash<double>()(k);
        return hash;
    }
    bool operator()(const std::shared_ptr<const JointLaw>& a, const std::shared_ptr<const JointLaw>& b) const {
        return *a == *b;
    }
};

class Assembler {
public:
    Assembler(const dttmm_network& description, Waves waves, const std::vector<bool>* lumped,
              std::span<const int> supported_by)
        : description_(description), waves_(waves), lumped_(lumped), supported_by_(supported_by) {
        place_bodies();
        place_nodes();
        for (uint32_t e = 0; e < description.element_count; ++e) take_apart(as_int(e));
        weld();
        hold_fixed_nodes();
        check_line_loads();
    }

    Assembly take() {
        assembly_.frames.shrink_to_fit();
        assembly_.joints.shrink_to_fit();
        assembly_.nodes.shrink_to_fit();
        return std::move(assembly_);
    }

private:
    const dttmm_node& node(int n) const { return description_.nodes[n]; }
    const dttmm_element& element(int e) const { return description_.elements[e]; }

    void place_bodies() {
        for (uint32_t b = 0; b < description_.body_count; ++b) {
            const dttmm_body& body = description_.bodies[b];
            FrameSpec frame;
            frame.kind = FrameSpec::Kind::port;
            frame.label = label("body", body.name);
            frame.pose = {Eigen::Map<const Vector3>(body.position), Eigen::Map<const RowMajor3>(body.rotation)};
            if (!frame.pose.position.allFinite() || !is_rotation(frame.pose.rotation))
                throw Error(DTTMM_ERROR_ARGUMENT,
                            fmt::format("{}: its position must be finite and its axes orthonormal", frame.name()));
            assembly_.frames.push_back(frame);
        }
        assembly_.port_count = as_int(assembly_.frames.size());
    }

    void place_nodes() {
        for (uint32_t n = 0; n < description_.node_count; ++n) {
            const dttmm_node& node = description_.nodes[n];
            if (node.kind > DTTMM_NODE_INNER)
                throw Error(DTTMM_ERROR_MODEL, fmt::format("node \"{}\": there is no node kind {}", node.name, node.kind));
            const Pose pose{Eigen::Map<const Vector3>(node.position), Eigen::Map<const RowMajor3>(node.rotation)};
            if (!pose.position.allFinite() || !is_rotation(pose.rotation))
                throw Error(DTTMM_ERROR_ARGUMENT,
                            fmt::format("node \"{}\": its position must be finite and its axes orthonormal", node.name));
            Part part;
            part.pose = pose;
            if (node.kind == DTTMM_NODE_ON_BODY) {
                if (node.body >= description_.body_count)
                    throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("node \"{}\": it is on no body", node.name));
                part.body = as_int(node.body);
            }
            part.frame.label = label("node", node.name);
            part.frame.kind = node.kind == DTTMM_NODE_ON_BODY                        ? FrameSpec::Kind::port
                              : node.kind == DTTMM_NODE_GROUND || node.fixed == 0x3f ? FrameSpec::Kind::ground
                                                                                     : FrameSpec::Kind::inner;
            parts_.push_back(part);
        }
    }

    /// What `body` returns; an error it throws names the element.
    template <class Body>
    static auto at(int e, const Body& body) {
        try {
            return body();
        } catch (const Error& error) {
            throw Error(error.status(), error.what(), e);
        }
    }

    /// The element's joints and lumps; its ends that are mounted on a lump become one with it.
    void take_apart(int e) {
        const dttmm_element& data = element(e);
        std::vector<Pose> ends;
        for (uint32_t i = 0; i < data.end_count; ++i) {
            if (data.ends[i] >= description_.node_count)
                throw Error(DTTMM_ERROR_MODEL, "an end is no node of the network", e);
            Part& part = parts_[data.ends[i]];
            ends.push_back(part.pose);
            if (part.frame.element < 0) part.frame.element = e;
        }
        const std::unique_ptr<const Element> made = make(e);
        const bool is_exact = waves_ == Waves::exact && !(lumped_ && (*lumped_)[as_size(e)]);
        const std::optional<Line> line = is_exact ? at(e, [&] { return made->line(ends); }) : std::nullopt;
        if (line) {
            assembly_.first_joint.push_back(as_int(assembly_.joints.size()));
            assembly_.lines.push_back(
                {e, as_int(data.ends[0]), as_int(data.ends[1]), ends[0].position, ends[1].position, *line});
            return;
        }
        const Parts parts = at(e, [&] { return made->discretise(ends); });

        const int first_lump = as_int(parts_.size());
        const auto of_element = label("element", data.name);
        for (size_t l = 0; l < parts.lumps.size(); ++l) {
            const Lump& lump = parts.lumps[l];
            FrameSpec frame;
            frame.segment = as_int(l) + 1;
            frame.label = of_element;
            frame.element = e;
            frame.mass = lump.mass;
            frame.inertia = lump.inertia;
            parts_.push_back({frame, lump.pose});
        }
        for (size_t i = 0; i < parts.mounted.size(); ++i) {
            if (parts.mounted[i] < 0) continue;
            const int end = as_int(data.ends[i]);
            if (parts_[as_size(end)].frame.kind != FrameSpec::Kind::inner)
                throw Error(DTTMM_ERROR_MODEL,
                            fmt::format("{}: a mass there would have no effect, or belongs to the body",
                                        parts_[as_size(end)].frame.name()),
                            e);
            welds_.emplace_back(first_lump + parts.mounted[i], end);
        }
        if (parts.segments)
            assembly_.segments.push_back({e, first_lump, as_int(parts.lumps.size()), parts.segments->length,
                                          parts.segments->arm, parts.segments->moduli});
        const auto station = [&](int s) {
            return s < as_int(data.end_count) ? as_int(data.ends[s]) : first_lump + s - as_int(data.end_count);
        };
        assembly_.first_joint.push_back(as_int(assembly_.joints.size()));
        for (const JointPart& joint : parts.joints) {
            assembly_.joints.push_back({e, station(joint.from), station(joint.to), shared(joint.law), joint.pose});
        }
    }

    /// Joints that are alike have one law.
    std::shared_ptr<const JointLaw> shared(const std::shared_ptr<const JointLaw>& law) {
        if (last_law_ != law && !(last_law_ && *last_law_ == *law)) last_law_ = *laws_.insert(law).first;
        return last_law_;
    }

    std::unique_ptr<const Element> make(int e) const {
        const dttmm_element& data = element(e);
        const auto types = element_types();
        if (data.type < types.size() && types[data.type].ends != DTTMM_ENDS_AT) {
            if (data.end_count != 2) throw Error(DTTMM_ERROR_MODEL, "an element of this type has two ends", e);
            if (data.ends[0] == data.ends[1]) throw Error(DTTMM_ERROR_MODEL, "both ends are the same node", e);
        }
        if (data.end_count == 0) throw Error(DTTMM_ERROR_ARGUMENT, "an element without an end", e);
        return at(e, [&] { return make_element(data.type, data.values); });
    }

    /// Makes frames of the parts, and points the joints and nodes at them.
    void weld() {
        std::vector<int> root(parts_.size());
        std::iota(root.begin(), root.end(), 0);
        const auto find = [&](int p) {
            while (root[as_size(p)] != p) p = root[as_size(p)];
            return p;
        };
        for (const auto& [a, b] : welds_) {
            const int i = find(a), j = find(b);
            root[as_size(std::max(i, j))] = std::min(i, j);
        }
        std::vector<std::vector<int>> groups(parts_.size());
        for (size_t p = 0; p < parts_.size(); ++p) groups[as_size(find(as_int(p)))].push_back(as_int(p));

        std::vector<int> frame_of(parts_.size(), -1);
        for (size_t p = 0; p < parts_.size(); ++p) {
            if (parts_[p].body < 0) continue;
            frame_of[p] = parts_[p].body;
            int& element = assembly_.frames[as_size(frame_of[p])].element;
            if (element < 0) element = parts_[p].frame.element;
        }
        for (const auto kind : {FrameSpec::Kind::ground, FrameSpec::Kind::inner}) {
            for (size_t p = 0; p < parts_.size(); ++p) {
                if (groups[p].empty() || parts_[p].frame.kind != kind) continue;
                for (int member : groups[p]) frame_of[as_size(member)] = as_int(assembly_.frames.size());
                assembly_.frames.push_back(merge(groups[p]));
            }
            if (kind == FrameSpec::Kind::ground) assembly_.driven_count = as_int(assembly_.frames.size());
        }
        for (uint32_t n = 0; n < description_.node_count; ++n) {
            NodeSpec spec;
            spec.frame = frame_of[n];
            const Pose& frame = assembly_.frames[as_size(spec.frame)].pose;
            spec.offset = frame.rotation.transpose() * (parts_[n].pose.position - frame.position);
            spec.rotation = frame.rotation.transpose() * parts_[n].pose.rotation;
            spec.name = parts_[n].frame.name();
            spec.element = parts_[n].frame.element;
            assembly_.nodes.push_back(spec);
        }
        for (JointSpec& joint : assembly_.joints) {
            joint.from = frame_of[as_size(joint.from)];
            joint.to = frame_of[as_size(joint.to)];
            check_ends(joint.from, joint.to, joint.law->rigid, joint.element);
        }
        for (SegmentsSpec& line : assembly_.segments) line.first = frame_of[as_size(line.first)];
        for (LineSpec& line : assembly_.lines) {
            line.from = frame_of[as_size(line.from)];
            line.to = frame_of[as_size(line.to)];
            if (line.from == line.to && !is_ground(line.from)) {
                if (!line.line.stretches_only) continue;  // its own mass bends it
                refuse_idle_rod(line.element);
            }
        }
        check_divided_rods();
    }

    [[noreturn]] static void refuse_idle_rod(int element) {
        throw Error(
            DTTMM_ERROR_MODEL,
            "both ends are on the same rigid body: only its own mass would stretch it; leave it out, or put a probe on it",
            element);
    }

    /// As with exact waves: all commands refuse such a model, in the same words.
    void check_divided_rods() const {
        for (const SegmentsSpec& line : assembly_.segments) {
            const auto first = as_size(assembly_.first_joint[as_size(line.element)]);
            const JointSpec &start = assembly_.joints[first], &finish = assembly_.joints[first + as_size(line.count)];
            Directions across = start.law->rigid;
            across[0] = true;  // a rod is elastic along x alone
            if (across.all() && start.from == finish.to && !is_ground(start.from)) refuse_idle_rod(line.element);
        }
    }

    FrameSpec merge(const std::vector<int>& members) const {
        const Part& first = parts_[as_size(members.front())];
        FrameSpec frame = first.frame;
        frame.pose = first.pose;
        Vector3 moment = Vector3::Zero(),
                about = frame.pose.position;  // the first mass: masses at one place stay just there
        frame.mass = 0;
        for (int member : members) {
            const Part& part = parts_[as_size(member)];
            if (frame.mass == 0) about = part.pose.position;
            frame.mass += part.frame.mass;
            moment += part.frame.mass * (part.pose.position - about);
        }
        if (frame.mass == 0) return frame;
        frame.pose.position = about + moment / frame.mass;
        frame.inertia.setZero();
        for (int member : members) {
            const Part& part = parts_[as_size(member)];
            const Matrix3 axes = frame.pose.rotation.transpose() * part.pose.rotation;
            Vector3 arm = frame.pose.rotation.transpose() * (part.pose.position - frame.pose.position);
            if (arm.norm() < kSamePoint) arm.setZero();
            frame.inertia += axes * part.frame.inertia * axes.transpose() - part.frame.mass * skew(arm) * skew(arm);
        }
        return frame;
    }

    bool is_ground(int frame) const { return assembly_.frames[as_size(frame)].kind == FrameSpec::Kind::ground; }

    void check_ends(int from, int to, Directions rigid, int element) const {
        if (from == to) throw Error(DTTMM_ERROR_MODEL, "both ends are on the same rigid body: nothing can deform", element);
        if (is_ground(from) && is_ground(to)) throw Error(DTTMM_ERROR_MODEL, "both ends are on the ground", element);
        const bool is_driven = from < assembly_.driven_count && to < assembly_.driven_count;
        if (is_driven && rigid.any() && waves_ == Waves::lumped)
            throw Error(
                DTTMM_ERROR_MODEL,
                fmt::format("it is rigid in {} and both its ends are driven: a body or the ground at each; give it a "
                            "stiffness there, or make it a joint of the model",
                            list(rigid)),
                element);
    }

    static std::string list(Directions directions) {
        std::string text;
        for (size_t d = 0; d < 6; ++d)
            if (directions[d]) text += (text.empty() ? "" : ", ") + std::string(kDirectionNames[d]);
        return text;
    }

    /// A node held in some directions hangs on the ground, or on the body of its support, by a joint rigid in these.
    void hold_fixed_nodes() {
        assembly_.first_joint.push_back(as_int(assembly_.joints.size()));
        for (uint32_t n = 0; n < description_.node_count; ++n) {
            const uint32_t fixed = node(as_int(n)).fixed;
            if (node(as_int(n)).kind != DTTMM_NODE_INNER || fixed == 0) continue;
            refuse_moving(n);
            if (fixed == 0x3f) continue;
            JointSpec joint;
            joint.element = parts_[n].frame.element;
            const int body = supported_by_.empty() ? -1 : supported_by_[n];
            joint.from = body >= 0 ? body : ground_at(parts_[n].pose.position);
            JointLaw law;
            law.rigid = Directions(fixed);
            joint.law = std::make_shared<const JointLaw>(law);
            joint.pose = {parts_[n].pose.position, Matrix3::Identity()};
            joint.to = assembly_.nodes[n].frame;
            assembly_.joints.push_back(joint);
            assembly_.held_nodes.push_back(as_int(n));
        }
    }

    /// A velocity and a direction held where it is exclude each other.
    void refuse_moving(uint32_t n) const {
        const dttmm_node& data = node(as_int(n));
        if (!data.moves) return;
        for (size_t d = 0; d < 6; ++d) {
            const double speed = d < 3 ? data.velocity[d] : data.angular_velocity[d - 3];
            if ((data.fixed >> d & 1) == 0 || speed == 0) continue;
            throw Error(DTTMM_ERROR_MODEL,
                        fmt::format("{}: its {} at the start moves it in {}, which is fixed; give none there",
                                    parts_[n].frame.name(), d < 3 ? "velocity" : "angular velocity", kDirectionNames[d]),
                        parts_[n].frame.element);
        }
    }

    /// A frame of the ground at a point; the frames behind it move up by one.
    int ground_at(const Vector3& point) {
        FrameSpec frame;
        frame.kind = FrameSpec::Kind::ground;
        frame.label = std::make_shared<const std::string>("the ground");
        frame.pose.position = point;
        const int index = assembly_.driven_count++;
        assembly_.frames.insert(assembly_.frames.begin() + index, frame);
        for (JointSpec& joint : assembly_.joints) {
            joint.from += joint.from >= index;
            joint.to += joint.to >= index;
        }
        for (LineSpec& line : assembly_.lines) {
            line.from += line.from >= index;
            line.to += line.to >= index;
        }
        for (SegmentsSpec& line : assembly_.segments) line.first += line.first >= index;
        for (NodeSpec& spec : assembly_.nodes) spec.frame += spec.frame >= index;
        return index;
    }

    void check_line_loads() const {
        const auto types = element_types();
        for (uint32_t k = 0; k < description_.line_load_count; ++k) {
            const dttmm_line_load& load = description_.line_loads[k];
            if (load.element >= description_.element_count)
                throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("line load {} is on no element", k));
            if (load.axes > DTTMM_AXES_ELEMENT)
                throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("line load {}: there are no axes {}", k, load.axes));
            const dttmm_element_type& type = types[element(as_int(load.element)).type];
            if (type.ends != DTTMM_ENDS_LINE)
                throw Error(
                    DTTMM_ERROR_MODEL,
                    fmt::format("a force per length acts on it, but a {} is no line; put a beam or a rod there", type.name),
                    as_int(load.element));
        }
    }

    const dttmm_network& description_;
    const Waves waves_;
    const std::vector<bool>* lumped_;
    const std::span<const int> supported_by_;
    std::vector<Part> parts_;  ///< the nodes, then the lumps of the elements
    std::vector<std::pair<int, int>> welds_;
    std::unordered_set<std::shared_ptr<const JointLaw>, OfLaw, OfLaw> laws_;  ///< no two are alike
    std::shared_ptr<const JointLaw> last_law_;                                ///< of the joint before
    Assembly assembly_;
};

}  // namespace

std::string FrameSpec::name() const { return segment > 0 ? fmt::format("segment {} of {}", segment, *label) : *label; }

Assembly assemble(const dttmm_network& description, Waves waves, const std::vector<bool>* lumped,
                  std::span<const int> supported_by) {
    return Assembler(description, waves, lumped, supported_by).take();
}

}  // namespace dttmm::plugin
