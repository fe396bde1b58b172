#include "geom/angle.h"
#include "geom/bvh.h"
#include "geom/mesh_bend.h"
#include "geom/mesh_curves.h"
#include "geom/mesh_features.h"
#include "geom/mesh_sides.h"

#include <patchwright/base/error.h>
#include <patchwright/geom/mesh_reference.h>
#include <patchwright/geom/nearest.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace patchwright::geom {

struct MeshReference::Impl {
    TriangleMesh mesh;
    MeshReferenceOptions options;
    Box3 bounds;
    MeshFeatures found;
    MeshBend bend;
    MeshCurves curves;
    std::vector<int> regions;
    int region_count = 0;
    Bvh tree;
    double reach = 0.0;
    double chord_error = 0.0;

    /// @param faces  one flag a triangle: where the answer may lie; null: on all
    [[nodiscard]] FootPoint nearest(const Vec3& query, const std::optional<Vec3>& side,
                                    const std::vector<char>* faces) const;
};

namespace {

void require(bool valid, const char* what) {
    if (!valid) throw base::InvalidArgument(what);
}

Vec3 at_weights(const TriangleMesh& mesh, int t, const Vec3& w) {
    return w[0] * corner_point(mesh, t, 0) + w[1] * corner_point(mesh, t, 1) +
           w[2] * corner_point(mesh, t, 2);
}

Vec3 normal_at(const MeshBend& bend, int t, const Vec3& w) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k)
        sum += w[Eigen::Index(k)] * bend.normal[std::size_t(bend.sector[std::size_t(t)][k])];
    const double norm = sum.norm();
    return norm > 1e-12 ? Vec3(sum / norm) : Vec3::Zero();
}

/// Triangles that hang together without a feature between them, of one part of the file.
std::vector<int> regions_of(const TriangleMesh& mesh, const MeshFeatures& features, int& count) {
    std::vector<int> region(mesh.triangles.size(), -1);
    std::vector<int> pending;
    count = 0;
    for (std::size_t first = 0; first < region.size(); ++first) {
        if (region[first] >= 0) continue;
        pending.assign(1, int(first));
        region[first] = count;
        while (!pending.empty()) {
            const auto t = std::size_t(pending.back());
            pending.pop_back();
            for (std::size_t k = 0; k < 3; ++k) {
                const int other = features.beyond[t][k];
                if (other < 0 || features.curve_under[t][k] >= 0 ||
                    region[std::size_t(other)] >= 0 ||
                    mesh.part[std::size_t(other)] != mesh.part[t])
                    continue;
                region[std::size_t(other)] = count;
                pending.push_back(other);
            }
        }
        ++count;
    }
    return region;
}

/// Largest absolute curvature of the triangle's corners.
double bend_of(const MeshBend& bend, int t) {
    double largest = 0.0;
    for (const int s : bend.sector[std::size_t(t)])
        largest = std::max(largest, bend.shape[std::size_t(s)].norm());
    return largest;
}

/// Of chords of length s that turn by an angle a from one to the next the arc is s a / 8 away. What
/// the rounded part of the area stays below, but for a twentieth.
double chord_error_of(const TriangleMesh& mesh, const MeshFeatures& features) {
    constexpr double flat_rad = 1e-3, share = 0.95;
    const auto height = [&](int t, std::size_t side) {
        const Vec3 along = corner_point(mesh, t, int(side) + 1) - corner_point(mesh, t, int(side));
        return area_vector(mesh, t).norm() / std::max(along.norm(), 1e-300);
    };
    std::vector<std::pair<double, double>> errors;  // with area
    double whole = 0.0;
    for (int t = 0; t < int(mesh.triangles.size()); ++t) {
        const Vec3 normal = area_vector(mesh, t);
        double error = 0.0;
        for (std::size_t k = 0; k < 3; ++k) {
            const int other = features.beyond[std::size_t(t)][k];
            if (other < 0 || features.curve_under[std::size_t(t)][k] >= 0) continue;
            const Vec3 beyond = area_vector(mesh, other);
            const double angle = angle_between(normal, beyond);
            if (angle < flat_rad) continue;
            std::size_t back = 0;
            while (back < 2 && features.beyond[std::size_t(other)][back] != t) ++back;
            error = std::max(error, std::min(height(t, k), height(other, back)) * angle / 8.0);
        }
        if (error == 0.0) continue;
        errors.emplace_back(error, normal.norm());
        whole += normal.norm();
    }
    std::sort(errors.begin(), errors.end());
    double sum = 0.0;
    for (const auto& [error, area] : errors) {
        sum += area;
        if (sum >= share * whole) return error;
    }
    return 0.0;
}

}  // namespace

