#include "measure/progress_loop.h"

#include <patchwright/measure/deviation.h>
#include <patchwright/measure/field.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace patchwright::measure {

namespace {

using geom::Vec3;

/// Halvings of a side by length, and after that by the distance's change.
constexpr int most_rounds = 12;
constexpr double shortest_side = 0.125;  ///< of the longest
/// Points on feature lines, fraction of the diagonal from each other.
constexpr double line_spacing_rel = 1.0 / 256;

class FieldMaker {
  public:
    FieldMaker(const geom::ModelSurface& model, const geom::ModelSurface* other,
               const FieldOptions& options)
        : model_(model),
          other_(other),
          options_(options),
          longest_(options.longest_side_rel * model.bounds().diagonal()) {}

    Field make() {
        for (const geom::SurfacePiece& piece : model_.pieces()) add_piece(piece);
        evaluate();
        for (int round = 0; round < most_rounds; ++round) {
            base::report_progress(options_.progress, "field", double(round) / most_rounds);
            if (!refine()) break;
            evaluate();
        }
        return result();
    }

  private:
    struct Triangle {
        int face;
        std::array<int, 3> vertex;
        std::array<Eigen::Vector2d, 3> uv;
    };

    struct Vertex {
        geom::FootPoint on_model;
        double curvature = 0.0;
        double distance = 0.0, angle = 0.0, other_curvature = 0.0;
    };

    int group_of(int face) const { return model_.has_cad_faces() ? face : 0; }

    /// Neighbouring triangles of a face share vertices: same place, same normal.
    int vertex_at(int face, const Eigen::Vector2d& uv) {
        const geom::FootPoint p = model_.point_on_face(face, uv);
        const auto key = std::tuple(group_of(face), p.point.x(), p.point.y(), p.point.z(),
                                    p.normal.x(), p.normal.y(), p.normal.z());
        const auto [found, is_new] = numbers_.try_emplace(key, int(vertices_.size()));
        if (is_new) vertices_.push_back({.on_model = p});
        return found->second;
    }

    void add_triangle(int face, const std::array<Eigen::Vector2d, 3>& uv) {
        const std::array<int, 3> v{vertex_at(face, uv[0]), vertex_at(face, uv[1]),
                                   vertex_at(face, uv[2])};
        if (v[0] != v[1] && v[1] != v[2] && v[2] != v[0]) triangles_.push_back({face, v, uv});
    }

    /// Counter-clockwise seen from outside, as its corners' normals tell.
    void add_piece(const geom::SurfacePiece& piece) {
        std::array<geom::FootPoint, 3> corner;
        for (std::size_t k = 0; k < 3; ++k)
            corner[k] = model_.point_on_face(piece.face, piece.uv[k]);
        const Vec3 area =
            (corner[1].point - corner[0].point).cross(corner[2].point - corner[0].point);
        const bool turned = area.dot(corner[0].normal + corner[1].normal + corner[2].normal) < 0.0;
        add_triangle(piece.face,
                     turned ? std::array{piece.uv[0], piece.uv[2], piece.uv[1]} : piece.uv);
    }

    static double mean_curvature(const geom::ModelSurface& surface, const geom::FootPoint& at) {
        if (at.face < 0) return 0.0;
        const auto curvature = surface.curvature(at);
        return curvature ? 0.5 * (curvature->value[0] + curvature->value[1]) : 0.0;
    }

    /// Fills in the vertices that are new.
    void evaluate() {
        loop_with_progress(evaluated_, vertices_.size(), 8192, 64, "field", options_.progress,
                           [&](std::size_t i) { evaluate(vertices_[i]); });
        for (std::size_t i = evaluated_; i < vertices_.size(); ++i)
            farthest_ = std::max(farthest_, vertices_[i].distance);
        evaluated_ = vertices_.size();
    }

    void evaluate(Vertex& vertex) const {
        vertex.curvature = mean_curvature(model_, vertex.on_model);
        if (other_ == nullptr) return;
        const geom::FootPoint foot = other_->foot_point(vertex.on_model.point);
        vertex.distance = foot.distance;
        vertex.angle = tangent_plane_angle(vertex.on_model.normal, foot.normal).value_or(0.0);
        vertex.other_curvature = mean_curvature(*other_, foot);
    }

