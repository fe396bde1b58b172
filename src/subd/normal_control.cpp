#include "geom/angle.h"
#include "subd/corner_spectrum.h"

#include <patchwright/base/error.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/normal_control.h>
#include <patchwright/subd/refine.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace patchwright::subd {

namespace {

/// Relative singular values of products of constraints that depend on each other.
constexpr double dependent = 1e-12;
/// Sine of the angle between two creases below which they are one line.
constexpr double flat_sector = 1e-3;
/// Relative changes that are rounding.
constexpr double settled = 1e-9;

using mesh::CornerId;
using mesh::SectorTagInput;
using mesh::Topology;
using mesh::VertexId;

/// The points around a sector: the vertex, the ends of its edges and the far vertices of its faces,
/// counter-clockwise each.
std::vector<VertexId> sector_points(const Topology& t, const std::vector<CornerId>& fan) {
    std::vector<VertexId> points{t.vertex(fan[0])};
    for (const CornerId c : fan) {
        if (t.size(t.face(c)) != 4) {
            throw base::InputError(
                fmt::format("sector at vertex {}: face {} is no quad; subdivide the cage once",
                            points[0].value, t.face(c).value));
        }
        points.push_back(t.vertex(t.next(c)));
    }
    points.push_back(t.vertex(t.previous(fan.back())));
    for (const CornerId c : fan) points.push_back(t.vertex(t.next(t.next(c))));
    return points;
}

/// The subdivision matrix of sector_points().
Eigen::MatrixXd sector_matrix(int faces, double angle, bool corner) {
    mesh::TopologyInput input;
    input.vertex_count = 2 * faces + 2;
    for (int i = 0; i < faces; ++i) {
        input.face_sizes.push_back(4);
        for (const int v : {0, 1 + i, faces + 2 + i, 2 + i}) input.face_vertices.push_back(v);
    }
    if (corner) input.corners.push_back({0, mesh::infinite_sharpness});
    input.sectors.push_back({0, 0, angle, {}});
    const Topology fan(input);
    const Refinement step = refine(fan);
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(input.vertex_count, input.vertex_count);
    const auto copy = [&](int from, int to) {
        for (auto k = step.stencils.begin[std::size_t(from)];
             k < step.stencils.begin[std::size_t(from) + 1]; ++k) {
            matrix(to, step.stencils.index[std::size_t(k)]) += step.stencils.weight[std::size_t(k)];
        }
    };
    copy(0, 0);
    for (const mesh::EdgeId e : fan.edges()) {
        const int a = fan.start(e).value, b = fan.end(e).value;
        if (a == 0 || b == 0) copy(fan.vertex_count() + e.value, a + b);
    }
    for (int i = 0; i < faces; ++i) {
        copy(fan.vertex_count() + fan.edge_count() + i, faces + 2 + i);
    }
    return matrix;
}

/// Whether a vertex stays where it is: by its own sharpness, or as more than two sharp edges meet.
bool is_corner(const Topology& t, VertexId v) {
    int sharp_edges = 0;
    CornerId c = t.corner(v);
    const CornerId first = c;
    do {
        sharp_edges += std::isinf(t.sharpness(t.edge(c))) ? 1 : 0;
        c = t.rotate(c);
    } while (c.valid() && c != first);
    if (!c.valid()) ++sharp_edges;  // the boundary edge that arrives
    return std::isinf(t.sharpness(v)) || sharp_edges > 2;
}

/// The sectors of three or four faces between sharp edges at a corner, of quads with ordinary rules
/// and no semi-sharp edges: they have exactly one eigenvalue between 1/2 and 1.
std::vector<std::vector<CornerId>> corner_fans(const Topology& t, VertexId v) {
    std::vector<std::vector<CornerId>> fans;
    CornerId c = t.corner(v);
    if (!c.valid() || !is_corner(t, v)) return fans;
    const CornerId first = c;
    do {
        std::vector<CornerId> fan = mesh::sector_corners(t, c);
        const auto is_ordinary = [&](CornerId k) {
            return t.size(t.face(k)) == 4 && !t.is_shifted(k) &&
                   (k == c || t.sharpness(t.edge(k)) == 0.0);
        };
        const bool has_one_part = fan.size() == 3 || fan.size() == 4;
        if (has_one_part && fan.front() == c && std::all_of(fan.begin(), fan.end(), is_ordinary))
            fans.push_back(std::move(fan));
        c = t.rotate(c);
    } while (c.valid() && c != first);
    return fans;
}

/// Whether a sector spans more than 180 degrees.
/// @param ring  of sector_points()
bool is_concave(const geom::Points& ring, int faces) {
    const auto edge = [&](int i) -> Eigen::Vector3d {
        return (ring.row(1 + i) - ring.row(0)).transpose();
    };
    double angle = 0.0;
    for (int i = 0; i < faces; ++i) angle += geom::angle_between(edge(i), edge(i + 1));
    return angle > std::numbers::pi;
}

/// The ring with inner edges in even angles between the creases, of lengths between theirs but no
/// longer than they are; held points stay.
/// @param ring  of sector_points()
/// @param free  by point: 0 where it is held
geom::Points even_sector(const geom::Points& ring, const Eigen::VectorXd& free, int faces,
                         bool concave) {
    const auto edge = [&](int i) -> Eigen::Vector3d {
        return (ring.row(1 + i) - ring.row(0)).transpose();
    };
    const Eigen::Vector3d first = edge(0), last = edge(faces);
    const Eigen::Vector3d normal = (concave ? -1.0 : 1.0) * first.cross(last).normalized();
    const double between = geom::angle_between(first, last);
    const double angle = concave ? 2.0 * std::numbers::pi - between : between;
    geom::Points even = ring;
    for (int i = 1; i < faces; ++i) {
        if (free[1 + i] == 0.0) continue;
        const double share = double(i) / faces;
        const double length = std::pow(first.norm(), 1.0 - share) * std::pow(last.norm(), share);
        const Eigen::Vector3d direction =
            Eigen::AngleAxisd(share * angle, normal) * first.normalized();
        even.row(1 + i) = ring.row(0) + std::min(length, edge(i).norm()) * direction.transpose();
    }
    for (int i = 0; i < faces; ++i) {
        if (free[faces + 2 + i] == 0.0) continue;
        even.row(faces + 2 + i) = even.row(1 + i) + even.row(2 + i) - even.row(0);
    }
    return even;
}

/// The directions between a sector's sharp edges, or between what points against them where it is
/// concave, in the plane of the two.
class SectorCone {
  public:
    SectorCone(const geom::Points& ring, int faces, bool concave) {
        const double sign = concave ? -1.0 : 1.0;
        axes_.col(0) = sign * (ring.row(1) - ring.row(0)).transpose().normalized();
        axes_.col(1) = sign * (ring.row(1 + faces) - ring.row(0)).transpose().normalized();
        const Eigen::Vector3d normal = axes_.col(0).cross(axes_.col(1));
        exists_ = normal.norm() > flat_sector;
        axes_.col(2) = normal.normalized();
    }

