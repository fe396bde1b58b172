// A program of its own, as it counts every call of malloc.
#include "support/cages.h"

#include <patchwright/base/parallel.h>
#include <patchwright/subd/limit_operator.h>
#include <patchwright/subd/refine.h>

#include <catch2/catch.hpp>

#include <atomic>
#include <cstdlib>

namespace {
std::atomic<long> allocations{0};
}

// Eigen's and the standard library's memory both come from here. NOLINTBEGIN
#ifndef __SANITIZE_ADDRESS__  // which has its own
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) {
    allocations.fetch_add(1, std::memory_order_relaxed);
    return __libc_malloc(size);
}
#endif
// NOLINTEND

using namespace patchwright;

namespace {

template <class Body>
long allocations_of(Body&& body) {
    const long before = allocations;
    body();
    return allocations - before;
}

}  // namespace

TEST_CASE("products with limit operators allocate nothing for faces or samples", "[subd]") {
    // Tasks of the parallel loops allocate, a few for each of at most 64 chunks.
    constexpr long most = 500;
    const mesh::Cage coarse = test::random_cage(3, {.open = true});
    for (const int levels : {2, 5}) {
        const mesh::Cage cage = subd::refine(coarse, levels);
        std::vector<subd::Site> sites;
        for (const mesh::FaceId f : cage.topology->faces()) sites.push_back({f, 0, 0});
        const subd::LimitOperator op(*cage.topology, {{{0.2, 0.3}, {0.7, 0.6}, {0.1, 0.9}}}, sites);
        geom::Points limit, back;
        op.apply(cage.points, limit);
        op.apply_transposed(limit, back);
        CAPTURE(levels, cage.topology->face_count());
        CHECK(allocations_of([&] { op.apply(cage.points, limit); }) < most);
        CHECK(allocations_of([&] { op.apply_transposed(limit, back); }) < most);
    }
}

TEST_CASE("evaluating points allocates nothing", "[subd]") {
    for (unsigned seed = 0; seed < 6; ++seed) {
        const mesh::Cage cage =
            test::random_cage(seed, {.open = seed % 2 == 1, .semi_sharp = seed % 3 == 0});
        const subd::LimitEvaluator evaluator(cage.topology);
        geom::Vec3 sum = geom::Vec3::Zero();
        const auto evaluate_all = [&] {
            for (const mesh::FaceId f : cage.topology->faces()) {
                for (const double u : {0.0, 1e-9, 0.3, 0.7, 1.0}) {
                    for (const double v : {0.0, 0.2, 1.0}) {
                        sum += evaluator.evaluate(cage.points, {f, u, v}).position;
                    }
                }
            }
        };
        evaluate_all();  // the kinds of neighbourhoods, and this thread's buffers
        CAPTURE(seed);
        CHECK(allocations_of(evaluate_all) == 0);
    }
}
