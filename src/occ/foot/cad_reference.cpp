#include "occ/brep/surface_mesh.h"
#include "occ/exchange/cad_model_impl.h"
#include "occ/foot/foot_point_engine.h"
#include "occ/foot/reference_sampling.h"
#include "occ/foot/surroundings.h"
#include "occ/kernel_guard.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/occ/cad_reference.h>

#include <BRepBndLib.hxx>
#include <Bnd_Box.hxx>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

namespace patchwright::occ {

using geom::Vec3;

struct CadReference::Impl {
    CadModel model;  ///< surfaces and curves are shared with it
    SearchModel search;
    std::optional<double> size;
};

namespace {

void require(bool valid, const char* what) {
    if (!valid) throw base::InvalidArgument(what);
}

double rough_diagonal(const TopoDS_Shape& shape) {
    Bnd_Box box;
    BRepBndLib::Add(shape, box, Standard_False);
    return box.IsVoid() || box.IsOpen() ? 0.0 : std::sqrt(box.SquareExtent());
}

std::vector<int> edges_of_kind(const EdgeNetwork& network, EdgeKind kind) {
    std::vector<int> result;
    for (std::size_t i = 0; i < network.edges.size(); ++i)
        if (network.edges[i].kind == kind) result.push_back(int(i));
    return result;
}

// The curves keep the addresses of the edges: the network must be in its final place.
void index_edges(SearchModel& model, double deflection) {
    const EdgeNetwork& network = model.network;
    std::vector<int> all(network.edges.size());
    std::iota(all.begin(), all.end(), 0);
    const auto search = [&](const std::vector<int>& subset) {
        return CurveSearch(network.edges, subset, deflection, model.size);
    };
    model.all_edges = search(all);
    model.sharp_edges = search(edges_of_kind(network, EdgeKind::Sharp));
    model.free_edges = search(edges_of_kind(network, EdgeKind::Free));
    model.smooth_edges = search(edges_of_kind(network, EdgeKind::Smooth));
    model.features = FeatureCurves(network, deflection, model.size);
    std::vector<geom::Box3> boxes;
    for (const geom::FeatureCorner& corner : model.features.features().corners) {
        boxes.emplace_back();
        boxes.back().add(corner.point);
    }
    model.corners = geom::Bvh(boxes);
}

void measure_bounds(SearchModel& model) {
    for (const MeshTriangle& t : model.mesh.triangles)
        for (const Vec3& p : t.corner) model.bounds.add(p);
    model.size = model.bounds.diagonal();
}

void fill(SearchModel& model, const TopoDS_Shape& shape, const ReferenceOptions& options) {
    base::report_progress(options.progress, "reference", 0.0);
    const double diagonal = rough_diagonal(shape);
    if (!(diagonal > 0.0))
        throw base::InputError(
            "CAD model: no faces of finite size; nothing to be measured against");
    const double deflection = options.deflection_rel * diagonal;
    const SearchableShape copy = make_searchable(shape);
    model.surfaces.reserve(copy.faces.size());
    for (const TopoDS_Face& face : copy.faces)
        model.surfaces.emplace_back(face, diagonal, &model.memory);
    base::report_progress(options.progress, "reference", 0.1);
    model.mesh = triangulate(copy, model.surfaces, deflection, options.progress);
    if (model.mesh.triangles.empty())
        throw base::InputError("CAD model: no face can be triangulated; heal the file");
    measure_bounds(model);
    base::report_progress(options.progress, "reference", 0.8);
    model.network = collect_edges(copy.shape, copy.faces, model.surfaces, options.sharp_angle_rad);
    base::report_progress(options.progress, "reference", 0.85);
    for (const ModelEdge& edge : model.network.edges) model.mesh.covers_edges &= !edge.uses.empty();
    index_edges(model, deflection);
    base::report_progress(options.progress, "reference", 0.9);
    model.mesh.around = look_around(model.mesh, model.surfaces, model.all_edges);
    model.side_reach = options.side_reach_rel * model.size;
    if (options.foot_points == FootPoints::Kernel)
        model.kernel =
            std::make_unique<const KernelExtrema>(copy.faces, model.surfaces, model.network.edges);
    base::report_progress(options.progress, "reference", 1.0);
}

std::optional<geom::FeaturePoint> nearest_corner(const SearchModel& model, const Vec3& query) {
    std::optional<geom::FeaturePoint> best;
    model.corners.nearest(
        query, std::numeric_limits<double>::infinity(), [&](int item, double bound) {
            const Vec3& point = model.features.features().corners[std::size_t(item)].point;
            const double distance = (point - query).norm();
            if (best && distance >= best->distance) return bound;
            best = geom::FeaturePoint{point, distance, item};
            return distance;
        });
    return best;
}

std::optional<geom::FeaturePoint> nearest_on_curves(const SearchModel& model,
                                                    const CurveSearch& curves, const Vec3& query) {
    std::optional<CurveHit> best;
    curves.visit(query, std::numeric_limits<double>::infinity(),
                 [&](const CurveHit& hit, double bound) {
                     if (best && hit.distance >= best->distance) return bound;
                     best = hit;
                     return hit.distance;
                 });
    if (!best) return std::nullopt;
    return model.features.point_of(*best);
}

geom::FootPoint nearest(const SearchModel& model, const Vec3& query,
                        const std::optional<Vec3>& side, double bound) {
    // Farther away double precision does not tell the model's points apart, and single precision
    // overflows: the point on the way there has the same nearest one.
    constexpr double farthest_rel = 1e12;
    const Vec3 centre = model.bounds.centre(), way = query - centre;
    const double farthest = farthest_rel * model.size;
    // Written so that an overflow of the square counts as far.
    if (farthest > 0.0 && !(way.squaredNorm() <= 1.002 * farthest * farthest)) {
        const Vec3 nearer = centre + farthest / way.stableNorm() * way;
        geom::FootPoint foot =
            nearest(model, nearer, side, std::numeric_limits<double>::infinity());
        foot.distance = (foot.point - query).stableNorm();
        return foot;
    }
    if (model.kernel)
        return side ? nearest_point_facing_by_kernel(model, query, *side)
                    : nearest_point_by_kernel(model, query);
    return side ? nearest_point_facing(model, query, *side, bound)
                : nearest_point(model, query, bound);
}

/// A query's number and its place on the curve that visits neighbours mostly one after the other.
struct Placed {
    std::uint32_t place, query;
};

// The queries in Z order (Morton 1966): what the last query has found bounds the next one's search,
// and the cache still holds it. Sorted by thousands of places at a time, which keeps the order of
// equal ones, so that the rest of the work is what several threads share.
std::vector<Placed> in_z_order(const geom::Points& queries) {
    constexpr int bits = 10;
    const geom::Box3 box = geom::bounding_box(queries);
    const double extent = queries.rows() > 0 ? (box.max - box.min).maxCoeff() : 0.0;
    const double cells = extent > 0.0 ? ((1 << bits) - 1) / extent : 0.0;
    std::vector<Placed> placed(std::size_t(queries.rows())), sorted(placed.size());
    base::parallel_for(placed.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            std::uint32_t place = 0;
            for (int k = 0; k < 3; ++k) {
                auto cell = std::uint32_t((queries(Eigen::Index(i), k) - box.min[k]) * cells);
                // Two zeros between any two bits.
                cell = (cell | cell << 16) & 0x030000ffu;
                cell = (cell | cell << 8) & 0x0300f00fu;
                cell = (cell | cell << 4) & 0x030c30c3u;
                cell = (cell | cell << 2) & 0x09249249u;
                place |= cell << k;
            }
            placed[i] = {place, std::uint32_t(i)};
        }
    });
    for (int shift = 0; shift < 3 * bits; shift += bits) {
        std::array<std::size_t, (1 << bits) + 1> start{};
        const auto digit = [&](const Placed& p) {
            return std::size_t(p.place >> shift & ((1u << bits) - 1u));
        };
        for (const Placed& p : placed) ++start[digit(p) + 1];
        for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
        for (const Placed& p : placed) sorted[start[digit(p)]++] = p;
        placed.swap(sorted);
    }
    return placed;
}

}  // namespace

