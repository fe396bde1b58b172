// Carries a cage along with the points of a structural model, and forces back to these points.
#pragma once

#include <patchwright/mesh/cage.h>
#include <patchwright/subd/limit_mask.h>

#include <functional>
#include <memory>
#include <string>

#pragma GCC visibility push(default)
namespace patchwright::fit {

/// Most points that a transfer starts from: their matrix takes 0.8 GB, its factors 23 s.
inline constexpr int max_transfer_points = 10000;

/// The linear map H from values at the points of a structural model (displacements, velocities) to
/// values at other points, such as a cage's: the field that interpolates the values with distances
/// from the structural points as radial basis functions and a linear polynomial. It reproduces
/// affine fields, and so rigid motions. The transpose carries forces back: their virtual work is
/// the same for all displacements, and so are their sum and their moment about any point, before
/// and after the displacement.
/// Source: Beckert and Wendland, Multivariate interpolation for fluid-structure-interaction
/// problems using radial basis functions (2001).
class PointTransfer {
  public:
    /// Names one of the structural points, which count from 0, in messages.
    using Name = std::function<std::string(int)>;

    /// @param from  of the structural model
    /// @param name  none: "point 1" is the first one
    /// @throw InputError for more than max_transfer_points points, for two in one place, and where
    ///        all are in one plane, as rotations about its lines are not known then
    PointTransfer(const geom::Points& from, const geom::Points& to, const Name& name = {});

    [[nodiscard]] int rows() const;     ///< points that values go to
    [[nodiscard]] int columns() const;  ///< points that values come from

    /// rows() x 3 = H values.  @pre values is columns() x 3
    [[nodiscard]] geom::Points apply(const geom::Points& values) const;
    /// columns() x 3 = H^T values.  @pre values is rows() x 3
    [[nodiscard]] geom::Points apply_transposed(const geom::Points& values) const;

    /// How far the farthest point that values go to is from the middle of the structural points, in
    /// their own root mean square extents, direction by direction: errors of their values grow as
    /// much there. 1 to 3 within them.
    [[nodiscard]] double extrapolation() const;

  private:
    struct Factors;
    std::shared_ptr<const Factors> factors_;
};

/// The cage with its points displaced by the field; topology, names and tags stay. Pinned points
/// are displaced, too: pins are for fits.
/// @param displacements  one row a structural point
/// @pre the transfer goes to the cage's points
/// @throw InputError when a tag prescribes a normal, which would not turn with the cage
mesh::Cage morph(const mesh::Cage& cage, const PointTransfer& transfer,
                 const geom::Points& displacements);

/// Forces at places of the limit surface as forces at the control points, M^T forces with the masks
/// M of the places; PointTransfer::apply_transposed carries them on to the structural points.
/// @param forces  one row a place
/// @throw InputError when the cage has tagged sectors: there the limit surface is not M times the
///        control points (see subd::control_normals)
/// @throw UsageError when a place is not on the mesh
geom::Points control_point_forces(const std::shared_ptr<const mesh::Topology>& topology,
                                  const subd::Locations& places, const geom::Points& forces);

/// Sum of forces at points, and of their moments about `centre`.
struct Resultant {
    geom::Vec3 force = geom::Vec3::Zero(), moment = geom::Vec3::Zero();
};
Resultant resultant(const geom::Points& points, const geom::Points& forces,
                    const geom::Vec3& centre);

}  // namespace patchwright::fit
#pragma GCC visibility pop
