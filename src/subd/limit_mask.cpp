#include "subd/ring_extractor.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/subd/limit_mask.h>

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace patchwright::subd {

namespace {

/// Uniform cubic B-spline basis at t in [0, 1]: values, first and second derivatives in columns.
Eigen::Matrix<double, 4, 3> uniform_basis(double t) {
    const double s = 1.0 - t;
    Eigen::Matrix<double, 4, 3> b;
    b << s * s * s / 6.0, -0.5 * s * s, s,                                          //
        (4.0 + t * t * (3.0 * t - 6.0)) / 6.0, t * (1.5 * t - 2.0), 3.0 * t - 2.0,  //
        (4.0 + s * s * (3.0 * s - 6.0)) / 6.0, s * (2.0 - 1.5 * s), 3.0 * s - 2.0,  //
        t * t * t / 6.0, 0.5 * t * t, t;
    return b;
}

/// How often each row of a mask is differentiated along u and v.
constexpr int derivatives[6][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};

/// Rows of a mask while they are carried up from a piece to the face that was asked for. Reusable:
/// allocates only until its buffers have grown.
class MaskWork {
  public:
    using Rows = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

    [[nodiscard]] Rows rows() { return {data_.data(), count_, columns_}; }

    void set_zero(Eigen::Index count, Eigen::Index columns) {
        count_ = count;
        columns_ = columns;
        data_.assign(std::size_t(count * columns), 0.0);
    }
    /// rows() = rows() * matrix
    void multiply(const Eigen::MatrixXd& matrix) {
        other_.resize(std::size_t(count_ * matrix.cols()));
        Rows result(other_.data(), count_, matrix.cols());
        // As sums of products: a blocked product would allocate.
        result.noalias() = rows().lazyProduct(matrix);
        columns_ = matrix.cols();
        std::swap(data_, other_);
    }
    void multiply(const Stencils& matrix) {
        other_.assign(std::size_t(count_ * matrix.columns), 0.0);
        Rows result(other_.data(), count_, matrix.columns);
        const Rows from = rows();
        for (int k = 0; k < matrix.rows(); ++k) {
            for (auto e = matrix.begin[std::size_t(k)]; e < matrix.begin[std::size_t(k) + 1]; ++e)
                result.col(matrix.index[std::size_t(e)]) +=
                    matrix.weight[std::size_t(e)] * from.col(k);
        }
        columns_ = matrix.columns;
        std::swap(data_, other_);
    }
    /// The same so many times, less what the rows have of eigenvalue 1, whose left eigenvector is
    /// `limit`: its rounding would outlive everything else, and so differences from the limit keep
    /// all their digits however many the steps.
    void contract(const Stencils& matrix, const Eigen::RowVectorXd& limit, int steps) {
        for (int step = 0; step < steps; ++step) {
            multiply(matrix);
            Rows now = rows();
            for (Eigen::Index row = 0; row < count_; ++row)
                now.row(row) -= now.row(row).sum() * limit;
        }
    }

  private:
    std::vector<double> data_, other_;
    Eigen::Index count_ = 0;
    Eigen::Index columns_ = 0;
};

void regular_rows(const RingKind& kind, double u, double v, int order, MaskWork& work) {
    const auto bu = uniform_basis(u);
    const auto bv = uniform_basis(v);
    work.set_zero(row_count(order), 16);
    auto basis = work.rows();
    for (int row = 0; row < basis.rows(); ++row) {
        for (int a = 0; a < 4; ++a) {
            basis.row(row).segment<4>(4 * a) =
                bu(a, derivatives[row][0]) * bv.col(derivatives[row][1]).transpose();
        }
    }
    work.multiply(kind.regular());
}

/// The corner of the unit square that (u, v) is nearest to.
int nearest_corner(double u, double v) { return v > 0.5 ? (u > 0.5 ? 2 : 3) : (u > 0.5 ? 1 : 0); }

/// Parameters of the child times 2^levels are those of the face.
void scale_derivatives(MaskWork& work, int levels) {
    auto rows = work.rows();
    for (Eigen::Index row = 1; row < rows.rows(); ++row) {
        rows.row(row) *= std::ldexp(1.0, levels * (row < 3 ? 1 : 2));
    }
}

Smoothness corner_rows(const RingKind& kind, int i, int order, MaskWork& work) {
    work.set_zero(row_count(order), kind.slots());
    work.rows().row(0) = kind.corner(i).limit;
    if (order == 0) return Smoothness::Position;  // not asked for
    const RingKind::TangentPlane& plane = kind.tangent_plane(i);
    work.rows().middleRows<2>(1) = plane.rows;
    return plane.eigenvalue > 0.0 ? Smoothness::TangentPlane : Smoothness::Position;
}

Smoothness mask_rows(const RingKind& kind, double u, double v, int sector, int order,
                     MaskWork& work) {
    if (kind.is_regular()) {
        regular_rows(kind, u, v, order, work);
        return Smoothness::Derivatives;
    }
    if (kind.size() != 4) {
        // A sector's parameters are its own: nothing to scale.
        const RingKind::Child& child = kind.child(sector);
        const Smoothness smoothness = mask_rows(*child.kind, u, v, 0, order, work);
        work.multiply(child.matrix);
        return smoothness;
    }
    const int i = nearest_corner(u, v);
    // Distances from the corner are exact: 1 - u is for u >= 1/2.
    const double away_u = at_end_u(i) ? 1.0 - u : u;
    const double away_v = at_end_v(i) ? 1.0 - v : v;
    const auto square = [](double distance, bool end) { return end ? 1.0 - distance : distance; };
    const auto magnified = [&](int levels, const RingKind& piece) {
        const double scale = std::ldexp(1.0, levels);
        return mask_rows(piece, square(away_u * scale, at_end_u(i)),
                         square(away_v * scale, at_end_v(i)), 0, order, work);
    };
    if (kind.is_stationary(i)) {
        const double away = std::max(away_u, away_v);
        if (away == 0.0) return corner_rows(kind, i, order, work);
        int exponent = 0;
        std::frexp(away, &exponent);  // away = m 2^exponent with m in [1/2, 1)
        const int levels = -exponent;
        if (levels > 0) {
            const Smoothness smoothness = magnified(levels, kind);
            const Eigen::RowVectorXd& limit = kind.corner(i).limit;
            work.contract(kind.child(i).matrix, limit, levels);
            work.rows().row(0) += limit;
            scale_derivatives(work, levels);
            return smoothness;
        }
    }
    const RingKind::Child& child = kind.child(i);
    const Smoothness smoothness = magnified(1, *child.kind);
    work.multiply(child.matrix);
    scale_derivatives(work, 1);
    return smoothness;
}

/// What one thread needs to evaluate anything.
struct Scratch {
    RingExtractor ring;
    MaskWork work;
};

Scratch& scratch() {
    thread_local Scratch buffers;
    return buffers;
}

/// About a millisecond's work.
constexpr std::size_t locations_a_chunk = 1024;

/// Appends a row over slots as one over vertices, several of which may be the same.
void append_row(Stencils& to, const Eigen::RowVectorXd& slots,
                std::span<const std::int32_t> vertices) {
    std::vector<std::pair<std::int32_t, double>> entries;
    for (std::size_t slot = 0; slot < vertices.size(); ++slot)
        entries.emplace_back(vertices[slot], slots[Eigen::Index(slot)]);
    std::stable_sort(entries.begin(), entries.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    const auto first = std::size_t(to.begin.back());
    for (const auto& [vertex, weight] : entries) {
        if (to.index.size() > first && to.index.back() == vertex) {
            to.weight.back() += weight;
            continue;
        }
        to.index.push_back(vertex);
        to.weight.push_back(weight);
    }
    to.begin.push_back(std::int64_t(to.index.size()));
}

}  // namespace

RingMask ring_mask(const RingKind& kind, double u, double v, int sector, int order) {
    // Not the thread's: masks are made from masks when kinds are.
    MaskWork work;
    RingMask mask;
    mask.smoothness = mask_rows(kind, u, v, sector, order, work);
    mask.rows = work.rows();
    return mask;
}

LimitEvaluator::LimitEvaluator(std::shared_ptr<const mesh::Topology> topology)
    : topology_(std::move(topology)),
      smooth_(smooth_valences(*topology_)),
      table_(std::make_unique<RingTable>()) {}

void LimitEvaluator::check(const Location& at) const {
    if (!at.face.valid() || at.face.value >= topology_->face_count()) {
        throw base::UsageError(fmt::format("face {} does not exist; there are {}", at.face.value,
                                           topology_->face_count()));
    }
    const int sectors = topology_->size(at.face) == 4 ? 1 : topology_->size(at.face);
    if (!(at.u >= 0.0 && at.u <= 1.0 && at.v >= 0.0 && at.v <= 1.0) || at.sector < 0 ||
        at.sector >= sectors) {
        throw base::UsageError(
            fmt::format("face {}: parameters ({}, {}) of sector {} are not on it", at.face.value,
                        at.u, at.v, at.sector));
    }
}

Mask LimitEvaluator::mask(const Location& at, int order) const {
    check(at);
    if (order < 0 || order > 2) throw base::InvalidArgument("masks have order 0, 1 or 2");
    auto& [ring, work] = scratch();
    Mask mask;
    mask.smoothness = mask_rows(extract_ring(*table_, ring, *topology_, smooth_, at.face), at.u,
                                at.v, at.sector, order, work);
    const auto filled = ring.vertices();
    mask.vertices.assign(filled.begin(), filled.end());
    std::sort(mask.vertices.begin(), mask.vertices.end());
    mask.vertices.erase(std::unique(mask.vertices.begin(), mask.vertices.end()),
                        mask.vertices.end());
    mask.rows = Eigen::MatrixXd::Zero(work.rows().rows(), Eigen::Index(mask.vertices.size()));
    for (std::size_t slot = 0; slot < filled.size(); ++slot) {
        const auto column =
            std::lower_bound(mask.vertices.begin(), mask.vertices.end(), filled[slot]) -
            mask.vertices.begin();
        mask.rows.col(column) += work.rows().col(Eigen::Index(slot));
    }
    return mask;
}

Mask relative_to_coarser(const Mask& mask, const Stencils& stencils) {
    Mask result;
    result.smoothness = mask.smoothness;
    const auto entries = [&](std::size_t k) {
        const auto row = std::size_t(mask.vertices[k]);
        return std::pair{std::size_t(stencils.begin[row]), std::size_t(stencils.begin[row + 1])};
    };
    for (std::size_t k = 0; k < mask.vertices.size(); ++k) {
        const auto [begin, end] = entries(k);
        result.vertices.insert(result.vertices.end(),
                               stencils.index.begin() + std::ptrdiff_t(begin),
                               stencils.index.begin() + std::ptrdiff_t(end));
    }
    std::sort(result.vertices.begin(), result.vertices.end());
    result.vertices.erase(std::unique(result.vertices.begin(), result.vertices.end()),
                          result.vertices.end());
    result.rows = Eigen::MatrixXd::Zero(mask.rows.rows(), Eigen::Index(result.vertices.size()));
    for (std::size_t k = 0; k < mask.vertices.size(); ++k) {
        const auto [begin, end] = entries(k);
        for (std::size_t e = begin; e < end; ++e) {
            const auto column = std::lower_bound(result.vertices.begin(), result.vertices.end(),
                                                 stencils.index[e]) -
                                result.vertices.begin();
            result.rows.col(column) += stencils.weight[e] * mask.rows.col(Eigen::Index(k));
        }
    }
    return result;
}

LimitPoint LimitEvaluator::evaluate(const geom::Points& points, const Location& at,
                                    int order) const {
    check(at);
    if (order < 0 || order > 2) throw base::InvalidArgument("derivatives have order 0, 1 or 2");
    auto& [ring, work] = scratch();
    LimitPoint point;
    point.smoothness = mask_rows(extract_ring(*table_, ring, *topology_, smooth_, at.face), at.u,
                                 at.v, at.sector, order, work);
    const auto rows = work.rows();
    const auto vertices = ring.vertices();
    geom::Vec3* const values[] = {&point.position, &point.du,  &point.dv,
                                  &point.duu,      &point.duv, &point.dvv};
    for (Eigen::Index row = 0; row < rows.rows(); ++row) {
        geom::Vec3 sum = geom::Vec3::Zero();
        for (std::size_t k = 0; k < vertices.size(); ++k) {
            sum += rows(row, Eigen::Index(k)) * points.row(vertices[k]).transpose();
        }
        *values[row] = sum;
    }
    const geom::Vec3 normal = point.du.cross(point.dv);
    const double size = normal.norm();
    if (size > 0.0) point.normal = normal / size;
    return point;
}

geom::Vec3 LimitEvaluator::position(const geom::Points& points, const Location& at) const {
    return evaluate(points, at, 0).position;
}

void LimitEvaluator::check(const Locations& at, int order) const {
    if (order < 0 || order > 2)
        throw base::UsageError("masks and derivatives have order 0, 1 or 2");
    if (at.uv.size() != 2 * at.size() || (!at.sectors.empty() && at.sectors.size() != at.size()))
        throw base::UsageError(
            fmt::format("{} faces, {} parameters and {} sectors do not go together", at.size(),
                        at.uv.size(), at.sectors.size()));
    for (std::size_t i = 0; i < at.size(); ++i) check(at[i]);
}

/// Calls `visit(i, smoothness, rows, vertices of the columns)` for all locations, on all threads.
template <class Visit>
void LimitEvaluator::visit(const Locations& at, int order, const Visit& visit) const {
    check(at, order);
    base::parallel_for(at.size(), locations_a_chunk, [&](std::size_t begin, std::size_t end) {
        auto& [ring, work] = scratch();
        const RingKind* kind = nullptr;
        mesh::FaceId face;
        for (std::size_t i = begin; i < end; ++i) {
            const Location here = at[i];
            check(here);  // again: the arrays' holder may change them meanwhile
            if (kind == nullptr || here.face != face)
                kind = &extract_ring(*table_, ring, *topology_, smooth_, here.face);
            face = here.face;
            const Smoothness smoothness =
                mask_rows(*kind, here.u, here.v, here.sector, order, work);
            visit(i, smoothness, work.rows(), ring.vertices());
        }
    });
}

geom::Points LimitEvaluator::evaluate(const geom::Points& points, const Locations& at,
                                      int order) const {
    if (points.rows() != topology_->vertex_count())
        throw base::UsageError(
            fmt::format("{} points for {} vertices", points.rows(), topology_->vertex_count()));
    const Eigen::Index rows = row_count(order);
    geom::Points result(rows * Eigen::Index(at.size()), 3);
    visit(at, order,
          [&](std::size_t i, Smoothness, const MaskWork::Rows& mask, const auto& vertices) {
              for (Eigen::Index row = 0; row < rows; ++row) {
                  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
                  for (std::size_t k = 0; k < vertices.size(); ++k)
                      sum += mask(row, Eigen::Index(k)) * points.row(vertices[k]);
                  result.row(rows * Eigen::Index(i) + row) = sum;
              }
          });
    return result;
}

std::vector<Smoothness> LimitEvaluator::smoothness(const Locations& at) const {
    std::vector<Smoothness> result(at.size());
    visit(at, 2, [&](std::size_t i, Smoothness smoothness, const auto&, const auto&) {
        result[i] = smoothness;
    });
    return result;
}

Stencils LimitEvaluator::masks(const Locations& at, int order) const {
    std::vector<Stencils> parts((at.size() + locations_a_chunk - 1) / locations_a_chunk);
    visit(at, order,
          [&](std::size_t i, Smoothness, const MaskWork::Rows& mask, const auto& vertices) {
              for (Eigen::Index row = 0; row < mask.rows(); ++row)
                  append_row(parts[i / locations_a_chunk], mask.row(row), vertices);
          });
    Stencils result;
    result.columns = topology_->vertex_count();
    for (const Stencils& part : parts) {
        const std::int64_t before = result.begin.back();
        for (std::size_t row = 1; row < part.begin.size(); ++row)
            result.begin.push_back(before + part.begin[row]);
        result.index.insert(result.index.end(), part.index.begin(), part.index.end());
        result.weight.insert(result.weight.end(), part.weight.begin(), part.weight.end());
    }
    return result;
}

Location corner_location(const mesh::Topology& topology, mesh::CornerId c) {
    const mesh::FaceId f = topology.face(c);
    const int i = c.value - topology.corners(f)[0].value;
    if (topology.size(f) != 4) return {f, 0.0, 0.0, i};
    return {f, at_end_u(i) ? 1.0 : 0.0, at_end_v(i) ? 1.0 : 0.0, 0};
}

geom::Vec3 LimitEvaluator::position(const geom::Points& points, mesh::VertexId v) const {
    return position(points, corner_location(*topology_, topology_->corner(v)));
}

geom::Vec3 limit_position(const mesh::Cage& cage, mesh::VertexId v) {
    return LimitEvaluator(cage.topology).position(cage.points, v);
}

}  // namespace patchwright::subd
