#include "grid/interfaces.h"

#include "grid/cell_point.h"

#include <algorithm>

namespace patchwright::grid {

namespace {

/// The first and last point of one use of an edge, in the edge's direction.
std::array<std::array<int, 2>, 2> ends_of(const Plan& plan, const EdgePlace& place) {
    const auto& uses = plan.layout.blocks[std::size_t(place.block)].sides[std::size_t(place.side)];
    int begin = 0;
    for (int k = 0; k < place.use; ++k) {
        begin += plan.edges[std::size_t(uses[std::size_t(k)].edge)].cells();
    }
    const BlockEdgeUse& use = uses[std::size_t(place.use)];
    const int end = begin + plan.edges[std::size_t(use.edge)].cells();
    const auto size = plan.size(place.block);
    const auto first = on_side(size, place.side, begin), last = on_side(size, place.side, end);
    return use.reversed ? std::array{last, first} : std::array{first, last};
}

Interface connection(const Plan& plan, const EdgePlace& a, const EdgePlace& b) {
    auto own = ends_of(plan, a), other = ends_of(plan, b);
    if (own[0] > own[1]) {
        std::swap(own[0], own[1]);
        std::swap(other[0], other[1]);
    }
    Interface i{a.block, b.block, own[0], own[1], other[0], other[1], {}};
    const int along = a.side % 2, along_donor = b.side % 2;
    const auto d = std::size_t(along_donor);
    const bool rises = other[1][d] > other[0][d];
    i.transform[std::size_t(along)] = (rises ? 1 : -1) * (along_donor + 1);
    // Out of one block is into the other. Sides 1 and 2 are where an index is highest.
    const bool same_end = (a.side == 1 || a.side == 2) == (b.side == 1 || b.side == 2);
    i.transform[std::size_t(1 - along)] = (same_end ? -1 : 1) * (2 - along_donor);
    return i;
}

}  // namespace

Interfaces find_interfaces(const Plan& plan) {
    Interfaces result;
    for (const auto& places : edge_places(plan.layout)) {
        if (places.size() == 2) {
            result.connections.push_back(connection(plan, places[0], places[1]));
            result.connections.push_back(connection(plan, places[1], places[0]));
        } else {
            const auto [begin, end] = ends_of(plan, places[0]);
            result.free.push_back({places[0].block, std::min(begin, end), std::max(begin, end)});
        }
    }
    return result;
}

}  // namespace patchwright::grid
