// How long edges may be in each direction, all over a block layout.
#pragma once

#include "cage/blocks/block_layout.h"
#include "cage/poll.h"

#include <patchwright/geom/model_surface.h>

#include <map>
#include <utility>
#include <vector>

namespace patchwright::cage {

struct MetricSizes {
    double tolerance_rel = 1e-3;  ///< of the diagonal: what the cage is to be fitted to
    double largest_rel = 0.3;     ///< of the diagonal: longest edge
    double fineness = 1.0;        ///< divides lengths by curvature and the shortest one
    double scale = 1.0;           ///< times all lengths
};

/// By its number in FlatPiece::triangles() of a piece.
struct PieceTriangle {
    int piece = -1, triangle = -1;
};

/// A Riemannian metric on the triangles of a layout's pieces, in which an edge of the wanted length
/// has length 1: by the principal curvatures of the surface there, no edge shorter than a few
/// tolerances, graded from triangle to triangle but not across features. Along the surface's normal
/// edges are as short as the shortest: a triangle may leave the tangent plane.
/// Source: Alauzet, Size gradation control of anisotropic meshes (2010), for the grading.
class SizeMetric {
  public:
    SizeMetric(const QuadLayout& layout, const geom::ModelSurface& reference,
               const MetricSizes& sizes, Poll& poll);

    /// Of two ways within a triangle.
    [[nodiscard]] double product(const PieceTriangle& t, const geom::Vec3& a,
                                 const geom::Vec3& b) const;
    /// In edges.
    [[nodiscard]] double length(const PieceTriangle& t, const geom::Vec3& way) const;

    /// Weights of the sides of a piece's triangles, by its points, in a sum of squared differences
    /// that is Dirichlet's energy: half the sums of the opposite angles' cotangents, at least a
    /// small positive number.
    [[nodiscard]] std::map<std::pair<int, int>, double> side_weights(const FlatPiece& piece,
                                                                     int number) const;

  private:
    std::vector<std::vector<Eigen::Matrix3d>> metric_;  ///< by piece and triangle
};

/// Fewest edges of a closed line: quads on both sides would share two.
constexpr int fewest_of_loop = 4;

/// Raises LayoutArc::least: loops need several edges, and so do arcs between the same two nodes but
/// for the shortest one.
void set_least(QuadLayout& layout);

/// Sets LayoutArc::wanted, shares and least, which is 0 where set_least() asks for nothing: by the
/// metric lengths of arcs and of lines through their blocks, so that what bends inside a block only
/// is not missed, and by how arcs on features bend.
void set_wanted(QuadLayout& layout, const SizeMetric& metric, const geom::ModelSurface& reference,
                const MetricSizes& sizes, Poll& poll);

}  // namespace patchwright::cage
