#include "cage/blocks/curve_spread.h"

#include "cage/blocks/line_shares.h"

#include <patchwright/base/numbers.h>

#include <algorithm>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

/// Arcs of the same curve that meet in nodes which may move along it, one after the other.
struct CurveChain {
    std::vector<Vec3> way;
    std::vector<int> points;
};

class CurveChains {
  public:
    CurveChains(const QuadLayout& layout, const std::vector<std::vector<int>>& lines)
        : layout_(layout),
          lines_(lines),
          arcs_at_(layout.nodes.size()),
          done_(layout.arcs.size(), 0) {
        for (std::size_t a = 0; a < layout.arcs.size(); ++a) {
            if (layout.arcs[a].curve < 0) continue;
            arcs_at_[at(layout.arcs[a].start)].push_back(a);
            arcs_at_[at(layout.arcs[a].end)].push_back(a);
        }
    }

    [[nodiscard]] const std::vector<std::size_t>& arcs_at(std::size_t node) const {
        return arcs_at_[node];
    }
    [[nodiscard]] bool moves(std::size_t node) const {
        return layout_.nodes[node].curve >= 0 && arcs_at_[node].size() == 2;
    }

    /// From a node along one of its arcs; empty when that is in a chain already.
    CurveChain take(std::size_t node, std::size_t arc) {
        CurveChain chain;
        while (done_[arc] == 0) {
            done_[arc] = 1;
            std::vector<Vec3> way = layout_.arcs[arc].points;
            std::vector<int> line = lines_[arc];
            if (line.front() != int(node)) {
                std::reverse(way.begin(), way.end());
                std::reverse(line.begin(), line.end());
            }
            const auto joint = chain.points.empty() ? 0 : 1;
            chain.way.insert(chain.way.end(), way.begin() + joint, way.end());
            chain.points.insert(chain.points.end(), line.begin() + joint, line.end());
            node = at(line.back());
            if (!moves(node)) break;
            arc = arcs_at_[node][0] == arc ? arcs_at_[node][1] : arcs_at_[node][0];
        }
        return chain;
    }

  private:
    const QuadLayout& layout_;
    const std::vector<std::vector<int>>& lines_;
    std::vector<std::vector<std::size_t>> arcs_at_;
    std::vector<char> done_;
};

}  // namespace

void spread_along_curves(const QuadLayout& layout, const std::vector<std::vector<int>>& lines,
                         const geom::ModelSurface& reference, std::vector<Vec3>& points) {
    CurveChains chains(layout, lines);
    // Closed curves without ends come last and begin at any node.
    for (const bool closed : {false, true}) {
        for (std::size_t node = 0; node < layout.nodes.size(); ++node) {
            if (!closed && chains.moves(node)) continue;
            for (const std::size_t arc : chains.arcs_at(node)) {
                const CurveChain chain = chains.take(node, arc);
                if (chain.points.empty()) continue;
                const auto spread =
                    resampled(chain.way, graded_shares(chain.way, int(chain.points.size()) - 1));
                for (std::size_t k = 1; k + 1 < spread.size(); ++k)
                    points[at(chain.points[k])] =
                        reference.nearest_on_curve(layout.arcs[arc].curve, spread[k]).point;
            }
        }
    }
}

}  // namespace patchwright::cage
