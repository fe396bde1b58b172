#include <patchwright/base/error.h>
#include <patchwright/mesh/cage.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace patchwright::mesh {

namespace {

using base::InputError;

struct HalfEdge {
    int low, high;  // vertices, low < high
    int face;
    bool forward;  // the face runs from low to high
};

class Checker {
  public:
    Checker(TopologyInput& input, geom::Points& points, std::string_view source, Facing facing)
        : input_(input), points_(points), source_(source), facing_(facing) {}

    int run() {
        check_vertices_and_sizes();
        check_duplicates();
        collect_half_edges();
        const int flipped = orient();
        check_tags();
        return flipped;
    }

    /// @param topology  of the same input, but for the sectors
    void check_sectors(const Topology& topology, const std::vector<SectorTagInput>& sectors) const {
        for (const SectorTagInput& tag : sectors) {
            const VertexId v{tag.vertex};
            const CornerId c = find_corner(topology, FaceId{tag.face}, v);
            if (!c.valid()) {
                fail("sector: face {} has no vertex {}", tag.face, tag.vertex);
            }
            if (tag.angle > 0.0 && sector_corners(topology, c).empty()) {
                fail("sector at vertex {}, face {}: no infinitely sharp edges bound it", tag.vertex,
                     tag.face);
            }
        }
    }

    /// @pre the input is oriented; every inner vertex then has one closed fan, others one open fan
    void check_fans(const Topology& topology) const {
        std::vector<int> incidences(std::size_t(input_.vertex_count), 0);
        for (const int v : input_.face_vertices) ++incidences[std::size_t(v)];
        for (const VertexId v : topology.vertices()) {
            const int in_fan = topology.face_valence(v);
            if (in_fan != incidences[v.index()]) {
                fail("vertex {} joins parts that share no edge there; split the vertex", v.value);
            }
            if (!topology.is_boundary(v) && in_fan < 3) {
                fail("inner vertex {} has only {} faces; remove it or split its faces", v.value,
                     in_fan);
            }
        }
    }

