#include "grid/cell_point.h"
#include "grid/limit_face.h"
#include "grid/moved_points.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/grid/evaluate.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace patchwright::grid {

using mesh::CornerId;

namespace {

/// What the four sides of a block say, in the block's own directions.
struct Frame {
    std::vector<double> low_i, high_i;  ///< along i on sides 0 and 2
    std::vector<double> low_j, high_j;  ///< along j on sides 3 and 1
    double columns = 0.0, rows = 0.0;

    [[nodiscard]] Eigen::Vector2d at(int i, int j) const {
        const auto m = std::size_t(i), n = std::size_t(j);
        const double a = low_i[m] / columns, b = high_i[m] / columns;
        const double c = low_j[n] / rows, d = high_j[n] / rows;
        const double u = (a + c * (b - a)) / (1.0 - (b - a) * (d - c));
        const double v = c + u * (d - c);
        return {u * columns, v * rows};
    }
};

/// Parameters and points of a side, counter-clockwise.
struct Side {
    std::vector<double> parameters;
    std::vector<geom::Vec3> points;
};

Side side_of(const Plan& plan, const Block& block, int number) {
    Side side;
    double begin = 0.0;
    for (const BlockEdgeUse& use : block.sides[std::size_t(number)]) {
        const EdgePoints& edge = plan.edges[std::size_t(use.edge)];
        const double length = edge.parameters.back();
        const std::size_t count = edge.parameters.size();
        for (std::size_t k = side.parameters.empty() ? 0 : 1; k < count; ++k) {
            const std::size_t at = use.reversed ? count - 1 - k : k;
            const double t = edge.parameters[at];
            side.parameters.push_back(begin + (use.reversed ? length - t : t));
            side.points.push_back(edge.points.row(Eigen::Index(at)).transpose());
        }
        begin += length;
    }
    return side;
}

std::vector<double> backwards(const std::vector<double>& parameters) {
    std::vector<double> result(parameters.rbegin(), parameters.rend());
    for (double& t : result) t = parameters.back() - t;
    return result;
}

Frame frame_of(const Block& block, const std::array<Side, 4>& sides) {
    return {sides[0].parameters, backwards(sides[2].parameters), backwards(sides[3].parameters),
            sides[1].parameters, double(block.columns),          double(block.rows)};
}

/// @throw InvalidArgument for plans whose points are not where these say
void require_parameters(const Plan& plan) {
    if (!plan.moved.empty())
        throw base::InvalidArgument("points of a smoothed grid have places, no block parameters");
}

std::array<Side, 4> sides_of(const Plan& plan, const Block& block) {
    return {side_of(plan, block, 0), side_of(plan, block, 1), side_of(plan, block, 2),
            side_of(plan, block, 3)};
}

/// The faces of a block, made as points ask for them.
class BlockFaces {
  public:
    BlockFaces(subd::RingTable& table, const mesh::Cage& cage, const Block& block)
        : table_(table), cage_(cage), block_(block), faces_(block.cells.size()) {}

    /// @param at  in [0, columns] and [0, rows]
    geom::Vec3 point(const Eigen::Vector2d& at) {
        const CellPoint p = cell_point(block_, at);
        const subd::Location place = place_in_face(*cage_.topology, p.cell, p.i, p.j);
        auto& face = faces_[p.number];
        if (!face) face = std::make_unique<LimitFace>(table_, cage_, place.face);
        return face->at(place.u, place.v);
    }

  private:
    subd::RingTable& table_;
    const mesh::Cage& cage_;
    const Block& block_;
    std::vector<std::unique_ptr<LimitFace>> faces_;
};

/// Points that are evaluated by one task: enough to make up for the pieces that it builds.
constexpr int points_a_task = 8192;

}  // namespace

struct BlockEvaluator::State {
    mutable subd::RingTable table;
};

BlockEvaluator::BlockEvaluator(const Plan& plan) : plan_(plan), state_(std::make_unique<State>()) {}
BlockEvaluator::~BlockEvaluator() = default;

Eigen::Vector2d BlockEvaluator::parameters(int block, int i, int j) const {
    require_parameters(plan_);
    const Block& b = plan_.layout.blocks.at(std::size_t(block));
    return frame_of(b, sides_of(plan_, b)).at(i, j);
}

