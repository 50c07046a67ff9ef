// SPDX-License-Identifier: BSD-3-Clause
#include "report/gltf_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/atomic_file.h"

namespace dttmm::host {

namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int kFloat = 5126, kUnsignedShort = 5123;  // component types
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;

// Shares of the machine's size
constexpr double kThinnestBox = 0.004, kNodeMark = 0.012, kElementMark = 0.03, kThinnestElement = 0.006,
                 kThickestElement = 0.1;

void append_number(std::string& bytes, uint32_t number) {
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(number >> shift & 0xff);
}

/// A named part of the tree: translation, rotation (x y z w) and scale of a node.
struct PartPose {
    Vector3d translation = Vector3d::Zero();
    Quaterniond rotation = Quaterniond::Identity();
    Vector3d scale = Vector3d::Ones();
};

/// The piece of an element between two points: a prism along x. Without length a cube.
PartPose piece_pose(const Vector3d& from, const Vector3d& to, double thickness, double mark) {
    const Vector3d along = to - from;
    const double length = along.norm();
    if (length < mark / 100) return {0.5 * (from + to), Quaterniond::Identity(), Vector3d::Constant(mark)};
    return {0.5 * (from + to), Quaterniond::FromTwoVectors(Vector3d::UnitX(), along), {length, thickness, thickness}};
}

/// Numbers and the tables that say where they are.
class GltfData {
public:
    /// Of 3 or 4 numbers per row, or of 1. Bounds are required of positions and times.
    int add(std::span<const float> numbers, std::size_t width, bool has_bounds, int target = 0) {
        const std::size_t begin = bytes_.size();
        for (const float number : numbers) append_number(bytes_, std::bit_cast<uint32_t>(number));
        Json accessor = {{"bufferView", add_view(begin, target)},
                         {"componentType", kFloat},
                         {"count", numbers.size() / width},
                         {"type", width == 1 ? "SCALAR" : fmt::format("VEC{}", width)}};
        for (const bool is_low : {true, false}) {
            if (!has_bounds) continue;
            Json& bound = accessor[is_low ? "min" : "max"] = Json::array();
            for (std::size_t k = 0; k < width; ++k) {
                float most = numbers[k];
                for (std::size_t i = k; i < numbers.size(); i += width)
                    most = is_low ? std::min(most, numbers[i]) : std::max(most, numbers[i]);
                bound.push_back(static_cast<double>(most));
            }
        }
        return add_accessor(std::move(accessor));
    }

    int add_indices(std::span<const uint16_t> indices) {
        const std::size_t begin = bytes_.size();
        for (const uint16_t index : indices) {
            bytes_ += static_cast<char>(index & 0xff);
            bytes_ += static_cast<char>(index >> 8);
        }
        Json accessor = {{"bufferView", add_view(begin, kElementArrayBuffer)},
                         {"componentType", kUnsignedShort},
                         {"count", indices.size()},
                         {"type", "SCALAR"}};
        bytes_.resize((bytes_.size() + 3) / 4 * 4);
        return add_accessor(std::move(accessor));
    }

    const std::string& bytes() const { return bytes_; }
    Json take_views() { return std::move(views_); }
    Json take_accessors() { return std::move(accessors_); }

private:
    int add_view(std::size_t begin, int target) {
        Json view = {{"buffer", 0}, {"byteOffset", begin}, {"byteLength", bytes_.size() - begin}};
        if (target != 0) view["target"] = target;
        views_.push_back(std::move(view));
        return as_int(views_.size()) - 1;
    }
    int add_accessor(Json accessor) {
        accessors_.push_back(std::move(accessor));
        return as_int(accessors_.size()) - 1;
    }

    std::string bytes_;
    Json views_ = Json::array(), accessors_ = Json::array();
};

/// A node whose pose may change from time to time.
struct MovingPart {
    int node;
    std::vector<PartPose> poses;  ///< one per time
};

class GltfWriter {
public:
    explicit GltfWriter(const Scene& scene) : scene_(scene), size_(scene.structure().size()) {
        add_meshes();
        add_nodes();
        for (const Film& film : scene.films()) {
            const double factor = enlargement(scene, film);
            if (film.kind != Film::Kind::mode) add_animation(film, 1);
            if (film.kind == Film::Kind::mode || factor > 1) add_animation(film, factor);
        }
    }

