// A ship's hull as legacy programs write it: loose one-span bicubic faces.
#pragma once

#include <BRepBuilderAPI_MakeFace.hxx>
#include <Geom_BezierSurface.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopoDS_Face.hxx>
#include <gp_Pnt.hxx>

#include <cmath>
#include <random>
#include <vector>

namespace patchwright::test {

inline constexpr double hull_length_mm = 100e3, beam_mm = 16e3, draught_mm = 9e3;

/// Half of the hull on one side of the middle plane; s along it from the stern, t from the keel up.
inline gp_Pnt hull_point(double s, double t) {
    const double fine = std::pow(1.0 - std::pow(2.0 * s - 1.0, 4.0), 0.6);
    const double y = 0.5 * beam_mm * fine * std::pow(t, 0.35 + 0.5 * s);
    const double narrow = std::pow(s, 8.0);  // all waterlines end in the stem's head
    return {hull_length_mm * s, y, draught_mm * (t * (1.0 - narrow) + narrow)};
}

/// Bezier points of the cubic surface that meets the hull at 4 x 4 places of the rectangle.
inline Handle(Geom_BezierSurface)
    hull_piece(double s0, double s1, double t0, double t1, double gap, std::mt19937& random) {
    TColgp_Array2OfPnt at(1, 4, 1, 4), poles(1, 4, 1, 4);
    const auto off = [&] { return gap * (double(random()) / double(std::mt19937::max()) - 0.5); };
    for (int i = 1; i <= 4; ++i)
        for (int j = 1; j <= 4; ++j)
            at(i, j) = hull_point(s0 + (s1 - s0) * (i - 1) / 3.0, t0 + (t1 - t0) * (j - 1) / 3.0);
    // The inverse of the Bernstein polynomials at 0, 1/3, 2/3, 1.
    constexpr double inverse[4][4] = {
        {1, 0, 0, 0}, {-5.0 / 6, 3, -1.5, 1.0 / 3}, {1.0 / 3, -1.5, 3, -5.0 / 6}, {0, 0, 0, 1}};
    for (int i = 1; i <= 4; ++i) {
        for (int j = 1; j <= 4; ++j) {
            gp_XYZ sum(off(), off(), off());
            for (int k = 1; k <= 4; ++k)
                for (int l = 1; l <= 4; ++l)
                    sum += inverse[i - 1][k - 1] * inverse[j - 1][l - 1] * at(k, l).XYZ();
            poles(i, j) = sum;
        }
    }
    return new Geom_BezierSurface(poles);
}

/// Faces without common edges; of the last station each has one side that is a point, or as long as
/// the gaps.
inline std::vector<TopoDS_Face> hull_faces(int stations, int waterlines, double gap_mm) {
    std::mt19937 random(1);
    std::vector<TopoDS_Face> faces;
    for (int i = 0; i < stations; ++i) {
        for (int j = 0; j < waterlines; ++j) {
            const auto surface =
                hull_piece(double(i) / stations, double(i + 1) / stations, double(j) / waterlines,
                           double(j + 1) / waterlines, gap_mm, random);
            faces.push_back(BRepBuilderAPI_MakeFace(surface, 1e-6).Face());
        }
    }
    return faces;
}

}  // namespace patchwright::test
