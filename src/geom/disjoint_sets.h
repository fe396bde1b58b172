// Disjoint sets with union by least member (Galler and Fischer 1964, path halving).
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace patchwright::geom {

/// Sets of the numbers 0 to size() - 1; at first each number is a set of its own.
class DisjointSets {
  public:
    explicit DisjointSets(std::size_t count = 0) : parent_(count) {
        std::iota(parent_.begin(), parent_.end(), 0);
    }

    /// Adds a set of one new number, which is returned.
    int add() {
        parent_.push_back(int(parent_.size()));
        return parent_.back();
    }

    /// The least number of the set that i is in.
    int find(int i) {
        while (parent_[std::size_t(i)] != i)
            i = parent_[std::size_t(i)] = parent_[std::size_t(parent_[std::size_t(i)])];
        return i;
    }

    void join(int a, int b) {
        a = find(a);
        b = find(b);
        parent_[std::size_t(std::max(a, b))] = std::min(a, b);
    }

    [[nodiscard]] std::size_t size() const { return parent_.size(); }

    /// All sets in the order of their least numbers, each in ascending order.
    [[nodiscard]] std::vector<std::vector<int>> sets() {
        std::vector<std::vector<int>> result;
        std::vector<std::size_t> number(size());
        for (std::size_t i = 0; i < size(); ++i) {
            const auto root = std::size_t(find(int(i)));
            if (root == i) {
                number[i] = result.size();
                result.emplace_back();
            }
            result[number[root]].push_back(int(i));
        }
        return result;
    }

  private:
    std::vector<int> parent_;
};

}  // namespace patchwright::geom
