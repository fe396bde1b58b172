#include "grid/sliding_points.h"

#include "grid/cell_point.h"

#include <patchwright/base/parallel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace patchwright::grid {

using geom::Vec3;
using mesh::CornerId;

namespace {

constexpr std::size_t points_a_walk = 1024;
/// A feature is a curve through its vertices where it turns by less than this, radians.
constexpr double smooth_turn = 0.5;

}  // namespace

SlidingPoints::SlidingPoints(const Plan& plan, const FrontMesh& mesh)
    : topology_(*plan.layout.cage.topology), places_(mesh.size()) {
    for (std::size_t first = 0; first < mesh.size(); first += points_a_walk)
        walks_.push_back(std::make_unique<SurfaceWalk>(table_, plan.layout.cage));
    place_in_blocks(plan, mesh);
    place_on_features(plan, mesh);
}

template <class Visit>
void SlidingPoints::for_walks(const Visit& visit) {
    base::parallel_for(walks_.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t w = first; w < last; ++w)
            for (std::size_t p = w * points_a_walk;
                 p < std::min(places_.size(), (w + 1) * points_a_walk); ++p)
                visit(*walks_[w], p);
    });
}

subd::Location SlidingPoints::location_of(const Place& place) const {
    if (const auto* line = std::get_if<LinePlace>(&place))
        return grid::location_of(topology_, *line);
    if (const auto* fixed = std::get_if<Fixed>(&place)) return fixed->at;
    return std::get<subd::Location>(place);
}

std::vector<int> SlidingPoints::freedom() const {
    std::vector<int> result;
    result.reserve(places_.size());
    for (const Place& place : places_) result.push_back(static_cast<int>(place.index()));
    return result;
}

void SlidingPoints::measure_bases(const geom::Points& normals,
                                  std::vector<SmoothCells::Basis>& bases) {
    bases.assign(places_.size(), SmoothCells::Basis::Zero());
    for_walks([&](SurfaceWalk& walk, std::size_t p) {
        if (const auto* line = std::get_if<LinePlace>(&places_[p])) {
            bases[p].col(0) = walk.direction(*line).normalized();
        } else if (std::holds_alternative<subd::Location>(places_[p])) {
            const Vec3 n = normals.row(Eigen::Index(p)).transpose();
            if (n.isZero(0.0)) return;  // stays
            bases[p].col(0) = n.unitOrthogonal();
            bases[p].col(1) = n.cross(bases[p].col(0));
        }
    });
}

void SlidingPoints::move(const geom::Points& by, Moved& result) {
    result.places.resize(places_.size());
    result.points.resize(by.rows(), 3);
    for_walks([&](SurfaceWalk& walk, std::size_t p) {
        const auto row = Eigen::Index(p);
        const Vec3 step = by.row(row).transpose();
        Place& to = result.places[p];
        to = places_[p];
        if (auto* line = std::get_if<LinePlace>(&to)) *line = walk.moved(*line, step);
        if (auto* free = std::get_if<subd::Location>(&to)) *free = walk.moved(*free, step);
        result.points.row(row) = walk.at(location_of(to)).point.transpose();
    });
}

void SlidingPoints::place_in_blocks(const Plan& plan, const FrontMesh& mesh) {
    const BlockEvaluator evaluator(plan);
    for (std::size_t b = 0; b < plan.layout.blocks.size(); ++b) {
        const std::vector<Eigen::Vector2d> parameters = evaluator.parameters(int(b));
        for (std::size_t n = 0; n < parameters.size(); ++n) {
            const CellPoint p = cell_point(plan.layout.blocks[b], parameters[n]);
            places_[std::size_t(mesh.numbers(int(b))[n])] =
                place_in_face(topology_, p.cell, p.i, p.j);
        }
    }
}

void SlidingPoints::place_on_features(const Plan& plan, const FrontMesh& mesh) {
    for (std::size_t e = 0; e < plan.edges.size(); ++e) {
        const auto& run = plan.layout.edges[e].run;
        const std::vector<double>& parameters = plan.edges[e].parameters;
        for (std::size_t n = 0; n < parameters.size(); ++n) {
            const auto k = std::min(std::size_t(parameters[n]), run.size() - 1);
            const double t = parameters[n] - double(k);
            Place& place = places_[std::size_t(mesh.on_edge(int(e))[n])];
            if (t == 0.0 || t == 1.0) {
                if (const auto known = place_at_vertex(run[k], t)) place = *known;
            } else if (is_feature(topology_, run[k])) {
                place = LinePlace{run[k], t};
            }
        }
    }
}

/// Of a point at an end of a half-edge: none where it moves freely. It slides along a curve with
/// two cells on each side; where block corners lie on features, somebody put them there.
std::optional<SlidingPoints::Place> SlidingPoints::place_at_vertex(CornerId edge, double t) {
    const mesh::VertexId v = topology_.vertex(t == 0.0 ? edge : topology_.next(edge));
    std::vector<LinePlace> features;
    std::vector<int> faces_before;  // counter-clockwise from the first one
    int faces = 0;
    CornerId c = topology_.corner(v);
    const CornerId first = c;
    do {
        const auto add = [&](const LinePlace& feature) {
            features.push_back(feature);
            faces_before.push_back(faces);
        };
        if (is_feature(topology_, c)) add({c, 0.0});
        ++faces;
        if (const CornerId in = topology_.previous(c); !topology_.twin(in).valid()) add({in, 1.0});
        c = topology_.rotate(c);
    } while (c.valid() && c != first);
    const bool is_corner = topology_.sharpness(v) > 0.0;
    if (features.empty() && !is_corner) return std::nullopt;
    const bool is_even = features.size() == 2 && faces_before[1] - faces_before[0] == 2 &&
                         faces == (topology_.is_boundary(v) ? 2 : 4);
    if (!is_corner && is_even) {
        std::array<Vec3, 2> away;
        for (std::size_t k = 0; k < 2; ++k)
            away[k] = (features[k].t == 0.0 ? 1.0 : -1.0) *
                      walks_.front()->direction(features[k]).normalized();
        if (away[0].dot(away[1]) < -std::cos(smooth_turn)) return features[0];
    }
    return Fixed{grid::location_of(topology_, {edge, t})};
}

}  // namespace patchwright::grid
