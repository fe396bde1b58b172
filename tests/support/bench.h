// Times and rates that benchmarks compare with.
#pragma once

#include <patchwright/base/parallel.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

namespace patchwright::test {

template <class Body>
double seconds(Body&& body) {
    const auto start = std::chrono::steady_clock::now();
    body();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The fastest of some runs: what the machine can do.
template <class Body>
double best_seconds(int runs, Body&& body) {
    double best = INFINITY;
    for (int i = 0; i < runs; ++i) best = std::min(best, seconds(body));
    return best;
}

/// Bytes a second of a[i] = b[i] + s c[i] on the threads that loops may use (STREAM triad).
inline double triad_rate() {
    constexpr std::size_t n = 8'000'000;
    std::vector<double> a(n, 0.0), b(n, 1.0), c(n, 2.0);
    const double best = best_seconds(5, [&] {
        base::parallel_for(n, n / 32, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) a[i] = b[i] + 3.0 * c[i];
        });
    });
    return 3.0 * sizeof(double) * double(n) / best;
}

}  // namespace patchwright::test
