#include "geom/bvh.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>

namespace patchwright::geom {

namespace {

constexpr int bin_count = 16;
// Below this depth splits go by the median, which bounds the depth that remains by log2 of the
// count.
constexpr int last_heuristic_depth = 48;

struct Bin {
    Box3 box;
    int count = 0;
};

// Padded, as flat boxes and points (area 0) must still be worth separating.
double half_area(const Box3& box, double pad) {
    if (box.empty()) return 0.0;
    const Vec3 d = (box.max - box.min).array() + pad;
    return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
}

// The bin after which to split at the least expected cost, or none when all lie in one bin.
std::optional<int> best_split(const std::array<Bin, bin_count>& bins, double pad) {
    std::array<double, bin_count> right_cost{};
    Bin right;
    for (int i = bin_count - 1; i > 0; --i) {
        right.box.add(bins[std::size_t(i)].box);
        right.count += bins[std::size_t(i)].count;
        right_cost[std::size_t(i)] = half_area(right.box, pad) * right.count;
    }
    const int total = right.count + bins[0].count;
    std::optional<int> best;
    double best_cost = std::numeric_limits<double>::infinity();
    Bin left;
    for (int i = 0; i + 1 < bin_count; ++i) {
        left.box.add(bins[std::size_t(i)].box);
        left.count += bins[std::size_t(i)].count;
        const double cost = half_area(left.box, pad) * left.count + right_cost[std::size_t(i) + 1];
        if (left.count > 0 && left.count < total && cost < best_cost) {
            best = i;
            best_cost = cost;
        }
    }
    return best;
}

}  // namespace

struct Bvh::BinaryNode {
    Box3 box;
    std::int32_t first = 0;  ///< inner node: left child, the right one follows; leaf: first item
    std::int32_t count = 0;  ///< 0 for inner nodes
};

struct Bvh::Builder {
    const std::vector<Box3>& boxes;
    std::vector<BinaryNode>& nodes;
    std::vector<std::int32_t>& items;
    int leaf_size;
    static constexpr std::int32_t few = 64;

    struct Task {
        std::int32_t node, begin, end;
        int depth;
    };

    [[nodiscard]] Vec3 centre(std::int32_t item) const { return boxes[std::size_t(item)].centre(); }

    // Few items are cut so that all leaves but one are full: half-full ones cost as much to look at
    // and to keep. Among such cuts across the three axes the one of least expected cost.
    std::int32_t split_few(const Task& task) {
        const std::int32_t count = task.end - task.begin;
        const auto first = items.begin() + task.begin, last = items.begin() + task.end;
        Box3 centres;
        for (auto it = first; it != last; ++it) centres.add(centre(*it));
        const double pad = 0.01 * (centres.max - centres.min).maxCoeff();
        const auto sort = [&](int axis) {
            std::sort(first, last, [&](std::int32_t a, std::int32_t b) {
                return std::pair(centre(a)[axis], a) < std::pair(centre(b)[axis], b);
            });
        };
        const auto leaves = [&](std::int32_t n) { return double((n + leaf_size - 1) / leaf_size); };
        std::array<double, few> right_area{};
        double best_cost = std::numeric_limits<double>::infinity();
        int best_axis = 0;
        std::int32_t best_cut = count / 2;
        for (int axis = 0; axis < 3; ++axis) {
            sort(axis);
            Box3 right, left;
            for (std::int32_t i = count - 1; i > 0; --i) {
                right.add(boxes[std::size_t(first[i])]);
                right_area[std::size_t(i)] = half_area(right, pad);
            }
            for (std::int32_t i = 1; i < count; ++i) {
                left.add(boxes[std::size_t(first[i - 1])]);
                if (i % leaf_size != 0 && (count - i) % leaf_size != 0) continue;
                const double cost = half_area(left, pad) * leaves(i) +
                                    right_area[std::size_t(i)] * leaves(count - i);
                if (!(cost < best_cost)) continue;
                best_cost = cost;
                best_axis = axis;
                best_cut = i;
            }
        }
        if (best_axis != 2) sort(best_axis);
        return task.begin + best_cut;
    }

    // Reorders [begin, end) and returns where the right half starts.
    std::int32_t split(const Task& task) {
        if (task.end - task.begin <= few) return split_few(task);
        Box3 centres;
        for (auto i = task.begin; i < task.end; ++i) centres.add(centre(items[std::size_t(i)]));
        int axis = 0;
        const double extent = (centres.max - centres.min).maxCoeff(&axis);
        const auto first = items.begin() + task.begin;
        const auto last = items.begin() + task.end;
        if (extent > 0.0 && task.depth < last_heuristic_depth) {
            const double low = centres.min[axis];
            const auto bin_of = [&](std::int32_t item) {
                const double x = (centre(item)[axis] - low) / extent;
                return std::clamp(int(x * bin_count), 0, bin_count - 1);
            };
            std::array<Bin, bin_count> bins;
            for (auto it = first; it != last; ++it) {
                Bin& bin = bins[std::size_t(bin_of(*it))];
                bin.box.add(boxes[std::size_t(*it)]);
                ++bin.count;
            }
            if (const auto cut = best_split(bins, 0.01 * extent)) {
                const auto middle = std::partition(
                    first, last, [&](std::int32_t item) { return bin_of(item) <= *cut; });
                return std::int32_t(middle - items.begin());
            }
        }
        const auto middle = first + (last - first) / 2;
        std::nth_element(first, middle, last, [&](std::int32_t a, std::int32_t b) {
            return std::pair(centre(a)[axis], a) < std::pair(centre(b)[axis], b);
        });
        return std::int32_t(middle - items.begin());
    }

