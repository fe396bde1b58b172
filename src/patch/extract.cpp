#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/patch/extract.h>
#include <patchwright/subd/refine.h>
#include <patchwright/subd/ring.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace patchwright::patch {

namespace {

using geom::Points;
using mesh::CornerId;
using mesh::EdgeId;
using mesh::FaceId;
using mesh::Topology;
using subd::RingKind;

/// The one corner around which the face is not regular after any number of steps.
enum class FaceShape { Regular, OneCorner, Other };

struct FaceClass {
    FaceShape shape;
    int corner;  // for OneCorner
};

FaceClass classify(const RingKind& given) {
    if (given.is_regular()) return {FaceShape::Regular, -1};
    if (given.size() != 4) return {FaceShape::Other, -1};
    int corner = 0;
    while (corner < 4 && given.child(corner).kind->is_regular()) ++corner;
    // From step to step all other children must be regular, until the kind repeats itself.
    for (const RingKind* kind = &given; corner < 4;) {
        for (int i = 0; i < 4; ++i) {
            if (kind->child(i).kind->is_regular() == (i == corner)) return {FaceShape::Other, -1};
        }
        const RingKind* next = kind->child(corner).kind;
        if (next == kind) return {FaceShape::OneCorner, corner};
        kind = next;
    }
    return {FaceShape::Other, -1};
}

/// Coefficients of the blossom at (r, s, t) over the four uniform control points of segment [0, 1].
Eigen::Vector4d blossom_weights(double r, double s, double t) {
    Eigen::Vector4d w = Eigen::Vector4d::Zero();
    const double b[2] = {1.0 - t, t};
    const double a[3] = {b[0] * (1.0 - s) / 2.0, b[0] * (1.0 + s) / 2.0 + b[1] * (2.0 - s) / 2.0,
                         b[1] * s / 2.0};
    for (int i = 0; i < 3; ++i) {
        w[i] += a[i] * (1.0 + i - r) / 3.0;
        w[i + 1] += a[i] * (r + 2.0 - i) / 3.0;
    }
    return w;
}

/// Knots 0^4, 2^-depth, ..., 1/2, 1^4; depth 0 is a single Bezier span.
std::vector<double> graded_knots(int depth) {
    std::vector<double> knots(4, 0.0);
    for (int level = depth; level > 0; --level) knots.push_back(std::ldexp(1.0, -level));
    knots.insert(knots.end(), 4, 1.0);
    return knots;
}

std::vector<double> mirrored(const std::vector<double>& knots) {
    std::vector<double> result(knots.rbegin(), knots.rend());
    for (double& t : result) t = 1.0 - t;
    return result;
}

/// A regular piece of the surface near the corner: uniform control points (a, b) in row 4 a + b,
/// with a and b counted away from the corner, over the square [a0, a0 + 1] x [b0, b0 + 1] * size.
using Piece = Eigen::Matrix<double, 16, 3>;

Piece oriented_piece(const Piece& grid, bool flip_a, bool flip_b) {
    Piece piece;
    for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < 4; ++b) {
            piece.row(4 * a + b) = grid.row(4 * (flip_a ? 3 - a : a) + (flip_b ? 3 - b : b));
        }
    }
    return piece;
}

class PatchBuilder {
  public:
    PatchBuilder(const subd::Ring& ring, const Points& points) : kind_(*ring.kind) {
        local_.resize(kind_.slots(), 3);
        for (std::size_t k = 0; k < ring.vertices.size(); ++k) {
            local_.row(Eigen::Index(k)) = points.row(ring.vertices[k]);
        }
    }

    geom::BsplineSurface regular() const {
        geom::BsplineSurface surface{graded_knots(0), graded_knots(0), Points(16, 3)};
        const Piece piece = kind_.regular() * local_;
        for (int i = 0; i < 4; ++i) {
            for (int j = 0; j < 4; ++j) {
                surface.point(i, j) = blossom(piece, bezier_triple(i), bezier_triple(j));
            }
        }
        return surface;
    }

