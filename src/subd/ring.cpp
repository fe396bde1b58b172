#include "subd/corner_spectrum.h"

#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/refine.h>
#include <patchwright/subd/ring.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace patchwright::subd {

namespace {

using mesh::CornerId;
using mesh::FaceId;
using mesh::Topology;
using mesh::VertexId;

/// Gathers the faces around one face as if nothing else of the mesh existed: places where the mesh
/// closes up outside the face's own vertices are not glued, so that equal kinds give equal slots.
class RingExtractor {
  public:
    RingExtractor(const Topology& topology, FaceId face) : topology_(topology) {
        own_ = static_cast<int>(topology.size(face));
        add_face(topology.corners(face)[0]);
        for (int i = 0; i < own_; ++i) {
            const CornerId across = topology.twin(topology.corners(face)[i]);
            neighbour_.push_back(across.valid() ? add_face(across) : -1);
        }
        put(own_);
        for (int i = 0; i < own_; ++i) walk(i);
        number_slots();
    }

    [[nodiscard]] const std::string& key() const { return key_; }

    [[nodiscard]] std::vector<std::int32_t> vertices() const {
        std::vector<std::int32_t> result(std::size_t(slot_count_), -1);
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            CornerId c = faces_[f].first;
            for (int k = 0; k < faces_[f].size; ++k, c = topology_.next(c)) {
                result[std::size_t(slot(int(f), k))] = topology_.vertex(c).value;
            }
        }
        return result;
    }

