// Dense tables of masks times gathered points, and their transposes: where operators spend their
// time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace patchwright::subd {

/// Masks of all samples of one kind of site, in both orders, padded with zeros to whole vectors.
class MaskTable {
  public:
    MaskTable() = default;
    MaskTable(int samples, int slots);

    void set(int sample, int slot, double weight);
    [[nodiscard]] int samples() const { return samples_; }
    [[nodiscard]] int slots() const { return slots_; }
    [[nodiscard]] std::size_t bytes() const {
        return sizeof(double) * (by_slot_.size() + by_sample_.size());
    }

    /// With the square of each weight.
    [[nodiscard]] MaskTable squared() const;
    /// Sums of the squares of each slot's weights.
    [[nodiscard]] std::vector<double> column_squares() const;

    /// Points of `sites` sites that follow each other: samples() rows of `y` each.
    /// @param vertices  slots() rows of `x` for each site
    void apply(int sites, const std::int32_t* vertices, const double* x, double* y) const;
    /// Adds the transposed products of `sites` sites to the rows of `x` that `vertices` names.
    void add_transposed(int sites, const std::int32_t* vertices, const double* y, double* x) const;

  private:
    int samples_ = 0;
    int slots_ = 0;
    int padded_samples_ = 0;
    int padded_slots_ = 0;
    std::vector<double> by_slot_;    // slots x padded samples
    std::vector<double> by_sample_;  // samples x padded slots
};

}  // namespace patchwright::subd
