#include "geom/mesh_sides.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
#include <unordered_map>

namespace patchwright::geom {

namespace {

std::string place(const Points& points, int v) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", points(v, 0), points(v, 1), points(v, 2));
}

void require_finite(const TriangleMesh& mesh, const std::string& source) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const int v : mesh.triangles[t])
            if (!((mesh.points.row(v).array().abs() <= largest_coordinate).all()))
                throw base::InputError(
                    fmt::format("{}: triangle {} has a point that is not finite, or beyond {:g}; "
                                "write the file again from its source",
                                source, t + 1, largest_coordinate));
}

/// Numbers of points that are to be one: each the least number of its like.
class Welding {
  public:
    explicit Welding(const Points& points) : points_(points) {
        // Single precision, as files have it, tells numbers of this size apart by an eighth of it.
        reach_ = std::max(
            points.cwiseAbs().maxCoeff() * double(std::numeric_limits<float>::epsilon()) * 4.0,
            1e-12);
        corner_ = points.colwise().minCoeff().transpose();
    }

    std::vector<int> run() {
        std::vector<int> same(std::size_t(points_.rows()));
        for (Eigen::Index i = 0; i < points_.rows(); ++i) same[std::size_t(i)] = place_of(int(i));
        return same;
    }

  private:
    using Cell = std::array<std::int64_t, 3>;
    struct Hash {
        std::size_t operator()(const Cell& c) const {
            return std::size_t(c[0] * 73856093 ^ c[1] * 19349663 ^ c[2] * 83492791);
        }
    };

    int place_of(int i) {
        // Cells of twice the reach: whatever is within it lies in one of eight.
        const Vec3 at = (points_.row(i).transpose() - corner_) / (2.0 * reach_);
        const Vec3 low = at.array().floor();
        for (int n = 0; n < 8; ++n) {
            Cell cell{};
            for (Eigen::Index k = 0; k < 3; ++k) {
                const double side = at[k] - low[k] < 0.5 ? -1.0 : 1.0;
                cell[std::size_t(k)] = std::int64_t(low[k] + ((n >> k) & 1 ? side : 0.0));
            }
            const auto found = cells_.find(cell);
            if (found == cells_.end()) continue;
            for (const int other : found->second)
                if ((points_.row(other) - points_.row(i)).norm() <= reach_) return other;
        }
        cells_[{std::int64_t(low[0]), std::int64_t(low[1]), std::int64_t(low[2])}].push_back(i);
        return i;
    }

    const Points& points_;
    double reach_ = 0.0;
    Vec3 corner_;
    std::unordered_map<Cell, std::vector<int>, Hash> cells_;
};

void weld(TriangleMesh& mesh, MeshRepair& repair) {
    const std::vector<int> same = Welding(mesh.points).run();
    std::vector<int> number(same.size(), -1);
    std::vector<int> kept;
    std::vector<char> used(same.size(), 0);
    for (auto& t : mesh.triangles) {
        for (int& v : t) {
            used[std::size_t(v)] = 1;
            v = same[std::size_t(v)];
            int& n = number[std::size_t(v)];
            if (n < 0) {
                n = int(kept.size());
                kept.push_back(v);
            }
            v = n;
        }
    }
    repair.welded = int(std::count(used.begin(), used.end(), 1)) - int(kept.size());
    Points points(Eigen::Index(kept.size()), 3);
    for (std::size_t i = 0; i < kept.size(); ++i)
        points.row(Eigen::Index(i)) = mesh.points.row(kept[i]);
    mesh.points = std::move(points);
}

void drop_useless(TriangleMesh& mesh, MeshRepair& repair) {
    const std::size_t count = mesh.triangles.size();
    std::vector<std::pair<std::array<int, 3>, std::size_t>> sorted;
    std::vector<char> gone(count, 0);
    for (std::size_t i = 0; i < count; ++i) {
        std::array<int, 3> t = mesh.triangles[i];
        std::sort(t.begin(), t.end());
        if (t[0] == t[1] || t[1] == t[2]) {
            gone[i] = 1;
            ++repair.degenerate;
        } else {
            sorted.emplace_back(t, i);
        }
    }
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 1; i < sorted.size(); ++i) {
        if (sorted[i].first != sorted[i - 1].first) continue;
        gone[sorted[i].second] = 1;
        ++repair.duplicates;
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (gone[i] != 0) continue;
        mesh.triangles[kept] = mesh.triangles[i];
        mesh.part[kept++] = mesh.part[i];
    }
    mesh.triangles.resize(kept);
    mesh.part.resize(kept);
}