    void run() {
        nodes.reserve(2 * boxes.size());
        nodes.emplace_back();
        std::vector<Task> tasks{{0, 0, std::int32_t(items.size()), 0}};
        while (!tasks.empty()) {
            const Task task = tasks.back();
            tasks.pop_back();
            Box3 box;
            for (auto i = task.begin; i < task.end; ++i)
                box.add(boxes[std::size_t(items[std::size_t(i)])]);
            nodes[std::size_t(task.node)].box = box;
            if (task.end - task.begin <= leaf_size) {
                nodes[std::size_t(task.node)].first = task.begin;
                nodes[std::size_t(task.node)].count = task.end - task.begin;
                continue;
            }
            const std::int32_t middle = split(task);
            const auto child = std::int32_t(nodes.size());
            nodes[std::size_t(task.node)].first = child;
            nodes.resize(nodes.size() + 2);
            tasks.push_back({child + 1, middle, task.end, task.depth + 1});
            tasks.push_back({child, task.begin, middle, task.depth + 1});
        }
    }
};

// Each node takes in the children of the larger of its children until it has four.
void Bvh::widen(const std::vector<BinaryNode>& binary) {
    bounds_ = binary.front().box;
    centre_ = bounds_.centre();
    const double extent = (bounds_.max - bounds_.min).maxCoeff();
    if (extent > 0.0) scale_ = 1.0 / extent;
    // Differences in single precision are off by this much at most.
    constexpr double slack = 8e-7;
    const auto lane = [&](Node& node, std::size_t child, const BinaryNode& from) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto i = static_cast<Eigen::Index>(k), c = static_cast<Eigen::Index>(child);
            node.low[k][c] = static_cast<float>((from.box.min[i] - centre_[i]) * scale_ - slack);
            node.high[k][c] = static_cast<float>((from.box.max[i] - centre_[i]) * scale_ + slack);
        }
        node.child[child] = pack(static_cast<std::size_t>(from.first), from.count);
    };
    struct Task {
        std::size_t node, binary;
    };
    nodes_.emplace_back();
    std::vector<Task> tasks{{0, 0}};
    while (!tasks.empty()) {
        const Task task = tasks.back();
        tasks.pop_back();
        std::vector<std::size_t> children{task.binary};
        while (children.size() < width) {
            const auto largest = std::max_element(
                children.begin(), children.end(), [&](std::size_t a, std::size_t b) {
                    const auto size = [&](std::size_t i) {
                        return binary[i].count > 0 ? -1.0 : half_area(binary[i].box, 0.0);
                    };
                    return size(a) < size(b);
                });
            if (binary[*largest].count > 0) break;
            const auto left = static_cast<std::size_t>(binary[*largest].first);
            *largest = left;
            children.push_back(left + 1);
        }
        Node node;
        for (auto& low : node.low) low = std::numeric_limits<float>::infinity();
        for (auto& high : node.high) high = -std::numeric_limits<float>::infinity();
        node.child.fill(0);
        for (std::size_t c = 0; c < children.size(); ++c) {
            lane(node, c, binary[children[c]]);
            if (binary[children[c]].count > 0) continue;
            node.child[c] = pack(nodes_.size(), 0);
            tasks.push_back({nodes_.size(), children[c]});
            nodes_.emplace_back();
        }
        nodes_[task.node] = node;
    }
}

Bvh::Bvh(const std::vector<Box3>& boxes, int leaf_size) {
    constexpr int largest_leaf = (1 << count_bits) - 1;
    if (leaf_size < 1 || leaf_size > largest_leaf)
        throw base::InvalidArgument(
            fmt::format("leaf size is {}, must be from 1 to {}", leaf_size, largest_leaf));
    // Sorting the items may leave three numbers in four without one.
    if (boxes.size() >> (30 - count_bits) != 0)
        throw base::InvalidArgument(fmt::format("{} boxes are too many", boxes.size()));
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        if (boxes[i].empty() || !boxes[i].min.allFinite() || !boxes[i].max.allFinite())
            throw base::InvalidArgument(fmt::format("box {} is empty or not finite", i));
    }
    if (boxes.empty()) return;
    items_.resize(boxes.size());
    std::iota(items_.begin(), items_.end(), 0);
    std::vector<BinaryNode> binary;
    Builder{boxes, binary, items_, leaf_size}.run();
    widen(binary);
}

std::vector<std::int32_t> Bvh::sort_items(int alignment) {
    if (alignment < 1)
        throw base::InvalidArgument(fmt::format("alignment is {}, must be at least 1", alignment));
    std::vector<std::int32_t> order;
    order.reserve(items_.size());
    for (Node& node : nodes_) {
        for (std::size_t child = 0; child < width; ++child) {
            const std::int32_t count = count_of(node.child[child]);
            if (count == 0) continue;
            const auto first = items_.begin() + first_of(node.child[child]);
            while (order.size() % std::size_t(alignment) != 0) order.push_back(-1);
            node.child[child] = pack(order.size(), count);
            order.insert(order.end(), first, first + count);
        }
    }
    while (order.size() % std::size_t(alignment) != 0) order.push_back(-1);
    items_.resize(order.size());
    std::iota(items_.begin(), items_.end(), 0);
    return order;
}

}  // namespace patchwright::geom