  private:
    template <class... Args>
    [[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args) const {
        throw InputError(
            fmt::format("{}: {}", source_, fmt::format(format, std::forward<Args>(args)...)));
    }

    std::span<int> face(int f) {
        return {input_.face_vertices.data() + begin_[std::size_t(f)],
                input_.face_vertices.data() + begin_[std::size_t(f) + 1]};
    }
    [[nodiscard]] int face_count() const { return static_cast<int>(input_.face_sizes.size()); }

    void check_vertices_and_sizes() {
        if (input_.face_sizes.empty()) fail("holds no faces");
        for (Eigen::Index v = 0; v < points_.rows(); ++v) {
            if (!points_.row(v).allFinite())
                fail("vertex {} has a coordinate that is not finite", v);
        }
        begin_.assign(input_.face_sizes.size() + 1, 0);
        std::partial_sum(input_.face_sizes.begin(), input_.face_sizes.end(), begin_.begin() + 1);
        std::vector<int> last_face(std::size_t(input_.vertex_count), -1);
        for (int f = 0; f < face_count(); ++f) {
            if (input_.face_sizes[std::size_t(f)] < 3) {
                fail("face {} has {} vertices; at least 3 are needed", f,
                     input_.face_sizes[std::size_t(f)]);
            }
            for (const int v : face(f)) {
                if (v < 0 || v >= input_.vertex_count) {
                    fail("face {} names vertex {}, but there are {}", f, v, input_.vertex_count);
                }
                if (last_face[std::size_t(v)] == f) fail("face {} has vertex {} twice", f, v);
                last_face[std::size_t(v)] = f;
            }
        }
        const auto unused = std::find(last_face.begin(), last_face.end(), -1);
        if (unused != last_face.end()) {
            fail("vertex {} belongs to no face; remove it", unused - last_face.begin());
        }
    }

    void check_duplicates() {
        std::vector<std::pair<std::vector<int>, int>> sorted;
        sorted.reserve(input_.face_sizes.size());
        for (int f = 0; f < face_count(); ++f) {
            sorted.emplace_back(std::vector<int>(face(f).begin(), face(f).end()), f);
            std::sort(sorted.back().first.begin(), sorted.back().first.end());
        }
        std::sort(sorted.begin(), sorted.end());
        for (std::size_t i = 1; i < sorted.size(); ++i) {
            if (sorted[i - 1].first == sorted[i].first) {
                fail("faces {} and {} have the same vertices; remove one", sorted[i - 1].second,
                     sorted[i].second);
            }
        }
    }

    void collect_half_edges() {
        half_edges_.reserve(input_.face_vertices.size());
        for (int f = 0; f < face_count(); ++f) {
            const auto vertices = face(f);
            for (std::size_t i = 0; i < vertices.size(); ++i) {
                const int a = vertices[i];
                const int b = vertices[(i + 1) % vertices.size()];
                half_edges_.push_back({std::min(a, b), std::max(a, b), f, a < b});
            }
        }
        std::sort(half_edges_.begin(), half_edges_.end(), [](const HalfEdge& x, const HalfEdge& y) {
            return std::tie(x.low, x.high, x.face) < std::tie(y.low, y.high, y.face);
        });
        for (std::size_t i = 2; i < half_edges_.size(); ++i) {
            const HalfEdge& a = half_edges_[i - 2];
            const HalfEdge& c = half_edges_[i];
            if (a.low == c.low && a.high == c.high) {
                fail("edge {}-{} has more than two faces ({}, {}, {}); split it", a.low, a.high,
                     a.face, half_edges_[i - 1].face, c.face);
            }
        }
    }

    struct Neighbour {
        int face;
        bool agrees;  // runs the shared edge the other way round
        int low, high;
    };

    /// Makes all faces of a part agree, the minority being turned; closed parts face outward if
    /// they are to.
    int orient() {
        std::vector<std::vector<Neighbour>> neighbours(input_.face_sizes.size());
        std::vector<char> open(input_.face_sizes.size(), 0);
        for (std::size_t i = 0; i < half_edges_.size(); ++i) {
            const HalfEdge& a = half_edges_[i];
            const bool paired = i + 1 < half_edges_.size() && half_edges_[i + 1].low == a.low &&
                                half_edges_[i + 1].high == a.high;
            if (!paired) {
                open[std::size_t(a.face)] = 1;
                continue;
            }
            const HalfEdge& b = half_edges_[++i];
            const bool agrees = a.forward != b.forward;
            neighbours[std::size_t(a.face)].push_back({b.face, agrees, a.low, a.high});
            neighbours[std::size_t(b.face)].push_back({a.face, agrees, a.low, a.high});
        }
        std::vector<signed char> turned(input_.face_sizes.size(), -1);
        int flipped = 0;
        for (int seed = 0; seed < face_count(); ++seed) {
            if (turned[std::size_t(seed)] >= 0) continue;
            const std::vector<int> part = spread(seed, neighbours, turned);
            const auto turned_count = std::count_if(part.begin(), part.end(),
                                                    [&](int f) { return turned[std::size_t(f)]; });
            bool invert = 2 * turned_count > static_cast<std::ptrdiff_t>(part.size());
            const bool closed =
                std::none_of(part.begin(), part.end(), [&](int f) { return open[std::size_t(f)]; });
            if (closed && facing_ == Facing::Outward) invert = volume(part, turned) < 0.0;
            for (const int f : part) {
                if ((turned[std::size_t(f)] != 0) == invert) continue;
                std::reverse(face(f).begin() + 1, face(f).end());
                ++flipped;
            }
        }
        return flipped;
    }

    std::vector<int> spread(int seed, const std::vector<std::vector<Neighbour>>& neighbours,
                            std::vector<signed char>& turned) const {
        std::vector<int> part{seed};
        turned[std::size_t(seed)] = 0;
        for (std::size_t next = 0; next < part.size(); ++next) {
            const int f = part[next];
            for (const Neighbour& n : neighbours[std::size_t(f)]) {
                const auto wanted = static_cast<signed char>(n.agrees ? turned[std::size_t(f)]
                                                                      : 1 - turned[std::size_t(f)]);
                auto& state = turned[std::size_t(n.face)];
                if (state < 0) {
                    state = wanted;
                    part.push_back(n.face);
                } else if (state != wanted) {
                    fail(
                        "faces around edge {}-{} cannot be oriented consistently (one-sided "
                        "surface)",
                        n.low, n.high);
                }
            }
        }
        return part;
    }

    /// Six times the signed volume of a closed part.
    double volume(const std::vector<int>& part, const std::vector<signed char>& turned) {
        const geom::Vec3 origin = points_.row(face(part.front())[0]).transpose();
        const auto at = [&](int v) { return geom::Vec3(points_.row(v).transpose() - origin); };
        double sum = 0.0;
        for (const int f : part) {
            const auto v = face(f);
            double faces_sum = 0.0;
            for (std::size_t i = 2; i < v.size(); ++i) {
                const geom::Vec3 a = at(v[0]), b = at(v[i - 1]), c = at(v[i]);
                faces_sum += a.x() * (b.y() * c.z() - b.z() * c.y()) +
                             a.y() * (b.z() * c.x() - b.x() * c.z()) +
                             a.z() * (b.x() * c.y() - b.y() * c.x());
            }
            sum += turned[std::size_t(f)] != 0 ? -faces_sum : faces_sum;
        }
        return sum;
    }

    void check_vertex(std::string_view what, int v) const {
        if (v < 0 || v >= input_.vertex_count) {
            fail("{} names vertex {}, but there are {}", what, v, input_.vertex_count);
        }
    }

    void check_sharpness(std::string_view what, double sharpness) const {
        if (!(sharpness >= 0.0)) fail("{}: sharpness {} is not a number >= 0", what, sharpness);
    }

    void check_tags() const {
        for (const EdgeTagInput& tag : input_.creases) {
            const std::string what = fmt::format("crease {}-{}", tag.v0, tag.v1);
            check_vertex(what, tag.v0);
            check_vertex(what, tag.v1);
            check_sharpness(what, tag.sharpness);
            const auto key = std::minmax(tag.v0, tag.v1);
            const auto found = std::lower_bound(
                half_edges_.begin(), half_edges_.end(), key, [](const HalfEdge& h, const auto& k) {
                    return std::tie(h.low, h.high) < std::tie(k.first, k.second);
                });
            if (found == half_edges_.end() || found->low != key.first ||
                found->high != key.second) {
                fail("{}: there is no such edge", what);
            }
        }
        for (const VertexTagInput& tag : input_.corners) {
            check_vertex("corner tag", tag.vertex);
            check_sharpness(fmt::format("corner {}", tag.vertex), tag.sharpness);
        }
        for (const int v : input_.pins) check_vertex("pin", v);
        for (const SectorTagInput& tag : input_.sectors) {
            check_vertex("sector", tag.vertex);
            const auto faces = static_cast<int>(input_.face_sizes.size());
            if (tag.face < 0 || tag.face >= faces) {
                fail("sector names face {}, but there are {}", tag.face, faces);
            }
            if (!(tag.angle >= 0.0 && tag.angle < 2.0 * M_PI)) {
                fail("sector at vertex {}: angle {} degrees is not within 0 and 360", tag.vertex,
                     tag.angle * 180.0 / M_PI);
            }
            for (const double n : tag.normal) {
                if (!std::isfinite(n))
                    fail("sector at vertex {}: normal is not finite", tag.vertex);
            }
        }
    }

    TopologyInput& input_;
    geom::Points& points_;
    std::string_view source_;
    std::vector<int> begin_;
    std::vector<HalfEdge> half_edges_;
    Facing facing_;
};

}  // namespace

BuildResult build_cage(TopologyInput input, geom::Points points, std::string_view source,
                       Facing facing) {
    if (points.rows() != input.vertex_count) {
        throw base::InvalidArgument(fmt::format("{}: {} points for {} vertices", source,
                                                points.rows(), input.vertex_count));
    }
    Checker checker(input, points, source, facing);
    BuildResult result;
    result.flipped_faces = checker.run();
    std::vector<SectorTagInput> sectors;
    std::swap(sectors, input.sectors);  // they need fans that were checked
    auto topology = std::make_shared<const Topology>(input);
    checker.check_fans(*topology);
    if (!sectors.empty()) {
        checker.check_sectors(*topology, sectors);
        std::swap(sectors, input.sectors);
        topology = std::make_shared<const Topology>(input);
    }
    result.cage = {std::move(topology), std::move(points)};
    return result;
}

bool is_extraordinary(const Topology& topology, VertexId v) {
    // Faces between one infinitely sharp edge and the next, counter-clockwise from the first
    // half-edge.
    std::vector<int> sectors{0};
    const CornerId first = topology.corner(v);
    const auto sharp = [&](CornerId c) { return std::isinf(topology.sharpness(topology.edge(c))); };
    CornerId c = first;
    do {
        if (sharp(c) && c != first) sectors.push_back(0);
        ++sectors.back();
        if (topology.is_shifted(c)) return true;
        c = topology.rotate(c);
    } while (c.valid() && c != first);
    const bool boundary = topology.is_boundary(v);
    if (!boundary && !sharp(first) && sectors.size() > 1) {
        sectors.front() += sectors.back();  // the last sector goes on in the first
        sectors.pop_back();
    }
    const std::size_t sharp_edges = boundary             ? sectors.size() + 1
                                    : sharp(first)       ? sectors.size()
                                    : sectors.size() > 1 ? sectors.size()
                                                         : 0;
    const bool dart = !boundary && sharp_edges == 1;
    const bool corner = std::isinf(topology.sharpness(v)) || sharp_edges > 2;
    if (sharp_edges == 0) return corner || sectors[0] != 4;
    const int regular = corner ? 1 : 2;
    return dart || std::any_of(sectors.begin(), sectors.end(), [&](int n) { return n != regular; });
}

CageSummary summarise(const Topology& topology) {
    CageSummary summary;
    summary.vertices = topology.vertex_count();
    summary.faces = topology.face_count();
    for (const FaceId f : topology.faces()) summary.non_quads += topology.size(f) != 4 ? 1 : 0;
    for (const EdgeId e : topology.edges()) {
        if (topology.is_boundary(e)) {
            ++summary.boundary_edges;
        } else if (topology.sharpness(e) > 0.0) {
            ++summary.creases;
        }
    }
    for (const VertexId v : topology.vertices()) {
        summary.corners += topology.tagged_sharpness(v) > 0.0 ? 1 : 0;
        summary.pins += topology.is_pinned(v) ? 1 : 0;
        summary.extraordinary += is_extraordinary(topology, v) ? 1 : 0;
    }
    return summary;
}

}  // namespace patchwright::mesh
