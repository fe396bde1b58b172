#include "mesh/two_face_vertices.h"

#include <patchwright/base/error.h>
#include <patchwright/mesh/cage.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

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
        vertex_of_file_ = remove_two_face_vertices(input_, points_);
        if (!vertex_of_file_.empty()) find_faces();
        check_duplicates();
        collect_half_edges();
        const int flipped = orient();
        check_tags();
        return flipped;
    }

    /// @param topology  of the same input, but for the sectors
    void check_sectors(const Topology& topology, const std::vector<SectorTagInput>& sectors) const {
        for (std::size_t k = 0; k < sectors.size(); ++k) {
            const SectorTagInput& tag = sectors[k];
            const VertexId v{tag.vertex};
            const CornerId c = find_corner(topology, FaceId{tag.face}, v);
            const std::string name = fmt::format("sector {} {}", number(tag.vertex) - 1, tag.face);
            const auto& lines = input_.lines.sectors;
            if (!c.valid()) fail_tag(name, lines, k, "the face does not have this vertex");
            if (tag.angle == 0.0) continue;
            const std::vector<CornerId> fan = sector_corners(topology, c);
            // A dart's faces go all around from its only sharp edge back to it.
            if (fan.empty() ||
                (!topology.is_boundary(v) && topology.rotate(fan.back()) == fan.front())) {
                fail_tag(name, lines, k, "its angle needs two infinitely sharp edges around it");
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
                fail("{} joins parts that share no edge there; split the vertex", vertex(v.value));
            }
            if (!topology.is_boundary(v) && in_fan < 3) {
                fail("inner {} has only {} faces; remove it or split its faces", vertex(v.value),
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

    static std::string with_line(std::string text, const std::vector<int>& lines, int k) {
        if (!lines.empty()) text += fmt::format(" (line {})", lines[std::size_t(k)]);
        return text;
    }
    /// "vertex 3 (line 7)", counted as in the file.
    [[nodiscard]] std::string vertex(int v) const {
        return with_line(fmt::format("vertex {}", number(v)), input_.lines.vertices, v);
    }
    [[nodiscard]] std::string face_name(int f) const {
        return with_line(fmt::format("face {}", f + 1), input_.lines.faces, f);
    }
    [[nodiscard]] std::string edge(int a, int b) const {
        return fmt::format("edge {}-{}", number(a), number(b));
    }
    /// Counted from 1, as vertices are in OBJ files.
    [[nodiscard]] int number(int v) const {
        return vertex_of_file_.empty() ? v + 1 : vertex_of_file_[std::size_t(v)] + 1;
    }

    /// A tag's k-th message; tags count from 0.
    template <class... Args>
    [[noreturn]] void fail_tag(const std::string& tag, const std::vector<int>& lines, std::size_t k,
                               fmt::format_string<Args...> format, Args&&... args) const {
        fail("{}: {} (tags count from 0)", with_line(tag, lines, int(k)),
             fmt::format(format, std::forward<Args>(args)...));
    }

    std::span<int> face(int f) {
        return {input_.face_vertices.data() + begin_[std::size_t(f)],
                input_.face_vertices.data() + begin_[std::size_t(f) + 1]};
    }
    [[nodiscard]] int face_count() const { return static_cast<int>(input_.face_sizes.size()); }

    void check_vertices_and_sizes() {
        if (input_.face_sizes.empty()) fail("holds no faces");
        for (Eigen::Index v = 0; v < points_.rows(); ++v) {
            if (!((points_.row(v).array().abs() <= geom::largest_coordinate).all()))
                fail("{} has a coordinate that is not a length up to {:g}", vertex(int(v)),
                     geom::largest_coordinate);
        }
        find_faces();
        std::vector<int> last_face(std::size_t(input_.vertex_count), -1);
        for (int f = 0; f < face_count(); ++f) {
            if (input_.face_sizes[std::size_t(f)] < 3) {
                fail("{} has {} vertices; at least 3 are needed", face_name(f),
                     input_.face_sizes[std::size_t(f)]);
            }
            for (const int v : face(f)) {
                if (v < 0 || v >= input_.vertex_count) {
                    fail("{} names vertex {}, but there are {}", face_name(f), v + 1,
                         input_.vertex_count);
                }
                if (last_face[std::size_t(v)] == f)
                    fail("{} has {} twice", face_name(f), vertex(v));
                last_face[std::size_t(v)] = f;
            }
        }
        const auto unused = std::find(last_face.begin(), last_face.end(), -1);
        if (unused != last_face.end()) {
            fail("{} belongs to no face; remove it", vertex(int(unused - last_face.begin())));
        }
    }

    void find_faces() {
        begin_.assign(input_.face_sizes.size() + 1, 0);
        std::partial_sum(input_.face_sizes.begin(), input_.face_sizes.end(), begin_.begin() + 1);
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
                fail("{} and {} have the same vertices; remove one",
                     face_name(sorted[i - 1].second), face_name(sorted[i].second));
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
                fail("{} has more than two faces: {}, {}, {}; split it", edge(a.low, a.high),
                     face_name(a.face), face_name(half_edges_[i - 1].face), face_name(c.face));
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
                    fail("faces around {} cannot be oriented consistently (one-sided surface)",
                         edge(n.low, n.high));
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

    void check_tag(const std::string& name, const std::vector<int>& lines, std::size_t k, int v,
                   double sharpness) const {
        if (v < 0 || v >= input_.vertex_count)
            fail_tag(name, lines, k, "there are {} vertices", input_.vertex_count);
        if (!(sharpness >= 0.0))
            fail_tag(name, lines, k, "sharpness {} is not a number >= 0", sharpness);
    }

    /// The number that a tag gives the vertex; others stay.
    [[nodiscard]] int in_tag(int v) const {
        return v < 0 || v >= input_.vertex_count ? v : number(v) - 1;
    }

    [[nodiscard]] bool is_edge(int a, int b) const {
        const auto key = std::minmax(a, b);
        const auto found = std::lower_bound(
            half_edges_.begin(), half_edges_.end(), key, [](const HalfEdge& h, const auto& k) {
                return std::tie(h.low, h.high) < std::tie(k.first, k.second);
            });
        return found != half_edges_.end() && found->low == key.first && found->high == key.second;
    }

    void check_tags() const {
        for (std::size_t k = 0; k < input_.creases.size(); ++k) {
            const EdgeTagInput& tag = input_.creases[k];
            const auto name = fmt::format("crease {}-{}", in_tag(tag.v0), in_tag(tag.v1));
            check_tag(name, input_.lines.creases, k, tag.v0, tag.sharpness);
            check_tag(name, input_.lines.creases, k, tag.v1, tag.sharpness);
            if (!is_edge(tag.v0, tag.v1))
                fail_tag(name, input_.lines.creases, k, "there is no such edge");
        }
        for (std::size_t k = 0; k < input_.corners.size(); ++k) {
            const auto [v, sharpness] = input_.corners[k];
            check_tag(fmt::format("corner {}", in_tag(v)), input_.lines.corners, k, v, sharpness);
        }
        for (std::size_t k = 0; k < input_.pins.size(); ++k) {
            const int v = input_.pins[k];
            check_tag(fmt::format("pin {}", in_tag(v)), input_.lines.pins, k, v, 0.0);
        }
        for (std::size_t k = 0; k < input_.sectors.size(); ++k) check_sector(k);
    }

    void check_sector(std::size_t k) const {
        const SectorTagInput& tag = input_.sectors[k];
        const auto name = fmt::format("sector {} {}", in_tag(tag.vertex), tag.face);
        const auto& lines = input_.lines.sectors;
        check_tag(name, lines, k, tag.vertex, 0.0);
        const auto faces = static_cast<int>(input_.face_sizes.size());
        if (tag.face < 0 || tag.face >= faces)
            fail_tag(name, lines, k, "there are {} faces", faces);
        if (!(tag.angle >= 0.0 && tag.angle < 2.0 * M_PI)) {
            fail_tag(name, lines, k, "angle {} degrees is not within 0 and 360",
                     tag.angle * 180.0 / M_PI);
        }
        for (const double n : tag.normal) {
            if (!(std::abs(n) <= geom::largest_coordinate))
                fail_tag(name, lines, k, "the normal is not finite");
        }
    }

    TopologyInput& input_;
    geom::Points& points_;
    std::string_view source_;
    std::vector<int> begin_;
    std::vector<HalfEdge> half_edges_;
    Facing facing_;
    std::vector<int> vertex_of_file_;  ///< empty: all vertices are still there
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
    const int given = input.vertex_count;
    result.flipped_faces = checker.run();
    result.removed_vertices = given - input.vertex_count;
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

}  // namespace patchwright::mesh
