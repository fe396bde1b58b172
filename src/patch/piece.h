// The polynomial pieces a face of the limit surface consists of.
#pragma once

#include <patchwright/geom/types.h>
#include <patchwright/subd/ring.h>

#include <vector>

namespace patchwright::patch {

/// A bicubic polynomial over the square [u0, u0 + size] x [v0, v0 + size] of a face's parameters.
/// Control point (a, b) is row 4 a + b, a along u: of the uniform B-spline with spacing `size`, or
/// of Bezier form.
struct PolynomialPiece {
    enum class Basis { Uniform, Bezier };
    using Control = Eigen::Matrix<double, 16, 3>;

    double u0 = 0.0, v0 = 0.0, size = 1.0;
    Basis basis = Basis::Uniform;
    Control control;

    [[nodiscard]] bool contains(double u, double v) const {
        return u >= u0 && u <= u0 + size && v >= v0 && v <= v0 + size;
    }
    /// The blossom at the parameter triples `u` and `v`.
    [[nodiscard]] Eigen::RowVector3d blossom(const Eigen::Vector3d& u,
                                             const Eigen::Vector3d& v) const;
};

/// Where a face's own (0, 0) lies when it is looked at from its corner `i`, with u along the edge
/// that leaves the corner and v along the one that arrives: the same piece in those parameters.
PolynomialPiece seen_from(const PolynomialPiece& piece, int i);

/// What a face consists of towards its corners.
enum class FaceShape {
    Regular,    ///< one polynomial
    OneCorner,  ///< regular but for one corner, and so is every child there: an extraordinary one
    Other       ///< to be subdivided
};

struct FaceClass {
    FaceShape shape = FaceShape::Regular;
    int corner = -1;  ///< for OneCorner
};

FaceClass classify(const subd::RingKind& kind);

/// Subdivision steps until the neighbourhood of corner `i` is of class OneCorner there.
/// @pre the corner is extraordinary
int steps_to_one_corner(const subd::RingKind& kind, int i);

/// Parameters strictly between 0 and 1 where pieces of the face meet, without those at its
/// extraordinary corners; rising.
struct Splits {
    std::vector<double> u, v;
};
Splits splits(const subd::RingKind& kind);

/// All pieces of a face but for the squares of size 2^-hole[i] at its extraordinary corners i.
/// @param hole  at least steps_to_one_corner() there; unused elsewhere
std::vector<PolynomialPiece> regular_pieces(const subd::Ring& ring, const geom::Points& points,
                                            const std::array<int, 4>& hole);

/// Points of the ring, in the order of its slots.
geom::Points gather(const subd::Ring& ring, const geom::Points& points);

}  // namespace patchwright::patch