    geom::BsplineSurface with_cap(int corner, int depth) const {
        const bool flip_a = subd::at_end_u(corner);
        const bool flip_b = subd::at_end_v(corner);
        const std::vector<double> knots = graded_knots(depth);
        geom::BsplineSurface surface{flip_a ? mirrored(knots) : knots,
                                     flip_b ? mirrored(knots) : knots,
                                     Points((depth + 4) * (depth + 4), 3)};
        const auto pieces = collect_pieces(corner, depth);
        const Eigen::RowVector3d limit = kind_.corner(corner).limit * local_;
        const int last = depth + 3;
        for (int i = 0; i <= last; ++i) {
            for (int j = 0; j <= last; ++j) {
                Eigen::RowVector3d p = limit;
                if (i > 0 || j > 0) {
                    const int interval_a = std::min(i, depth);
                    const int interval_b = std::min(j, depth);
                    const int outer = std::max(interval_a, interval_b);
                    const int level = depth - outer + 1;
                    const int a0 = interval_a == outer ? 1 : 0;
                    const int b0 = interval_b == outer ? 1 : 0;
                    p = blossom(pieces[std::size_t(level - 1)][std::size_t(2 * a0 + b0)],
                                triple(knots, i, level, a0), triple(knots, j, level, b0));
                }
                surface.point(flip_a ? last - i : i, flip_b ? last - j : j) = p;
            }
        }
        return surface;
    }

  private:
    static Eigen::Vector3d bezier_triple(int i) {
        return {i > 2 ? 1.0 : 0.0, i > 1 ? 1.0 : 0.0, i > 0 ? 1.0 : 0.0};
    }

    /// The inner knots of control point i in the coordinates of a piece.
    static Eigen::Vector3d triple(const std::vector<double>& knots, int i, int level, int origin) {
        Eigen::Vector3d t;
        for (int k = 0; k < 3; ++k) {
            t[k] = std::ldexp(knots[std::size_t(i + 1 + k)], level) - origin;
        }
        return t;
    }

    static Eigen::RowVector3d blossom(const Piece& piece, const Eigen::Vector3d& a,
                                      const Eigen::Vector3d& b) {
        const Eigen::Vector4d wa = blossom_weights(a[0], a[1], a[2]);
        const Eigen::Vector4d wb = blossom_weights(b[0], b[1], b[2]);
        Eigen::RowVector3d p = Eigen::RowVector3d::Zero();
        for (int i = 0; i < 4; ++i) p += wa[i] * (wb.transpose() * piece.middleRows<4>(4 * i));
        return p;
    }

    /// Per level 1..depth the regular pieces (1, 0), (0, 1), (1, 1) at index 2 a0 + b0.
    std::vector<std::array<Piece, 4>> collect_pieces(int corner, int depth) const {
        std::vector<std::array<Piece, 4>> pieces(static_cast<std::size_t>(depth));
        const RingKind* kind = &kind_;
        Points local = local_;
        for (auto& level : pieces) {
            for (int i = 0; i < 4; ++i) {
                if (i == corner) continue;
                const RingKind::Child& child = kind->child(i);
                const Piece grid = child.kind->regular() * (child.matrix * local);
                const int a0 = subd::at_end_u(i) != subd::at_end_u(corner) ? 1 : 0;
                const int b0 = subd::at_end_v(i) != subd::at_end_v(corner) ? 1 : 0;
                level[std::size_t(2 * a0 + b0)] =
                    oriented_piece(grid, subd::at_end_u(corner), subd::at_end_v(corner));
            }
            const RingKind::Child& inner = kind->child(corner);
            local = (inner.matrix * local).eval();
            kind = inner.kind;
        }
        return pieces;
    }

    const RingKind& kind_;
    Points local_;
};

/// The boundary curve of side i (v = 0, u = 1, v = 1, u = 0), in counter-clockwise direction.
geom::BsplineCurve side_curve(const geom::BsplineSurface& s, int side) {
    const bool along_u = side % 2 == 0;
    const Eigen::Index count = along_u ? s.rows() : s.columns();
    const std::vector<double>& knots = along_u ? s.knots_u : s.knots_v;
    const bool backwards = side >= 2;
    geom::BsplineCurve curve{backwards ? mirrored(knots) : knots, Points(count, 3)};
    for (Eigen::Index k = 0; k < count; ++k) {
        const Eigen::Index at = backwards ? count - 1 - k : k;
        curve.points.row(k) = side == 0   ? s.point(at, 0)
                              : side == 1 ? s.point(s.rows() - 1, at)
                              : side == 2 ? s.point(at, s.columns() - 1)
                                          : s.point(0, at);
    }
    return curve;
}

