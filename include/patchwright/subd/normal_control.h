// Concave corners and prescribed normals.
#pragma once

#include <patchwright/mesh/cage.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::subd {

/// Moves control points next to the cage's tagged sectors (see mesh::SectorTagInput) so that the
/// limit surface has a tangent plane there, at right angles to the tag's normal if there is one. In
/// a sector with an angle, what would shrink by less than half at every step, and fold the surface
/// at concave corners, is taken out of the points around the vertex; a normal moves them by the
/// least that it takes, and never the vertex itself.
/// Source: Biermann, Levin, Zorin, Piecewise smooth subdivision surfaces with normal control
/// (2000). They apply the correction at every step; here it is made once, on the control points, so
/// that the rules stay linear and as local as the ordinary ones.
/// @throw InputError when the faces of a tagged sector are no quads (subdivide once), or when the
///        vertex has no tangent plane to turn
mesh::Cage control_normals(const mesh::Cage& cage);

/// Sectors of three or four quads between sharp edges at corners, without an angle. One part of
/// their control points shrinks by less than half at every step, so that near the corner its
/// direction decides whether the limit surface folds: it must lie between the sharp edges, in
/// concave sectors between what points against them. Sectors of more quads have several such parts;
/// they are left as they are, and so are those whose inner edges all end at points that are held.
class CornerSectors {
  public:
    /// @param points  say which sectors are concave, and how much room they have
    /// @param held    not zero: control points that do not move
    CornerSectors(const mesh::Topology& topology, const geom::Points& points,
                  const std::vector<std::uint8_t>& held);

    /// Where that part points elsewhere, moves the points around the corner by the least that
    /// mends it, each by its share of one vector, and keeps the part from going back there.
    void settle(geom::Points& points);

    /// Takes out of displacements what would move parts that are kept.
    void project(geom::Points& displacements) const;
    /// The transpose of project().
    void project_transposed(geom::Points& rows) const;

  private:
    struct Sector {
        std::vector<std::int32_t> ring;
        bool concave = false;
        Eigen::RowVectorXd mask;  ///< of the part
        Eigen::VectorXd motion;   ///< that changes the part by one, of points that move
        /// How far off the part stays when edges that are not held have even angles, where there is
        /// too little room.
        Eigen::Vector3d room = Eigen::Vector3d::Zero();
        Eigen::Matrix3d kept = Eigen::Matrix3d::Zero();  ///< projection onto directions
        [[nodiscard]] geom::Points local(const geom::Points& points) const;
    };
    std::vector<Sector> sectors_;
};

}  // namespace patchwright::subd
#pragma GCC visibility pop
