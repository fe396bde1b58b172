#include <patchwright/base/error.h>
#include <patchwright/fit/model_change.h>

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace patchwright::fit {

namespace {

using geom::ModelSurface;
using geom::Vec3;

/// Of the earlier diagonal: nodes of two faces this close are one point of their common side.
constexpr double same_point_rel = 1e-5;
/// Of the smaller one's size: nodes of two faces that have come farther apart do not fit.
constexpr double fitting_rel = 1e-3;

/// Of a face in one state of the model.
struct FaceNodes {
    Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Array2d high = -low;
    std::vector<Eigen::Vector2d> border;  ///< parameters of the nodes of sides with one triangle
};

/// One a face.
std::vector<FaceNodes> nodes_of(const ModelSurface& model, std::size_t count) {
    using Node = std::pair<double, double>;
    std::vector<FaceNodes> faces(count);
    std::vector<std::map<std::pair<Node, Node>, int>> sides(count);
    for (const geom::SurfacePiece& piece : model.pieces()) {
        FaceNodes& face = faces.at(std::size_t(piece.face));
        for (std::size_t k = 0; k < 3; ++k) {
            const Eigen::Vector2d &a = piece.uv[k], &b = piece.uv[(k + 1) % 3];
            face.low = face.low.min(a.array());
            face.high = face.high.max(a.array());
            ++sides[std::size_t(piece.face)][std::minmax(Node{a.x(), a.y()}, Node{b.x(), b.y()})];
        }
    }
    for (std::size_t f = 0; f < count; ++f) {
        std::set<Node> border;
        for (const auto& [side, triangles] : sides[f])
            if (triangles == 1) border.insert({side.first, side.second});
        for (const auto& [u, v] : border) faces[f].border.emplace_back(u, v);
    }
    return faces;
}

/// The later face of each earlier one: by names where each names one face in both models.
std::vector<int> later_faces(const std::vector<std::string>& earlier,
                             const std::vector<std::string>& later) {
    std::map<std::string, int> numbers;
    for (std::size_t i = 0; i < later.size(); ++i) numbers.emplace(later[i], int(i));
    std::vector<int> by_name, by_number;
    for (std::size_t i = 0; i < earlier.size(); ++i) {
        by_number.push_back(int(i));
        if (const auto found = numbers.find(earlier[i]); found != numbers.end())
            by_name.push_back(found->second);
    }
    const std::set<int> different(by_name.begin(), by_name.end());
    return different.size() == later.size() ? by_name : by_number;
}

/// A node on a side that two faces have in common.
struct SharedNode {
    std::array<std::size_t, 2> face;
    Vec3 earlier;
    std::array<Vec3, 2> later;  ///< by the parameters of either face
};

struct BorderNode {
    std::size_t face;
    Vec3 earlier, later;
};

/// Pairs of nodes of different faces in the same place.
std::vector<SharedNode> shared_nodes(std::vector<BorderNode> nodes, double reach) {
    std::stable_sort(nodes.begin(), nodes.end(), [](const BorderNode& a, const BorderNode& b) {
        return a.earlier.x() < b.earlier.x();
    });
    std::vector<SharedNode> shared;
    for (auto a = nodes.begin(); a != nodes.end(); ++a)
        for (auto b = a + 1; b != nodes.end() && b->earlier.x() - a->earlier.x() <= reach; ++b)
            if (a->face != b->face && (a->earlier - b->earlier).norm() <= reach)
                shared.push_back({{a->face, b->face}, a->earlier, {a->later, b->later}});
    return shared;
}

/// Largest extent of the nodes of each face.
std::vector<double> sizes_of(const std::vector<BorderNode>& nodes, std::size_t count) {
    std::vector<geom::Box3> boxes(count);
    for (const BorderNode& node : nodes) boxes[node.face].add(node.later);
    std::vector<double> sizes;
    for (const geom::Box3& box : boxes) sizes.push_back(box.diagonal());
    return sizes;
}

/// Of each face, whether its border fits: the one that fits its neighbours at the least share of
/// its nodes is left out, and the others are judged without it, until all fit everywhere.
std::vector<bool> fitting_faces(const std::vector<SharedNode>& shared,
                                const std::vector<double>& sizes) {
    std::vector<bool> fits(sizes.size(), true);
    while (true) {
        std::vector<double> off(sizes.size(), 0.0), all(sizes.size(), 0.0);
        for (const auto& [face, earlier, later] : shared) {
            if (!fits[face[0]] || !fits[face[1]]) continue;
            const double most = fitting_rel * std::min(sizes[face[0]], sizes[face[1]]);
            const bool apart = (later[0] - later[1]).norm() > most;
            for (const std::size_t f : face) {
                off[f] += apart ? 1.0 : 0.0;
                all[f] += 1.0;
            }
        }
        for (std::size_t f = 0; f < sizes.size(); ++f) off[f] /= std::max(all[f], 1.0);
        const auto worst = std::max_element(off.begin(), off.end());
        if (worst == off.end() || *worst == 0.0) return fits;
        fits[std::size_t(worst - off.begin())] = false;
    }
}

/// Displacement of a node of a face's border.
struct BorderMove {
    Vec3 place;
    Vec3 wanted;  ///< as a neighbour that fits tells
    Vec3 own;     ///< by the face's own parameters
};

/// The affine displacements that are nearest to those of a border; where this is in a plane or on a
/// line, the least ones.
class AffineMove {
  public:
    /// @pre the border is not empty
    explicit AffineMove(const std::vector<BorderMove>& border) {
        const auto count = Eigen::Index(border.size());
        geom::Points places(count, 3), displacements(count, 3);
        for (Eigen::Index i = 0; i < count; ++i) {
            places.row(i) = border[std::size_t(i)].place.transpose();
            displacements.row(i) = border[std::size_t(i)].wanted.transpose();
        }
        centre_ = places.colwise().mean().transpose();
        mean_ = displacements.colwise().mean().transpose();
        places.rowwise() -= centre_.transpose();
        displacements.rowwise() -= mean_.transpose();
        Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver(places);
        solver.setThreshold(1e-6);
        linear_ = solver.solve(displacements).transpose();
    }

    [[nodiscard]] Vec3 operator()(const Vec3& point) const {
        return mean_ + linear_ * (point - centre_);
    }

  private:
    Vec3 centre_, mean_;
    Eigen::Matrix3d linear_;
};

/// How a face that does not fit moves: by its own parameters, or affinely where that is nearer to
/// its border's displacements, and by what that leaves of these, interpolated by inverse squared
/// distances (Shepard 1968).
class WithBorder {
  public:
    /// @pre the border is not empty
    explicit WithBorder(const std::vector<BorderMove>& border) {
        const AffineMove affine(border);
        double own_error = 0.0, affine_error = 0.0;
        for (const BorderMove& move : border) {
            own_error += (move.wanted - move.own).squaredNorm();
            affine_error += (move.wanted - affine(move.place)).squaredNorm();
        }
        if (affine_error < own_error) affine_ = affine;
        for (const BorderMove& move : border)
            rest_.emplace_back(move.place, move.wanted - (affine_ ? affine(move.place) : move.own));
    }

    /// @param own  by the face's own parameters
    [[nodiscard]] Vec3 displacement(const Vec3& point, const Vec3& own) const {
        constexpr double nearest = 1e-12;  // mm^2
        Vec3 sum = Vec3::Zero();
        double weights = 0.0;
        for (const auto& [place, rest] : rest_) {
            const double weight = 1.0 / std::max((point - place).squaredNorm(), nearest);
            sum += weight * rest;
            weights += weight;
        }
        return (affine_ ? (*affine_)(point) : own) + sum / weights;
    }

  private:
    std::optional<AffineMove> affine_;
    std::vector<std::pair<Vec3, Vec3>> rest_;
};

}  // namespace

struct ModelChange::FaceMap {
    int later = 0;  ///< number of the face
    Eigen::Array2d low, scale, later_low;
    std::optional<WithBorder> with_border;  ///< of faces that do not fit

    [[nodiscard]] Eigen::Vector2d uv(const Eigen::Vector2d& earlier) const {
        return (later_low + (earlier.array() - low) * scale).matrix();
    }
};

ModelChange::ModelChange(const ModelState& from_state, const ModelState& to_state)
    : earlier_(from_state.surface), later_(to_state.surface) {
    const auto refuse = [&](const std::string& why) {
        throw base::InputError(
            fmt::format("{}: {}: it does not tell how {} has come about; refit "
                        "without it",
                        from_state.name, why, to_state.name));
    };
    if (!earlier_.has_cad_faces() || !later_.has_cad_faces())
        refuse("triangles do not tell which faces belong together");
    const auto names = earlier_.face_names(), later_names = later_.face_names();
    if (names.size() != later_names.size())
        refuse(
            fmt::format("it has {} faces, and the new model {}", names.size(), later_names.size()));
    const std::vector<int> numbers = later_faces(names, later_names);
    const auto from = nodes_of(earlier_, names.size()), to = nodes_of(later_, names.size());
    std::vector<BorderNode> nodes;
    for (std::size_t f = 0; f < names.size(); ++f) {
        const FaceNodes &a = from[f], &b = to[std::size_t(numbers[f])];
        faces_.push_back({numbers[f], a.low, (b.high - b.low) / (a.high - a.low), b.low, {}});
        for (const Eigen::Vector2d& uv : a.border)
            nodes.push_back({f, earlier_.point_on_face(int(f), uv).point,
                             later_.point_on_face(numbers[f], faces_[f].uv(uv)).point});
    }
    const auto shared = shared_nodes(nodes, same_point_rel * earlier_.bounds().diagonal());
    const std::vector<bool> fits = fitting_faces(shared, sizes_of(nodes, names.size()));
    const auto fitting = std::size_t(std::count(fits.begin(), fits.end(), true));
    std::vector<std::vector<BorderMove>> borders(names.size());
    for (const auto& [face, place, gone] : shared)
        for (const std::size_t side : {0, 1})
            if (!fits[face[side]] && fits[face[1 - side]])
                borders[face[side]].push_back({place, gone[1 - side] - place, gone[side] - place});
    for (std::size_t f = 0; f < names.size(); ++f) {
        if (fits[f]) continue;
        if (2 * fitting < names.size() || borders[f].empty())
            refuse(fmt::format(
                "{} of its {} faces have another order or other parameters than the new model's",
                names.size() - fitting, names.size()));
        faces_[f].with_border.emplace(borders[f]);
    }
}

ModelChange::~ModelChange() = default;

Vec3 ModelChange::displacement_at(const Vec3& point) const {
    const geom::FootPoint foot = earlier_.foot_point(point);
    const FaceMap& face = faces_.at(std::size_t(foot.face));
    const Vec3 own = later_.point_on_face(face.later, face.uv(foot.uv)).point - foot.point;
    return face.with_border ? face.with_border->displacement(foot.point, own) : own;
}

}  // namespace patchwright::fit
