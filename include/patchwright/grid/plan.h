// How many points a grid has and where they lie on the edges of its blocks.
#pragma once

#include <patchwright/base/progress.h>
#include <patchwright/grid/layout.h>
#include <patchwright/grid/spacing.h>

#include <functional>
#include <optional>

#pragma GCC visibility push(default)
namespace patchwright::grid {

/// Millimetres that a cell shall be long at a point; positive.
using SizeFunction = std::function<double(const geom::Vec3& point)>;

/// What spreads the points of a line before the law does.
enum class Measure {
    ArcLength,
    Curvature  ///< arc length times sqrt(0.1 + curvature / its mean along the edge)
};

/// Size of the first cell off the border between blocks of two families; "" is any family.
struct BorderCluster {
    std::string family_a, family_b;
    double first_mm = 0.0;
};

/// What one edge, numbered as in the layout, gets instead of what the other options say.
struct EdgeRule {
    int edge = -1;
    std::optional<int> cells;  ///< for all edges that must match this one
    std::optional<Law> law;
    std::optional<double> first_mm, last_mm;  ///< along the edge's own direction; 0: free
    /// The law and the sizes hold at the corresponding ends of all edges that lines connect to this
    /// one, so that lines do not shear.
    bool connected = false;
};

struct PlanOptions {
    double size_mm = 0.0;  ///< mean length of cells on block edges at most; 0: by `cells`
    int cells = 16;        ///< along every edge where no size is given
    /// Numbers of cells are multiples of 2^levels, so that levels can be coarsened away.
    int levels = 0;
    Law law = Law::Uniform;
    Measure measure = Measure::ArcLength;
    double first_at_creases_mm = 0.0;     ///< first cell of lines that end on a crease; 0: free
    std::vector<BorderCluster> clusters;  ///< the smallest that applies counts
    std::vector<EdgeRule> rules;
    /// Cells as small as this asks for, everywhere on the lines of a block: refines whole lines.
    /// Used in place of size, cells and measure.
    SizeFunction size;
};

/// The points of one edge.
struct EdgePoints {
    /// Rising from 0 to the number of half-edges of the edge's run, whose k-th has [k, k + 1].
    std::vector<double> parameters;
    geom::Points points;     ///< one row a parameter
    double length_mm = 0.0;  ///< of the curve
    [[nodiscard]] int cells() const { return static_cast<int>(parameters.size()) - 1; }
};

/// A grid but for the points inside blocks.
struct Plan {
    BlockLayout layout;
    std::vector<EdgePoints> edges;
    /// Of a plan that was smoothed: per block the places on layout.cage of all its points, i
    /// fastest, those on its sides too; edges then hold their points and chords' lengths, and the
    /// parameters from before. Else empty: points are where the edges' parameters say.
    std::vector<std::vector<subd::Location>> moved;

    /// Points of a block along i and j.
    [[nodiscard]] std::array<int, 2> size(int block) const;
    [[nodiscard]] std::int64_t point_count() const;  ///< sum over blocks
    [[nodiscard]] std::int64_t cell_count() const;
};

/// Places the points of all edges by arc length along the limit curves; each is evaluated once.
/// @throw UsageError for families that do not exist, numbers of cells and rules that contradict
///        each other, and more points than memory holds; InvalidArgument for options out of range;
///        InputError for edges of no length
Plan make_plan(const BlockLayout& layout, const PlanOptions& options = {});

/// Every 2^levels-th point; of blocks' inner points as well.
/// @throw UsageError when numbers of cells are no multiples of that
Plan coarsened(const Plan& plan, int levels);

/// The same places on the given cage with other control points: for shapes that move, or with
/// velocities in place of points, whose limits are those of the surface.
/// @param points  one row a vertex of layout.given
/// @throw InvalidArgument when there are not as many
Plan with_points(const Plan& plan, const geom::Points& points);

struct RefineOptions {
    int max_rounds = 20;
    base::Progress progress;
};

/// Asked for on any thread: the error of the line from `a` to `b` that a grid has in place of the
/// surface; `middle` is the limit point halfway between them by parameters. The chord's error is
/// |middle - (a + b) / 2|.
using LineError =
    std::function<double(const geom::Vec3& a, const geom::Vec3& b, const geom::Vec3& middle)>;

/// Halves cells, along whole lines through all blocks that must match, until no cell's sides have
/// an error above the limit, or for so many rounds.
/// @throw InvalidArgument when the limit is not positive or the plan is smoothed, UsageError when
/// the grid would not fit
///        into memory, Cancelled
Plan refined(const Plan& plan, const LineError& error, double limit,
             const RefineOptions& options = {});

}  // namespace patchwright::grid
#pragma GCC visibility pop