    [[nodiscard]] std::shared_ptr<const Topology> local_topology() const {
        mesh::TopologyInput input;
        input.vertex_count = slot_count_;
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            input.face_sizes.push_back(faces_[f].size);
            for (int k = 0; k < faces_[f].size; ++k) input.face_vertices.push_back(slot(int(f), k));
        }
        for (const Spoke& s : spokes_) {
            if (s.sharpness > 0.0) {
                input.creases.push_back(
                    {slot(s.face, s.position),
                     slot(s.face, (s.position + 1) % faces_[std::size_t(s.face)].size),
                     s.sharpness});
            }
        }
        for (int i = 0; i < own_; ++i) {
            const double sharpness = topology_.sharpness(own_vertex(i));
            if (sharpness > 0.0) input.corners.push_back({i, sharpness});
        }
        return std::make_shared<const Topology>(input);
    }

  private:
    struct FaceCopy {
        CornerId first;
        int size;
        int begin;  // of its nodes
    };
    struct Spoke {
        int face, position;
        double sharpness;
    };

    [[nodiscard]] VertexId own_vertex(int i) const {
        return topology_.vertex(topology_.corners(topology_.face(faces_[0].first))[i]);
    }

    int add_face(CornerId first) {
        const int begin = static_cast<int>(parent_.size());
        const int size = topology_.size(topology_.face(first));
        for (int k = 0; k < size; ++k) parent_.push_back(begin + k);
        faces_.push_back({first, size, begin});
        return static_cast<int>(faces_.size()) - 1;
    }

    /// Position of `c` within face copy `f`, counted from the copy's first corner.
    [[nodiscard]] int position(int f, CornerId c) const {
        const FaceCopy& copy = faces_[std::size_t(f)];
        return (c.value - copy.first.value + copy.size) % copy.size;
    }

    int root(int node) {
        while (parent_[std::size_t(node)] != node) node = parent_[std::size_t(node)];
        return node;
    }
    void unite(int f, int k, int g, int l) {
        const FaceCopy& a = faces_[std::size_t(f)];
        const FaceCopy& b = faces_[std::size_t(g)];
        const int x = root(a.begin + (k + a.size) % a.size);
        const int y = root(b.begin + (l + b.size) % b.size);
        parent_[std::size_t(std::max(x, y))] = std::min(x, y);
    }

    void put(double value) {
        char bytes[sizeof value];
        std::memcpy(bytes, &value, sizeof value);
        key_.append(bytes, sizeof bytes);
    }

    void note_spoke(int f, int position, CornerId c) {
        const double sharpness = topology_.sharpness(topology_.edge(c));
        spokes_.push_back({f, position, sharpness});
        put(sharpness);
    }

    /// Glues the faces around own vertex `i` along its edges and writes what is met into the key.
    void walk(int i) {
        const CornerId start = topology_.corners(topology_.face(faces_[0].first))[i];
        const int before = (i + own_ - 1) % own_;
        put(topology_.sharpness(topology_.vertex(start)));
        note_spoke(0, i, start);
        // Counter-clockwise from the face: first across the edge that arrives at the vertex.
        int f = 0;
        CornerId c = start;
        for (int step = 0;; ++step) {
            const CornerId arriving = topology_.previous(c);
            const CornerId next = topology_.twin(arriving);
            note_spoke(f, position(f, arriving), arriving);
            if (!next.valid()) {
                put(-1);
                walk_clockwise(i, start);
                return;
            }
            if (next == start) return;
            const bool last = topology_.twin(topology_.previous(next)) == start;
            const int g = step == 0 ? neighbour_[std::size_t(before)]
                          : last    ? neighbour_[std::size_t(i)]
                                    : add_face(next);
            put(faces_[std::size_t(g)].size);
            glue(f, arriving, g, next);
            if (last) glue(g, topology_.previous(next), 0, start);
            f = g;
            c = next;
        }
    }

    void walk_clockwise(int i, CornerId start) {
        int f = 0;
        CornerId c = start;
        for (int step = 0;; ++step) {
            const CornerId arriving = topology_.twin(c);
            if (!arriving.valid()) {
                put(-2);
                return;
            }
            const CornerId next = topology_.next(arriving);
            const int g = step == 0 ? neighbour_[std::size_t(i)] : add_face(next);
            put(faces_[std::size_t(g)].size);
            glue(g, arriving, f, c);
            note_spoke(g, position(g, next), next);
            f = g;
            c = next;
        }
    }

    /// Identifies the ends of an edge that `f` runs as `arriving` and `g` as its twin `leaving`.
    void glue(int f, CornerId arriving, int g, CornerId leaving) {
        const int k = position(f, arriving);
        const int l = position(g, leaving);
        unite(f, k, g, l + 1);
        unite(f, k + 1, g, l);
    }

    void number_slots() {
        slot_.assign(parent_.size(), -1);
        for (std::size_t node = 0; node < parent_.size(); ++node) {
            auto& number = slot_[std::size_t(root(int(node)))];
            if (number < 0) number = slot_count_++;
            slot_[node] = number;
        }
    }
    [[nodiscard]] int slot(int f, int k) const {
        return slot_[std::size_t(faces_[std::size_t(f)].begin + k)];
    }

    const Topology& topology_;
    int own_ = 0;
    std::vector<FaceCopy> faces_;
    std::vector<int> neighbour_;  // per own edge: face copy across it, -1 at a boundary
    std::vector<int> parent_;     // union-find over (face copy, position)
    std::vector<int> slot_;
    int slot_count_ = 0;
    std::vector<Spoke> spokes_;
    std::string key_;
};

/// Whether the face is one polynomial as seen from its own corner `c`.
bool corner_is_regular(const Topology& t, CornerId c) {
    const auto sharp = [&](CornerId half_edge) {
        return std::isinf(t.sharpness(t.edge(half_edge)));
    };
    const VertexId v = t.vertex(c);
    int smooth_spokes = 0;
    int sharp_spokes = 0;
    CornerId spoke = t.corner(v);
    const CornerId first = spoke;
    do {
        const double s = t.sharpness(t.edge(spoke));
        if (s > 0.0 && !std::isinf(s)) return false;
        (s > 0.0 ? sharp_spokes : smooth_spokes) += 1;
        const CornerId arriving = t.previous(spoke);
        spoke = t.twin(arriving);
        if (!spoke.valid()) ++sharp_spokes;  // the other boundary edge
    } while (spoke.valid() && spoke != first);

    const double s = t.sharpness(v);
    if (s > 0.0 && !std::isinf(s)) return false;
    const bool corner = s > 0.0 || sharp_spokes > 2;
    const bool leaving = sharp(c);
    const bool arriving = sharp(t.previous(c));
    if (leaving && arriving) return corner;
    if (corner) return false;
    if (!leaving && !arriving) return sharp_spokes == 0 && smooth_spokes == 4;
    // A crease vertex: regular when just one more face lies between the face and the other crease
    // edge.
    if (sharp_spokes != 2) return false;
    if (leaving) return sharp(t.previous(t.twin(t.previous(c))));
    return sharp(t.next(t.twin(c)));
}