CadReference::CadReference(const CadModel& model, const ReferenceOptions& options)
    : impl_(new Impl{model, {}, options.size_mm}) {
    require(options.deflection_rel > 0.0 && options.deflection_rel < 1.0,
            "ReferenceOptions::deflection_rel must lie between 0 and 1");
    require(options.sharp_angle_rad > 0.0, "ReferenceOptions::sharp_angle_rad must be positive");
    require(options.side_reach_rel >= 0.0, "ReferenceOptions::side_reach_rel must not be negative");
    require(options.size_mm.value_or(1.0) > 0.0, "ReferenceOptions::size_mm must be positive");
    guard_kernel<base::InputError>("preparing the CAD reference",
                                   [&] { fill(impl_->search, model.impl().shape, options); });
}

CadReference::~CadReference() = default;
CadReference::CadReference(CadReference&&) noexcept = default;
CadReference& CadReference::operator=(CadReference&&) noexcept = default;

geom::Box3 CadReference::bounds() const { return impl_->search.bounds; }

double CadReference::size() const { return impl_->size.value_or(bounds().diagonal()); }

geom::FootPoint CadReference::foot_point(const Vec3& query, const std::optional<Vec3>& side) const {
    require(query.allFinite(), "foot_point: the query is not finite");
    return guard_kernel<base::InputError>("foot point", [&] {
        return nearest(impl_->search, query, side, std::numeric_limits<double>::infinity());
    });
}

