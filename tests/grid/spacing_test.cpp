#include <patchwright/base/error.h>
#include <patchwright/grid/spacing.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

namespace patchwright {
namespace {

using grid::EndSizes;
using grid::fractions;
using grid::Law;

double first_of(const std::vector<double>& s) { return s[1]; }
double last_of(const std::vector<double>& s) { return 1.0 - s[s.size() - 2]; }

TEST_CASE("spacing laws give rising fractions with the sizes asked for", "[grid]") {
    for (const Law law : {Law::Geometric, Law::Tanh}) {
        for (const int cells : {2, 3, 8, 65, 1000}) {
            // From far below the uniform size to above it.
            for (const double share : {1e-5, 0.01, 0.3, 1.0, 1.5}) {
                const double size = share / cells;
                CAPTURE(int(law), cells, share);
                const auto one = fractions(law, cells, {size, 0.0});
                const auto other = fractions(law, cells, {0.0, size});
                CHECK(first_of(one) == Approx(size).epsilon(1e-6));
                CHECK(last_of(other) == Approx(size).epsilon(1e-6));
                for (const auto& s : {one, other}) {
                    CHECK(s.size() == std::size_t(cells) + 1);
                    CHECK(s.front() == 0.0);
                    CHECK(s.back() == 1.0);
                    CHECK(std::adjacent_find(s.begin(), s.end(), std::greater_equal<>()) ==
                          s.end());
                }
                // One end is the other's mirror image.
                for (std::size_t k = 0; k < one.size(); ++k) {
                    CHECK(one[k] == Approx(1.0 - other[other.size() - 1 - k]).margin(1e-9));
                }
            }
        }
    }
}

TEST_CASE("two-sided laws meet both sizes", "[grid]") {
    for (const Law law : {Law::Geometric, Law::Tanh}) {
        for (const int cells : {8, 65, 400}) {
            for (const double a : {0.01, 0.5, 1.0}) {
                for (const double b : {0.02, 0.4, 0.9}) {
                    CAPTURE(int(law), cells, a, b);
                    const auto s = fractions(law, cells, {a / cells, b / cells});
                    CHECK(first_of(s) == Approx(a / cells).epsilon(1e-6));
                    CHECK(last_of(s) == Approx(b / cells).epsilon(1e-6));
                    CHECK(std::is_sorted(s.begin(), s.end()));
                }
            }
        }
    }
}

TEST_CASE("laws with closed forms", "[grid][oracle]") {
    const auto uniform = fractions(Law::Uniform, 4, {0.01, 0.01});
    CHECK(uniform == std::vector<double>{0.0, 0.25, 0.5, 0.75, 1.0});
    CHECK(fractions(Law::Tanh, 4) == uniform);
    CHECK(fractions(Law::Geometric, 4) == uniform);
    // 1 + 2 + 4 + 8 fifteenths.
    const auto doubling = fractions(Law::Geometric, 4, {1.0 / 15.0, 0.0});
    for (int k = 0; k <= 4; ++k)
        CHECK(doubling[std::size_t(k)] == Approx(((1 << k) - 1) / 15.0).margin(1e-12));
    const auto cosine = fractions(Law::Cosine, 6);
    for (int k = 0; k <= 6; ++k)
        CHECK(cosine[std::size_t(k)] == Approx(0.5 * (1.0 - std::cos(M_PI * k / 6))).margin(1e-15));
    const auto front = fractions(Law::Cosine, 6, {0.1, 0.0});
    for (int k = 0; k <= 6; ++k)
        CHECK(front[std::size_t(k)] == Approx(1.0 - std::cos(M_PI * k / 12)).margin(1e-15));
    // One-sided tanh: 1 - tanh(d (1 - x)) / tanh(d).
    const double d = 3.0;
    const double first = 1.0 - std::tanh(d * 0.9) / std::tanh(d);
    const auto tanh = fractions(Law::Tanh, 10, {first, 0.0});
    for (int k = 0; k <= 10; ++k) {
        CHECK(tanh[std::size_t(k)] ==
              Approx(1.0 - std::tanh(d * (1.0 - 0.1 * k)) / std::tanh(d)).margin(1e-12));
    }
    // Two-sided with equal sizes: symmetric tanh.
    const auto both = fractions(Law::Tanh, 20, {0.005, 0.005});
    for (int k = 0; k <= 20; ++k)
        CHECK(both[std::size_t(k)] == Approx(1.0 - both[std::size_t(20 - k)]).margin(1e-14));
}

TEST_CASE("impossible spacings are refused", "[grid]") {
    CHECK_THROWS_AS(fractions(Law::Tanh, 0), base::InvalidArgument);
    CHECK_THROWS_AS(fractions(Law::Tanh, 4, {-0.1, 0.0}), base::InvalidArgument);
    CHECK_THROWS_AS(fractions(Law::Tanh, 4, {1.0, 0.0}), base::InvalidArgument);
    CHECK_THROWS_AS(fractions(Law::Tanh, 4, {0.5, 0.5}), base::InvalidArgument);
    CHECK_THROWS_AS(fractions(Law::Tanh, 4, {std::nan(""), 0.0}), base::InvalidArgument);
}

}  // namespace
}  // namespace patchwright
