#include "subd/template_kernels.h"

#include <cstring>

#define PATCHWRIGHT_INLINE [[gnu::always_inline]] inline

#pragma GCC diagnostic ignored "-Wpsabi"  // vectors are passed between inlined functions only

namespace patchwright::subd {

namespace {

constexpr int width = 4;
using Vector [[gnu::vector_size(32), gnu::aligned(8)]] = double;

constexpr int padded(int n) { return (n + width - 1) / width * width; }

PATCHWRIGHT_INLINE Vector load(const double* from) {
    Vector v;
    std::memcpy(&v, from, sizeof v);
    return v;
}

/// sums[c] += table row i (Blocks vectors) times coordinate c of point i, for all rows.
template <int Blocks, class Row>
PATCHWRIGHT_INLINE void accumulate(int count, const double* table, int stride, const Row& point,
                                   Vector (&sums)[3][Blocks]) {
    for (auto& coordinate : sums) {
        for (Vector& v : coordinate) v = Vector{0, 0, 0, 0};
    }
    for (int i = 0; i < count; ++i) {
        const double* p = point(i);
        const double* row = table + std::ptrdiff_t(i) * stride;
        const double px = p[0], py = p[1], pz = p[2];
        for (int b = 0; b < Blocks; ++b) {
            const Vector weights = load(row + width * b);
            sums[0][b] += weights * px;
            sums[1][b] += weights * py;
            sums[2][b] += weights * pz;
        }
    }
}

/// Coordinates in separate vectors to points in rows.
template <int Blocks>
PATCHWRIGHT_INLINE void to_rows(const Vector (&sums)[3][Blocks], double* rows) {
    using Mask [[gnu::vector_size(32)]] = std::int64_t;
    for (int b = 0; b < Blocks; ++b) {
        const Vector x = sums[0][b], y = sums[1][b], z = sums[2][b];
        const Vector xy_low = __builtin_shuffle(x, y, Mask{0, 4, 1, 5});
        const Vector xy_high = __builtin_shuffle(x, y, Mask{2, 6, 3, 7});
        const Vector first = __builtin_shuffle(xy_low, z, Mask{0, 1, 4, 2});
        const Vector second_low = __builtin_shuffle(xy_low, z, Mask{3, 5, 3, 5});
        const Vector second = __builtin_shuffle(second_low, xy_high, Mask{0, 1, 4, 5});
        const Vector third = __builtin_shuffle(xy_high, z, Mask{6, 2, 3, 7});
        std::memcpy(rows + 3 * width * b, &first, sizeof first);
        std::memcpy(rows + 3 * width * b + 4, &second, sizeof second);
        std::memcpy(rows + 3 * width * b + 8, &third, sizeof third);
    }
}

/// Rows [begin, begin + Blocks vectors) of the product with a table's columns, written or added.
template <int Blocks, bool Whole>
PATCHWRIGHT_INLINE void apply_block(int slots, const double* table, int stride, int samples,
                                    const std::int32_t* vertices, const double* x, double* y) {
    Vector sums[3][Blocks];
    accumulate<Blocks>(
        slots, table, stride, [&](int i) { return x + 3 * std::ptrdiff_t(vertices[i]); }, sums);
    if constexpr (Whole) {
        to_rows<Blocks>(sums, y);
    } else {
        double rows[3 * width * Blocks];
        to_rows<Blocks>(sums, rows);
        std::memcpy(y, rows, sizeof(double) * 3 * std::size_t(samples));
    }
}

template <int Blocks>
PATCHWRIGHT_INLINE void transposed_block(int samples, const double* table, int stride, int slots,
                                         const std::int32_t* vertices, const double* y, double* x) {
    Vector sums[3][Blocks];
    accumulate<Blocks>(
        samples, table, stride, [&](int i) { return y + 3 * std::ptrdiff_t(i); }, sums);
    double rows[3 * width * Blocks];
    to_rows<Blocks>(sums, rows);
    for (int k = 0; k < slots; ++k) {
        double* to = x + 3 * std::ptrdiff_t(vertices[k]);
        to[0] += rows[3 * k];
        to[1] += rows[3 * k + 1];
        to[2] += rows[3 * k + 2];
    }
}

/// Calls `block` for 16, 12, 8 or 4 rows at a time: (number of vectors, first row, rows).
template <class Block>
PATCHWRIGHT_INLINE void in_blocks(int rows, const Block& block) {
    int begin = 0;
    for (; rows - begin > 12; begin += 16) {
        block.template operator()<4>(begin, rows - begin < 16 ? rows - begin : 16);
    }
    const int left = rows - begin;
    if (left > 8) {
        block.template operator()<3>(begin, left);
    } else if (left > 4) {
        block.template operator()<2>(begin, left);
    } else if (left > 0) {
        block.template operator()<1>(begin, left);
    }
}

PATCHWRIGHT_INLINE void apply_sites(int sites, int samples, int slots, const double* table,
                                    int stride, const std::int32_t* vertices, const double* x,
                                    double* y) {
    for (int site = 0; site < sites; ++site) {
        in_blocks(
            samples, [&]<int Blocks>(int begin, int count) __attribute__((always_inline)) {
                double* to = y + 3 * std::ptrdiff_t(begin);
                if (count == Blocks * width) {
                    apply_block<Blocks, true>(slots, table + begin, stride, count, vertices, x, to);
                } else {
                    apply_block<Blocks, false>(slots, table + begin, stride, count, vertices, x,
                                               to);
                }
            });
        vertices += slots;
        y += 3 * std::ptrdiff_t(samples);
    }
}

PATCHWRIGHT_INLINE void transposed_sites(int sites, int samples, int slots, const double* table,
                                         int stride, const std::int32_t* vertices, const double* y,
                                         double* x) {
    for (int site = 0; site < sites; ++site) {
        in_blocks(
            slots, [&]<int Blocks>(int begin, int count) __attribute__((always_inline)) {
                transposed_block<Blocks>(samples, table + begin, stride, count, vertices + begin, y,
                                         x);
            });
        vertices += slots;
        y += 3 * std::ptrdiff_t(samples);
    }
}

// Each loop once for any processor and, on x86, once for those with AVX2 and fused multiply-add.
using Loop = void (*)(int, int, int, const double*, int, const std::int32_t*, const double*,
                      double*);
#define PATCHWRIGHT_LOOP(name, body)                                              \
    void name(int sites, int samples, int slots, const double* table, int stride, \
              const std::int32_t* vertices, const double* from, double* to) {     \
        body(sites, samples, slots, table, stride, vertices, from, to);           \
    }
PATCHWRIGHT_LOOP(apply_any, apply_sites)
PATCHWRIGHT_LOOP(transposed_any, transposed_sites)
#if defined(__x86_64__)
[[gnu::target("avx2,fma")]] PATCHWRIGHT_LOOP(apply_avx2, apply_sites)
    [[gnu::target("avx2,fma")]] PATCHWRIGHT_LOOP(transposed_avx2, transposed_sites)

