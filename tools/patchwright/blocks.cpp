#include "blocks.h"

#include "checks.h"
#include "options.h"

namespace patchwright::cli {

void add_block_options(CLI::App& command, BlockArguments& options) {
    command
        .add_option("--blocks", options.blocks,
                    "one for as many faces of one group as possible (groups), for as many faces "
                    "as possible (charts), or for each face (faces)")
        ->check(CLI::IsMember({"groups", "charts", "faces"}).description(""))
        ->capture_default_str();
    command.add_flag("--no-join", options.no_join,
                     "end blocks wherever a line out of a corner ends, so that each side meets one "
                     "other; else those of groups and charts that share a side are joined");
    command
        .add_option("--size", options.size,
                    "mean length of cells along block edges at most: 5mm, 0.2in, or 0.01rel "
                    "(of the cage's diagonal)")
        ->check(is_length());
    command.add_option("--points", options.points, "points along every block edge without --size")
        ->check(number_in(2, 1 << 20))
        ->capture_default_str();
}

grid::BlockLayout make_layout(const mesh::Cage& cage, const BlockArguments& options) {
    const grid::BlockLayout layout =
        grid::make_layout(cage, options.blocks == "faces"    ? grid::BlockCovering::Faces
                                : options.blocks == "charts" ? grid::BlockCovering::Charts
                                                             : grid::BlockCovering::Groups);
    return options.no_join || options.blocks == "faces" ? layout : grid::join_all(layout);
}

grid::PlanOptions plan_options(const BlockArguments& options, double diagonal_mm) {
    return {.size_mm = options.size.empty() ? 0.0 : length_mm(options.size, diagonal_mm),
            .cells = options.points - 1};
}

}  // namespace patchwright::cli
