#include <patchwright/base/error.h>
#include <patchwright/geom/bvh.h>

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

struct Bvh::Builder {
    const std::vector<Box3>& boxes;
    std::vector<Node>& nodes;
    std::vector<std::int32_t>& items;
    int leaf_size;

    struct Task {
        std::int32_t node, begin, end;
        int depth;
    };

    [[nodiscard]] Vec3 centre(std::int32_t item) const { return boxes[std::size_t(item)].centre(); }

    // Reorders [begin, end) and returns where the right half starts.
    std::int32_t split(const Task& task) {
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
        nodes.shrink_to_fit();
    }
};

Bvh::Bvh(const std::vector<Box3>& boxes, int leaf_size) {
    if (leaf_size < 1)
        throw base::InvalidArgument(fmt::format("leaf size is {}, must be at least 1", leaf_size));
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        if (boxes[i].empty() || !boxes[i].min.allFinite() || !boxes[i].max.allFinite())
            throw base::InvalidArgument(fmt::format("box {} is empty or not finite", i));
    }
    if (boxes.empty()) return;
    items_.resize(boxes.size());
    std::iota(items_.begin(), items_.end(), 0);
    Builder{boxes, nodes_, items_, leaf_size}.run();
}

}  // namespace patchwright::geom
