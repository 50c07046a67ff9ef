// SPDX-License-Identifier: BSD-3-Clause
#include "solve/elimination_order.h"

#include <algorithm>
#include <deque>
#include <functional>
#include <queue>
#include <utility>

#include "core/index.h"

namespace dttmm::plugin {

namespace {

/// Of every frame its neighbours, ascending.
using Graph = std::vector<std::vector<int>>;

void join(std::vector<int>& neighbours, int frame) {
    const auto at = std::ranges::lower_bound(neighbours, frame);
    if (at == neighbours.end() || *at != frame) neighbours.insert(at, frame);
}

/// Order of elimination: frames with one neighbour left as long as there are any, in the order in which they come up, so
/// that a chain is eaten from both tips; among them those held by something known last, so that the frames of a tree that
/// hangs there find the frame which carries them; where only loops are left, the frame with the fewest neighbours. `graph`
/// is filled in on the way.
std::vector<int> find_order(Graph& graph, const std::vector<bool>& is_held) {
    const size_t n = graph.size();
    Graph left = graph;
    std::vector<bool> done(n), queued(n);
    std::deque<int> free_tips, held_tips;
    // Number of neighbours and frame, the fewest first; entries of former numbers stay in it
    using Entry = std::pair<size_t, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> by_degree;
    const auto note = [&](size_t f) {
        by_degree.emplace(left[f].size(), as_int(f));
        if (left[f].size() > 1 || queued[f]) return;
        (is_held[f] ? held_tips : free_tips).push_back(as_int(f));
        queued[f] = true;
    };
    for (size_t f = 0; f < n; ++f) note(f);
    std::vector<int> order;
    while (order.size() < n) {
        int frame;
        if (std::deque<int>& tips = free_tips.empty() ? held_tips : free_tips; !tips.empty()) {
            frame = tips.front();
            tips.pop_front();
        } else {
            const auto [degree, fewest] = by_degree.top();
            by_degree.pop();
            if (degree != left[as_size(fewest)].size()) continue;
            frame = fewest;
        }
        const auto f = as_size(frame);
        if (done[f]) continue;
        done[f] = true;
        order.push_back(frame);
        const std::vector<int> neighbours = std::move(left[f]);
        for (int a : neighbours) {
            auto& of_a = left[as_size(a)];
            of_a.erase(std::ranges::lower_bound(of_a, frame));
            for (int b : neighbours)
                if (a != b) {
                    join(of_a, b);
                    join(graph[as_size(a)], b);
                }
            note(as_size(a));
        }
    }
    return order;
}

}  // namespace

EliminationOrder::EliminationOrder(int frame_count, const std::vector<Link>& links) {
    const auto n = as_size(frame_count);
    Graph graph(n);
    std::vector<bool> is_held(n);
    for (const Link& link : links) {
        if (link.from < 0 || link.to < 0) {
            if (link.rigid_count > 0) is_held[as_size(std::max(link.from, link.to))] = true;
        } else if (link.from != link.to) {
            join(graph[as_size(link.from)], link.to);
            join(graph[as_size(link.to)], link.from);
        }
    }
    const std::vector<int> order = find_order(graph, is_held);
    place_.resize(n);
    for (size_t k = 0; k < n; ++k) place_[as_size(order[k])] = as_int(k);

    // Couplings of later frames with each frame, those that fill in among them
    Later later(n);
    for (size_t f = 0; f < n; ++f)
        for (int other : graph[f]) {
            if (!earlier(as_int(f), other)) continue;
            later[f].push_back({other, as_int(couplings_.size())});
            couplings_.push_back({as_int(f), other});
        }
    add_links(links, later);
    add_pivots(order, later);
    sort_pivots();
}

bool EliminationOrder::earlier(int a, int b) const { return place_[as_size(a)] < place_[as_size(b)]; }

int EliminationOrder::coupling_of(const Later& later, int a, int b) const {
    if (!earlier(a, b)) std::swap(a, b);
    for (const auto& [frame, coupling] : later[as_size(a)])
        if (frame == b) return coupling;
    return -1;
}

void EliminationOrder::add_links(const std::vector<Link>& links, const Later& later) {
    for (size_t l = 0; l < links.size(); ++l) {
        const Link& link = links[l];
        OfLink own;
        own.first_row = as_int(rows_.size());
        if (link.from >= 0 && link.to >= 0 && link.from != link.to) {
            own.coupling = coupling_of(later, link.from, link.to);
            own.is_transposed = !earlier(link.from, link.to);
        }
        links_.push_back(own);
        for (int i = 0; i < link.rigid_count; ++i) rows_.push_back({as_int(l), i, {link.from, link.to}});
    }
}

void EliminationOrder::add_pivots(const std::vector<int>& order, const Later& later) {
    pivots_.reserve(order.size());
    for (int frame : order) {
        Pivot& pivot = pivots_.emplace_back();
        pivot.frame = frame;
        pivot.neighbours = later[as_size(frame)];
        for (size_t i = 0; i < pivot.neighbours.size(); ++i)
            for (size_t j = i + 1; j < pivot.neighbours.size(); ++j) {
                pivot.fills.push_back(coupling_of(later, pivot.neighbours[i].frame, pivot.neighbours[j].frame));
            }
    }
    for (size_t row = 0; row < rows_.size(); ++row) {
        const auto& [a, b] = rows_[row].frames;
        const int first = a >= 0 && b >= 0 ? (earlier(a, b) ? a : b) : std::max(a, b);
        pivots_[as_size(place_[as_size(first)])].rigid.push_back(as_int(row));
    }
}

/// Which are elastic, which of these plain, and which may pass rows on to whom.
void EliminationOrder::sort_pivots() {
    for (size_t k = 0; k < pivots_.size(); ++k) {
        Pivot& pivot = pivots_[k];
        pivot.is_elastic = pivot.rigid.empty() && pivot.children.empty();
        pivot.is_plain = pivot.is_elastic && pivot.neighbours.size() <= 1;
        plain_index_.push_back(pivot.is_plain ? as_int(plain_.size()) : -1);
        // The rigid directions of one joint are independent of each other: nothing to pass on
        const auto link_of = [&](int row) { return rows_[as_size(row)].link; };
        const bool of_one_joint = pivot.rigid.empty() || link_of(pivot.rigid.front()) == link_of(pivot.rigid.back());
        if (!pivot.neighbours.empty() && (!of_one_joint || !pivot.children.empty())) {
            pivot.passed = as_int(passing_.size());
            passing_.push_back(pivot.neighbours.size());
            int next = as_int(pivots_.size());
            for (const Neighbour& neighbour : pivot.neighbours) next = std::min(next, place_[as_size(neighbour.frame)]);
            pivots_[as_size(next)].children.push_back(as_int(k));
        }
        if (pivot.is_plain)
            plain_.push_back(pivot.neighbours.empty()
                                 ? Plain{pivot.frame, -1, -1}
                                 : Plain{pivot.frame, pivot.neighbours.front().frame, pivot.neighbours.front().coupling});
        if (pivot.is_elastic) continue;
        pivot.index = as_int(general_.size());
        general_.push_back(pivot.neighbours.size());
    }
}

}  // namespace dttmm::plugin
