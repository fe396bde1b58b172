#include "geom/bvh.h"

#include <patchwright/base/error.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <random>

using namespace patchwright;
using geom::Box3;
using geom::Bvh;
using geom::Vec3;

namespace {

std::vector<Box3> random_boxes(int count, double size, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-1.0, 1.0), extent(0.0, size);
    std::vector<Box3> boxes;
    for (int i = 0; i < count; ++i) {
        Box3 box;
        box.min = Vec3(place(random), place(random), place(random));
        box.max = box.min + Vec3(extent(random), extent(random), extent(random));
        boxes.push_back(box);
    }
    return boxes;
}

double nearest_box(const Bvh& tree, const std::vector<Box3>& boxes, const Vec3& query,
                   int* visits = nullptr) {
    return tree.nearest(query, 1e30, [&](int item, double bound) {
        if (visits != nullptr) ++*visits;
        return std::min(bound, std::sqrt(boxes[std::size_t(item)].squared_distance(query)));
    });
}

double brute_force(const std::vector<Box3>& boxes, const Vec3& query) {
    double best = 1e30;
    for (const Box3& box : boxes) best = std::min(best, std::sqrt(box.squared_distance(query)));
    return best;
}

}  // namespace

TEST_CASE("the nearest box equals the one found by trying all", "[geom][oracle]") {
    for (int count : {1, 2, 5, 64, 3000}) {
        for (int leaf_size : {1, 4, 16}) {
            const auto boxes = random_boxes(count, 0.05, unsigned(count));
            const Bvh tree(boxes, leaf_size);
            std::mt19937 random(7);
            std::uniform_real_distribution<double> place(-2.0, 2.0);
            for (int i = 0; i < 200; ++i) {
                const Vec3 query(place(random), place(random), place(random));
                CHECK(nearest_box(tree, boxes, query) == brute_force(boxes, query));
            }
        }
    }
}

TEST_CASE("boxes far from the origin are found too", "[geom][oracle]") {
    auto boxes = random_boxes(500, 0.05, 11);
    const Vec3 far(1e6, -2e6, 5e5);
    for (Box3& box : boxes) {
        box.min += far;
        box.max += far;
    }
    const Bvh tree(boxes);
    std::mt19937 random(8);
    std::uniform_real_distribution<double> place(-2.0, 2.0);
    for (int i = 0; i < 200; ++i) {
        const Vec3 query = far + Vec3(place(random), place(random), place(random));
        CHECK(nearest_box(tree, boxes, query) == brute_force(boxes, query));
    }
}

TEST_CASE("queries far beyond single precision's squares find the nearest box", "[geom][oracle]") {
    const auto boxes = random_boxes(300, 0.05, 14);
    const Bvh tree(boxes);
    for (const double far : {1e10, 1e15, 1e18, 1e25}) {
        const Vec3 query(far, -far, 0.5);
        CHECK(nearest_box(tree, boxes, query) == brute_force(boxes, query));
    }
}

TEST_CASE("sorted items are the same boxes", "[geom][oracle]") {
    const auto boxes = random_boxes(300, 0.05, 12);
    Bvh tree(boxes, 2);
    std::vector<Box3> sorted;
    for (const auto number : tree.sort_items()) sorted.push_back(boxes[std::size_t(number)]);
    REQUIRE(sorted.size() == boxes.size());
    for (int i = 0; i < 50; ++i) {
        const Vec3 query(0.1 * i - 2, 0.3, 0.7);
        CHECK(nearest_box(tree, sorted, query) == brute_force(boxes, query));
    }
}

