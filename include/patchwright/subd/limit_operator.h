// Limit points of a whole mesh as a linear operator on its control points; stores no sparse matrix.
#pragma once

#include <patchwright/subd/limit_mask.h>

#include <span>
#include <vector>

namespace patchwright::subd {

/// Parameters at which a face is sampled, in order.
using ParameterSet = std::vector<Eigen::Vector2d>;

/// One face (or sector of a face that is no quad) sampled at one parameter set.
struct Site {
    mesh::FaceId face;
    int sector = 0;
    int set = 0;  ///< index into the parameter sets
};

/// The matrix M with one row a sample, M x = limit points, kept as one dense table for each kind of
/// neighbourhood and parameter set ("template") and the vertex numbers of each site. Belongs to a
/// topology; serves any points on it.
class LimitOperator {
  public:
    LimitOperator(const mesh::Topology& topology, std::vector<ParameterSet> sets,
                  std::span<const Site> sites);

    [[nodiscard]] int rows() const { return rows_; }
    [[nodiscard]] int columns() const { return columns_; }
    /// First row of each site; one more entry than sites.
    [[nodiscard]] const std::vector<std::int32_t>& site_rows() const { return site_rows_; }

    /// rows() x 3 = M x.  @pre x is columns() x 3
    void apply(const geom::Points& x, geom::Points& y) const;
    /// columns() x 3 = M^T y, the same to the last bit for any number of threads.  @pre y is rows()
    /// x 3
    void apply_transposed(const geom::Points& y, geom::Points& x) const;
    /// Directions du x dv (not unit) at all samples; zero where there is no tangent plane.
    [[nodiscard]] geom::Points normals(const geom::Points& x) const;

    [[nodiscard]] int template_count() const { return static_cast<int>(templates_.size()); }

  private:
    using Table = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    struct Template {
        Table position, du, dv;  // samples x slots
    };
    /// Consecutive sites that one task handles, and the range of vertices they touch.
    struct Chunk {
        std::size_t begin, end;
        std::int32_t first_vertex, last_vertex;
    };

    void gather(std::size_t site, const geom::Points& x, geom::Points& local) const;
    void build_chunks();

    int rows_ = 0;
    int columns_ = 0;
    std::vector<Template> templates_;
    std::vector<std::int32_t> site_template_;
    std::vector<std::int32_t> site_rows_;   // sites + 1
    std::vector<std::int64_t> slot_begin_;  // sites + 1
    std::vector<std::int32_t> slot_vertices_;
    std::vector<Chunk> chunks_;
};

}  // namespace patchwright::subd