    /// Whether the edges are not on one line.
    [[nodiscard]] bool exists() const { return exists_; }
    /// Projection onto the plane.
    [[nodiscard]] Eigen::Matrix3d plane() const {
        return Eigen::Matrix3d::Identity() - axes_.col(2) * axes_.col(2).transpose();
    }
    /// What is nearest to v within the cone; height over the plane stays.
    [[nodiscard]] Eigen::Vector3d nearest(const Eigen::Vector3d& v) const {
        const Eigen::Vector3d parts = axes_.inverse() * v;
        if (parts[0] >= 0.0 && parts[1] >= 0.0) return v;
        const Eigen::Vector3d height = parts[2] * axes_.col(2);
        const double first = std::max(0.0, v.dot(axes_.col(0))),
                     last = std::max(0.0, v.dot(axes_.col(1)));
        return height + (first > last ? first * axes_.col(0) : last * axes_.col(1));
    }

  private:
    Eigen::Matrix3d axes_;
    bool exists_ = false;
};

class NormalControl {
  public:
    explicit NormalControl(const mesh::Cage& cage)
        : topology_(*cage.topology), evaluator_(cage.topology), points_(cage.points) {}

    void apply(const SectorTagInput& tag) {
        const CornerId c =
            mesh::find_corner(topology_, mesh::FaceId{tag.face}, VertexId{tag.vertex});
        Eigen::MatrixXd growing(0, points_.rows());  // masks that must stay zero
        if (tag.angle > 0.0) growing = take_out_growth(tag, mesh::sector_corners(topology_, c));
        const Eigen::Vector3d normal(tag.normal[0], tag.normal[1], tag.normal[2]);
        if (normal.norm() > 0.0)
            turn(tag, corner_location(topology_, c), normal.normalized(), growing);
    }