geom::BsplineCurve reversed(const geom::BsplineCurve& curve) {
    return {mirrored(curve.knots), curve.points.colwise().reverse()};
}

std::string patch_name(const Topology& t, FaceId f) {
    const int group = t.group(f);
    return fmt::format("{}:{}", group < 0 ? "face" : t.group_names()[std::size_t(group)], f.value);
}

/// Refines until every face is regular or has one extraordinary corner.
void prepare(Extraction& extraction, subd::RingTable& table, std::vector<subd::Ring>& rings,
             std::vector<FaceClass>& classes) {
    for (;;) {
        const Topology& t = *extraction.cage.topology;
        rings.clear();
        classes.clear();
        bool ready = true;
        for (const FaceId f : t.faces()) {
            rings.push_back(table.ring(t, f));
            classes.push_back(classify(*rings.back().kind));
            ready = ready && classes.back().shape != FaceShape::Other;
            if (!ready) break;
        }
        if (ready) return;
        extraction.cage = subd::refine(extraction.cage, 1);
        ++extraction.refinements;
    }
}

void connect(Extraction& extraction) {
    const Topology& t = *extraction.cage.topology;
    PatchSet& set = extraction.patches;
    set.vertices.resize(t.vertex_count(), 3);
    set.edges.resize(std::size_t(t.edge_count()));
    for (const FaceId f : t.faces()) {
        Patch& patch = set.patches[f.index()];
        for (int i = 0; i < 4; ++i) {
            const CornerId c = t.corners(f)[i];
            const EdgeId e = t.edge(c);
            const bool owner = t.corner(e) == c;
            PatchEdge& edge = set.edges[e.index()];
            geom::BsplineCurve curve = side_curve(patch.surface, i);
            // Both sides have the same curve; the one with fewer knots says so more simply.
            if (edge.start < 0 || curve.knots.size() < edge.curve.knots.size()) {
                edge.curve = owner ? std::move(curve) : reversed(curve);
            }
            edge.start = t.start(e).value;
            edge.end = t.end(e).value;
            edge.crease = !t.is_boundary(e) && t.sharpness(e) > 0.0;
            patch.sides[std::size_t(i)] = {{e.value, !owner}};
        }
    }
    for (const PatchEdge& edge : set.edges) {
        set.vertices.row(edge.start) = edge.curve.points.row(0);
        set.vertices.row(edge.end) = edge.curve.points.row(edge.curve.points.rows() - 1);
    }
}

}  // namespace

Extraction extract(const mesh::Cage& cage, const ExtractOptions& options) {
    if (options.cap_depth < 1 || options.cap_depth > 20) {
        throw base::InvalidArgument(
            fmt::format("cap depth {} is out of range; use 1 to 20", options.cap_depth));
    }
    Extraction extraction;
    extraction.cage = cage;
    subd::RingTable table;
    std::vector<subd::Ring> rings;
    std::vector<FaceClass> classes;
    prepare(extraction, table, rings, classes);

    const Topology& t = *extraction.cage.topology;
    extraction.patches.patches.resize(rings.size());
    base::parallel_for(rings.size(), 256, [&](std::size_t first, std::size_t last) {
        for (std::size_t f = first; f < last; ++f) {
            const PatchBuilder builder(rings[f], extraction.cage.points);
            Patch& patch = extraction.patches.patches[f];
            patch.surface = classes[f].shape == FaceShape::Regular
                                ? builder.regular()
                                : builder.with_cap(classes[f].corner, options.cap_depth);
            patch.name = patch_name(t, FaceId{static_cast<std::int32_t>(f)});
        }
    });
    for (const FaceClass& c : classes) extraction.caps += c.shape == FaceShape::OneCorner ? 1 : 0;
    connect(extraction);
    return extraction;
}

Points crease_midpoints(const PatchSet& patches) {
    std::vector<geom::Vec3> middles;
    for (const PatchEdge& edge : patches.edges) {
        if (edge.crease)
            middles.push_back(edge.curve.at(0.5 * (edge.curve.begin() + edge.curve.end())));
    }
    Points points(Eigen::Index(middles.size()), 3);
    for (std::size_t i = 0; i < middles.size(); ++i) points.row(Eigen::Index(i)) = middles[i];
    return points;
}

}  // namespace patchwright::patch