        bool has_avx2() {
    static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    return has;
}
Loop apply_loop() { return has_avx2() ? apply_avx2 : apply_any; }
Loop transposed_loop() { return has_avx2() ? transposed_avx2 : transposed_any; }
#else
Loop apply_loop() { return apply_any; }
Loop transposed_loop() { return transposed_any; }
#endif

}  // namespace

MaskTable::MaskTable(int samples, int slots)
    : samples_(samples),
      slots_(slots),
      padded_samples_(padded(samples)),
      padded_slots_(padded(slots)),
      by_slot_(std::size_t(slots) * std::size_t(padded_samples_), 0.0),
      by_sample_(std::size_t(samples) * std::size_t(padded_slots_), 0.0) {}

void MaskTable::set(int sample, int slot, double weight) {
    by_slot_[std::size_t(slot) * std::size_t(padded_samples_) + std::size_t(sample)] = weight;
    by_sample_[std::size_t(sample) * std::size_t(padded_slots_) + std::size_t(slot)] = weight;
}

MaskTable MaskTable::squared() const {
    MaskTable result = *this;
    for (double& w : result.by_slot_) w *= w;
    for (double& w : result.by_sample_) w *= w;
    return result;
}

std::vector<double> MaskTable::column_squares() const {
    std::vector<double> sums(std::size_t(slots_), 0.0);
    for (int slot = 0; slot < slots_; ++slot) {
        for (int k = 0; k < samples_; ++k) {
            const double w =
                by_slot_[std::size_t(slot) * std::size_t(padded_samples_) + std::size_t(k)];
            sums[std::size_t(slot)] += w * w;
        }
    }
    return sums;
}

void MaskTable::apply(int sites, const std::int32_t* vertices, const double* x, double* y) const {
    apply_loop()(sites, samples_, slots_, by_slot_.data(), padded_samples_, vertices, x, y);
}

void MaskTable::add_transposed(int sites, const std::int32_t* vertices, const double* y,
                               double* x) const {
    transposed_loop()(sites, samples_, slots_, by_sample_.data(), padded_slots_, vertices, y, x);
}

}  // namespace patchwright::subd
