#include "adapt/quad_forest.h"

#include <tuple>

namespace patchwright::adapt {

std::int32_t QuadForest::add_point(const ForestPlace& place) {
    places_.push_back(place);
    return static_cast<std::int32_t>(places_.size() - 1);
}

std::int32_t QuadForest::add_edge(std::int32_t a, std::int32_t b) {
    edges_.push_back({.a = a, .b = b});
    return static_cast<std::int32_t>(edges_.size() - 1);
}

void QuadForest::add_quad(const Quad& quad) {
    const auto number = static_cast<std::int32_t>(quads_.size());
    quads_.push_back(quad);
    for (const std::int32_t edge : quad.edges) use(edge, number);
}

void QuadForest::use(std::int32_t edge, std::int32_t quad) {
    auto& users = edges_[std::size_t(edge)].users;
    (users[0] < 0 ? users[0] : users[1]) = quad;
}

void QuadForest::mark_border() {
    for (Edge& edge : edges_) edge.is_border = edge.users[1] < 0;
}

void QuadForest::leave(std::int32_t edge, std::int32_t quad) {
    for (std::int32_t& user : edges_[std::size_t(edge)].users)
        if (user == quad) user = -1;
}

void QuadForest::divide_edge(std::int32_t edge, const ForestPlace& place) {
    const std::int32_t middle = add_point(place);
    const auto [a, b] = std::pair(edges_[std::size_t(edge)].a, edges_[std::size_t(edge)].b);
    const std::int32_t first = add_edge(a, middle);
    const std::int32_t second = add_edge(middle, b);
    edges_[std::size_t(first)].parent = edges_[std::size_t(second)].parent = edge;
    edges_[std::size_t(first)].is_border = edges_[std::size_t(second)].is_border =
        edges_[std::size_t(edge)].is_border;
    edges_[std::size_t(edge)].middle = middle;
    edges_[std::size_t(edge)].child = first;
}

std::pair<std::int32_t, bool> QuadForest::half(const Quad& quad, std::size_t side,
                                               bool second) const {
    const bool reversed = quad.reversed[side];
    return {edges_[std::size_t(quad.edges[side])].child + (second != reversed ? 1 : 0), reversed};
}

void QuadForest::divide(std::int32_t number) {
    if (!is_leaf(number)) return;
    for (std::size_t side = 0; side < 4; ++side) {
        const std::int32_t edge = quads_[std::size_t(number)].edges[side];
        if (edges_[std::size_t(edge)].child >= 0) continue;
        // A leaf that has the whole edge of which this one is half would get two hanging nodes.
        const std::int32_t whole = edges_[std::size_t(edge)].parent;
        for (std::size_t k = 0; whole >= 0 && k < 2; ++k)
            if (const std::int32_t user = edges_[std::size_t(whole)].users[k]; user >= 0)
                divide(user);
        divide_edge(edge, middle(number, side));
    }
    const Quad parent = quads_[std::size_t(number)];
    const ForestPlace centre{parent.block,
                             0.25 * (parent.at[0] + parent.at[1] + parent.at[2] + parent.at[3])};
    const std::int32_t centre_point = add_point(centre);
    std::array<std::int32_t, 4> inner{};  // from the middles of the sides to the centre
    for (std::size_t k = 0; k < 4; ++k)
        inner[k] = add_edge(edges_[std::size_t(parent.edges[k])].middle, centre_point);
    for (const std::int32_t edge : parent.edges) leave(edge, number);
    quads_[std::size_t(number)].child = static_cast<std::int32_t>(quads_.size());
    for (std::size_t k = 0; k < 4; ++k) {
        // The child keeps its parent's directions: corner k is the parent's.
        const std::size_t k1 = (k + 1) % 4, k2 = (k + 2) % 4, k3 = (k + 3) % 4;
        Quad child{.edges = {},
                   .reversed = {},
                   .block = parent.block,
                   .level = parent.level + 1,
                   .at = {}};
        std::tie(child.edges[k], child.reversed[k]) = half(parent, k, false);
        child.edges[k1] = inner[k];
        child.reversed[k1] = false;
        child.edges[k2] = inner[k3];
        child.reversed[k2] = true;
        std::tie(child.edges[k3], child.reversed[k3]) = half(parent, k3, true);
        child.at[k] = parent.at[k];
        child.at[k1] = 0.5 * (parent.at[k] + parent.at[k1]);
        child.at[k2] = centre.at;
        child.at[k3] = 0.5 * (parent.at[k] + parent.at[k3]);
        add_quad(child);
    }
}

}  // namespace patchwright::adapt
