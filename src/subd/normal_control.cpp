#include "subd/corner_spectrum.h"

#include <patchwright/base/error.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/normal_control.h>
#include <patchwright/subd/refine.h>

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace patchwright::subd {

namespace {

/// Relative singular values of products of constraints that depend on each other.
constexpr double dependent = 1e-12;

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
        int sharp_edges = 0;
        CornerId c = topology_.corner(ring[0]);
        const CornerId first = c;
        do {
            sharp_edges += std::isinf(topology_.sharpness(topology_.edge(c))) ? 1 : 0;
            c = topology_.rotate(c);
        } while (c.valid() && c != first);
        if (!c.valid()) ++sharp_edges;  // the boundary edge that arrives
        const bool corner = std::isinf(topology_.sharpness(ring[0])) || sharp_edges > 2;
        const Eigen::MatrixXd growth =
            growing_part(sector_matrix(static_cast<int>(fan.size()), tag.angle, corner), 0.5);
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

mesh::Cage control_normals(const mesh::Cage& cage) {
    NormalControl control(cage);
    for (const SectorTagInput& tag : cage.topology->sectors()) control.apply(tag);
    return {cage.topology, std::move(control).points()};
}

}  // namespace patchwright::subd
