// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

namespace dttmm::plugin {

/// A coupling of two unknown frames, or of one with what is known (to = −1), and the number of equations in which the joint
/// there is rigid.
struct Link {
    int from, to;
    int rigid_count;
};

/// In which order the frames of a network are eliminated, and what each then meets. It follows from the links alone and does
/// not change: factors of matrices with the same links share it.
class EliminationOrder {
public:
    EliminationOrder(int frame_count, const std::vector<Link>& links);

    /// A frame that is eliminated later than the one at hand, and the block (this frame, neighbour).
    struct Neighbour {
        int frame;
        int coupling;
    };
    /// The elimination of one frame.
    struct Pivot {
        int frame;
        std::vector<int> rigid;     ///< rows of J first met here
        std::vector<int> children;  ///< pivots that may pass rows on to this one
        std::vector<Neighbour> neighbours;
        std::vector<int> fills;   ///< couplings between two neighbours, as pairs i < j run
        bool is_elastic = false;  ///< nothing rigid meets here
        bool is_plain = false;    ///< nor more than one neighbour
        int index = -1;           ///< of one that is not elastic: among the general ones
        int passed = -1;          ///< among those that may pass rows on; −1: there never are any
    };
    /// All that a solution wants to know of a plain pivot, close together; neighbour: −1: none.
    struct Plain {
        int frame, neighbour;
        int coupling;  ///< of the two
    };
    struct Coupling {
        int row, column;  ///< frames; the row is eliminated first
    };
    struct OfLink {
        int coupling = -1;  ///< −1: with what is known
        bool is_transposed = false;
        int first_row = 0;  ///< of J
    };
    /// A rigid direction: number `index` of a link.
    struct Row {
        int link, index;
        int frames[2];
    };

    const std::vector<Pivot>& pivots() const { return pivots_; }
    /// Of a pivot among the plain ones; −1: it is not plain.
    const std::vector<int>& plain_index() const { return plain_index_; }
    const std::vector<Plain>& plain() const { return plain_; }
    const std::vector<Coupling>& couplings() const { return couplings_; }
    const std::vector<OfLink>& links() const { return links_; }
    const std::vector<Row>& rows() const { return rows_; }
    /// Numbers of neighbours: of every pivot that is not elastic, of every one that may pass rows on.
    const std::vector<std::size_t>& general() const { return general_; }
    const std::vector<std::size_t>& passing() const { return passing_; }

private:
    using Later = std::vector<std::vector<Neighbour>>;  ///< of every frame
    bool earlier(int a, int b) const;
    int coupling_of(const Later& later, int a, int b) const;
    Later find_later(const std::vector<int>& order, const std::vector<Link>& links);
    void add_links(const std::vector<Link>& links, const Later& later);
    void add_pivots(const std::vector<int>& order, const Later& later);
    void sort_pivots();

    std::vector<int> place_;  ///< of every frame in the order
    std::vector<Pivot> pivots_;
    std::vector<int> plain_index_;
    std::vector<Plain> plain_;
    std::vector<Coupling> couplings_;
    std::vector<OfLink> links_;
    std::vector<Row> rows_;
    std::vector<std::size_t> general_, passing_;
};

}  // namespace dttmm::plugin
