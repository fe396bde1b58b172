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

/// Searches in one graph, one after another; each takes no longer than what it reaches.
class PathSearch {
  public:
    /// Of nodes 0 to count - 1.
    explicit PathSearch(std::size_t count)
        : paths_{std::vector<double>(count, std::numeric_limits<double>::infinity()),
                 std::vector<int>(count, -1)} {}

    /// Of paths of one length the first one found stays; nodes of one length are visited in the
    /// order of their numbers.
    /// Source: Dijkstra, A note on two problems in connexion with graphs (1959).
    /// @param starts  nodes with the lengths that their paths begin with
    /// @param visit   visit(node, length, reach) calls reach(next, length_there) for every edge of
    ///                the node; that is true when the path to `next` was shortened
    template <class Visit>
    void run(const std::vector<std::pair<int, double>>& starts, const Visit& visit) {
        for (const int node : reached_) {
            paths_.length[std::size_t(node)] = std::numeric_limits<double>::infinity();
            paths_.from[std::size_t(node)] = -1;
        }
        reached_.clear();
        using Item = std::pair<double, int>;
        std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
        const auto reach = [&](int node, double length, int from) {
            double& known = paths_.length[std::size_t(node)];
            if (!(length < known)) return false;
            if (known == std::numeric_limits<double>::infinity()) reached_.push_back(node);
            known = length;
            paths_.from[std::size_t(node)] = from;
            queue.emplace(length, node);
            return true;
        };
        for (const auto& [node, length] : starts) reach(node, length, -1);
        while (!queue.empty()) {
            const auto [length, node] = queue.top();
            queue.pop();
            if (length > paths_.length[std::size_t(node)]) continue;
            visit(node, length,
                  [&, from = node](int next, double there) { return reach(next, there, from); });
        }
    }

    [[nodiscard]] const ShortestPaths& paths() const& { return paths_; }
    [[nodiscard]] ShortestPaths paths() && { return std::move(paths_); }
    /// Nodes with a path, each once.
    [[nodiscard]] const std::vector<int>& reached() const { return reached_; }

  private:
    ShortestPaths paths_;
    std::vector<int> reached_;
};

/// One search, see PathSearch.
template <class Visit>
ShortestPaths shortest_paths(std::size_t count, const std::vector<std::pair<int, double>>& starts,
                             const Visit& visit) {
    PathSearch search(count);
    search.run(starts, visit);
    return std::move(search).paths();
}

}  // namespace patchwright::geom
