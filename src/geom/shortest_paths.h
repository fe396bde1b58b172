// Shortest paths in a graph from one or several nodes.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

namespace patchwright::geom {

struct ShortestPaths {
    std::vector<double> length;  ///< one a node; infinite where it cannot be reached
    std::vector<int> from;       ///< one a node: the one before it on its path; -1: none

    /// The nodes of the path that ends here, beginning with the one where it starts.
    [[nodiscard]] std::vector<int> path_to(int node) const {
        std::vector<int> path;
        for (int i = node; i >= 0; i = from[std::size_t(i)]) path.push_back(i);
        std::reverse(path.begin(), path.end());
        return path;
    }
};

/// Paths of nodes 0 to count - 1. Of paths of one length the first one found stays; nodes of one
/// length are visited in the order of their numbers.
/// Source: Dijkstra, A note on two problems in connexion with graphs (1959).
/// @param starts  nodes with the lengths that their paths begin with
/// @param visit   visit(node, length, reach) calls reach(next, length_there) for every edge of the
///                node; that is true when the path to `next` was shortened
template <class Visit>
ShortestPaths shortest_paths(std::size_t count, const std::vector<std::pair<int, double>>& starts,
                             const Visit& visit) {
    ShortestPaths result{std::vector<double>(count, std::numeric_limits<double>::infinity()),
                         std::vector<int>(count, -1)};
    using Item = std::pair<double, int>;
    std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
    for (const auto& [node, length] : starts) {
        result.length[std::size_t(node)] = length;
        queue.emplace(length, node);
    }
    while (!queue.empty()) {
        const auto [length, node] = queue.top();
        queue.pop();
        if (length > result.length[std::size_t(node)]) continue;
        visit(node, length, [&, from = node](int next, double there) {
            if (there >= result.length[std::size_t(next)]) return false;
            result.length[std::size_t(next)] = there;
            result.from[std::size_t(next)] = from;
            queue.emplace(there, next);
            return true;
        });
    }
    return result;
}

}  // namespace patchwright::geom