/// The triangle beyond each side; -1: none.
std::vector<std::array<int, 3>> neighbours_of(const TriangleMesh& mesh, const std::string& source,
                                              MeshRepair& repair) {
    const std::vector<MeshSide> sides = sorted_sides(mesh);
    std::vector<std::array<int, 3>> beyond(mesh.triangles.size(), {-1, -1, -1});
    for (std::size_t i = 0; i < sides.size();) {
        std::size_t end = i + 1;
        while (end < sides.size() && sides[end].low == sides[i].low &&
               sides[end].high == sides[i].high)
            ++end;
        if (end - i > 2)
            throw base::InputError(fmt::format(
                "{}: {} triangles meet at the side from {} to {}; a surface has two there: repair "
                "the mesh",
                source, end - i, place(mesh.points, sides[i].low),
                place(mesh.points, sides[i].high)));
        if (end - i == 2) {
            beyond[std::size_t(sides[i].triangle)][std::size_t(sides[i].side)] =
                sides[i + 1].triangle;
            beyond[std::size_t(sides[i + 1].triangle)][std::size_t(sides[i + 1].side)] =
                sides[i].triangle;
        } else {
            ++repair.free_sides;
        }
        i = end;
    }
    return beyond;
}

struct Component {
    std::vector<int> triangles;
    bool closed = true;
};

/// Makes the triangles of a body face like the first of them.
class Orienting {
  public:
    Orienting(TriangleMesh& mesh, const std::vector<std::array<int, 3>>& beyond,
              const std::string& source)
        : mesh_(mesh), beyond_(beyond), source_(source), state_(mesh.triangles.size(), 0) {}

    std::vector<Component> run() {
        std::vector<Component> bodies;
        for (std::size_t first = 0; first < state_.size(); ++first)
            if (state_[first] == 0) bodies.push_back(body_of(int(first)));
        // Most triangles of a body are right: of the two ways the one that turns fewer.
        for (const Component& body : bodies) {
            std::size_t turned = 0;
            for (const int t : body.triangles) turned += state_[std::size_t(t)] < 0 ? 1 : 0;
            if (2 * turned > body.triangles.size())
                for (const int t : body.triangles) state_[std::size_t(t)] *= -1;
        }
        for (std::size_t t = 0; t < state_.size(); ++t)
            if (state_[t] < 0) std::swap(mesh_.triangles[t][1], mesh_.triangles[t][2]);
        return bodies;
    }

    void turn(const Component& body) {
        for (const int t : body.triangles) {
            state_[std::size_t(t)] *= -1;
            std::swap(mesh_.triangles[std::size_t(t)][1], mesh_.triangles[std::size_t(t)][2]);
        }
    }

    [[nodiscard]] int turned() const {
        return int(std::count(state_.begin(), state_.end(), static_cast<signed char>(-1)));
    }

  private:
    Component body_of(int first) {
        Component body;
        state_[std::size_t(first)] = 1;
        body.triangles.push_back(first);
        for (std::size_t i = 0; i < body.triangles.size(); ++i) {
            const int t = body.triangles[i];
            for (std::size_t k = 0; k < 3; ++k) {
                const int other = beyond_[std::size_t(t)][k];
                if (other < 0) {
                    body.closed = false;
                    continue;
                }
                const int a = mesh_.triangles[std::size_t(t)][k];
                const int b = mesh_.triangles[std::size_t(t)][(k + 1) % 3];
                const auto wanted = static_cast<signed char>(
                    runs(other, a, b) ? -state_[std::size_t(t)] : state_[std::size_t(t)]);
                signed char& state = state_[std::size_t(other)];
                if (state == 0) {
                    state = wanted;
                    body.triangles.push_back(other);
                } else if (state != wanted) {
                    throw base::InputError(fmt::format(
                        "{}: at the side from {} to {} the surface's two sides run into each "
                        "other, as on a Moebius strip: repair the mesh",
                        source_, place(mesh_.points, a), place(mesh_.points, b)));
                }
            }
        }
        return body;
    }

    [[nodiscard]] bool runs(int triangle, int a, int b) const {
        const auto& t = mesh_.triangles[std::size_t(triangle)];
        for (std::size_t k = 0; k < 3; ++k)
            if (t[k] == a && t[(k + 1) % 3] == b) return true;
        return false;
    }

    TriangleMesh& mesh_;
    const std::vector<std::array<int, 3>>& beyond_;
    const std::string& source_;
    std::vector<signed char> state_;  ///< -1: to be turned, 0: not seen yet
};

/// How often a body goes around a point (van Oosterom and Strackee, The solid angle of a plane
/// triangle, 1983).
double winding(const TriangleMesh& mesh, const Component& body, const Vec3& p) {
    double sum = 0.0;
    for (const int t : body.triangles) {
        std::array<Vec3, 3> r;
        std::array<double, 3> n{};
        for (std::size_t k = 0; k < 3; ++k) {
            r[k] = mesh.points.row(mesh.triangles[std::size_t(t)][k]).transpose() - p;
            n[k] = r[k].norm();
        }
        const double volume = r[0].dot(r[1].cross(r[2]));
        const double base = n[0] * n[1] * n[2] + r[0].dot(r[1]) * n[2] + r[1].dot(r[2]) * n[0] +
                            r[2].dot(r[0]) * n[1];
        sum += 2.0 * std::atan2(volume, base);
    }
    return sum / (4.0 * M_PI);
}

