// Limit points of a whole mesh as a linear operator on its control points; stores no sparse matrix.
#pragma once

#include <patchwright/subd/limit_mask.h>

#include <functional>
#include <memory>
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

/// What an operator's rows are.
enum class SampleRows {
    Points,             ///< one a sample: the limit point
    PointsAndTangents,  ///< the same; normals() are wanted too
    /// Three a sample: second derivatives uu, sqrt(2) uv and vv, so that sums of squares are the
    /// thin-plate energy over the unit square.
    Bending
};

/// The matrix M with one row a sample, M x = limit points, kept as one dense table for each kind of
/// neighbourhood and parameter set ("template") and the vertex numbers of each site: 72 bytes for a
/// regular face. Belongs to a topology; serves any points on it. Thread-safe; products allocate
/// nothing for a face or a sample and are the same to the last bit for any number of threads.
/// Fastest when sites that follow each other are neighbours and vertices are numbered likewise.
class LimitOperator {
  public:
    /// @throw InvalidArgument when a site names what does not exist or rows do not fit 31 bits
    LimitOperator(const mesh::Topology& topology, const std::vector<ParameterSet>& sets,
                  std::span<const Site> sites, SampleRows rows = SampleRows::Points);
    ~LimitOperator();
    LimitOperator(LimitOperator&&) noexcept;
    LimitOperator& operator=(LimitOperator&&) noexcept;

    [[nodiscard]] int rows() const { return site_rows_.back(); }
    [[nodiscard]] int columns() const { return columns_; }
    /// First row of each site; one more entry than sites.
    [[nodiscard]] const std::vector<std::int32_t>& site_rows() const { return site_rows_; }

    /// rows() x 3 = M x.  @pre x is columns() x 3
    void apply(const geom::Points& x, geom::Points& y) const;
    /// columns() x 3 = M^T y.  @pre y is rows() x 3
    void apply_transposed(const geom::Points& y, geom::Points& x) const;

    /// t = M^T M x in one sweep, limit points being kept nowhere; returns the squared norm of each
    /// column of M x.
    Eigen::Array3d normal_product(const geom::Points& x, geom::Points& t) const;

    /// Rows of M x that are visited together: they follow each other from `first`.
    using Rows = Eigen::Map<geom::Points>;
    using RowVisit = std::function<Eigen::Array3d(Eigen::Index first, Rows rows)>;
    /// The same with `visit` called for all rows of M x, a few at a time, which it may change
    /// before they are multiplied with M^T.
    /// @return the sum of what the visits return
    Eigen::Array3d normal_product(const geom::Points& x, geom::Points& t,
                                  const RowVisit& visit) const;
    /// Calls `visit(first site, end, rows of M x, directions du x dv)` for some sites that follow
    /// each other at a time, in any order and on any thread: for work that needs them only once.
    /// There are directions when made with SampleRows::PointsAndTangents, else no rows of them.
    using SiteVisit =
        std::function<void(std::size_t first, std::size_t end, Rows rows, Rows directions)>;
    void visit_sites(const geom::Points& x, const SiteVisit& visit) const;
    /// Directions du x dv (not unit) at all samples; zero where there is no tangent plane.
    /// @pre made with SampleRows::PointsAndTangents
    [[nodiscard]] geom::Points normals(const geom::Points& x) const;

    /// Sums of the squares of each column: the diagonal of M^T M, or of M^T W M.
    /// @param weights  W's diagonal, one number a site; empty: ones
    [[nodiscard]] Eigen::VectorXd column_squares(const Eigen::VectorXd& weights = {}) const;

    /// x = (M with each entry squared)^T y, columns() x 3: the diagonals of M^T diag(y_c) M.
    /// @pre y is rows() x 3
    void apply_squares_transposed(const geom::Points& y, geom::Points& x) const;

    [[nodiscard]] int template_count() const;
    /// Memory held, templates apart and in them.
    [[nodiscard]] std::size_t site_bytes() const;
    [[nodiscard]] std::size_t template_bytes() const;

  private:
    struct Template;
    /// Consecutive sites that one task handles.
    struct Chunk {
        std::size_t begin, end;
        std::vector<std::int32_t> slot_vertices;  // site after site
    };

    void colour_chunks();
    /// Directions du x dv of a run of sites; `dv` is a buffer.
    void directions(const Template& t, std::size_t begin, std::size_t end,
                    const std::int32_t* vertices, const geom::Points& x, geom::Points& dv,
                    Rows to) const;
    /// Calls `visit(template, first site, end, their slots' vertices)` for runs of equal sites.
    template <class Visit>
    void for_runs(const Chunk& chunk, const Visit& visit) const;
    /// Calls `visit(chunk)` for all chunks so that those that share vertices take turns.
    template <class VisitChunk>
    void by_colour(const VisitChunk& visit) const;

    int columns_ = 0;
    std::vector<Template> templates_;
    std::vector<std::int32_t> site_template_;
    std::vector<std::int32_t> site_rows_{0};  // sites + 1
    std::vector<Chunk> chunks_;
    // Chunks of one colour have no vertex in common: they add to a sum at the same time.
    std::vector<std::vector<std::int32_t>> colours_;
};

}  // namespace patchwright::subd