std::vector<Eigen::Vector2d> BlockEvaluator::parameters(int block) const {
    require_parameters(plan_);
    const Block& b = plan_.layout.blocks.at(std::size_t(block));
    const Frame frame = frame_of(b, sides_of(plan_, b));
    std::vector<Eigen::Vector2d> all;
    all.reserve(frame.low_i.size() * frame.low_j.size());
    for (int j = 0; j < int(frame.low_j.size()); ++j)
        for (int i = 0; i < int(frame.low_i.size()); ++i) all.push_back(frame.at(i, j));
    return all;
}

BlockPoints BlockEvaluator::evaluate(int block) const {
    BlockPoints points;
    evaluate(block, points);
    return points;
}

void BlockEvaluator::places(int number, BlockPlaces& places) const {
    const Block& block = plan_.layout.blocks.at(std::size_t(number));
    const bool moved = !plan_.moved.empty();
    const Frame frame = moved ? Frame{} : frame_of(block, sides_of(plan_, block));
    const auto [columns, rows] = plan_.size(number);
    const std::size_t ni = std::size_t(columns), count = ni * std::size_t(rows);
    const bool with_sectors = !plan_.layout.given->all_quads();
    places.faces.resize(count);
    places.u.resize(count);
    places.v.resize(count);
    places.sectors.resize(with_sectors ? count : 0);
    base::parallel_for(count, points_a_task, [&](std::size_t first, std::size_t last) {
        for (std::size_t n = first; n < last; ++n) {
            const CellPoint p =
                moved ? cell_point(*plan_.layout.cage.topology, plan_.moved[std::size_t(number)][n])
                      : cell_point(block, frame.at(int(n % ni), int(n / ni)));
            const subd::Location place = place_on_given(plan_.layout, p.cell, p.i, p.j);
            places.faces[n] = place.face.value;
            places.u[n] = place.u;
            places.v[n] = place.v;
            if (with_sectors) places.sectors[n] = place.sector;
        }
    });
}

void BlockEvaluator::evaluate(int number, BlockPoints& points) const {
    if (number < 0 || number >= static_cast<int>(plan_.layout.blocks.size())) {
        throw base::InvalidArgument(fmt::format("block {} does not exist; there are {}", number,
                                                plan_.layout.blocks.size()));
    }
    if (!plan_.moved.empty()) {
        evaluate_moved(plan_, number, state_->table, points);
        return;
    }
    const Block& block = plan_.layout.blocks[std::size_t(number)];
    const std::array<Side, 4> sides = sides_of(plan_, block);
    const Frame frame = frame_of(block, sides);
    points.ni = static_cast<int>(sides[0].points.size());
    points.nj = static_cast<int>(sides[1].points.size());
    points.nk = 1;
    for (auto& c : points.coordinates) c.resize(points.count());

    const int inner_i = points.ni - 2, inner_j = points.nj - 2;
    // Rectangles of points, as square as they go: neighbours lie on the same faces.
    const int step_i =
        std::min(std::max(inner_i, 1), 4 * static_cast<int>(std::sqrt(points_a_task)));
    const int step_j = std::max(1, points_a_task / step_i);
    const int tiles_i = (inner_i + step_i - 1) / step_i, tiles_j = (inner_j + step_j - 1) / step_j;
    const auto evaluate_tile = [&](int i0, int j0) {
        BlockFaces faces(state_->table, plan_.layout.cage, block);
        for (int j = j0; j < std::min(j0 + step_j, points.nj - 1); ++j)
            for (int i = i0; i < std::min(i0 + step_i, points.ni - 1); ++i)
                points.set(points.index(i, j), faces.point(frame.at(i, j)));
    };
    base::parallel_for(
        std::size_t(tiles_i) * std::size_t(tiles_j), 1, [&](std::size_t first, std::size_t last) {
            for (std::size_t tile = first; tile < last; ++tile)
                evaluate_tile(1 + int(tile) % tiles_i * step_i, 1 + int(tile) / tiles_i * step_j);
        });
    for (int i = 0; i < points.ni; ++i) {
        points.set(points.index(i, 0), sides[0].points[std::size_t(i)]);
        points.set(points.index(points.ni - 1 - i, points.nj - 1), sides[2].points[std::size_t(i)]);
    }
    for (int j = 0; j < points.nj; ++j) {
        points.set(points.index(points.ni - 1, j), sides[1].points[std::size_t(j)]);
        points.set(points.index(0, points.nj - 1 - j), sides[3].points[std::size_t(j)]);
    }
}

}  // namespace patchwright::grid
