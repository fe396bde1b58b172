#include "places.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <cmath>

namespace patchwright::cli {

void Places::add(const subd::Location& at) {
    faces_.push_back(at.face.value);
    uv_.push_back(at.u);
    uv_.push_back(at.v);
    sectors_.push_back(at.sector);
}

void Places::read(const std::string& file, const mesh::Topology& topology) {
    const Table table = read_table(file, 3, 4);
    for (std::size_t i = 0; i < table.rows(); ++i) add(table, i, table.columns == 4, topology);
}

void Places::add(const Table& table, std::size_t i, bool has_sector,
                 const mesh::Topology& topology) {
    const double *row = table.row(i), face = row[0], sector = has_sector ? row[3] : 0.0;
    if (face != std::floor(face) || face < 0.0 || face >= topology.face_count())
        throw base::InputError(fmt::format("{}there is no face {}; the cage has 0 to {}",
                                           table.place(i), face, topology.face_count() - 1));
    const mesh::FaceId f{static_cast<std::int32_t>(face)};
    const int sectors = topology.size(f) == 4 ? 1 : topology.size(f);
    if (sector != std::floor(sector) || sector < 0.0 || sector >= sectors)
        throw base::InputError(fmt::format("{}face {} has no sector {}, only 0 to {}",
                                           table.place(i), face, sector, sectors - 1));
    if (row[1] < 0.0 || row[1] > 1.0 || row[2] < 0.0 || row[2] > 1.0)
        throw base::InputError(fmt::format("{}u and v are {} and {}; they lie from 0 to 1",
                                           table.place(i), row[1], row[2]));
    add({f, row[1], row[2], static_cast<int>(sector)});
}

void refuse_sectors(const std::string& cage, const mesh::Topology& topology,
                    const std::string& options) {
    if (topology.sectors().empty()) return;
    throw base::InputError(fmt::format(
        "{}: has tags of sectors, whose corrections are in no mask; take them out, or leave out {}",
        cage, options));
}

}  // namespace patchwright::cli
