#include "grid/cgns_file.h"
#include "grid/interfaces.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <limits>
#include <map>

namespace patchwright::grid {

namespace {

class CgnsWriter : public GridWriter {
  public:
    CgnsWriter(const BlockSource& grid, const base::PendingFile& file,
               const GridWriteOptions& options)
        : grid_(grid),
          dimension_(grid.layers() > 1 ? 3 : 2),
          file_(file, dimension_, options.unit) {
        check_sizes();
        // Families and zones are nodes of the base beside each other.
        CgnsNames names;
        write_families(names);
        for (const Block& block : grid.plan().layout.blocks) {
            zone_names_.push_back(names.make(block.name));
        }
        interfaces_ = find_interfaces(grid.plan());
    }

    void write(int block, const BlockData& data) override {
        mute_hdf5();
        const std::array<int, 3> size = grid_.size(block);
        std::array<cgsize_t, 9> sizes{};
        for (int d = 0; d < dimension_; ++d) {
            sizes[std::size_t(d)] = size[std::size_t(d)];
            sizes[std::size_t(dimension_ + d)] = size[std::size_t(d)] - 1;
        }
        int zone = 0;
        check(cg_zone_write(file_.handle(), file_.base(), zone_names_[std::size_t(block)].c_str(),
                            sizes.data(), CGNS_ENUMV(Structured), &zone));
        file_.write_coordinates(zone, data.points.coordinates);
        check(cg_goto(file_.handle(), file_.base(), "Zone_t", zone, "end"));
        check(cg_famname_write(family_of(block).c_str()));
        // Of volumes the layer on the surface.
        file_.write_places(zone, data.places, std::array<cgsize_t, 2>{size[0], size[1]});
        write_velocities(zone, data.velocities);
        write_connections(block, zone, size);
        write_conditions(block, zone, size);
    }

    void finish() override { file_.finish(grid_.block_count()); }

  private:
    void check(int status) const { file_.check(status); }
    void check_sizes() const {
        for (int b = 0; b < grid_.block_count(); ++b) {
            const auto [ni, nj, nk] = grid_.size(b);
            if (double(ni) * nj * nk > double(std::numeric_limits<std::int32_t>::max())) {
                throw base::UsageError(
                    fmt::format("{}: block {} has {} x {} x {} points, more than the CGNS library "
                                "counts; use smaller blocks",
                                file_.name().string(), b, ni, nj, nk));
            }
        }
    }
    const std::string& family_of(int block) const {
        return families_.at(grid_.plan().layout.blocks[std::size_t(block)].family);
    }
    void write_families(CgnsNames& names) {
        for (const Block& block : grid_.plan().layout.blocks) {
            if (families_.contains(block.family)) continue;
            const auto [node, family] = file_.write_family(names, block.family);
            families_[block.family] = node;
            if (dimension_ < 3) continue;
            int condition = 0;
            check(cg_fambc_write(file_.handle(), file_.base(), family, "FamBC", CGNS_ENUMV(BCWall),
                                 &condition));
        }
    }
    /// A range of the block, over all layers.
    std::array<cgsize_t, 6> range(const std::array<int, 2>& begin, const std::array<int, 2>& end,
                                  int layers) const {
        if (dimension_ == 2) return {begin[0] + 1, begin[1] + 1, end[0] + 1, end[1] + 1, 0, 0};
        return {begin[0] + 1, begin[1] + 1, 1, end[0] + 1, end[1] + 1, layers};
    }
    /// As the standard has it for grids that deform with time.
    void write_velocities(int zone, const BlockPoints& velocities) {
        if (velocities.count() == 0) return;
        int motion = 0;
        check(cg_arbitrary_motion_write(file_.handle(), file_.base(), zone, "Motion",
                                        CGNS_ENUMV(DeformingGrid), &motion));
        check(cg_goto(file_.handle(), file_.base(), "Zone_t", zone, "ArbitraryGridMotion_t", motion,
                      "end"));
        const cgsize_t sizes[] = {velocities.ni, velocities.nj};
        constexpr const char* names[] = {"GridVelocityX", "GridVelocityY", "GridVelocityZ"};
        for (std::size_t c = 0; c < 3; ++c)
            check(cg_array_write(names[c], CGNS_ENUMV(RealDouble), 2, sizes,
                                 velocities.coordinates[c].data()));
    }
    void write_connections(int block, int zone, const std::array<int, 3>& size) {
        int count = 0;
        for (const Interface& i : interfaces_.connections) {
            if (i.block != block) continue;
            const auto own = range(i.begin, i.end, size[2]);
            const auto donor = range(i.donor_begin, i.donor_end, size[2]);
            const int transform[3] = {i.transform[0], i.transform[1], 3};
            int number = 0;
            check(cg_1to1_write(file_.handle(), file_.base(), zone,
                                fmt::format("to {}", ++count).c_str(),
                                zone_names_[std::size_t(i.donor)].c_str(), own.data(), donor.data(),
                                transform, &number));
        }
    }
    void condition(int zone, const std::string& name, CGNS_ENUMT(BCType_t) type,
                   const std::array<cgsize_t, 6>& points, const std::string& family) {
        int number = 0;
        check(cg_boco_write(file_.handle(), file_.base(), zone, name.c_str(), type,
                            CGNS_ENUMV(PointRange), 2, points.data(), &number));
        if (family.empty()) return;
        check(cg_goto(file_.handle(), file_.base(), "Zone_t", zone, "ZoneBC_t", 1, "BC_t", number,
                      "end"));
        check(cg_famname_write(family.c_str()));
    }
    void write_conditions(int block, int zone, const std::array<int, 3>& size) {
        const auto [ni, nj, nk] = size;
        if (dimension_ == 3) {
            condition(zone, "wall", CGNS_ENUMV(FamilySpecified), {1, 1, 1, ni, nj, 1},
                      family_of(block));
            condition(zone, grid_.has_far_field() ? "far field" : "outer",
                      grid_.has_far_field() ? CGNS_ENUMV(BCFarfield) : CGNS_ENUMV(BCGeneral),
                      {1, 1, nk, ni, nj, nk}, "");
        }
        int count = 0;
        for (const FreeSide& side : interfaces_.free) {
            if (side.block != block) continue;
            condition(zone, fmt::format("free {}", ++count), CGNS_ENUMV(BCGeneral),
                      range(side.begin, side.end, nk), "");
        }
    }

    const BlockSource& grid_;
    int dimension_;
    CgnsFile file_;
    std::vector<std::string> zone_names_;
    std::map<std::string, std::string> families_;
    Interfaces interfaces_;
};

}  // namespace

std::unique_ptr<GridWriter> make_cgns_writer(const BlockSource& grid, base::PendingFile& file,
                                             const GridWriteOptions& options) {
    return std::make_unique<CgnsWriter>(grid, file, options);
}

}  // namespace patchwright::grid
