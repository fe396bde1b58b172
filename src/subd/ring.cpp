#include "subd/corner_spectrum.h"
#include "subd/ring_extractor.h"

#include <patchwright/mesh/regular.h>
#include <patchwright/subd/limit_mask.h>
#include <patchwright/subd/refine.h>
#include <patchwright/subd/ring.h>

#include <cmath>
#include <deque>
#include <mutex>

namespace patchwright::subd {

namespace {

using mesh::CornerId;
using mesh::FaceId;
using mesh::Topology;
using mesh::VertexId;

/// The 16 x slots matrix of RingKind::regular(), empty when the kind is not regular.
Eigen::MatrixXd regular_matrix(const Topology& t) {
    const FaceId face{0};
    if (!mesh::is_regular(t, face)) return {};
    const auto corners = t.corners(face);
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

/// rows * matrix
Eigen::MatrixXd product(const Eigen::MatrixXd& rows, const Stencils& matrix) {
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(rows.rows(), matrix.columns);
    for (int k = 0; k < matrix.rows(); ++k) {
        for (auto e = matrix.begin[std::size_t(k)]; e < matrix.begin[std::size_t(k) + 1]; ++e)
            result.col(matrix.index[std::size_t(e)]) += matrix.weight[std::size_t(e)] * rows.col(k);
    }
    return result;
}

Eigen::MatrixXd dense(const Stencils& matrix) {
    return product(Eigen::MatrixXd::Identity(matrix.rows(), matrix.rows()), matrix);
}

/// A value for each of a face's corners, computed by the first thread that asks.
template <class T>
class PerCorner {
  public:
    explicit PerCorner(int corners) : entries_(std::size_t(corners)) {}

    template <class Make>
    const T& get(int i, Make&& make) {
        Entry& entry = entries_[std::size_t(i)];
        std::call_once(entry.once, [&] { entry.value = make(); });
        return entry.value;
    }

  private:
    struct Entry {
        std::once_flag once;
        T value;
    };
    std::deque<Entry> entries_;  // its entries need not move
};

}  // namespace

struct RingKind::Lazy {
    explicit Lazy(int corners) : children(1), corner(corners), tangent_plane(corners) {}