    std::string text();
    std::size_t animations() const { return animations_.size(); }

private:
    /// Where every moving part is; in the order of moving_.
    std::vector<PartPose> poses_of(const Placement& placement) const;
    void add_meshes();
    void add_nodes();
    int add_node(const std::string& name, const PartPose& pose, int mesh, int parent);
    void add_animation(const Film& film, double factor);
    double thickness(const ElementLine& element) const {
        return std::clamp(element.diameter, kThinnestElement * size_, kThickestElement * size_);
    }

    const Scene& scene_;
    double size_;
    GltfData data_;
    Json nodes_ = Json::array(), meshes_ = Json::array(), materials_ = Json::array(), animations_ = Json::array();
    std::vector<int> moving_;
    enum Mesh : int { kBodyMesh, kNodeMesh, kElementMesh };
};

/// A cube of edges 1 about the origin, with the normals of its faces.
void GltfWriter::add_meshes() {
    std::vector<float> positions, normals;
    std::vector<uint16_t> indices;
    for (int axis = 0; axis < 3; ++axis)
        for (const float sign : {-1.f, 1.f}) {
            const auto first = static_cast<uint16_t>(positions.size() / 3);
            for (const auto& [a, b] :
                 {std::pair(-0.5f, -0.5f), std::pair(0.5f, -0.5f), std::pair(0.5f, 0.5f), std::pair(-0.5f, 0.5f)}) {
                std::array<float, 3> at{}, normal{};
                at[as_size(axis)] = 0.5f * sign;
                at[as_size((axis + 1) % 3)] = a * sign;  // mirrored on the lower face: seen from outside counterclockwise
                at[as_size((axis + 2) % 3)] = b;
                normal[as_size(axis)] = sign;
                positions.insert(positions.end(), at.begin(), at.end());
                normals.insert(normals.end(), normal.begin(), normal.end());
            }
            for (const int corner : {0, 1, 2, 0, 2, 3}) indices.push_back(static_cast<uint16_t>(first + corner));
        }
    const int position = data_.add(positions, 3, true, kArrayBuffer), normal = data_.add(normals, 3, false, kArrayBuffer),
              index = data_.add_indices(indices);
    const auto add = [&](const char* name, std::array<double, 4> colour) {
        Json material = {
            {"name", name},
            {"pbrMetallicRoughness", {{"baseColorFactor", colour}, {"metallicFactor", 0}, {"roughnessFactor", 0.8}}}};
        if (colour[3] < 1) material["alphaMode"] = "BLEND";
        materials_.push_back(material);
        meshes_.push_back({{"name", name},
                           {"primitives",
                            {{{"attributes", {{"POSITION", position}, {"NORMAL", normal}}},
                              {"indices", index},
                              {"material", as_int(materials_.size()) - 1}}}}});
    };
    add("body", {0.38, 0.53, 0.66, 0.6});
    add("node", {0.2, 0.2, 0.22, 1});
    add("element", {0.85, 0.6, 0.25, 1});
}

int GltfWriter::add_node(const std::string& name, const PartPose& pose, int mesh, int parent) {
    const auto& [t, q, s] = pose;
    Json node = {{"name", name},
                 {"translation", {t.x(), t.y(), t.z()}},
                 {"rotation", {q.x(), q.y(), q.z(), q.w()}},
                 {"scale", {s.x(), s.y(), s.z()}}};
    if (mesh >= 0) node["mesh"] = mesh;
    nodes_.push_back(std::move(node));
    const int index = as_int(nodes_.size()) - 1;
    if (parent >= 0) nodes_[as_size(parent)]["children"].push_back(index);
    return index;
}

void GltfWriter::add_nodes() {
    // x stays, z of the world becomes y of glTF, y becomes -z
    const double half = std::sqrt(0.5);
    const int root = add_node("dttmm", {Vector3d::Zero(), Quaterniond(half, -half, 0, 0), Vector3d::Ones()}, -1, -1);
    Instant start{std::vector<Moved>(scene_.structure().owners().size()),
                  std::vector<BentLine>(scene_.structure().elements().size()),
                  {}};
    start.lines = scene_.films().front().at(0).lines;  // its pieces; as they are at the beginning
    const Placement placement = scene_.place(start);
    const std::vector<PartPose> poses = poses_of(placement);
    std::size_t next = 0;
    for (const Owner& owner : scene_.structure().owners()) {
        moving_.push_back(add_node(owner.name, poses[next++], owner.box ? -1 : static_cast<int>(kNodeMesh), root));
        if (!owner.box) continue;
        const Vector3d edges = owner.box->edges.cwiseMax(kThinnestBox * size_);
        add_node(owner.name + " box", {owner.box->centre, owner.box->turn, edges}, kBodyMesh, moving_.back());
    }
    for (const ElementLine& element : scene_.structure().elements()) {
        const std::size_t e = as_size(&element - scene_.structure().elements().data());
        const std::size_t points = placement.lines[e].size(), pieces = points < 2 ? 1 : points - 1;
        const int parent = pieces == 1 ? root : add_node(element.name, {}, -1, root);
        for (std::size_t piece = 0; piece < pieces; ++piece)
            moving_.push_back(add_node(pieces == 1 ? element.name : fmt::format("{} {}", element.name, piece + 1),
                                       poses[next++], kElementMesh, parent));
    }
}

std::vector<PartPose> GltfWriter::poses_of(const Placement& placement) const {
    std::vector<PartPose> poses;
    const Structure& structure = scene_.structure();
    for (std::size_t i = 0; i < structure.owners().size(); ++i) {
        const auto& [position, turn] = placement.owners[i];
        const double scale = structure.owners()[i].box ? 1 : kNodeMark * size_;
        poses.push_back({position, turn, Vector3d::Constant(scale)});
    }
    for (std::size_t e = 0; e < structure.elements().size(); ++e) {
        const std::vector<Vector3d>& line = placement.lines[e];
        for (std::size_t i = 0; i + 1 < std::max<std::size_t>(line.size(), 2); ++i)
            poses.push_back(piece_pose(line[i], line[std::min(i + 1, line.size() - 1)], thickness(structure.elements()[e]),
                                       kElementMark * size_));
    }
    return poses;
}

void GltfWriter::add_animation(const Film& film, double factor) {
    const std::size_t count = film.times.size();
    std::vector<std::vector<float>> translations(moving_.size()), rotations(moving_.size()), scales(moving_.size());
    std::vector<Quaterniond> last(moving_.size(), Quaterniond::Identity());
    const auto append = [](std::vector<float>& list, std::initializer_list<double> numbers) {
        for (const double number : numbers) list.push_back(static_cast<float>(number));
    };
    for (std::size_t i = 0; i < count; ++i) {
        const std::vector<PartPose> poses = poses_of(scene_.place(film.at(i), factor));
        for (std::size_t p = 0; p < poses.size(); ++p) {
            const auto& [t, turn, s] = poses[p];
            Quaterniond q = turn;
            if (i > 0 && q.dot(last[p]) < 0) q.coeffs() = -q.coeffs();  // the shorter way
            last[p] = q;
            append(translations[p], {t.x(), t.y(), t.z()});
            append(rotations[p], {q.x(), q.y(), q.z(), q.w()});
            append(scales[p], {s.x(), s.y(), s.z()});
        }
    }
    std::vector<float> times;
    for (const double time : film.times) times.push_back(static_cast<float>(time - film.times.front()));
    for (std::size_t i = 1; i < count; ++i)  // seven digits cannot tell apart what is close together after a long time
        times[i] = std::max(times[i], std::nextafter(times[i - 1], std::numeric_limits<float>::infinity()));
    const int input = data_.add(times, 1, true);
    Json channels = Json::array(), samplers = Json::array();
    const auto add = [&](std::size_t part, const char* path, const std::vector<float>& numbers, std::size_t width) {
        samplers.push_back({{"input", input}, {"output", data_.add(numbers, width, false)}, {"interpolation", "LINEAR"}});
        channels.push_back(
            {{"sampler", as_int(samplers.size()) - 1}, {"target", {{"node", moving_[part]}, {"path", path}}}});
    };
    const auto changes = [&](std::size_t part, const char* member, const std::vector<float>& numbers, std::size_t width) {
        for (std::size_t i = 0; i < numbers.size(); ++i)
            if (numbers[i] != static_cast<float>(nodes_[as_size(moving_[part])][member][i % width].get<double>()))
                return true;
        return false;
    };
    for (std::size_t p = 0; p < moving_.size(); ++p) {
        if (changes(p, "translation", translations[p], 3)) add(p, "translation", translations[p], 3);
        if (changes(p, "rotation", rotations[p], 4)) add(p, "rotation", rotations[p], 4);
        if (changes(p, "scale", scales[p], 3)) add(p, "scale", scales[p], 3);
    }
    if (channels.empty()) return;
    std::string name = film.name;
    if (film.kind != Film::Kind::mode && factor != 1) name += fmt::format(", enlarged {:g} times", factor);
    Json extras = {{"displacements_times", factor}, {"begins_at_s", film.times.front()}};
    if (film.kind == Film::Kind::mode) extras = {{"frequency_hz", film.frequency}, {"shape_times_m", factor}};
    animations_.push_back({{"name", name}, {"channels", channels}, {"samplers", samplers}, {"extras", extras}});
}

std::string GltfWriter::text() {
    Json json = {{"asset", {{"generator", "dttmm " DTTMM_VERSION}, {"version", "2.0"}}},
                 {"scene", 0},
                 {"scenes", {{{"name", scene_.title().empty() ? "dttmm" : scene_.title()}, {"nodes", {0}}}}},
                 {"extras",
                  {{"title", scene_.title()},
                   {"unit", "m"},
                   {"bodies", "boxes of the same mass and inertia, not the real shape"},
                   {"left_out", scene_.notes()}}},
                 {"nodes", std::move(nodes_)},
                 {"meshes", std::move(meshes_)},
                 {"materials", std::move(materials_)}};
    if (!animations_.empty()) json["animations"] = std::move(animations_);
    json["accessors"] = data_.take_accessors();
    json["bufferViews"] = data_.take_views();
    const std::string& bytes = data_.bytes();
    json["buffers"] = {{{"byteLength", bytes.size()}}};
    std::string head = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    head.resize((head.size() + 3) / 4 * 4, ' ');
    const std::size_t total = 12 + 8 + head.size() + 8 + bytes.size();
    if (total > std::numeric_limits<uint32_t>::max())
        throw Error(ExitCode::resource_limit, "a glTF file has at most 4 GB; record fewer parts or instants");
    std::string all = "glTF";
    append_number(all, 2);
    append_number(all, as_whole<uint32_t>(total));
    append_number(all, as_whole<uint32_t>(head.size()));
    all += "JSON" + head;
    append_number(all, as_whole<uint32_t>(bytes.size()));
    all += std::string("BIN\0", 4) + bytes;
    return all;
}

}  // namespace