TEST_CASE("sorted leaves begin at multiples of the alignment", "[geom][oracle]") {
    const auto boxes = random_boxes(300, 0.05, 13);
    Bvh tree(boxes, 3);
    const auto number = tree.sort_items(4);
    CHECK(number.size() % 4 == 0);
    CHECK(std::count_if(number.begin(), number.end(), [](auto n) { return n >= 0; }) == 300);
    for (int i = 0; i < 50; ++i) {
        const Vec3 query(0.1 * i - 2, 0.3, 0.7);
        const double found =
            tree.nearest_leaves(query, 1e30, [&](int first, int count, double bound) {
                CHECK(first % 4 == 0);
                for (int k = first; k < first + count; ++k) {
                    const Box3& box = boxes[std::size_t(number[std::size_t(k)])];
                    bound = std::min(bound, std::sqrt(box.squared_distance(query)));
                }
                return bound;
            });
        CHECK(found == brute_force(boxes, query));
    }
    CHECK_THROWS_AS(tree.sort_items(0), base::InvalidArgument);
}

TEST_CASE("a nearest query visits few of many boxes", "[geom]") {
    const auto boxes = random_boxes(20000, 0.01, 3);
    const Bvh tree(boxes);
    std::mt19937 random(11);
    std::uniform_real_distribution<double> place(-1.0, 1.0);
    int visits = 0;
    for (int i = 0; i < 100; ++i)
        nearest_box(tree, boxes, Vec3(place(random), place(random), place(random)), &visits);
    CHECK(visits < 100 * 100);
}

TEST_CASE("a fixed bound visits every box within it", "[geom]") {
    const auto boxes = random_boxes(2000, 0.02, 5);
    const Bvh tree(boxes);
    const Vec3 query(0.1, -0.2, 0.3);
    std::vector<bool> seen(boxes.size(), false);
    CHECK(tree.nearest(query, 0.4, [&](int item, double bound) {
        seen[std::size_t(item)] = true;
        return bound;
    }) == 0.4);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        if (boxes[i].squared_distance(query) <= 0.4 * 0.4) CHECK(seen[i]);
    }
}

TEST_CASE("coincident boxes are split all the same", "[geom]") {
    const std::vector<Box3> boxes(5000, random_boxes(1, 1.0, 1).front());
    const Bvh tree(boxes);
    int visits = 0;
    tree.nearest(Vec3::Zero(), 10.0, [&](int, double bound) {
        ++visits;
        return bound;
    });
    CHECK(visits == 5000);
}

TEST_CASE("boxes of geometrically growing size and distance keep the tree shallow enough",
          "[geom]") {
    // Each split by bins takes off one box: the worst case for the depth.
    std::vector<Box3> boxes;
    for (int i = 0; i < 900; ++i) {
        Box3 box;
        box.add(Vec3::Constant(std::pow(2.0, 0.5 * i)));
        boxes.push_back(box);
    }
    const Bvh tree(boxes, 1);
    CHECK(nearest_box(tree, boxes, Vec3::Constant(2.0)) == Approx(0.0).margin(1e-12));
    CHECK(nearest_box(tree, boxes, Vec3::Zero()) == Approx(std::sqrt(3.0)));
}

TEST_CASE("an empty hierarchy finds nothing, a bad box is refused", "[geom]") {
    const Bvh none(std::vector<Box3>{});
    CHECK(none.empty());
    CHECK(none.bounds().empty());
    CHECK(none.nearest(Vec3::Zero(), 3.0, [](int, double) { return 0.0; }) == 3.0);

    CHECK_THROWS_AS(Bvh({Box3{}}), base::InvalidArgument);
    Box3 bad;
    bad.min = Vec3::Zero();
    bad.max = Vec3::Constant(std::nan(""));
    CHECK_THROWS_AS(Bvh({bad}), base::InvalidArgument);
    CHECK_THROWS_AS(Bvh(random_boxes(1, 1.0, 1), 0), base::InvalidArgument);
    CHECK_THROWS_AS(Bvh(random_boxes(1, 1.0, 1), 32), base::InvalidArgument);
}

TEST_CASE("a query inside a box meets it whatever the bound", "[geom]") {
    const auto boxes = random_boxes(500, 0.3, 8);
    const Bvh tree(boxes);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        bool met = false;
        tree.nearest(boxes[i].centre(), 0.0, [&](int item, double bound) {
            met |= item == int(i);
            return bound;
        });
        CHECK(met);
    }
}
