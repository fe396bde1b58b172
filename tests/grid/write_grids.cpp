// Writes grids in all formats for the checks by other programs, which compare them with each other.
//
// Usage: write_grids FOLDER SAMPLES
#include "support/cages.h"

#include <patchwright/grid/layers.h>
#include <patchwright/grid/write.h>
#include <patchwright/mesh/obj.h>

#include <cstdio>
#include <filesystem>
#include <string>

namespace {

using namespace patchwright;
namespace fs = std::filesystem;

void write_all(const mesh::Cage& cage, const fs::path& folder, const std::string& name, bool join) {
    grid::BlockLayout layout = grid::make_layout(cage);
    if (join) layout = grid::join_all(layout);
    const double size = geom::bounding_box(cage.points).diagonal();
    const grid::PlanOptions options{.size_mm = size / 40.0,
                                    .levels = 1,
                                    .law = grid::Law::Tanh,
                                    .first_at_creases_mm = size / 2000.0};
    const grid::Plan plan = grid::make_plan(layout, options);
    const grid::SurfaceGrid source(plan);
    using Form = grid::Plot3dOptions::Form;
    grid::write_grid(source, folder / (name + ".cgns"));
    // From the start, to be compared with the first.
    grid::write_grid(grid::SurfaceGrid(grid::make_plan(layout, options)),
                     folder / (name + "_again.cgns"));
    grid::write_grid(source, folder / (name + ".vtm"));
    for (const auto form : {Form::Binary, Form::Fortran, Form::Ascii}) {
        for (const bool big : {false, true}) {
            if (form == Form::Ascii && big) continue;
            const std::string kind = form == Form::Ascii ? "ascii"
                                     : form == Form::Binary
                                         ? (big ? "binary_big" : "binary_little")
                                         : (big ? "fortran_big" : "fortran_little");
            grid::write_grid(source, folder / (name + "_" + kind + ".xyz"),
                             {.plot3d = {form, big}});
        }
    }
    // As large in metres.
    grid::write_grid(source, folder / (name + "_m.cgns"), {.unit = base::LengthUnit::Metre});
    // With layers on it.
    const grid::LayerGrid layers(plan, {.cells = 6, .first_mm = size * 1e-4});
    grid::write_grid(layers, folder / (name + "_layers.cgns"));
    grid::write_grid(layers, folder / (name + "_layers.vtm"));
    grid::write_grid(layers, folder / (name + "_layers_binary_little.xyz"));
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) return 1;
    const fs::path folder = argv[1], samples = argv[2];
    const auto sample = [&](const char* name) { return mesh::read_obj(samples / name).cage; };
    fs::create_directories(folder);
    write_all(test::cube(2.0), folder, "cube", false);
    write_all(test::torus(8, 6, 3.0, 1.0), folder, "torus", true);
    write_all(sample("wing/wing_cage.obj"), folder, "wing", false);
    write_all(sample("cages/genus2.obj"), folder, "genus2", true);
    write_all(sample("cages/dish.obj"), folder, "dish", false);
    return 0;
}
