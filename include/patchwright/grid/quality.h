// How good the cells of a grid are.
#pragma once

#include <patchwright/grid/source.h>

#include <optional>

#pragma GCC visibility push(default)
namespace patchwright::grid {

/// A figure over many places: its mean, and the worst one with the place. Indices count from 0.
struct Spread {
    double worst = 0.0, mean = 0.0;
    std::int64_t count = 0;
    int block = -1, i = 0, j = 0, k = 0;
    geom::Vec3 at = geom::Vec3::Zero();
};

/// The cells around a corner of blocks where other than four edges meet.
struct VertexQuality {
    mesh::VertexId vertex;  ///< of the layout's cage
    int cells = 0;
    double min_angle_rad = 0.0, max_angle_rad = 0.0;  ///< at the vertex
    double size_ratio = 1.0;                          ///< largest area over smallest
    geom::Vec3 at = geom::Vec3::Zero();
};

/// Angles are radians; ratios are at least 1.
struct GridQuality {
    int blocks = 0, interfaces = 0;
    std::int64_t points = 0, cells = 0;
    Spread min_angle;   ///< smallest angle of a cell
    Spread skewness;    ///< equiangular: 0 right angles, 1 degenerate
    Spread aspect;      ///< longer over shorter of a cell's mean opposite sides
    Spread stretching;  ///< lengths of cells that follow each other on a line
    /// Angle off the right one between block edges and the lines that leave them.
    Spread orthogonality;
    /// Across block edges that are no creases: the angle by which lines turn, beyond what they do
    /// at the points beside it, and the ratio of cells' lengths.
    Spread turning, jump;
    std::int64_t folded = 0;  ///< cells with a corner that looks the other way
    std::vector<VertexQuality> extraordinary;
    /// Of volume grids: least of the Jacobians at a cell's corners over the product of their edges'
    /// lengths, and cells where it is not positive. Angles and skewness are then those of faces of
    /// constant k.
    std::optional<Spread> scaled_jacobian;
    std::int64_t negative = 0;
};

/// Per cell, i fastest.
struct CellFields {
    std::vector<float> min_angle_deg, skewness, aspect;
    std::vector<float> scaled_jacobian;  ///< of volume grids
};

/// Takes the blocks of a grid one by one, in order.
class QualityMeter {
  public:
    explicit QualityMeter(const BlockSource& grid);
    ~QualityMeter();
    QualityMeter(const QualityMeter&) = delete;
    QualityMeter& operator=(const QualityMeter&) = delete;

    /// @param fields  filled when given
    void add(int block, const BlockPoints& points, CellFields* fields = nullptr);
    /// @pre all blocks were added
    [[nodiscard]] GridQuality result() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Evaluates and measures all blocks.
GridQuality measure_quality(const BlockSource& grid);

}  // namespace patchwright::grid
#pragma GCC visibility pop