geom::FootPoint CadReference::foot_point_on(const std::vector<char>& faces, const Vec3& query,
                                            const std::optional<Vec3>& side) const {
    require(query.allFinite(), "foot_point_on: the query is not finite");
    require(faces.size() == impl_->search.surfaces.size(),
            "foot_point_on: there must be one flag a face");
    return guard_kernel<base::InputError>(
        "foot point", [&] { return nearest_point_on(impl_->search, faces, query, side); });
}

std::vector<geom::FaceBorder> CadReference::face_borders() const {
    std::vector<geom::FaceBorder> result = impl_->search.features.face_borders();
    std::vector<char> listed(impl_->search.surfaces.size(), 0);
    for (const geom::FaceBorder& b : result)
        for (const int face : {b.left, b.right})
            if (face >= 0) listed[std::size_t(face)] = 1;
    for (std::size_t f = 0; f < listed.size(); ++f)
        if (listed[f] == 0) result.push_back({.left = int(f)});
    return result;
}

geom::FootPoint CadReference::foot_point_from(const geom::FootPoint& last, const Vec3& query,
                                              const std::optional<Vec3>& side) const {
    require(query.allFinite(), "foot_point_from: the query is not finite");
    return guard_kernel<base::InputError>("foot point", [&] {
        return nearest(impl_->search, query, side, (last.point - query).norm());
    });
}

std::vector<geom::FootPoint> CadReference::foot_points(const geom::Points& queries,
                                                       const geom::Points& sides) const {
    require(sides.rows() == 0 || sides.rows() == queries.rows(),
            "foot_points: sides must be none or one a query");
    require(queries.allFinite(), "foot_points: a query is not finite");
    require(queries.rows() <= Eigen::Index(std::numeric_limits<std::uint32_t>::max()),
            "foot_points: too many queries at once");
    std::vector<geom::FootPoint> result(std::size_t(queries.rows()));
    const std::vector<Placed> order = in_z_order(queries);
    constexpr std::size_t grain = 256, ahead = 4;
    base::parallel_for(result.size(), grain, [&](std::size_t begin, std::size_t end) {
        guard_kernel<base::InputError>("foot points", [&] {
            double bound = std::numeric_limits<double>::infinity();
            Vec3 last = Vec3::Zero();
            for (std::size_t i = begin; i < end; ++i) {
                if (i + ahead < end) {
                    const std::uint32_t next = order[i + ahead].query;
                    __builtin_prefetch(&queries(Eigen::Index(next), 0));
                    __builtin_prefetch(&result[next], 1);
                }
                const auto row = Eigen::Index(order[i].query);
                const Vec3 query = queries.row(row).transpose();
                std::optional<Vec3> side;
                if (sides.rows() > 0 && !sides.row(row).isZero(0.0))
                    side = sides.row(row).transpose();
                if (i > begin) bound = (last - query).norm();
                const geom::FootPoint foot = nearest(impl_->search, query, side, bound);
                last = foot.point;
                result[order[i].query] = foot;
            }
        });
    });
    return result;
}

