// Volume grids: layers of hexahedra grown off the surface.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/grid/source.h>

#include <memory>

#pragma GCC visibility push(default)
namespace patchwright::grid {

struct LayerOptions {
    int cells = 20;             ///< layers
    double growth = 1.2;        ///< each layer's height over the one below
    double first_mm = 0.0;      ///< height of the first layer; 0: by the thickness
    double thickness_mm = 0.0;  ///< of all layers; only where first_mm is 0
    /// Radius of a sphere around the middle of the surface's box up to which more fronts follow, of
    /// half a one where the surface ends in a plane; 0: none.
    double far_field_mm = 0.0;
    base::Progress progress;
};

/// Hexahedra between the surface and fronts that march off it, one a layer: every point goes along
/// the direction that its cells see best, smoothed with its neighbours' the more the farther the
/// front has come. Where a cell would get a corner with a scaled Jacobian below 0.025 (or 0.8 of
/// what the surface allows), the steps around it are evened out and shortened until none has. Where
/// that was necessary all layers are marched anew with less growth around there, so that they get
/// thinner in tight concave places by and by.
/// Points of a free border that lies in a plane across the surface stay in that plane.
/// Up to a far field the cells' shapes are optimised, from coarse grids to fine ones.
/// Source: the direction after Aubry and Loehner, On the 'most normal' normal (2008).
class LayerGrid : public BlockSource {
  public:
    /// @pre the plan outlives this
    /// @throw InvalidArgument for options out of range; UsageError for far fields where the surface
    ///        is not one body without handles, closed or with one border in a plane; Cancelled
    LayerGrid(const Plan& plan, const LayerOptions& options);
    ~LayerGrid() override;

    [[nodiscard]] const Plan& plan() const override { return plan_; }
    [[nodiscard]] int layers() const override;
    [[nodiscard]] bool has_far_field() const override;
    void evaluate(int block, BlockPoints& points) const override;

    /// Share of the height asked for that the thinnest layer has somewhere, without far fields.
    [[nodiscard]] double thinnest() const;

  private:
    struct State;
    const Plan& plan_;
    std::unique_ptr<State> state_;
};

}  // namespace patchwright::grid
#pragma GCC visibility pop
