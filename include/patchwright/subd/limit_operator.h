// Limit points of a whole mesh as a linear operator on its control points; stores no sparse matrix.
#pragma once

#include <patchwright/subd/limit_mask.h>

#include <functional>
#include <memory>
#include <span>
#include <vector>

#pragma GCC visibility push(default)
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

    /// Rows that follow each other.
    using Rows = Eigen::Map<geom::Points>;
    /// Calls `visit(first site, end, rows of M x, their normals)` for a few consecutive sites at a
    /// time, in any order and on any thread: for work that needs the rows only once, which it may
    /// overwrite. Normals are those of normals(), or no rows where these are not available.
    using SiteVisit =
        std::function<void(std::size_t first, std::size_t end, Rows rows, Rows normals)>;
    void visit_sites(const geom::Points& x, const SiteVisit& visit) const;
    /// Normals du x dv at all samples, not of unit length: their length is the Jacobian of the
    /// face's parametrisation. Zero where there is no tangent plane.
    /// @pre made with SampleRows::PointsAndTangents
    [[nodiscard]] geom::Points normals(const geom::Points& x) const;

    [[nodiscard]] int template_count() const;
    /// Memory held, without the templates and in them.
    [[nodiscard]] std::size_t site_bytes() const;
    [[nodiscard]] std::size_t template_bytes() const;

  private:
    friend class SolverProducts;

    struct Template;
    /// Consecutive sites that one task handles.
    struct Chunk {
        std::size_t begin, end;
        std::vector<std::int32_t> slot_vertices;  // site after site
    };

    void colour_chunks();
    /// Normals of a run of sites; `dv` is a buffer.
    void run_normals(const Template& t, std::size_t begin, std::size_t end,
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
#pragma GCC visibility pop