    geom::Points points() && { return std::move(points_); }

  private:
    Eigen::MatrixXd take_out_growth(const SectorTagInput& tag, const std::vector<CornerId>& fan) {
        const std::vector<VertexId> ring = sector_points(topology_, fan);
        const Eigen::MatrixXd growth = growing_part(
            sector_matrix(static_cast<int>(fan.size()), tag.angle, is_corner(topology_, ring[0])),
            0.5);
        geom::Points local(Eigen::Index(ring.size()), 3);
        for (std::size_t k = 0; k < ring.size(); ++k) {
            local.row(Eigen::Index(k)) = points_.row(ring[k].value);
        }
        local -= growth * local;
        Eigen::MatrixXd masks = Eigen::MatrixXd::Zero(growth.rows(), points_.rows());
        for (std::size_t k = 0; k < ring.size(); ++k) {
            points_.row(ring[k].value) = local.row(Eigen::Index(k));
            masks.col(ring[k].value) = growth.col(Eigen::Index(k));
        }
        return masks;
    }

    void turn(const SectorTagInput& tag, const Location& at, const Eigen::Vector3d& normal,
              const Eigen::MatrixXd& growing) {
        const Mask mask = evaluator_.mask(at, 1);
        if (mask.smoothness == Smoothness::Position) {
            throw base::InputError(
                fmt::format("sector at vertex {}: there is no tangent plane that a normal could "
                            "turn; give the sector's angle",
                            tag.vertex));
        }
        // Least change of heights over the plane, with the vertex's own height fixed.
        std::vector<std::int32_t> free;
        for (const std::int32_t v : mask.vertices) {
            if (v != tag.vertex) free.push_back(v);
        }
        Eigen::MatrixXd constraints(2 + growing.rows(), Eigen::Index(free.size()));
        Eigen::VectorXd target = Eigen::VectorXd::Zero(constraints.rows());
        for (std::size_t k = 0, column = 0; k < mask.vertices.size(); ++k) {
            const std::int32_t v = mask.vertices[k];
            const Eigen::Vector2d tangent = mask.rows.block<2, 1>(1, Eigen::Index(k));
            target.head<2>() -= tangent * points_.row(v).dot(normal.transpose());
            if (v == tag.vertex) continue;
            constraints.col(Eigen::Index(column)) << tangent, growing.col(v);
            ++column;
        }
        // The shortest solution; constraints may say the same twice.
        Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::NoQRPreconditioner> products(
            constraints * constraints.transpose(), Eigen::ComputeFullU | Eigen::ComputeFullV);
        products.setThreshold(dependent);
        const Eigen::VectorXd change = constraints.transpose() * products.solve(target);
        for (std::size_t k = 0; k < free.size(); ++k) {
            points_.row(free[k]) += change[Eigen::Index(k)] * normal.transpose();
        }
    }

    const Topology& topology_;
    LimitEvaluator evaluator_;
    geom::Points points_;
};

}  // namespace

geom::Points CornerSectors::Sector::local(const geom::Points& points) const {
    geom::Points result(Eigen::Index(ring.size()), 3);
    for (std::size_t k = 0; k < ring.size(); ++k) result.row(Eigen::Index(k)) = points.row(ring[k]);
    return result;
}