MeshReference::MeshReference(TriangleMesh mesh, const MeshReferenceOptions& options)
    : impl_(new Impl) {
    require(!mesh.triangles.empty(), "MeshReference: the mesh has no triangles");
    require(mesh.part.size() == mesh.triangles.size(),
            "MeshReference: there must be one part a triangle");
    require(options.sharp_angle_rad > 0.0,
            "MeshReferenceOptions::sharp_angle_rad must be positive");
    require(options.side_reach_rel >= 0.0,
            "MeshReferenceOptions::side_reach_rel must not be negative");
    impl_->mesh = std::move(mesh);
    impl_->options = options;
    const TriangleMesh& m = impl_->mesh;
    std::vector<Box3> boxes(m.triangles.size());
    for (std::size_t t = 0; t < boxes.size(); ++t) {
        for (int k = 0; k < 3; ++k) boxes[t].add(corner_point(m, int(t), k));
        impl_->bounds.add(boxes[t]);
    }
    impl_->tree = Bvh(boxes);
    impl_->reach = options.side_reach_rel * impl_->bounds.diagonal();
    impl_->found = find_mesh_features(m, options.sharp_angle_rad);
    impl_->bend = measure_mesh_bend(m, impl_->found);
    impl_->curves = MeshCurves(m, impl_->found);
    impl_->regions = regions_of(m, impl_->found, impl_->region_count);
    impl_->chord_error = chord_error_of(m, impl_->found);
}

FootPoint MeshReference::Impl::nearest(const Vec3& query, const std::optional<Vec3>& side,
                                       const std::vector<char>* faces) const {
    const auto within = [&](double bound, bool facing) {
        FootPoint best;
        best.distance = std::numeric_limits<double>::infinity();
        tree.nearest(query, bound, [&](int t, double limit) {
            if (faces != nullptr && (*faces)[std::size_t(t)] == 0) return limit;
            const Vec3 w = nearest_weights(
                query,
                {corner_point(mesh, t, 0), corner_point(mesh, t, 1), corner_point(mesh, t, 2)});
            const Vec3 point = at_weights(mesh, t, w);
            const double distance = (point - query).norm();
            if (distance > limit || distance >= best.distance) return limit;
            const Vec3 normal = normal_at(bend, t, w);
            if (facing && !(normal.dot(*side) > 0.0)) return limit;
            best = {point, normal, distance, t, {w[1], w[2]}};
            return distance;
        });
        return best;
    };
    const FootPoint plain = within(std::numeric_limits<double>::infinity(), false);
    if (!side || plain.normal.dot(*side) > 0.0) return plain;
    const FootPoint facing = within(plain.distance + reach, true);
    return facing.face >= 0 ? facing : plain;
}

MeshReference::~MeshReference() = default;
MeshReference::MeshReference(MeshReference&&) noexcept = default;
MeshReference& MeshReference::operator=(MeshReference&&) noexcept = default;

Box3 MeshReference::bounds() const { return impl_->bounds; }

FootPoint MeshReference::foot_point(const Vec3& query, const std::optional<Vec3>& side) const {
    require(query.allFinite(), "foot_point: the query is not finite");
    return impl_->nearest(query, side, nullptr);
}

