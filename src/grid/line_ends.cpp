#include "grid/line_ends.h"

#include <algorithm>

namespace patchwright::grid {

namespace {

double smaller(double a, double b) { return a == 0.0 ? b : b == 0.0 ? a : std::min(a, b); }

}  // namespace

std::vector<Ends> ends_at_borders(const BlockLayout& layout, const PlanOptions& options) {
    const auto places = edge_places(layout);
    std::vector<double> off_border(layout.edges.size(), 0.0);
    for (std::size_t e = 0; e < layout.edges.size(); ++e) {
        if (is_crease(layout, int(e))) off_border[e] = options.first_at_creases_mm;
        if (places[e].size() != 2) continue;
        const std::string& a = layout.blocks[std::size_t(places[e][0].block)].family;
        const std::string& b = layout.blocks[std::size_t(places[e][1].block)].family;
        if (a == b) continue;
        for (const BorderCluster& cluster : options.clusters) {
            const auto is = [](const std::string& wanted, const std::string& family) {
                return wanted.empty() || wanted == family;
            };
            if ((is(cluster.family_a, a) && is(cluster.family_b, b)) ||
                (is(cluster.family_a, b) && is(cluster.family_b, a))) {
                off_border[e] = smaller(off_border[e], cluster.first_mm);
            }
        }
    }
    std::vector<Ends> ends(layout.edges.size());
    for (const Block& block : layout.blocks) {
        for (std::size_t side = 0; side < 4; ++side) {
            // Lines along this side end at the last edge of the side before it and at the first of
            // the one after it.
            const auto& uses = block.sides[side];
            const auto set = [&](const BlockEdgeUse& use, bool at_begin,
                                 const BlockEdgeUse& border) {
                Ends& e = ends[std::size_t(use.edge)];
                double& size = at_begin != use.reversed ? e.first_mm : e.last_mm;
                size = smaller(size, off_border[std::size_t(border.edge)]);
            };
            set(uses.front(), true, block.sides[(side + 3) % 4].back());
            set(uses.back(), false, block.sides[(side + 1) % 4].front());
        }
    }
    return ends;
}

void share_ends(const LineClasses& classes, std::vector<Ends>& ends) {
    std::vector<Ends> of_class(std::size_t(classes.count()));
    const auto turned = [](const Ends& e, bool reversed) {
        return reversed ? Ends{e.last_mm, e.first_mm} : e;
    };
    for (std::size_t e = 0; e < ends.size(); ++e) {
        const auto c = std::size_t(classes.edges[e].line_class);
        const Ends own = turned(ends[e], classes.edges[e].reversed);
        Ends& all = of_class[c];
        all = {smaller(all.first_mm, own.first_mm), smaller(all.last_mm, own.last_mm)};
        if (classes.mirrored[c] != 0) {
            all.first_mm = all.last_mm = smaller(all.first_mm, all.last_mm);
        }
    }
    for (std::size_t e = 0; e < ends.size(); ++e) {
        ends[e] =
            turned(of_class[std::size_t(classes.edges[e].line_class)], classes.edges[e].reversed);
    }
}

}  // namespace patchwright::grid