CornerSectors::CornerSectors(const Topology& topology, const geom::Points& points,
                             const std::vector<std::uint8_t>& held) {
    for (const VertexId v : topology.vertices()) {
        for (const std::vector<CornerId>& fan : corner_fans(topology, v)) {
            Sector sector;
            const int faces = int(fan.size());
            for (const VertexId p : sector_points(topology, fan)) sector.ring.push_back(p.value);
            Eigen::VectorXd free(Eigen::Index(sector.ring.size()));
            for (Eigen::Index k = 0; k < free.size(); ++k)
                free[k] = held[std::size_t(sector.ring[std::size_t(k)])] == 0 ? 1.0 : 0.0;
            // Where all inner edges end on features there is nothing to turn.
            if (!(free.segment(2, faces - 1).array() > 0.0).any()) continue;
            // Of rank one: every row is a multiple of the mask, every column of the motion.
            const Eigen::MatrixXd growth = growing_part(sector_matrix(faces, 0.0, true), 0.5);
            Eigen::Index row = 0, column = 0;
            growth.cwiseAbs().maxCoeff(&row, &column);
            sector.mask = growth.row(row).normalized();
            sector.motion = growth.col(column).normalized().cwiseProduct(free);
            if (sector.motion.segment(2, faces - 1).sum() < 0.0) sector.motion *= -1.0;
            sector.mask /= sector.mask * sector.motion;
            const geom::Points local = sector.local(points);
            sector.concave = is_concave(local, faces);
            const SectorCone cone(local, faces, sector.concave);
            if (!cone.exists()) continue;
            const Eigen::Vector3d even =
                (sector.mask * even_sector(local, free, faces, sector.concave)).transpose();
            sector.room = even - cone.nearest(even);
            sectors_.push_back(std::move(sector));
        }
    }
}

void CornerSectors::settle(geom::Points& points) {
    for (Sector& sector : sectors_) {
        const geom::Points local = sector.local(points);
        const SectorCone cone(local, int(sector.ring.size()) / 2 - 1, sector.concave);
        const Eigen::Vector3d part = (sector.mask * local).transpose() - sector.room;
        const Eigen::Vector3d change = cone.nearest(part) - part;
        if (!(change.norm() > settled * part.norm())) continue;
        for (std::size_t k = 0; k < sector.ring.size(); ++k)
            points.row(sector.ring[k]) += sector.motion[Eigen::Index(k)] * change.transpose();
        // At the tip of the cone both directions are kept.
        const Eigen::Vector3d across = change.normalized();
        const bool tip = sector.kept.isZero() ? cone.nearest(part).isZero()
                                              : (sector.kept * across - across).norm() > settled;
        sector.kept = tip ? cone.plane() : Eigen::Matrix3d(across * across.transpose());
    }
}

void CornerSectors::project(geom::Points& displacements) const {
    for (const Sector& sector : sectors_) {
        if (sector.kept.isZero()) continue;
        const Eigen::RowVector3d part = sector.mask * sector.local(displacements) * sector.kept;
        for (std::size_t k = 0; k < sector.ring.size(); ++k)
            displacements.row(sector.ring[k]) -= sector.motion[Eigen::Index(k)] * part;
    }
}

void CornerSectors::project_transposed(geom::Points& rows) const {
    for (auto sector = sectors_.rbegin(); sector != sectors_.rend(); ++sector) {
        if (sector->kept.isZero()) continue;
        const Eigen::RowVector3d part =
            sector->motion.transpose() * sector->local(rows) * sector->kept;
        for (std::size_t k = 0; k < sector->ring.size(); ++k)
            rows.row(sector->ring[k]) -= sector->mask[Eigen::Index(k)] * part;
    }
}

mesh::Cage control_normals(const mesh::Cage& cage) {
    NormalControl control(cage);
    for (const SectorTagInput& tag : cage.topology->sectors()) control.apply(tag);
    return {cage.topology, std::move(control).points()};
}

}  // namespace patchwright::subd