    bool is_to_be_halved(int a, int b) const {
        const Vertex &p = vertices_[std::size_t(a)], &q = vertices_[std::size_t(b)];
        const double length = (p.on_model.point - q.on_model.point).norm();
        return length > longest_ ||
               (length > shortest_side * longest_ &&
                std::abs(p.distance - q.distance) > options_.largest_step_rel * farthest_);
    }

    /// Whether a side is halved depends on its ends only, so that neighbours agree.
    bool refine() {
        if (int(vertices_.size()) >= options_.most_vertices) return false;
        const std::vector<Triangle> before = std::exchange(triangles_, {});
        bool changed = false;
        for (const Triangle& t : before) {
            std::array<bool, 3> halved{};
            for (std::size_t k = 0; k < 3; ++k)
                halved[k] = is_to_be_halved(t.vertex[k], t.vertex[(k + 1) % 3]);
            const auto count = std::count(halved.begin(), halved.end(), true);
            changed = changed || count > 0;
            if (count == 0)
                triangles_.push_back(t);
            else
                split(t, halved, int(count));
        }
        return changed;
    }

    void split(const Triangle& t, const std::array<bool, 3>& halved, int count) {
        // Turned so that of one halved side it is the first, of two the last is whole.
        std::size_t first = 0;
        while (count == 1 && !halved[first]) ++first;
        while (count == 2 && halved[(first + 2) % 3]) ++first;
        const auto corner = [&](std::size_t k) { return t.uv[(first + k) % 3]; };
        const auto middle = [&](std::size_t k) {
            return Eigen::Vector2d(0.5 * (corner(k) + corner((k + 1) % 3)));
        };
        const auto add = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                             const Eigen::Vector2d& c) {
            add_triangle(t.face, {a, b, c});
        };
        const Eigen::Vector2d a = corner(0), b = corner(1), c = corner(2);
        if (count == 1) {
            add(a, middle(0), c);
            add(middle(0), b, c);
        } else if (count == 2) {
            add(middle(0), b, middle(1));
            add(a, middle(0), middle(1));
            add(a, middle(1), c);
        } else {
            add(a, middle(0), middle(2));
            add(middle(0), b, middle(1));
            add(middle(2), middle(1), c);
            add(middle(0), middle(1), middle(2));
        }
    }

    Field result() const {
        Field field;
        const auto count = Eigen::Index(vertices_.size());
        field.points.resize(count, 3);
        field.normals.resize(count, 3);
        for (Eigen::Index i = 0; i < count; ++i) {
            const Vertex& vertex = vertices_[std::size_t(i)];
            field.points.row(i) = vertex.on_model.point;
            field.normals.row(i) = vertex.on_model.normal;
            field.curvature.push_back(vertex.curvature);
            if (other_ == nullptr) continue;
            field.distance_mm.push_back(vertex.distance);
            field.normal_angle_rad.push_back(vertex.angle);
            field.other_curvature.push_back(vertex.other_curvature);
        }
        for (const Triangle& t : triangles_) {
            field.triangles.push_back(t.vertex);
            field.faces.push_back(group_of(t.face));
        }
        const double spacing = line_spacing_rel * model_.bounds().diagonal();
        for (const geom::FeatureKind kind : {geom::FeatureKind::Sharp, geom::FeatureKind::Free})
            add_lines(field, model_.sample_curves(kind, spacing));
        return field;
    }

    /// @param samples  curve by curve
    static void add_lines(Field& field, const std::vector<geom::CurveSample>& samples) {
        for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
            while (end < samples.size() && samples[end].curve == samples[begin].curve) ++end;
            geom::Points line(Eigen::Index(end - begin), 3);
            for (std::size_t i = begin; i < end; ++i)
                line.row(Eigen::Index(i - begin)) = samples[i].point;
            field.lines.push_back(std::move(line));
        }
    }

    const geom::ModelSurface& model_;
    const geom::ModelSurface* other_;
    const FieldOptions& options_;
    double longest_, farthest_ = 0.0;
    std::size_t evaluated_ = 0;
    std::vector<Vertex> vertices_;
    std::vector<Triangle> triangles_;
    std::map<std::tuple<int, double, double, double, double, double, double>, int> numbers_;
};

}  // namespace

Field measure_field(const geom::ModelSurface& model, const geom::ModelSurface* other,
                    const FieldOptions& options) {
    return FieldMaker(model, other, options).make();
}

}  // namespace patchwright::measure
