#include "adapt/write_local.h"
#include "grid/cgns_file.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <limits>

namespace patchwright::adapt {

namespace {

/// One zone, whose points all families share.
class Writer {
  public:
    Writer(const LocalFile& content, base::PendingFile& file)
        : content_(content), file_(file, 2, content.options.unit) {}

    void write() {
        grid::mute_hdf5();
        const LocalGrid& grid = content_.grid;
        if (double(grid.points.rows()) > double(std::numeric_limits<std::int32_t>::max()))
            throw base::UsageError(
                fmt::format("{}: {} points are more than the CGNS library counts",
                            file_.name().string(), grid.points.rows()));
        std::vector<Family> families = families_in_order();
        const auto points = cgsize_t(grid.points.rows());
        const cgsize_t sizes[] = {points, cgsize_t(grid.cells.size()), 0};
        check(cg_zone_write(file_.handle(), file_.base(), names_.make("grid").c_str(), sizes,
                            CGNS_ENUMV(Unstructured), &zone_));
        file_.write_coordinates(zone_, content_.coordinates);
        for (const Family& family : families) write_cells(family);
        if (!grid.free_sides.empty()) write_free_sides();
        file_.write_places(zone_, grid.places, std::array<cgsize_t, 1>{points});
        file_.finish(1);
    }

  private:
    /// Cells of content_.order that follow each other.
    struct Family {
        std::string name;
        std::size_t begin = 0, end = 0;
    };

    void check(int status) const { file_.check(status); }

    std::vector<Family> families_in_order() {
        std::vector<Family> families;
        std::string last;
        for (std::size_t n = 0; n < content_.order.size(); ++n) {
            const LocalCell& cell = content_.grid.cells[std::size_t(content_.order[n])];
            const std::string& name = content_.grid.block_families[std::size_t(cell.block)];
            if (families.empty() || name != last) {
                families.push_back({file_.write_family(names_, name).first, n, n});
                last = name;
            }
            families.back().end = n + 1;
        }
        return families;
    }

    /// In a section of the family's name: elements have no families of their own.
    void write_cells(const Family& family) {
        std::vector<std::int32_t> corners;
        std::vector<cgsize_t> nodes, offsets{0};
        for (std::size_t n = family.begin; n < family.end; ++n) {
            corners.clear();
            content_.add_corners(content_.order[n], corners);
            for (const std::int32_t corner : corners) nodes.push_back(corner + 1);
            offsets.push_back(cgsize_t(nodes.size()));
        }
        int section = 0;
        const auto first = cgsize_t(family.begin + 1), last = cgsize_t(family.end);
        if (content_.options.cells == LocalCells::Quads)
            check(cg_section_write(file_.handle(), file_.base(), zone_, family.name.c_str(),
                                   CGNS_ENUMV(QUAD_4), first, last, 0, nodes.data(), &section));
        else
            check(cg_poly_section_write(file_.handle(), file_.base(), zone_, family.name.c_str(),
                                        CGNS_ENUMV(NGON_n), first, last, 0, nodes.data(),
                                        offsets.data(), &section));
    }

    void write_free_sides() {
        std::vector<cgsize_t> nodes;
        for (const auto& [a, b] : content_.grid.free_sides)
            nodes.insert(nodes.end(), {cgsize_t(a) + 1, cgsize_t(b) + 1});
        const auto first = cgsize_t(content_.grid.cells.size() + 1),
                   last = first + cgsize_t(content_.grid.free_sides.size()) - 1;
        int number = 0;
        check(cg_section_write(file_.handle(), file_.base(), zone_, names_.make("free").c_str(),
                               CGNS_ENUMV(BAR_2), first, last, 0, nodes.data(), &number));
        const cgsize_t range[] = {first, last};
        check(cg_boco_write(file_.handle(), file_.base(), zone_, "free", CGNS_ENUMV(BCGeneral),
                            CGNS_ENUMV(PointRange), 2, range, &number));
        check(cg_boco_gridlocation_write(file_.handle(), file_.base(), zone_, number,
                                         CGNS_ENUMV(EdgeCenter)));
    }

    const LocalFile& content_;
    grid::CgnsFile file_;
    grid::CgnsNames names_;
    int zone_ = 0;
};

}  // namespace

void write_local_cgns(const LocalFile& content, base::PendingFile& file) {
    Writer(content, file).write();
}

}  // namespace patchwright::adapt