FootPoint MeshReference::foot_point_on(const std::vector<char>& faces, const Vec3& query,
                                       const std::optional<Vec3>& side) const {
    require(query.allFinite(), "foot_point_on: the query is not finite");
    require(faces.size() == impl_->mesh.triangles.size(),
            "foot_point_on: there must be one flag a triangle");
    const FootPoint on = impl_->nearest(query, side, &faces);
    return on.face >= 0 ? on : impl_->nearest(query, side, nullptr);
}

std::vector<FaceBorder> MeshReference::face_borders() const {
    std::set<std::pair<int, int>> steps;  // along the curves
    for (const MeshChain& chain : impl_->found.chains)
        for (std::size_t i = 0; i + 1 < chain.points.size(); ++i)
            steps.insert({chain.points[i], chain.points[i + 1]});
    std::vector<FaceBorder> result;
    for (int t = 0; t < int(impl_->mesh.triangles.size()); ++t) {
        const auto& corners = impl_->mesh.triangles[std::size_t(t)];
        for (std::size_t k = 0; k < 3; ++k) {
            const int other = impl_->found.beyond[std::size_t(t)][k];
            if (other > t) continue;  // found from there
            const int curve = impl_->found.curve_under[std::size_t(t)][k];
            const bool along = curve < 0 || steps.contains({corners[k], corners[(k + 1) % 3]});
            result.push_back({along ? t : other, along ? other : t, curve});
        }
    }
    return result;
}

const Features& MeshReference::features() const { return impl_->found.features; }

FeaturePoint MeshReference::nearest_on_curve(int curve, const Vec3& query,
                                             const std::optional<ArcRange>& within) const {
    require(curve >= 0 && curve < int(features().curves.size()),
            "nearest_on_curve: there is no such feature curve");
    require(query.allFinite(), "nearest_on_curve: the query is not finite");
    require(!within || within->from <= within->to,
            "nearest_on_curve: the piece ends before it starts");
    return impl_->curves.nearest(curve, query, within);
}

FeaturePoint MeshReference::point_on_curve(int curve, double arc_length) const {
    require(curve >= 0 && curve < int(features().curves.size()),
            "point_on_curve: there is no such feature curve");
    require(std::isfinite(arc_length), "point_on_curve: the arc length is not finite");
    return impl_->curves.at(curve, arc_length);
}

std::optional<Curvature> MeshReference::curvature(const FootPoint& foot) const {
    require(foot.face >= 0 && foot.face < int(impl_->mesh.triangles.size()),
            "curvature: the foot point is on no triangle of this mesh");
    const auto& sector = impl_->bend.sector[std::size_t(foot.face)];
    const Vec3 w(1.0 - foot.uv[0] - foot.uv[1], foot.uv[0], foot.uv[1]);
    const Vec3 normal = normal_at(impl_->bend, foot.face, w);
    if (normal.isZero(0.0)) return std::nullopt;
    Eigen::Matrix3d shape = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < 3; ++k)
        shape += w[Eigen::Index(k)] * impl_->bend.shape[std::size_t(sector[k])];
    const Vec3 x = normal.unitOrthogonal(), y = normal.cross(x);
    // Mohr's circle of the symmetric part: the larger value is at half its angle from x.
    const double xx = x.dot(shape * x), yy = y.dot(shape * y);
    const double xy = 0.5 * (x.dot(shape * y) + y.dot(shape * x));
    const double middle = 0.5 * (xx + yy), radius = std::hypot(0.5 * (xx - yy), xy);
    const double angle = 0.5 * std::atan2(xy, 0.5 * (xx - yy));
    const Vec3 along = std::cos(angle) * x + std::sin(angle) * y;
    return Curvature{.value = {middle - radius, middle + radius},
                     .direction = {normal.cross(along), along}};
}

std::optional<FeaturePoint> MeshReference::feature_point(const Vec3& query,
                                                         FeatureKind kind) const {
    require(query.allFinite(), "feature_point: the query is not finite");
    return impl_->curves.nearest(query, kind);
}

