// SPDX-License-Identifier: BSD-3-Clause
#include "report/three_views.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <vector>

#include "analysis/machine_geometry.h"
#include "model/index.h"
#include "model/wording.h"
#include "report/html_text.h"
#include "report/svg_chart.h"

namespace dttmm::host {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMargin = 46, kBetween = 34, kHeading = 22, kFoot = 54;  // [px]
constexpr double kWidest = 560, kHighest = 400, kBeside = 400;            // of the front view, of any, of the right view
constexpr double kLeastSide = 150;  // of any view: the longest heading has 21 characters of at most 7 px
constexpr double kAxis = 17, kArrow = 34, kCharacter = 6.3, kLine = 12;  // of axes, loads, labels

constexpr const char* kViewStyle = R"(<style>
svg{color-scheme:light dark;font:11px system-ui,sans-serif;--text:#1d1f21;--faint:#c9c9c4;--body:#9dbcd4;--edge:#3d6685;--element:#6d7276;--load:#c04e00;--x:#b3261e;--y:#00795a;--z:#0072b2}
@media(prefers-color-scheme:dark){svg{--text:#e4e4e0;--faint:#4a4d50;--body:#3f617c;--edge:#a9cbe6;--element:#a4a9ad;--load:#f0a030;--x:#ff8a80;--y:#37cfa5;--z:#62b5f0}}
text{fill:var(--text)}.heading{font-weight:600}path{fill:none}.body{fill:var(--body);fill-opacity:.22;stroke:var(--edge)}.edges{stroke:var(--edge);stroke-opacity:.35}.arm{stroke:var(--edge);stroke-dasharray:2 2}
.element{stroke:var(--element);stroke-width:2.4}.mark{stroke:var(--element);stroke-width:1.6}.node{fill:var(--text)}.joint{stroke:var(--text);stroke-width:1.6}.ground{stroke:var(--text)}
.load{stroke:var(--load);stroke-width:1.8}.head{fill:var(--load)}.x{stroke:var(--x)}.y{stroke:var(--y)}.z{stroke:var(--z)}.frame{stroke:var(--faint)}
text.x{fill:var(--x);stroke:none}text.y{fill:var(--y);stroke:none}text.z{fill:var(--z);stroke:none}
</style>
)";

/// Directions of the world that point right and up in a view.
struct Projection {
    const char* heading;
    Vector3d right, up;
    Vector2d of(const Vector3d& v) const { return {right.dot(v), up.dot(v)}; }
};

/// Front, top, right, from a corner: of the latter every axis is shortened alike (isometric).
std::array<Projection, 4> projections() {
    const double a = std::sqrt(0.5), b = std::sqrt(1. / 6), c = std::sqrt(2. / 3);
    return {{{"front, seen along y", {1, 0, 0}, {0, 0, 1}},
             {"top, seen from above", {1, 0, 0}, {0, 1, 0}},
             {"right, seen against x", {0, 1, 0}, {0, 0, 1}},
             {"from a corner", {a, a, 0}, {-b, b, c}}}};
}

struct DrawnBody {
    std::string name;
    Vector3d centre;
    std::array<Vector3d, 8> corners;  ///< bit 0, 1, 2 of the index: which end of the first, second, third edge
    std::vector<Vector3d> arms;       ///< places at which elements or joints hold it, apart from the centre
};

struct DrawnElement {
    std::string name;
    ElementPlace place;
};

struct DrawnArrow {
    std::string name;
    Vector3d at, direction;
    bool is_moment;
};

struct DrawnPoint {
    std::string name;
    Vector3d at;
    bool is_held;
    Vector3d axis = Vector3d::Zero();  ///< of a joint; zero: it has none
};

/// What there is to draw, in the world [m].
class DrawnMachine {
public:
    DrawnMachine(const Model& model, const ElementCatalogue& catalogue);

    std::vector<DrawnBody> bodies;
    std::vector<DrawnElement> elements;
    std::vector<DrawnPoint> nodes, joints;
    std::vector<DrawnArrow> loads;

    /// Everything that must be inside of the picture.
    std::vector<Vector3d> points() const;

private:
    void add_body(const Body& body);
    void add_arm(const Attachment& end, const Model& model);
    void add_load(const Model& model, const ElementCatalogue& catalogue, const Load& load);
};

DrawnMachine::DrawnMachine(const Model& model, const ElementCatalogue& catalogue) {
    for (const Body& body : model.bodies) add_body(body);
    for (const Node& node : model.nodes) nodes.push_back({node.name, node.position, node.fixed.any()});
    for (const Element& element : model.elements) {
        elements.push_back({element.name, place_at_start(model, element, *catalogue.types[as_size(element.type)])});
        for (const Attachment& end : element.ends) add_arm(end, model);
    }
    for (const Joint& joint : model.joints) {
        const bool has_axis = joint.type != JointType::ball && joint.type != JointType::fixed;
        joints.push_back({joint.name, joint.anchor, joint.first < 0 || joint.second < 0,
                          has_axis ? Vector3d(joint.axis) : Vector3d(Vector3d::Zero())});
        for (const int body : {joint.first, joint.second})
            if (body >= 0) bodies[as_size(body)].arms.push_back(joint.anchor);
    }
    for (const Load& load : model.loads) add_load(model, catalogue, load);
}

void DrawnMachine::add_body(const Body& body) {
    const EqualBox box = equal_box(body.mass, body.inertia);
    DrawnBody drawn{body.name, body.position + body.rotation * body.center_of_mass, {}, {}};
    for (std::size_t corner = 0; corner < 8; ++corner) {
        Vector3d half;
        for (int i = 0; i < 3; ++i) half[i] = (corner >> i & 1 ? 0.5 : -0.5) * box.edges[i];
        drawn.corners[corner] = drawn.centre + body.rotation * box.axes * half;
    }
    bodies.push_back(std::move(drawn));
}

void DrawnMachine::add_arm(const Attachment& end, const Model& model) {
    if (end.body >= 0) bodies[as_size(end.body)].arms.push_back(position_at_start(model, end));
}

void DrawnMachine::add_load(const Model& model, const ElementCatalogue& catalogue, const Load& load) {
    if (load.is_per_length()) {
        const Element& element = model.elements[as_size(load.element)];
        const ElementPlace place = place_at_start(model, element, *catalogue.types[as_size(element.type)]);
        const Vector3d direction = load.turns ? Vector3d(place.axes * load.direction) : load.direction;
        for (const double share : {0., 0.25, 0.5, 0.75, 1.})
            loads.push_back({share == 0.5 ? load.name : "", place.from + share * (place.to - place.from), direction, false});
        return;
    }
    Vector3d at = position_at_start(model, load.on), direction = load.direction;
    if (load.on.body >= 0) {
        const Body& body = model.bodies[as_size(load.on.body)];
        if (load.on.marker < 0) at = body.position + body.rotation * body.center_of_mass;
        if (load.turns) direction = body.rotation * load.direction;
    }
    loads.push_back({load.name, at, direction, load.is_moment});
}

std::vector<Vector3d> DrawnMachine::points() const {
    std::vector<Vector3d> all;
    for (const DrawnBody& body : bodies) {
        std::ranges::copy(body.corners, std::back_inserter(all));
        std::ranges::copy(body.arms, std::back_inserter(all));
    }
    for (const DrawnElement& element : elements) all.insert(all.end(), {element.place.from, element.place.to});
    for (const auto* list : {&nodes, &joints})
        for (const DrawnPoint& point : *list) all.push_back(point.at);
    return all;
}

struct Rectangle {
    double left, top, right, bottom;
    bool meets(const Rectangle& other) const {
        return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
    }
};

/// Names that cover no other name.
class Labels {
public:
    Labels(const Rectangle& frame, const Rectangle& kept_free) : frame_(frame), taken_{kept_free} {}

    /// Near a point of the picture. False: there is no room.
    bool put(const std::string& name, const Vector2d& at, std::string& svg) {
        const double width = kCharacter * static_cast<double>(name.size());
        for (const double distance : {7., 13., 20.})
            for (const Vector2d& way : {Vector2d(1, -0.6), Vector2d(1, 0.8), Vector2d(-1, -0.6), Vector2d(-1, 0.8),
                                        Vector2d(0, -1.3), Vector2d(0, 1.6)}) {
                const double x = at.x() + way.x() * distance - (way.x() < 0 ? width : way.x() == 0 ? width / 2 : 0);
                const double y = at.y() + way.y() * distance;
                const Rectangle place{x - 1, y - kLine / 2, x + width + 1, y + kLine / 2};
                if (!is_free(place)) continue;
                taken_.push_back(place);
                svg += fmt::format("<text class=\"name\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x, y + 4, html_text(name));
                return true;
            }
        return false;
    }

private:
    bool is_free(const Rectangle& place) const {
        return place.left >= frame_.left && place.right <= frame_.right && place.top >= frame_.top &&
               place.bottom <= frame_.bottom &&
               std::ranges::none_of(taken_, [&](const Rectangle& other) { return place.meets(other); });
    }

    Rectangle frame_;
    std::vector<Rectangle> taken_;
};

/// The corners of the convex hull of points, in order (Andrew's monotone chain).
std::vector<Vector2d> convex_hull(std::vector<Vector2d> points) {
    std::ranges::sort(
        points, [](const Vector2d& a, const Vector2d& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
    std::vector<Vector2d> hull;
    for (int turn = 0; turn < 2; ++turn) {
        const std::size_t begin = hull.size();
        for (const Vector2d& p : points) {
            const auto turns_left = [&] {
                const Vector2d a = hull.back() - hull[hull.size() - 2], b = p - hull.back();
                return a.x() * b.y() - a.y() * b.x() > 0;
            };
            while (hull.size() >= begin + 2 && !turns_left()) hull.pop_back();
            hull.push_back(p);
        }
        hull.pop_back();  // the first of the other half
        std::ranges::reverse(points);
    }
    return hull;
}

/// One view in its frame.
class View {
public:
    View(const DrawnMachine& machine, const Projection& projection, const Rectangle& frame, double scale,
         const Vector2d& middle, std::string& svg)
        : machine_(machine), projection_(projection), frame_(frame), scale_(scale), middle_(middle), svg_(svg) {}

    /// Returns the number of names without a place.
    int draw() {
        svg_ += fmt::format("<g><path class=\"frame\" d=\"M{:.1f} {:.1f}H{:.1f}V{:.1f}H{:.1f}Z\"/>\n", frame_.left,
                            frame_.top, frame_.right, frame_.bottom, frame_.left);
        svg_ += fmt::format("<text class=\"heading\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", frame_.left, frame_.top - 7,
                            projection_.heading);
        for (const DrawnBody& body : machine_.bodies) draw_body(body);
        for (const DrawnElement& element : machine_.elements) draw_element(element);
        for (const DrawnPoint& joint : machine_.joints) draw_joint(joint);
        for (const DrawnPoint& node : machine_.nodes) draw_node(node);
        for (const DrawnArrow& load : machine_.loads) draw_load(load);
        draw_world_axes();
        const int left_out = draw_names();
        svg_ += "</g>\n";
        return left_out;
    }

private:
    Vector2d place(const Vector3d& point) const {
        const Vector2d p = scale_ * (projection_.of(point) - middle_);
        return {(frame_.left + frame_.right) / 2 + p.x(), (frame_.top + frame_.bottom) / 2 - p.y()};
    }
    /// A direction in the picture; its length is the cosine of its angle to the plane of the picture.
    Vector2d way(const Vector3d& direction) const {
        const Vector2d d = projection_.of(direction);
        return {d.x(), -d.y()};
    }
    void line(const char* kind, const Vector2d& from, const Vector2d& to) {
        svg_ += fmt::format("<path class=\"{}\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}\"/>\n", kind, from.x(), from.y(), to.x(),
                            to.y());
    }

    void draw_body(const DrawnBody& body) {
        std::vector<Vector2d> corners;
        for (const Vector3d& corner : body.corners) corners.push_back(place(corner));
        svg_ += "<path class=\"body\" d=\"";
        char letter = 'M';
        for (const Vector2d& corner : convex_hull(corners))
            svg_ += fmt::format("{}{:.1f} {:.1f}", std::exchange(letter, 'L'), corner.x(), corner.y());
        svg_ += "Z\"/>\n<path class=\"edges\" d=\"";
        for (std::size_t from = 0; from < 8; ++from)
            for (const std::size_t bit : {1u, 2u, 4u})
                if (const std::size_t to = from | bit; to != from)
                    svg_ += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", corners[from].x(), corners[from].y(),
                                        corners[to].x(), corners[to].y());
        svg_ += "\"/>\n";
        for (const Vector3d& arm : body.arms)
            if ((place(arm) - place(body.centre)).norm() > 2) line("arm", place(body.centre), place(arm));
    }

    void draw_element(const DrawnElement& element) {
        const Vector2d from = place(element.place.from), to = place(element.place.to), middle = (from + to) / 2;
        if (element.place.is_long())
            line("element", from, to);
        else
            svg_ += fmt::format("<path class=\"mark\" d=\"M{:.1f} {:.1f}l5 5l-5 5l-5 -5Z\"/>\n", from.x(), from.y() - 5);
        if (element.place.is_grounded) draw_ground(from);
        // Axes at a place where others like them are drawn would only cover them
        const auto is_same = [&](const auto& other) {
            return (other.first - middle).norm() < 8 && (other.second - element.place.axes).norm() < 0.05;
        };
        if (std::ranges::any_of(drawn_axes_, is_same)) return;
        drawn_axes_.emplace_back(middle, element.place.axes);
        for (int i = 0; i < (element.place.has_only_x ? 1 : 3); ++i)
            line(kAxisNames[as_size(i)], middle, middle + kAxis * way(element.place.axes.col(i)));
    }

    void draw_joint(const DrawnPoint& joint) {
        const Vector2d at = place(joint.at), along = kAxis * way(joint.axis);
        svg_ += fmt::format("<circle class=\"joint\" fill=\"none\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5\"/>\n", at.x(), at.y());
        if (along.norm() > 5) line("joint", at - along, at + along);
        if (joint.is_held) draw_ground(at);
    }

    void draw_node(const DrawnPoint& node) {
        const Vector2d at = place(node.at);
        svg_ += fmt::format("<circle class=\"node\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.5\"/>\n", at.x(), at.y());
        if (node.is_held) draw_ground(at);
    }

    void draw_ground(const Vector2d& at) {
        svg_ += fmt::format("<path class=\"ground\" d=\"M{:.1f} {:.1f}l6 9h-12Zm-9 9h18\"/>\n", at.x(), at.y());
    }

    /// Forces end at their point, moments have a second head. What points at the eye is a ring.
    void draw_load(const DrawnArrow& load) {
        const Vector2d at = place(load.at), along = way(load.direction);
        if (along.norm() < 0.1) {
            svg_ +=
                fmt::format("<circle class=\"load\" fill=\"none\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"7\"/>\n", at.x(), at.y());
            return;
        }
        line("load", at - kArrow * along, at);
        const Vector2d ahead = along.normalized(), aside(-ahead.y(), ahead.x());
        for (const double back : {0., 7.}) {
            if (back > 0 && !load.is_moment) continue;
            const Vector2d tip = at - back * ahead, left = tip - 9 * ahead + 4 * aside, right = tip - 9 * ahead - 4 * aside;
            svg_ += fmt::format("<path class=\"head\" d=\"M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}Z\"/>\n", tip.x(),
                                tip.y(), left.x(), left.y(), right.x(), right.y());
        }
    }

    void draw_world_axes() {
        const Vector2d corner(frame_.left + 20, frame_.bottom - 20);
        for (int i = 0; i < 3; ++i) {
            const Vector2d along = way(Vector3d::Unit(i));
            if (along.norm() < 0.1) continue;
            const Vector2d end = corner + 22 * along, text = corner + 29 * along;
            line(kAxisNames[as_size(i)], corner, end);
            svg_ += fmt::format("<text class=\"{0}\" x=\"{1:.1f}\" y=\"{2:.1f}\" text-anchor=\"middle\">{0}</text>\n",
                                kAxisNames[as_size(i)], text.x(), text.y() + 4);
        }
    }

    int draw_names() {
        Labels labels(frame_, {frame_.left, frame_.bottom - 58, frame_.left + 58, frame_.bottom});
        int left_out = 0;
        const auto put = [&](const std::string& name, const Vector3d& at) {
            if (!name.empty() && !labels.put(name, place(at), svg_)) ++left_out;
        };
        for (const DrawnBody& body : machine_.bodies) put(body.name, body.centre);
        for (const DrawnPoint& joint : machine_.joints) put(joint.name, joint.at);
        for (const DrawnElement& element : machine_.elements) put(element.name, (element.place.from + element.place.to) / 2);
        for (const DrawnPoint& node : machine_.nodes) put(node.name, node.at);
        for (const DrawnArrow& load : machine_.loads) put(load.name, load.at);
        return left_out;
    }

    static constexpr std::array<const char*, 3> kAxisNames = {"x", "y", "z"};
    const DrawnMachine& machine_;
    const Projection& projection_;
    Rectangle frame_;
    double scale_;     ///< [px/m]
    Vector2d middle_;  ///< of the machine in this view [m]
    std::string& svg_;
    std::vector<std::pair<Vector2d, Eigen::Matrix3d>> drawn_axes_;
};

/// Smallest and largest coordinates of points, as a view has them.
struct Extent {
    Vector2d low, high;
    Vector2d size() const { return high - low; }
    Vector2d middle() const { return (low + high) / 2; }
};

Extent extent_of(const std::vector<Vector3d>& points, const Projection& projection) {
    Extent extent{projection.of(points.front()), projection.of(points.front())};
    for (const Vector3d& point : points) {
        extent.low = extent.low.cwiseMin(projection.of(point));
        extent.high = extent.high.cwiseMax(projection.of(point));
    }
    return extent;
}

/// A bar of a round length, about a fifth of the front view.
std::string scale_bar(double scale, double width, double y) {
    const double length = round_ticks(0, width / scale, 5)[1];
    const bool is_small = length < 1;
    return fmt::format(
        "<path class=\"ground\" d=\"M{0:.1f} {1:.1f}v6v-3h{2:.1f}v3v-6\"/><text x=\"{3:.1f}\" y=\"{4:.1f}\">{5:.6g} "
        "{6}</text>\n",
        kMargin, y, scale * length, kMargin + scale * length + 8, y + 7, is_small ? 1000 * length : length,
        is_small ? "mm" : "m");
}

}  // namespace

std::string draw_three_views(const Model& model, const ElementCatalogue& catalogue) {
    const DrawnMachine machine(model, catalogue);
    std::vector<Vector3d> points = machine.points();
    if (points.empty()) points.push_back(Vector3d::Zero());
    const std::array<Projection, 4> views = projections();
    std::array<Extent, 4> extents;
    for (std::size_t v = 0; v < views.size(); ++v) extents[v] = extent_of(points, views[v]);

    // One scale for front, top and right; a machine of no size gets one of its own
    const Vector2d front = extents[0].size(), right = extents[2].size(), corner = extents[3].size();
    const double room = 2 * kMargin;
    const double scale =
        1 / std::max({front.x() / (kWidest - room), front.y() / (kHighest - room), right.x() / (kBeside - room), 1e-6});
    const auto fitted = [&](double size) { return std::max(kLeastSide, scale * size + room); };
    const double width = fitted(front.x()), height = fitted(front.y()), depth = fitted(right.x());
    const double beside = std::max(depth, 260.), above = std::max(depth, 220.);
    const double corner_scale = 1 / std::max({corner.x() / (beside - room), corner.y() / (above - room), 1e-6});

    const double left = kBetween / 2, top = kHeading + 20, second = left + width + kBetween, lower = top + above + kBetween;
    const std::array<Rectangle, 4> frames = {{{left, lower, left + width, lower + height},
                                              {left, top, left + width, top + above},
                                              {second, lower, second + beside, lower + height},
                                              {second, top, second + beside, top + above}}};
    std::string drawn;
    int left_out = 0;
    for (std::size_t v = 0; v < views.size(); ++v)
        left_out += View(machine, views[v], frames[v], v == 3 ? corner_scale : scale, extents[v].middle(), drawn).draw();
    const std::string words =
        fmt::format("arrows: loads{}",
                    left_out > 0 ? "; " + counted(as_size(left_out), "label finds", "labels find") + " no place" : "");
    const std::string legend = "bodies: boxes of their mass and inertia; local axes of elements: x y z; ";
    const double whole_width = std::max(second + beside + kBetween / 2,
                                        left + kCharacter * static_cast<double>(legend.size() + words.size())),
                 whole_height = lower + height + kFoot;
    std::string svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
        "role=\"img\">\n<title>{2}</title>\n{3}",
        whole_width, whole_height, html_text(model.title.empty() ? "Three views of the machine" : model.title), kViewStyle);
    svg += fmt::format("<text class=\"heading\" x=\"{:.1f}\" y=\"16\">{}</text>\n", left, html_text(model.title));
    svg += drawn + scale_bar(scale, width - room, whole_height - 38);
    const std::string coloured =
        "<tspan style=\"fill:var(--x)\">x</tspan> <tspan style=\"fill:var(--y)\">y</tspan> "
        "<tspan style=\"fill:var(--z)\">z</tspan>; ";
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}{}{}</text>\n", left, whole_height - 12,
                       legend.substr(0, legend.size() - std::string("x y z; ").size()), coloured, words);
    return svg + "</svg>\n";
}

}  // namespace dttmm::host
