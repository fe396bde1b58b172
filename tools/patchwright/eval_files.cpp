#include "eval_files.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>

#include <fmt/compile.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <iterator>

namespace patchwright::cli {

namespace {

using Text = fmt::memory_buffer;

// Lines that one task makes.
constexpr std::size_t chunk_lines = 4096;

/// The head, then the lines that `add(text, i)` makes.
template <class Add>
std::string lines_of(const std::string& head, std::size_t count, const Add& add) {
    std::vector<Text> chunks((count + chunk_lines - 1) / chunk_lines);
    base::parallel_for(count, chunk_lines, [&](std::size_t begin, std::size_t end) {
        Text& text = chunks[begin / chunk_lines];
        for (std::size_t i = begin; i < end; ++i) add(text, i);
    });
    std::size_t size = head.size();
    for (const Text& chunk : chunks) size += chunk.size();
    std::string all;
    all.reserve(size);
    all += head;
    for (const Text& chunk : chunks) all.append(chunk.data(), chunk.size());
    return all;
}

void add_point(Text& text, const geom::Vec3& p, char end) {
    fmt::format_to(std::back_inserter(text), FMT_COMPILE("{},{},{}{}"), p.x(), p.y(), p.z(), end);
}

std::string points_csv(const mesh::Cage& cage, const subd::LimitEvaluator& evaluator,
                       const subd::Locations& places) {
    const geom::Points rows = evaluator.evaluate(cage.points, places, 1);
    return lines_of("x,y,z,nx,ny,nz\n", places.size(), [&](Text& text, std::size_t i) {
        const auto r = static_cast<Eigen::Index>(3 * i);
        add_point(text, rows.row(r), ',');
        // Not normalized(): that keeps what is too short to tell a direction.
        const geom::Vec3 du = rows.row(r + 1), dv = rows.row(r + 2), normal = du.cross(dv);
        const double length = normal.norm();
        add_point(text, length > 0.0 ? geom::Vec3(normal / length) : geom::Vec3::Zero(), '\n');
    });
}

std::string matrix_market(const subd::Stencils& masks) {
    const std::string head = fmt::format(
        "%%MatrixMarket matrix coordinate real general\n"
        "% derivatives of limit points (rows) by control points (columns), the same for x, y, z\n"
        "{} {} {}\n",
        masks.rows(), masks.columns, masks.index.size());
    return lines_of(head, static_cast<std::size_t>(masks.rows()), [&](Text& text, std::size_t i) {
        for (auto k = masks.begin[i]; k < masks.begin[i + 1]; ++k) {
            const auto entry = static_cast<std::size_t>(k);
            fmt::format_to(std::back_inserter(text), FMT_COMPILE("{} {} {}\n"), i + 1,
                           masks.index[entry] + 1, masks.weight[entry]);
        }
    });
}

geom::Points read_gradient(const std::string& file, std::size_t places) {
    const Table table = read_table(file, 3, 3);
    if (table.rows() != places)
        throw base::InputError(fmt::format("{}: has {} rows for {} places; one a place is needed",
                                           file, table.rows(), places));
    return table.points(0);
}

std::string adjoint_csv(const subd::Stencils& masks, const geom::Points& gradient) {
    const geom::Points by_control_points = masks.transposed().apply(gradient);
    return lines_of("x,y,z\n", static_cast<std::size_t>(by_control_points.rows()),
                    [&](Text& text, std::size_t i) {
                        add_point(text, by_control_points.row(static_cast<Eigen::Index>(i)), '\n');
                    });
}

}  // namespace

std::string write_eval_files(Run& run, const mesh::Cage& cage,
                             const subd::LimitEvaluator& evaluator, const Places& places,
                             const EvalFiles& files) {
    const subd::Locations at = places.locations();
    std::string text;
    if (!files.output.empty()) {
        run.outputs.add(files.output, points_csv(cage, evaluator, at));
        text += fmt::format("{}: points and normals of {} places\n", files.output, at.size());
        run.end_stage("points");
    }
    if (files.jacobian.empty() && files.adjoint.empty()) return text;
    const subd::Stencils masks = evaluator.masks(at);
    if (!files.jacobian.empty()) {
        run.outputs.add(files.jacobian, matrix_market(masks));
        text += fmt::format("{}: {} rows, {} columns, {} entries\n", files.jacobian, masks.rows(),
                            masks.columns, masks.index.size());
    }
    if (!files.adjoint.empty()) {
        run.outputs.add(files.adjoint,
                        adjoint_csv(masks, read_gradient(files.gradient, at.size())));
        text += fmt::format("{}: derivatives by {} control points\n", files.adjoint, masks.columns);
    }
    run.end_stage("derivatives");
    return text;
}

}  // namespace patchwright::cli
