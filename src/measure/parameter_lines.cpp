#include "measure/parameter_lines.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

namespace patchwright::measure {

namespace {

using Eigen::Vector2d;
using geom::Vec3;

/// Of the rectangle of its parameters that an untrimmed face's pieces cover; the rest is what lies
/// between its boundary curves and their chords.
constexpr double untrimmed_share = 0.99;
constexpr int steps_for_length = 64, most_line_steps = 2000;

/// Shares of multiples of two irrational numbers fill a square evenly.
Vector2d even_place(std::size_t i) {
    constexpr double a = 0.7548776662466927, b = 0.5698402909980532;  // plastic number, -1 and -2
    const auto share = [&](double x) { return x - std::floor(x); };
    return {share(double(i + 1) * a), share(double(i + 1) * b)};
}

std::vector<double> areas_up_to(const geom::ModelSurface& model,
                                const std::vector<geom::SurfacePiece>& pieces) {
    std::vector<double> result;
    double sum = 0.0;
    for (const geom::SurfacePiece& piece : pieces) {
        const auto corner = [&](std::size_t k) -> Vec3 {
            return model.point_on_face(piece.face, piece.uv[k]).point;
        };
        const Vec3 first = corner(0);
        const double area = 0.5 * (corner(1) - first).cross(corner(2) - first).norm();
        sum += std::isfinite(area) ? area : 0.0;
        result.push_back(sum);
    }
    return result;
}

struct ParameterBox {
    Eigen::AlignedBox2d box;
    double covered = 0.0;  ///< area of the pieces in parameters

    [[nodiscard]] bool is_filled() const {
        return covered > untrimmed_share * box.sizes().prod() && covered > 0.0;
    }
};

std::map<int, ParameterBox> boxes_of(const std::vector<geom::SurfacePiece>& pieces) {
    std::map<int, ParameterBox> boxes;
    for (const geom::SurfacePiece& piece : pieces) {
        ParameterBox& of_face = boxes[piece.face];
        for (const Vector2d& uv : piece.uv) of_face.box.extend(uv);
        const Vector2d a = piece.uv[1] - piece.uv[0], b = piece.uv[2] - piece.uv[0];
        of_face.covered += 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
    }
    return boxes;
}

double length_of(const geom::ModelSurface& model, ParameterLine line) {
    line.steps = steps_for_length;
    const std::vector<geom::FootPoint> points = points_on(model, line);
    double length = 0.0;
    for (std::size_t i = 1; i < points.size(); ++i)
        length += (points[i].point - points[i - 1].point).norm();
    return length;
}

}  // namespace

std::vector<SurfacePlace> places_by_area(const geom::ModelSurface& model, int count) {
    const std::vector<geom::SurfacePiece> pieces = model.pieces();
    const std::vector<double> up_to = areas_up_to(model, pieces);
    std::vector<SurfacePlace> places;
    if (up_to.empty() || !(up_to.back() > 0.0)) return places;
    for (int i = 0; i < count; ++i) {
        const double area = up_to.back() * (i + 0.5) / count;
        const auto found = std::upper_bound(up_to.begin(), up_to.end(), area);
        const auto& piece = pieces[std::min(std::size_t(found - up_to.begin()), pieces.size() - 1)];
        Vector2d w = even_place(std::size_t(i));
        if (w.sum() > 1.0) w = Vector2d::Ones() - w;
        places.push_back({piece.face, piece.uv[0] + w[0] * (piece.uv[1] - piece.uv[0]) +
                                          w[1] * (piece.uv[2] - piece.uv[0])});
    }
    return places;
}

std::vector<ParameterLine> parameter_lines(const geom::ModelSurface& model, int count,
                                           double step_mm) {
    const std::map<int, ParameterBox> boxes = boxes_of(model.pieces());
    std::vector<ParameterLine> lines;
    for (const SurfacePlace& place : places_by_area(model, count)) {
        const ParameterBox& of_face = boxes.at(place.face);
        if (!of_face.is_filled()) continue;
        const int axis = int(lines.size() % 2);
        ParameterLine line{place.face, place.uv, place.uv, 1};
        line.start[axis] = of_face.box.min()[axis];
        line.end[axis] = of_face.box.max()[axis];
        line.steps =
            std::clamp(int(std::ceil(length_of(model, line) / step_mm)), 1, most_line_steps);
        lines.push_back(line);
    }
    return lines;
}

std::vector<geom::FootPoint> points_on(const geom::ModelSurface& model, const ParameterLine& line) {
    std::vector<geom::FootPoint> points;
    for (int i = 0; i <= line.steps; ++i)
        points.push_back(model.point_on_face(
            line.face, line.start + (double(i) / line.steps) * (line.end - line.start)));
    return points;
}

}  // namespace patchwright::measure
