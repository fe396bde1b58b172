#include <patchwright/base/error.h>
#include <patchwright/grid/spacing.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace patchwright::grid {

namespace {

/// The root of a rising function between `low` and `high`, to the last bits.
template <class F>
double root(const F& f, double low, double high) {
    for (int step = 0; step < 200; ++step) {
        const double middle = 0.5 * (low + high);
        if (middle == low || middle == high) break;
        (f(middle) < 0.0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

/// tanh(d x) / tanh(d) for positive d and tan(-d x) / tan(-d) for negative: convex, straight or
/// concave bends of one family. Rising with d for 0 < x < 1; d > -pi / 2.
double bend(double d, double x) {
    if (std::abs(d) < 1e-5) return x * (1.0 + d * std::abs(d) * (1.0 - x * x) / 3.0);
    return d > 0.0 ? std::tanh(d * x) / std::tanh(d) : std::tan(-d * x) / std::tan(-d);
}

/// The d with bend(d, x) == value.
double bend_parameter(double x, double value) {
    constexpr double steepest = 700.0;
    return root([&](double d) { return bend(d, x) - value; }, -0.5 * M_PI * (1.0 - 1e-9), steepest);
}

std::vector<double> one_sided_tanh(int cells, double first) {
    const double d = bend_parameter(1.0 - 1.0 / cells, 1.0 - first);
    std::vector<double> s(std::size_t(cells) + 1);
    for (int k = 0; k <= cells; ++k) s[std::size_t(k)] = 1.0 - bend(d, 1.0 - double(k) / cells);
    return s;
}

/// Of a symmetric bend, then of a projective map of [0, 1], which moves cells to one end. Both
/// follow in closed form from where the first and the last inner point shall lie.
std::vector<double> two_sided_tanh(int cells, double first, double last) {
    const double q = std::sqrt(first * last / ((1.0 - first) * (1.0 - last)));
    const double u = q / (1.0 + q);
    const double a = u * (1.0 - first) / (first * (1.0 - u));
    const double d = cells > 2 ? bend_parameter(1.0 - 2.0 / cells, 1.0 - 2.0 * u) : 0.0;
    std::vector<double> s(std::size_t(cells) + 1);
    for (int k = 0; k <= cells; ++k) {
        const double x = 2.0 * k / cells - 1.0;
        const double v = 0.5 * (1.0 + std::copysign(bend(d, std::abs(x)), x));
        s[std::size_t(k)] = v / (a + (1.0 - a) * v);
    }
    return s;
}

std::vector<double> geometric(int cells, const EndSizes& sizes) {
    // Sizes that grow or shrink by the factor r from each end that is given; where both are, the
    // one that is ahead in a cell counts.
    const bool grows = cells * (sizes.first == 0.0  ? sizes.last
                                : sizes.last == 0.0 ? sizes.first
                                                    : std::min(sizes.first, sizes.last)) <
                       1.0;
    const auto cell = [&](double log_r, int k) {
        const double from_first = std::log(sizes.first) + log_r * k;
        const double from_last = std::log(sizes.last) + log_r * (cells - 1 - k);
        if (sizes.first == 0.0) return std::exp(from_last);
        if (sizes.last == 0.0) return std::exp(from_first);
        return std::exp(grows ? std::min(from_first, from_last) : std::max(from_first, from_last));
    };
    const auto total = [&](double log_r) {
        double sum = 0.0;
        for (int k = 0; k < cells; ++k) sum += cell(log_r, k);
        return sum - 1.0;
    };
    const double log_r = grows ? root(total, 0.0, 50.0) : root(total, -50.0, 0.0);
    std::vector<double> s{0.0};
    for (int k = 0; k < cells; ++k) s.push_back(s.back() + cell(log_r, k));
    for (double& x : s) x /= s.back();
    return s;
}

std::vector<double> cosine(int cells, const EndSizes& sizes) {
    std::vector<double> s(std::size_t(cells) + 1);
    for (int k = 0; k <= cells; ++k) {
        const double x = double(k) / cells;
        s[std::size_t(k)] = (sizes.first == 0.0) == (sizes.last == 0.0)
                                ? std::pow(std::sin(0.5 * M_PI * x), 2)
                            : sizes.last == 0.0 ? 2.0 * std::pow(std::sin(0.25 * M_PI * x), 2)
                                                : std::sin(0.5 * M_PI * x);
    }
    return s;
}

void check(int cells, const EndSizes& sizes) {
    if (cells < 1) {
        throw base::InvalidArgument(fmt::format("{} cells make no line; use 1 or more", cells));
    }
    for (const double size : {sizes.first, sizes.last}) {
        if (!(size >= 0.0 && size < 1.0)) {
            throw base::InvalidArgument(
                fmt::format("the cell at an end of a line is {} of it; use less than 1", size));
        }
    }
    if (sizes.first + sizes.last >= 1.0) {
        throw base::InvalidArgument(
            fmt::format("the cells at both ends of a line, {} and {} of it, leave nothing between",
                        sizes.first, sizes.last));
    }
}

}  // namespace

std::vector<double> fractions(Law law, int cells, const EndSizes& sizes) {
    check(cells, sizes);
    const bool sized = sizes.first > 0.0 || sizes.last > 0.0;
    std::vector<double> s;
    if (law == Law::Cosine) {
        s = cosine(cells, sizes);
    } else if (law == Law::Geometric && sized && cells > 1) {
        s = geometric(cells, sizes);
    } else if (law == Law::Tanh && sized && cells > 1) {
        if (sizes.first > 0.0 && sizes.last > 0.0 && cells > 2) {
            s = two_sided_tanh(cells, sizes.first, sizes.last);
        } else if (sizes.first > 0.0) {
            s = one_sided_tanh(cells, sizes.first);
        } else {
            s = one_sided_tanh(cells, sizes.last);
            for (double& x : s) x = 1.0 - x;
            std::reverse(s.begin(), s.end());
        }
    } else {
        for (int k = 0; k <= cells; ++k) s.push_back(double(k) / cells);
    }
    s.front() = 0.0;
    s.back() = 1.0;
    return s;
}

}  // namespace patchwright::grid