/// The 16 x slots matrix of RingKind::regular(), empty when the kind is not regular.
Eigen::MatrixXd regular_matrix(const Topology& t) {
    const FaceId face{0};
    if (t.size(face) != 4) return {};
    for (const FaceId f : t.faces()) {
        if (t.size(f) != 4) return {};
    }
    const auto corners = t.corners(face);
    for (const CornerId c : corners) {
        if (!corner_is_regular(t, c)) return {};
    }
    Eigen::MatrixXd grid = Eigen::MatrixXd::Zero(16, t.vertex_count());
    const auto unit = [&](int a, int b, CornerId c) { grid(4 * a + b, t.vertex(c).value) = 1.0; };
    // Per side: the two outer grid places beyond it, and those of the corner past its start.
    constexpr int inner[4][2] = {{1, 1}, {2, 1}, {2, 2}, {1, 2}};
    constexpr int outward[4][2] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}};
    bool crease[4];
    for (int i = 0; i < 4; ++i) {
        unit(inner[i][0], inner[i][1], corners[i]);
        crease[i] = std::isinf(t.sharpness(t.edge(corners[i])));
    }
    for (int i = 0; i < 4; ++i) {
        const int j = (i + 1) % 4;
        if (crease[i]) continue;
        const CornerId across = t.twin(corners[i]);  // runs from corner j to corner i
        const CornerId beyond_i = t.next(t.next(across));
        unit(inner[i][0] + outward[i][0], inner[i][1] + outward[i][1], beyond_i);
        unit(inner[j][0] + outward[i][0], inner[j][1] + outward[i][1], t.previous(across));
        const int before = (i + 3) % 4;
        if (crease[before]) continue;
        // The face diagonally across corner i lies past the neighbour's edge that leaves corner i.
        const CornerId diagonal = t.twin(t.next(across));
        unit(inner[i][0] + outward[i][0] + outward[before][0],
             inner[i][1] + outward[i][1] + outward[before][1], t.previous(diagonal));
    }
    const auto mirror = [&](int to, int edge, int from) {
        grid.row(to) = 2.0 * grid.row(edge) - grid.row(from);
    };
    for (int a = 0; a < 4; ++a) {
        if (crease[0]) mirror(4 * a, 4 * a + 1, 4 * a + 2);
        if (crease[2]) mirror(4 * a + 3, 4 * a + 2, 4 * a + 1);
    }
    for (int b = 0; b < 4; ++b) {
        if (crease[3]) mirror(b, 4 + b, 8 + b);
        if (crease[1]) mirror(12 + b, 8 + b, 4 + b);
    }
    return grid;
}

}  // namespace

RingKind::RingKind(RingTable& table, std::shared_ptr<const Topology> local)
    : table_(table), local_(std::move(local)), regular_(regular_matrix(*local_)) {}

const RingKind::Child& RingKind::child(int i) const {
    const std::lock_guard lock(table_.mutex_);
    if (children_.empty()) {
        const Refinement fine = refine(*local_);
        std::vector<Child> children;
        for (int k = 0; k < size(); ++k) {
            const Ring ring = table_.ring(*fine.topology, FaceId{k});
            Child child{ring.kind, Eigen::MatrixXd::Zero(ring.kind->slots(), slots())};
            for (std::size_t row = 0; row < ring.vertices.size(); ++row) {
                const auto from = std::size_t(ring.vertices[row]);
                for (auto e = fine.stencils.begin[from]; e < fine.stencils.begin[from + 1]; ++e) {
                    child.matrix(Eigen::Index(row), fine.stencils.index[std::size_t(e)]) +=
                        fine.stencils.weight[std::size_t(e)];
                }
            }
            children.push_back(std::move(child));
        }
        children_ = std::move(children);
    }
    return children_[std::size_t(i)];
}

