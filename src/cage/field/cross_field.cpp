#include "cage/field/cross_field.h"

#include "cage/field/vertex_fan.h"

#include <patchwright/base/numbers.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <complex>

namespace patchwright::cage {

using base::at;
using geom::Vec3;
using Complex = std::complex<double>;

namespace {

// Pull of a principal direction against the smoothness between neighbours. With the weights of
// curvature_hints() both are energies: how much normals change along a field that turns from it.
constexpr double hint_weight = 0.5;
// Steps of diffusion, and the square of its width in each, of a region's area. Fields settle in
// about ten.
constexpr int diffusion_steps = 12;
constexpr double diffusion_area = 0.01;
// Of the mean weight between neighbours: keeps a field without features and hints determined.
constexpr double anchor_weight = 1e-6;
// Radians over the diagonal that curvatures must differ by to count as clear.
constexpr double least_bend = 1.0;

/// Axes in the plane of a triangle: along its first side, and at a right angle to that.
struct Frame {
    Vec3 x, y;
};

Frame frame_of(const geom::EditableMesh& mesh, int t) {
    const auto& c = mesh.triangle(t);
    const Vec3 x = (mesh.point(c[1]) - mesh.point(c[0])).normalized();
    return {x, mesh.area_vector(t).normalized().cross(x)};
}

double angle_in(const Frame& frame, const Vec3& d) {
    return std::atan2(frame.y.dot(d), frame.x.dot(d));
}

Vec3 side_vector(const geom::EditableMesh& mesh, int t, int k) {
    const auto& c = mesh.triangle(t);
    return mesh.point(c[at((k + 1) % 3)]) - mesh.point(c[at(k)]);
}

Complex fourfold(double angle) { return std::polar(1.0, 4.0 * angle); }

class FieldSolver {
  public:
    FieldSolver(const geom::EditableMesh& mesh, const std::vector<FieldHint>& hints, Poll& poll)
        : mesh_(mesh),
          hints_(hints),
          poll_(poll),
          number_(at(mesh.triangle_count()), -1),
          cross_(at(mesh.triangle_count()), Complex(1.0)),
          frame_(at(mesh.triangle_count())) {
        for (int t = 0; t < mesh.triangle_count(); ++t) {
            if (!mesh.alive(t)) continue;
            frame_[at(t)] = frame_of(mesh, t);
            if (!constrain(t)) number_[at(t)] = unknowns_++;
        }
        measure_regions();
    }

    CrossField solve() {
        if (unknowns_ > 0) diffuse();
        CrossField field;
        field.direction.assign(cross_.size(), Vec3::Zero());
        for (int t = 0; t < mesh_.triangle_count(); ++t) {
            if (!mesh_.alive(t)) continue;
            const double angle = std::arg(cross_[at(t)]) / 4.0;
            field.direction[at(t)] =
                std::cos(angle) * frame_[at(t)].x + std::sin(angle) * frame_[at(t)].y;
        }
        return field;
    }

  private:
    /// Whether a feature decides the cross.
    bool constrain(int t) {
        for (int k = 0; k < 3; ++k) {
            if (!is_border(mesh_, t, k)) continue;
            cross_[at(t)] = fourfold(angle_in(frame_[at(t)], side_vector(mesh_, t, k)));
            return true;
        }
        return false;
    }

    /// Areas of what features bound, one a triangle.
    void measure_regions() {
        region_area_.assign(number_.size(), 0.0);
        for (int seed = 0; seed < mesh_.triangle_count(); ++seed) {
            if (!mesh_.alive(seed) || region_area_[at(seed)] > 0.0) continue;
            std::vector<int> region{seed};
            region_area_[at(seed)] = 1.0;
            double area = 0.0;
            for (std::size_t i = 0; i < region.size(); ++i) {
                area += 0.5 * mesh_.area_vector(region[i]).norm();
                for (int k = 0; k < 3; ++k) {
                    if (is_border(mesh_, region[i], k)) continue;
                    const int u = across(mesh_, region[i], k);
                    if (region_area_[at(u)] > 0.0) continue;
                    region_area_[at(u)] = 1.0;
                    region.push_back(u);
                }
            }
            for (const int t : region) region_area_[at(t)] = std::max(area, 1e-300);
        }
    }

