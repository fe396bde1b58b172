#include "grid/line_classes.h"

namespace patchwright::grid {

LineClasses line_classes(const BlockLayout& layout) {
    struct Link {
        int to;
        bool reversed;
    };
    std::vector<std::vector<Link>> links(layout.edges.size());
    for (const Block& block : layout.blocks) {
        for (const std::size_t side : {0U, 1U}) {
            const auto& uses = block.sides[side];
            const auto& opposite = block.sides[side + 2];
            for (std::size_t k = 0; k < uses.size(); ++k) {
                const BlockEdgeUse a = uses[k], b = opposite[opposite.size() - 1 - k];
                // Counter-clockwise, opposite sides run against each other.
                const bool reversed = a.reversed == b.reversed;
                links[std::size_t(a.edge)].push_back({b.edge, reversed});
                links[std::size_t(b.edge)].push_back({a.edge, reversed});
            }
        }
    }
    LineClasses classes;
    classes.edges.resize(layout.edges.size());
    for (std::size_t seed = 0; seed < links.size(); ++seed) {
        if (classes.edges[seed].line_class >= 0) continue;
        const int number = classes.count();
        classes.mirrored.push_back(0);
        classes.edges[seed] = {number, false};
        std::vector<std::size_t> open{seed};
        while (!open.empty()) {
            const std::size_t e = open.back();
            open.pop_back();
            for (const Link& link : links[e]) {
                auto& other = classes.edges[std::size_t(link.to)];
                const bool reversed = classes.edges[e].reversed != link.reversed;
                if (other.line_class < 0) {
                    other = {number, reversed};
                    open.push_back(std::size_t(link.to));
                } else if (other.reversed != reversed) {
                    classes.mirrored[std::size_t(number)] = 1;
                }
            }
        }
    }
    return classes;
}

}  // namespace patchwright::grid