std::optional<geom::Curvature> CadReference::curvature(const geom::FootPoint& foot) const {
    const auto& surfaces = impl_->search.surfaces;
    require(foot.face >= 0 && foot.face < int(surfaces.size()),
            "curvature: the foot point is on no face of this reference");
    const auto found = surfaces[std::size_t(foot.face)].curvature(foot.uv);
    if (!found) return std::nullopt;
    return geom::Curvature{found->value, found->direction};
}

std::optional<geom::FeaturePoint> CadReference::feature_point(const Vec3& query,
                                                              geom::FeatureKind kind) const {
    require(query.allFinite(), "feature_point: the query is not finite");
    return guard_kernel<base::InputError>("feature point", [&] {
        const SearchModel& model = impl_->search;
        switch (kind) {
            case geom::FeatureKind::Sharp:
                return nearest_on_curves(model, model.sharp_edges, query);
            case geom::FeatureKind::Free: return nearest_on_curves(model, model.free_edges, query);
            case geom::FeatureKind::Smooth:
                return nearest_on_curves(model, model.smooth_edges, query);
            case geom::FeatureKind::Corner: return nearest_corner(model, query);
        }
        return std::optional<geom::FeaturePoint>{};
    });
}

const geom::Features& CadReference::features() const { return impl_->search.features.features(); }

geom::FeaturePoint CadReference::nearest_on_curve(
    int curve, const Vec3& query, const std::optional<geom::ArcRange>& within) const {
    require(curve >= 0 && curve < int(features().curves.size()),
            "nearest_on_curve: there is no such feature curve");
    require(query.allFinite(), "nearest_on_curve: the query is not finite");
    require(!within || within->from <= within->to,
            "nearest_on_curve: the piece ends before it starts");
    return guard_kernel<base::InputError>(
        "feature point", [&] { return impl_->search.features.nearest(curve, query, within); });
}

geom::FeaturePoint CadReference::point_on_curve(int curve, double arc_length) const {
    require(curve >= 0 && curve < int(features().curves.size()),
            "point_on_curve: there is no such feature curve");
    require(std::isfinite(arc_length), "point_on_curve: the arc length is not finite");
    return guard_kernel<base::InputError>(
        "feature point", [&] { return impl_->search.features.at(curve, arc_length); });
}

const SearchModel& CadReference::search_model() const { return impl_->search; }

std::vector<geom::SurfaceSample> CadReference::sample(int count) const {
    require(count > 0, "sample: the count must be positive");
    return guard_kernel<base::InputError>("sampling",
                                          [&] { return sample_model(impl_->search, count); });
}

std::vector<geom::SurfacePiece> CadReference::pieces() const {
    std::vector<geom::SurfacePiece> result;
    result.reserve(impl_->search.mesh.triangles.size());
    for (const MeshTriangle& t : impl_->search.mesh.triangles) result.push_back({t.face, t.uv});
    return result;
}

geom::FootPoint CadReference::point_on_face(int face, const Eigen::Vector2d& uv) const {
    const FaceSurface& surface = impl_->search.surfaces[std::size_t(face)];
    return {surface.at(uv), surface.normal(uv), 0.0, face, uv};
}

geom::SurfaceMesh CadReference::surface_mesh(double deflection_mm) const {
    return occ::surface_mesh(impl_->model, impl_->search, deflection_mm);
}

std::vector<std::string> CadReference::face_names() const { return occ::face_names(impl_->model); }

}  // namespace patchwright::occ