const RingKind::Corner& RingKind::corner(int i) const {
    const std::lock_guard lock(table_.mutex_);
    if (corners_.empty()) corners_.resize(std::size_t(size()));
    Corner& corner = corners_[std::size_t(i)];
    if (corner.limit.size() > 0) return corner;
    const Child& next = child(i);
    // Children of other polygons than quads start at the parent's vertex.
    const int same = size() == 4 ? i : 0;
    if (next.kind != this) {
        const Corner& fine = next.kind->corner(same);
        corner.tangents = fine.tangents * next.matrix;
        corner.eigenvalue = fine.eigenvalue;
        corner.limit = fine.limit * next.matrix;
        return corner;
    }
    const Eigen::RowVectorXd limit = limit_row(next.matrix);
    constexpr double other_end_u[] = {1, 0, 0, 1}, other_end_v[] = {1, 1, 0, 0};
    const double u = at_end_u(i) ? 1 : 0, v = at_end_v(i) ? 1 : 0;
    CornerProbes probes{ring_mask(*this, other_end_u[i], v).position() - limit,
                        ring_mask(*this, u, other_end_v[i]).position() - limit,
                        Eigen::MatrixXd(4, slots())};
    constexpr double inside[4][2] = {{0.5, 0.5}, {0.75, 0.3}, {0.3, 0.75}, {0.6, 0.2}};
    for (int k = 0; k < 4; ++k) {
        probes.inside.row(k) =
            ring_mask(*this, std::abs(u - inside[k][0]), std::abs(v - inside[k][1])).position() -
            limit;
    }
    const TangentRows tangents = tangent_rows(next.matrix, probes);
    corner.tangents = Eigen::MatrixXd::Zero(2, slots());
    if (tangents.rows.size() > 0) {
        // The probes lie away from the corner, which is against u or v at their ends.
        corner.tangents.row(0) = (at_end_u(i) ? -1.0 : 1.0) * tangents.rows.row(0);
        corner.tangents.row(1) = (at_end_v(i) ? -1.0 : 1.0) * tangents.rows.row(1);
    }
    corner.eigenvalue = tangents.eigenvalue;
    corner.limit = limit;
    return corner;
}

const Eigen::MatrixXd& RingKind::contraction_power(int i, int exponent) const {
    const std::lock_guard lock(table_.mutex_);
    if (powers_.empty()) powers_.resize(std::size_t(size()));
    auto& powers = powers_[std::size_t(i)];
    if (powers.empty()) {
        Eigen::MatrixXd contraction = child(i).matrix.rowwise() - corner(i).limit;
        // Its rows sum to the rounding of those of the matrix; that part must not stay either.
        contraction -= contraction.rowwise().sum() * corner(i).limit;
        powers.push_back(std::move(contraction));
    }
    while (powers.size() <= std::size_t(exponent)) {
        Eigen::MatrixXd square = powers.back() * powers.back();
        square -= square.rowwise().sum() * corner(i).limit;
        powers.push_back(std::move(square));
    }
    return powers[std::size_t(exponent)];
}

RingTable::RingTable() = default;
RingTable::~RingTable() = default;

Ring RingTable::ring(const Topology& topology, FaceId f) {
    const RingExtractor extractor(topology, f);
    Ring ring;
    ring.vertices = extractor.vertices();
    const std::lock_guard lock(mutex_);
    auto& kind = kinds_[extractor.key()];
    if (!kind) kind.reset(new RingKind(*this, extractor.local_topology()));
    ring.kind = kind.get();
    return ring;
}

int RingTable::kind_count() const {
    const std::lock_guard lock(mutex_);
    return static_cast<int>(kinds_.size());
}

}  // namespace patchwright::subd