double enlargement(const Scene& scene, const Film& film) {
    constexpr double kAmplitude = 0.1, kMostAngle = 0.5, kVisible = 0.02, kFar = 0.3;  // of the size; [rad]
    const double size = scene.structure().size();
    Scene::Largest most;
    if (film.kind == Film::Kind::run) {
        const std::size_t every = std::max<std::size_t>(film.times.size() / 100, 1);
        for (std::size_t i = 0; i < film.times.size(); i += every) {
            const Scene::Largest one = scene.largest(film.at(i));
            most = {std::max(most.shift, one.shift), std::max(most.angle, one.angle)};
        }
    } else {
        most = scene.largest(film.at(film.fullest));
    }
    if (!(most.shift > 0) || !std::isfinite(most.shift)) return 1;
    const double wanted = std::min(kAmplitude * size / most.shift, most.angle > 0 ? kMostAngle / most.angle : INFINITY);
    if (film.kind == Film::Kind::mode) return wanted;
    if (most.shift > kVisible * size || most.angle > kFar || wanted < 2) return 1;
    const double power = std::pow(10, std::floor(std::log10(wanted)));
    for (const double step : {5.0, 2.0})
        if (step * power <= wanted) return step * power;
    return power;
}

std::string write_gltf(const Scene& scene, const std::filesystem::path& path) {
    GltfWriter writer(scene);
    const std::size_t animations = writer.animations();
    write_atomically(path, writer.text());
    std::string what = counted(animations, "animation", "animations");
    for (const std::string& note : scene.notes()) what += "\n" + note;
    return what;
}

}  // namespace dttmm::host
