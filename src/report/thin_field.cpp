#include "report/thin_field.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <vector>

namespace patchwright::report {

namespace {

/// Of one face, one cube of the grid, and one of the eight ways to face.
using Cell = std::tuple<int, int, int, int, int>;

/// @return for each vertex the one that stands for it
std::vector<int> representatives(const measure::Field& field, const std::vector<int>& faces,
                                 double size) {
    std::map<Cell, int> chosen;
    std::vector<Cell> cells;
    const geom::Vec3 origin = geom::bounding_box(field.points).min;
    for (int i = 0; i < int(field.points.rows()); ++i) {
        const geom::Vec3 place = (field.points.row(i).transpose() - origin) / size;
        int octant = 0;
        for (int k = 0; k < 3; ++k) octant = 2 * octant + (field.normals(i, k) > 0.0 ? 1 : 0);
        cells.emplace_back(faces[std::size_t(i)], octant, int(place.x()), int(place.y()),
                           int(place.z()));
        const auto [found, is_new] = chosen.try_emplace(cells.back(), i);
        if (!is_new && !field.distance_mm.empty() &&
            field.distance_mm[std::size_t(i)] > field.distance_mm[std::size_t(found->second)])
            found->second = i;
    }
    std::vector<int> result;
    for (const Cell& cell : cells) result.push_back(chosen.at(cell));
    return result;
}

std::vector<double> picked(const std::vector<double>& values, const std::vector<int>& kept) {
    std::vector<double> result;
    for (const int i : kept)
        if (!values.empty()) result.push_back(values[std::size_t(i)]);
    return result;
}

geom::Points rows_of(const geom::Points& points, const std::vector<int>& kept) {
    geom::Points result(Eigen::Index(kept.size()), 3);
    for (std::size_t i = 0; i < kept.size(); ++i) result.row(Eigen::Index(i)) = points.row(kept[i]);
    return result;
}

/// Every so manieth point, and the ends.
std::vector<geom::Points> thin_lines(const std::vector<geom::Points>& lines, int most_points) {
    Eigen::Index count = 0;
    for (const geom::Points& line : lines) count += line.rows();
    const Eigen::Index step = count / most_points + 1;
    std::vector<geom::Points> result;
    for (const geom::Points& line : lines) {
        std::vector<int> kept;
        for (Eigen::Index i = 0; i < line.rows(); i += step) kept.push_back(int(i));
        if (line.rows() > 0 && kept.back() + 1 != int(line.rows()))
            kept.push_back(int(line.rows()) - 1);
        result.push_back(rows_of(line, kept));
    }
    return result;
}

}  // namespace

measure::Field thin_field(const measure::Field& field, int most_vertices) {
    measure::Field result{.lines = thin_lines(field.lines, most_vertices)};
    std::vector<int> faces(std::size_t(field.points.rows()), 0);
    for (std::size_t i = 0; i < field.triangles.size(); ++i)
        for (const int vertex : field.triangles[i]) faces[std::size_t(vertex)] = field.faces[i];
    std::vector<int> stands(faces.size());
    for (std::size_t i = 0; i < stands.size(); ++i) stands[i] = int(i);
    // A surface has about the square of its diagonal; many small cubes to begin with.
    constexpr double small = 0.25;
    double size =
        small * geom::bounding_box(field.points).diagonal() / std::sqrt(double(most_vertices));
    std::set<int> kept(stands.begin(), stands.end());
    constexpr double growth = 1.25;
    for (int round = 0; int(kept.size()) > most_vertices && round < 64; ++round, size *= growth) {
        stands = representatives(field, faces, size);
        kept = {stands.begin(), stands.end()};
    }
    const std::vector<int> order(kept.begin(), kept.end());
    std::vector<int> number(faces.size(), -1);
    for (std::size_t i = 0; i < order.size(); ++i) number[std::size_t(order[i])] = int(i);
    for (std::size_t i = 0; i < field.triangles.size(); ++i) {
        std::array<int, 3> t{};
        for (std::size_t k = 0; k < 3; ++k)
            t[k] = number[std::size_t(stands[std::size_t(field.triangles[i][k])])];
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        result.triangles.push_back(t);
        result.faces.push_back(field.faces[i]);
    }
    result.points = rows_of(field.points, order);
    result.normals = rows_of(field.normals, order);
    result.curvature = picked(field.curvature, order);
    result.distance_mm = picked(field.distance_mm, order);
    result.normal_angle_rad = picked(field.normal_angle_rad, order);
    result.other_curvature = picked(field.other_curvature, order);
    return result;
}

}  // namespace patchwright::report