double signed_volume(const TriangleMesh& mesh, const Component& body) {
    const Vec3 origin = mesh.points.row(0).transpose();
    double sum = 0.0;
    for (const int t : body.triangles) {
        const auto at = [&](std::size_t k) {
            return Vec3(mesh.points.row(mesh.triangles[std::size_t(t)][k]).transpose() - origin);
        };
        sum += at(0).dot(at(1).cross(at(2))) / 6.0;
    }
    return sum;
}

Box3 box_of(const TriangleMesh& mesh, const Component& body) {
    Box3 box;
    for (const int t : body.triangles)
        for (const int v : mesh.triangles[std::size_t(t)]) box.add(mesh.points.row(v).transpose());
    return box;
}

/// @return how many are hollows
int face_outward(const TriangleMesh& mesh, const std::vector<Component>& bodies,
                 Orienting& orienting) {
    int hollows = 0;
    std::vector<Box3> boxes;
    for (const Component& body : bodies) boxes.push_back(box_of(mesh, body));
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        if (!bodies[i].closed) continue;
        const Vec3 p = mesh.points.row(mesh.triangles[std::size_t(bodies[i].triangles[0])][0]);
        int around = 0;
        for (std::size_t j = 0; j < bodies.size(); ++j) {
            if (i == j || !bodies[j].closed || boxes[j].squared_distance(p) > 0.0) continue;
            around += std::abs(winding(mesh, bodies[j], p)) > 0.5 ? 1 : 0;
        }
        const bool outward = signed_volume(mesh, bodies[i]) > 0.0;
        if (outward != (around % 2 == 0)) orienting.turn(bodies[i]);
        hollows += around % 2;
    }
    return hollows;
}

/// Gives every fan of triangles at a point a point of its own: bodies that merely touch there part.
void part_fans(TriangleMesh& mesh, const std::vector<std::array<int, 3>>& beyond) {
    std::vector<char> taken(std::size_t(mesh.points.rows()), 0);
    std::vector<std::array<char, 3>> done(mesh.triangles.size(), {0, 0, 0});
    std::vector<int> origin, pending;
    for (std::size_t first = 0; first < mesh.triangles.size(); ++first) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (done[first][k] != 0) continue;
            const int v = mesh.triangles[first][k];
            int number = v;
            if (taken[std::size_t(v)] != 0) {
                number = int(mesh.points.rows()) + int(origin.size());
                origin.push_back(v);
            }
            taken[std::size_t(v)] = 1;
            pending.assign(1, int(first));
            while (!pending.empty()) {
                const auto t = std::size_t(pending.back());
                pending.pop_back();
                std::size_t c = 0;
                while (c < 3 && (mesh.triangles[t][c] != v || done[t][c] != 0)) ++c;
                if (c == 3) continue;
                done[t][c] = 1;
                mesh.triangles[t][c] = number;
                for (const std::size_t side : {c, (c + 2) % 3})
                    if (beyond[t][side] >= 0) pending.push_back(beyond[t][side]);
            }
        }
    }
    const Eigen::Index before = mesh.points.rows();
    mesh.points.conservativeResize(before + Eigen::Index(origin.size()), 3);
    for (std::size_t i = 0; i < origin.size(); ++i)
        mesh.points.row(before + Eigen::Index(i)) = mesh.points.row(origin[i]).eval();
}

}  // namespace

std::vector<MeshSide> sorted_sides(const TriangleMesh& mesh) {
    std::vector<MeshSide> sides;
    sides.reserve(3 * mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const auto [low, high] = std::minmax(mesh.triangles[t][std::size_t(k)],
                                                 mesh.triangles[t][std::size_t((k + 1) % 3)]);
            sides.push_back({low, high, int(t), k});
        }
    }
    std::sort(sides.begin(), sides.end(), [](const MeshSide& a, const MeshSide& b) {
        return std::tie(a.low, a.high, a.triangle, a.side) <
               std::tie(b.low, b.high, b.triangle, b.side);
    });
    return sides;
}

Vec3 area_vector(const TriangleMesh& mesh, int triangle) {
    const Vec3 a = corner_point(mesh, triangle, 0);
    return (corner_point(mesh, triangle, 1) - a).cross(corner_point(mesh, triangle, 2) - a);
}

MeshRepair make_sound(TriangleMesh& mesh, const std::string& source) {
    MeshRepair repair;
    mesh.part.resize(mesh.triangles.size(), -1);
    require_finite(mesh, source);
    if (mesh.triangles.empty()) throw base::InputError(source + ": holds no triangles");
    weld(mesh, repair);
    drop_useless(mesh, repair);
    if (mesh.triangles.empty())
        throw base::InputError(
            fmt::format("{}: none of its {} triangles has three different points", source,
                        repair.degenerate + repair.duplicates));
    const auto beyond = neighbours_of(mesh, source, repair);
    part_fans(mesh, beyond);
    Orienting orienting(mesh, beyond, source);
    const std::vector<Component> bodies = orienting.run();
    repair.hollows = face_outward(mesh, bodies, orienting);
    repair.turned = orienting.turned();
    repair.bodies = int(bodies.size());
    repair.closed_bodies = int(std::count_if(bodies.begin(), bodies.end(),
                                             [](const Component& body) { return body.closed; }));
    return repair;
}

}  // namespace patchwright::geom