    [[nodiscard]] double area(int t) const { return 0.5 * mesh_.area_vector(t).norm(); }

    /// Smoothness and hints: the matrix of the free triangles, and what is known.
    void assemble() {
        known_ = Eigen::VectorXcd::Zero(unknowns_);
        for (int t = 0; t < mesh_.triangle_count(); ++t) {
            if (number_[at(t)] < 0) continue;
            const int i = number_[at(t)];
            if (!hints_.empty() && hints_[at(t)].weight > 0.0) {
                const double w = hint_weight * hints_[at(t)].weight;
                entries_.emplace_back(i, i, w);
                known_[i] += w * fourfold(angle_in(frame_[at(t)], hints_[at(t)].direction));
            }
            for (int k = 0; k < 3; ++k) {
                const int u = across(mesh_, t, k);
                const Vec3 edge = side_vector(mesh_, t, k);
                const double w = side_weight(mesh_, t, k);
                entries_.emplace_back(i, i, w);
                const Complex carried = fourfold(angle_in(frame_[at(t)], edge)) *
                                        std::conj(fourfold(angle_in(frame_[at(u)], edge)));
                if (number_[at(u)] >= 0)
                    entries_.emplace_back(i, number_[at(u)], -w * carried);
                else
                    known_[i] += w * carried * cross_[at(u)];
            }
        }
    }

    void diffuse() {
        assemble();
        Eigen::VectorXcd u(unknowns_);
        for (std::size_t t = 0; t < number_.size(); ++t)
            if (number_[t] >= 0) u[number_[t]] = cross_[t];
        // The first step reaches everywhere.
        for (const bool first : {true, false}) {
            Eigen::VectorXd mass(unknowns_);
            for (std::size_t t = 0; t < number_.size(); ++t)
                if (number_[t] >= 0)
                    mass[number_[t]] =
                        first ? anchor_weight : area(int(t)) / (diffusion_area * region_area_[t]);
            Eigen::SparseMatrix<Complex> matrix(unknowns_, unknowns_);
            auto entries = entries_;
            for (int i = 0; i < unknowns_; ++i) entries.emplace_back(i, i, mass[i]);
            matrix.setFromTriplets(entries.begin(), entries.end());
            const Eigen::SimplicialLDLT<Eigen::SparseMatrix<Complex>> solver(matrix);
            for (int step = 0; step < (first ? 2 : diffusion_steps); ++step) {
                poll_();
                const Eigen::VectorXcd right = known_ + mass.cwiseProduct(u);
                u = solver.solve(right);
                for (int i = 0; i < unknowns_; ++i) {
                    const double size = std::abs(u[i]);
                    u[i] = size > 1e-12 ? u[i] / size : Complex(1.0);
                }
            }
        }
        for (std::size_t t = 0; t < number_.size(); ++t)
            if (number_[t] >= 0) cross_[t] = u[number_[t]];
    }