    PerCorner<std::vector<Child>> children;  // all at once
    PerCorner<Corner> corner;
    PerCorner<TangentPlane> tangent_plane;
};

RingKind::RingKind(RingTable& table, int number, const RingExtractor& extracted)
    : table_(table), number_(number) {
    if (auto points = extracted.control_points()) {
        regular_ = std::move(*points);
    } else {
        local_ = extracted.local_topology();
        regular_ = regular_matrix(*local_);
    }
    lazy_ = std::make_unique<Lazy>(size());
}

RingKind::~RingKind() = default;

const RingKind::Child& RingKind::child(int i) const {
    const std::vector<Child>& children = lazy_->children.get(0, [&] {
        const Refinement fine = refine(*local_);
        std::vector<Child> made;
        for (int k = 0; k < size(); ++k) {
            const Ring ring = table_.ring(*fine.topology, FaceId{k});
            Child child{ring.kind, {}};
            child.matrix.columns = slots();
            for (const std::int32_t vertex : ring.vertices) {
                const auto from = std::size_t(vertex);
                for (auto e = fine.stencils.begin[from]; e < fine.stencils.begin[from + 1]; ++e) {
                    child.matrix.index.push_back(fine.stencils.index[std::size_t(e)]);
                    child.matrix.weight.push_back(fine.stencils.weight[std::size_t(e)]);
                }
                child.matrix.begin.push_back(std::int64_t(child.matrix.index.size()));
            }
            made.push_back(std::move(child));
        }
        return made;
    });
    return children[std::size_t(i)];
}

const RingKind::Corner& RingKind::corner(int i) const {
    return lazy_->corner.get(i, [&] { return make_corner(i); });
}

const RingKind::TangentPlane& RingKind::tangent_plane(int i) const {
    return lazy_->tangent_plane.get(i, [&] { return make_tangent_plane(i); });
}

RingKind::Corner RingKind::make_corner(int i) const {
    if (!local_) return {ring_mask(*this, at_end_u(i) ? 1 : 0, at_end_v(i) ? 1 : 0).rows};
    const Child& next = child(i);
    if (next.kind == this) return {limit_row(next.matrix)};
    // Children of other polygons than quads start at the parent's vertex.
    return {product(next.kind->corner(size() == 4 ? i : 0).limit, next.matrix)};
}

RingKind::TangentPlane RingKind::make_tangent_plane(int i) const {
    if (!local_) {
        constexpr double step = 0.5;  // eigenvalue of a regular vertex
        return {
            ring_mask(*this, at_end_u(i) ? 1 : 0, at_end_v(i) ? 1 : 0, 0, 1).rows.bottomRows<2>(),
            step};
    }
    const Child& next = child(i);
    if (next.kind != this) {
        const TangentPlane& fine = next.kind->tangent_plane(size() == 4 ? i : 0);
        return {product(fine.rows, next.matrix), fine.eigenvalue};
    }
    if (is_smooth_ring(i)) return smooth_tangent_plane(i);
    const Eigen::RowVectorXd limit = corner(i).limit;
    const double u = at_end_u(i) ? 1 : 0, v = at_end_v(i) ? 1 : 0;
    // Along the parameters' axes, which lead away from the corner or against that.
    const double sign_u = at_end_u(i) ? -1.0 : 1.0, sign_v = at_end_v(i) ? -1.0 : 1.0;
    CornerProbes probes;
    probes.u = sign_u * (ring_mask(*this, 1.0 - u, v).position() - limit);
    probes.v = sign_v * (ring_mask(*this, u, 1.0 - v).position() - limit);
    constexpr double inside[][2] = {{0.55, 0.52}, {0.75, 0.3}, {0.3, 0.75}, {0.6, 0.2}, {0.1, 0.9}};
    probes.du.resize(std::size(inside), slots());
    probes.dv.resize(std::size(inside), slots());
    for (std::size_t k = 0; k < std::size(inside); ++k) {
        const RingMask mask =
            ring_mask(*this, std::abs(u - inside[k][0]), std::abs(v - inside[k][1]), 0, 1);
        probes.du.row(Eigen::Index(k)) = mask.rows.row(1);
        probes.dv.row(Eigen::Index(k)) = mask.rows.row(2);
    }
    // In sectors with an angle control_normals() takes out what shrinks by less than half.
    const CornerId own = local_->corners(FaceId{0})[i];
    const CornerId beside = local_->twin(local_->previous(own));
    const bool controlled = local_->is_shifted(own) || local_->is_shifted(beside);
    TangentRows tangents = tangent_rows(dense(next.matrix), probes, controlled ? 0.5 : 1.0);
    if (tangents.rows.size() == 0) return {Eigen::MatrixXd::Zero(2, slots()), 0.0};
    return {std::move(tangents.rows), tangents.eigenvalue};
}

bool RingKind::is_smooth_ring(int i) const {
    const Topology& t = *local_;
    const CornerId first = t.corners(FaceId{0})[i];
    if (t.sharpness(t.vertex(first)) > 0.0) return false;
    CornerId c = first;
    do {
        if (t.size(t.face(c)) != 4 || t.sharpness(t.edge(c)) > 0.0 || t.is_shifted(c) ||
            t.is_shifted(t.twin(c)))
            return false;
        c = t.rotate(c);
    } while (c.valid() && c != first);
    return c.valid();
}

// Halstead, Kass, DeRose, Efficient, fair interpolation using Catmull-Clark surfaces (1993),
// appendix A: the direction along an edge weighs what lies at an angle from it by cosines.
RingKind::TangentPlane RingKind::smooth_tangent_plane(int i) const {
    const Topology& t = *local_;
    const CornerId own = t.corners(FaceId{0})[i];
    const int n = t.face_valence(t.vertex(own));
    const double angle = 2.0 * M_PI / n, c = std::cos(angle);
    const double edge_weight = 1.0 + c + std::cos(0.5 * angle) * std::sqrt(2.0 * (9.0 + c));
    TangentPlane plane{Eigen::MatrixXd::Zero(2, slots()),
                       (5.0 + c + std::sqrt((9.0 + c) * (1.0 + c))) / 16.0};
    // Spokes by their angles from the one that leaves the corner in the face; the face's other side
    // is the next one. Of the two sides the even corners' first is along u.
    const auto add = [&](Eigen::Index row, double from, double sign) {
        CornerId spoke = own;
        for (int k = 0; k < n; ++k, spoke = t.rotate(spoke)) {
            const double at = k * angle - from;
            plane.rows(row, t.vertex(t.next(spoke)).value) += sign * edge_weight * std::cos(at);
            plane.rows(row, t.vertex(t.next(t.next(spoke))).value) +=
                sign * (std::cos(at) + std::cos(at + angle));
        }
    };
    const Eigen::Index leaving = i % 2;  // row of the side that leaves the corner
    const auto sign = [&](Eigen::Index row) {
        return (row == 0 ? at_end_u(i) : at_end_v(i)) ? -1.0 : 1.0;
    };
    add(leaving, 0.0, sign(leaving));
    add(1 - leaving, angle, sign(1 - leaving));
    return plane;
}

RingTable::RingTable() = default;
RingTable::~RingTable() = default;

Ring RingTable::ring(const Topology& topology, FaceId f) {
    thread_local RingExtractor extractor;
    extractor.extract(topology, f);
    const auto vertices = extractor.vertices();
    Ring ring{nullptr, {vertices.begin(), vertices.end()}};
    ring.kind = &kind(extractor);
    return ring;
}

const RingKind& RingTable::kind(const RingExtractor& extracted) {
    {
        const std::shared_lock lock(mutex_);
        const auto known = kinds_.find(std::string_view(extracted.key()));
        if (known != kinds_.end()) return *known->second;
    }
    const std::unique_lock lock(mutex_);
    auto& kind = kinds_[extracted.key()];
    if (!kind) kind.reset(new RingKind(*this, static_cast<int>(kinds_.size()) - 1, extracted));
    return *kind;
}

int RingTable::kind_count() const {
    const std::shared_lock lock(mutex_);
    return static_cast<int>(kinds_.size());
}

}  // namespace patchwright::subd