std::vector<SurfaceSample> MeshReference::sample(int count) const {
    require(count > 0, "sample: the count must be positive");
    const TriangleMesh& mesh = impl_->mesh;
    const std::size_t triangles = mesh.triangles.size();
    // Bend between that of the whole model's size and a hundred times more, as for CAD models.
    const double least = 1.0 / std::max(impl_->bounds.diagonal(), 1e-300);
    std::vector<double> area(triangles), share(triangles);
    double whole = 0.0, bent = 0.0;
    for (std::size_t t = 0; t < triangles; ++t) {
        area[t] = 0.5 * area_vector(mesh, int(t)).norm();
        share[t] = area[t] * std::clamp(bend_of(impl_->bend, int(t)), least, 100.0 * least);
        whole += area[t];
        bent += share[t];
    }
    std::vector<SurfaceSample> samples;
    if (!(whole > 0.0)) return samples;
    for (std::size_t t = 0; t < triangles; ++t)
        share[t] = 0.5 * area[t] / whole + 0.5 * share[t] / bent;
    std::size_t at = 0;
    double passed = 0.0;
    for (int i = 0; i < count; ++i) {
        const double target = (i + 0.5) / count;
        while (at + 1 < triangles && passed + share[at] < target) passed += share[at++];
        // The R2 sequence (Roberts, 2018) in the triangle.
        double a = std::fmod(0.5 + 0.7548776662466927 * i, 1.0);
        double b = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
        if (a + b > 1.0) {
            a = 1.0 - a;
            b = 1.0 - b;
        }
        const Vec3 w(1.0 - a - b, a, b);
        samples.push_back({at_weights(mesh, int(at), w), normal_at(impl_->bend, int(at), w),
                           int(at), area[at] / (share[at] * count)});
    }
    // Points are what the file is sure of: all of them, or as many as there are other samples.
    const std::size_t step = std::max<std::size_t>(1, triangles / std::size_t(count));
    std::vector<char> seen(std::size_t(mesh.points.rows()), 0);
    for (std::size_t t = 0; t < triangles; t += step) {
        for (std::size_t k = 0; k < 3; ++k) {
            const int v = mesh.triangles[t][k];
            if (seen[std::size_t(v)] != 0) continue;
            seen[std::size_t(v)] = 1;
            samples.push_back({mesh.points.row(v),
                               impl_->bend.normal[std::size_t(impl_->bend.sector[t][k])], int(t),
                               0.0});
        }
    }
    return samples;
}

std::vector<SurfacePiece> MeshReference::pieces() const {
    std::vector<SurfacePiece> result;
    result.reserve(impl_->mesh.triangles.size());
    for (int t = 0; t < int(impl_->mesh.triangles.size()); ++t)
        result.push_back(
            {t, {Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)}});
    return result;
}

FootPoint MeshReference::point_on_face(int face, const Eigen::Vector2d& uv) const {
    const Vec3 w(1.0 - uv[0] - uv[1], uv[0], uv[1]);
    return {at_weights(impl_->mesh, face, w), normal_at(impl_->bend, face, w), 0.0, face, uv};
}

SurfaceMesh MeshReference::surface_mesh(double /*deflection_mm*/) const {
    return {.points = impl_->mesh.points,
            .triangles = impl_->mesh.triangles,
            .faces = impl_->regions,
            .features = impl_->found.sides,
            .corners = impl_->found.corner_of};
}

std::vector<std::string> MeshReference::face_names() const {
    std::vector<std::string> names(std::size_t(impl_->region_count));
    const TriangleMesh& mesh = impl_->mesh;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (mesh.part[t] >= 0)
            names[std::size_t(impl_->regions[t])] = mesh.part_names[std::size_t(mesh.part[t])];
    return names;
}

const TriangleMesh& MeshReference::mesh() const { return impl_->mesh; }
int MeshReference::region_count() const { return impl_->region_count; }
double MeshReference::chord_error() const { return impl_->chord_error; }

}  // namespace patchwright::geom