    const geom::EditableMesh& mesh_;
    const std::vector<FieldHint>& hints_;
    Poll& poll_;
    int unknowns_ = 0;
    std::vector<int> number_;  ///< among the unknowns; -1: known or gone
    std::vector<Complex> cross_;
    std::vector<Frame> frame_;
    std::vector<double> region_area_;
    std::vector<Eigen::Triplet<Complex>> entries_;
    Eigen::VectorXcd known_;
};

/// At a border that turns away from the surface and at the ends of features, wedges that are wider
/// than narrow_wedge are split: the field turns there by more than a few triangles tell from
/// nothing.
void split_wedges(geom::EditableMesh& mesh, int v) {
    // Radians: 28 degrees, and 35 beyond a straight border.
    constexpr double narrow_wedge = 0.5, turned_away = M_PI + 0.6;
    const auto stops = [&](int a, int b) { return mesh.is_feature(a, b); };
    const std::vector<int> borders = border_neighbours(mesh, v);
    for (const int first : borders) {
        const VertexFan fan = fan_from(mesh, v, first, stops);
        if (fan.angle < turned_away && borders.size() > 1) continue;
        for (const Wedge& w : fan.wedges) {
            const int k = (w.corner + 1) % 3;
            if (w.angle < narrow_wedge || is_border(mesh, w.triangle, k)) continue;
            const auto& c = mesh.triangle(w.triangle);
            const int a = c[at(k)], b = c[at((k + 1) % 3)];
            mesh.split(a, b, 0.5 * (mesh.point(a) + mesh.point(b)));
        }
    }
}

}  // namespace

std::vector<FieldHint> curvature_hints(const geom::EditableMesh& mesh,
                                       const geom::ModelSurface& reference, Poll& poll) {
    const double diagonal = reference.size();
    std::vector<FieldHint> hints(at(mesh.triangle_count()));
    for (int t = 0; t < mesh.triangle_count(); ++t) {
        if (!mesh.alive(t)) continue;
        poll();
        const auto& c = mesh.triangle(t);
        const Vec3 middle = (mesh.point(c[0]) + mesh.point(c[1]) + mesh.point(c[2])) / 3.0;
        const Vec3 normal = mesh.area_vector(t).normalized();
        if (!normal.allFinite()) continue;
        const auto bend = reference.curvature(reference.foot_point(middle, normal));
        if (!bend) continue;
        const double sum = std::abs(bend->value[0]) + std::abs(bend->value[1]);
        const double difference = bend->value[0] - bend->value[1];
        const double clear = difference / (sum + least_bend / diagonal);
        hints[at(t)] = {bend->direction[0],
                        clear * clear * difference * difference * 0.5 * mesh.area_vector(t).norm()};
    }
    return hints;
}

void open_corners(geom::EditableMesh& mesh) {
    const auto on_border = [&](int v) {
        return !mesh.feature_neighbours(v).empty() || mesh.is_boundary(v);
    };
    std::vector<char> border(at(mesh.vertex_count()), 0);
    for (int v = 0; v < mesh.vertex_count(); ++v)
        border[at(v)] = mesh.vertex_alive(v) && on_border(v) ? 1 : 0;
    for (int t = 0; t < mesh.triangle_count(); ++t) {
        for (int k = 0; k < 3 && mesh.alive(t); ++k) {
            const int a = mesh.triangle(t)[at(k)], b = mesh.triangle(t)[at((k + 1) % 3)];
            // Vertices that were added here are inside.
            if (a >= int(border.size()) || b >= int(border.size())) continue;
            if (border[at(a)] == 0 || border[at(b)] == 0 || is_border(mesh, t, k)) continue;
            mesh.split(a, b, 0.5 * (mesh.point(a) + mesh.point(b)));
        }
    }
    for (std::size_t v = 0; v < border.size(); ++v)
        if (border[v] != 0) split_wedges(mesh, int(v));
}

CrossField cross_field(const geom::EditableMesh& mesh, const std::vector<FieldHint>& hints,
                       Poll& poll) {
    return FieldSolver(mesh, hints, poll).solve();
}

double side_weight(const geom::EditableMesh& mesh, int t, int k) {
    // Slivers would have more and spoil the solution.
    constexpr double most_weight = 100.0;
    const double areas =
        0.5 * (mesh.area_vector(t).norm() + mesh.area_vector(across(mesh, t, k)).norm());
    return std::min(most_weight,
                    3.0 * side_vector(mesh, t, k).squaredNorm() / std::max(areas, 1e-300));
}

double field_turn(const geom::EditableMesh& mesh, const CrossField& field, int from, int to) {
    for (int k = 0; k < 3; ++k) {
        if (across(mesh, from, k) != to) continue;
        const Vec3 edge = side_vector(mesh, from, k);
        const Frame f = frame_of(mesh, from), g = frame_of(mesh, to);
        const double before = angle_in(f, field.direction[at(from)]) - angle_in(f, edge);
        const double after = angle_in(g, field.direction[at(to)]) - angle_in(g, edge);
        return std::remainder(after - before, 0.5 * M_PI);
    }
    return 0.0;
}

}  // namespace patchwright::cage
