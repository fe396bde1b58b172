#include "grid/interfaces.h"
#include "grid/writer.h"

#include <patchwright/base/error.h>
#include <patchwright/base/output_set.h>

#include <cgnslib.h>
#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <map>
#include <set>

namespace patchwright::grid {

namespace {

constexpr std::size_t longest_name = 32;

/// Names of CGNS nodes: up to 32 characters, no slash, different from each other.
class Names {
  public:
    std::string make(std::string name) {
        for (char& c : name) {
            if (c == '/' || static_cast<unsigned char>(c) < 32) c = '_';
        }
        if (name.empty() || name == "." || name == "..") name = "_";
        std::string result = name.substr(0, longest_name);
        for (int k = 2; !used_.insert(result).second; ++k) {
            const std::string number = fmt::format(" {}", k);
            result = name.substr(0, longest_name - number.size()) + number;
        }
        return result;
    }

  private:
    std::set<std::string> used_{"DataClass", "DimensionalUnits"};  ///< nodes of the base as well
};

CGNS_ENUMT(LengthUnits_t) cgns_unit(base::LengthUnit unit) {
    switch (unit) {
        case base::LengthUnit::Millimetre: return CGNS_ENUMV(Millimeter);
        case base::LengthUnit::Centimetre: return CGNS_ENUMV(Centimeter);
        case base::LengthUnit::Metre: return CGNS_ENUMV(Meter);
        case base::LengthUnit::Inch: return CGNS_ENUMV(Inch);
        default: return CGNS_ENUMV(Foot);
    }
}

/// HDF5 prints its own errors, in each thread anew, unless told not to; CGNS has no call for that.
void mute_hdf5() {
    using SetAuto = int (*)(std::int64_t, void*, void*);
    static const auto set_auto = reinterpret_cast<SetAuto>(::dlsym(RTLD_DEFAULT, "H5Eset_auto2"));
    if (set_auto != nullptr) set_auto(0, nullptr, nullptr);
}

/// Source: CGNS standard interface data structures, version 3.4; index ranges count from 1.
class CgnsWriter : public GridWriter {
  public:
    CgnsWriter(const BlockSource& grid, const base::PendingFile& file,
               const GridWriteOptions& options)
        : grid_(grid),
          file_(file.target().given),
          pending_(file.path()),
          dimension_(grid.layers() > 1 ? 3 : 2) {
        check_sizes();
        mute_hdf5();
        check(cg_set_file_type(CG_FILE_HDF5));
        check(cg_open(pending_.c_str(), CG_MODE_WRITE, &handle_));
        open_ = true;
        check(cg_base_write(handle_, "Base", dimension_, 3, &base_));
        check(cg_goto(handle_, base_, "end"));
        check(cg_dataclass_write(CGNS_ENUMV(Dimensional)));
        check(cg_units_write(CGNS_ENUMV(MassUnitsNull), cgns_unit(options.unit),
                             CGNS_ENUMV(TimeUnitsNull), CGNS_ENUMV(TemperatureUnitsNull),
                             CGNS_ENUMV(AngleUnitsNull)));
        // Families and zones are nodes of the base beside each other.
        Names names;
        write_families(names);
        for (const Block& block : grid.plan().layout.blocks) {
            zone_names_.push_back(names.make(block.name));
        }
        interfaces_ = find_interfaces(grid.plan());
    }
    ~CgnsWriter() override {
        if (open_) cg_close(handle_);
    }
    CgnsWriter(const CgnsWriter&) = delete;
    CgnsWriter& operator=(const CgnsWriter&) = delete;

    void write(int block, const BlockData& data) override {
        mute_hdf5();
        const std::array<int, 3> size = grid_.size(block);
        std::array<cgsize_t, 9> sizes{};
        for (int d = 0; d < dimension_; ++d) {
            sizes[std::size_t(d)] = size[std::size_t(d)];
            sizes[std::size_t(dimension_ + d)] = size[std::size_t(d)] - 1;
        }
        int zone = 0;
        check(cg_zone_write(handle_, base_, zone_names_[std::size_t(block)].c_str(), sizes.data(),
                            CGNS_ENUMV(Structured), &zone));
        constexpr const char* names[] = {"CoordinateX", "CoordinateY", "CoordinateZ"};
        for (std::size_t c = 0; c < 3; ++c) {
            int coordinate = 0;
            check(cg_coord_write(handle_, base_, zone, CGNS_ENUMV(RealDouble), names[c],
                                 data.points.coordinates[c].data(), &coordinate));
            check(cg_goto(handle_, base_, "Zone_t", zone, "GridCoordinates_t", 1, "DataArray_t",
                          coordinate, "end"));
            // Of mass, length, time, temperature and angle.
            constexpr float exponents[] = {0.0f, 1.0f, 0.0f, 0.0f, 0.0f};
            check(cg_exponents_write(CGNS_ENUMV(RealSingle), exponents));
        }
        check(cg_goto(handle_, base_, "Zone_t", zone, "end"));
        check(cg_famname_write(family_of(block).c_str()));
        write_places(zone, data.places, size);
        write_velocities(zone, data.velocities);
        write_connections(block, zone, size);
        write_conditions(block, zone, size);
    }

    void finish() override {
        close();
        check(cg_open(pending_.c_str(), CG_MODE_READ, &handle_));
        open_ = true;
        int zones = 0;
        check(cg_nzones(handle_, 1, &zones));
        close();
        if (zones != grid_.block_count())
            throw base::OutputError(fmt::format("{}: has {} of {} blocks when it is read back",
                                                file_.string(), zones, grid_.block_count()));
    }

  private:
    void close() {
        open_ = false;
        check(cg_close(handle_));
    }
    void check(int status) const {
        if (status == CG_OK) return;
        throw base::OutputError(
            fmt::format("{}: cannot be written: {}", file_.string(), cg_get_error()));
    }
    void check_sizes() const {
        for (int b = 0; b < grid_.block_count(); ++b) {
            const auto [ni, nj, nk] = grid_.size(b);
            if (double(ni) * nj * nk > double(std::numeric_limits<std::int32_t>::max())) {
                throw base::UsageError(
                    fmt::format("{}: block {} has {} x {} x {} points, more than the CGNS library "
                                "counts; use smaller blocks",
                                file_.string(), b, ni, nj, nk));
            }
        }
    }
    const std::string& family_of(int block) const {
        return families_.at(grid_.plan().layout.blocks[std::size_t(block)].family);
    }
    void write_families(Names& names) {
        const auto add = [&](const std::string& name) {
            int family = 0;
            const std::string node = names.make(name);
            check(cg_family_write(handle_, base_, node.c_str(), &family));
            return std::pair{node, family};
        };
        for (const Block& block : grid_.plan().layout.blocks) {
            if (families_.contains(block.family)) continue;
            const auto [node, family] = add(block.family);
            families_[block.family] = node;
            if (dimension_ < 3) continue;
            int condition = 0;
            check(cg_fambc_write(handle_, base_, family, "FamBC", CGNS_ENUMV(BCWall), &condition));
        }
    }
    /// A range of the block, over all layers.
    std::array<cgsize_t, 6> range(const std::array<int, 2>& begin, const std::array<int, 2>& end,
                                  int layers) const {
        if (dimension_ == 2) return {begin[0] + 1, begin[1] + 1, end[0] + 1, end[1] + 1, 0, 0};
        return {begin[0] + 1, begin[1] + 1, 1, end[0] + 1, end[1] + 1, layers};
    }
    /// As the user's data, for which the standard has no names; of volumes the layer on the
    /// surface.
    void write_places(int zone, const BlockPlaces& places, const std::array<int, 3>& size) {
        check(cg_goto(handle_, base_, "Zone_t", zone, "end"));
        check(cg_user_data_write("CagePlaces"));
        check(cg_goto(handle_, base_, "Zone_t", zone, "UserDefinedData_t", 1, "end"));
        check(cg_dataclass_write(CGNS_ENUMV(NondimensionalParameter)));
        const cgsize_t sizes[] = {size[0], size[1]};
        const auto write = [&](const char* name, CGNS_ENUMT(DataType_t) type, const void* values) {
            check(cg_array_write(name, type, 2, sizes, values));
        };
        write("Face", CGNS_ENUMV(Integer), places.faces.data());
        write("U", CGNS_ENUMV(RealDouble), places.u.data());
        write("V", CGNS_ENUMV(RealDouble), places.v.data());
        if (!places.sectors.empty()) write("Sector", CGNS_ENUMV(Integer), places.sectors.data());
    }
    /// As the standard has it for grids that deform with time.
    void write_velocities(int zone, const BlockPoints& velocities) {
        if (velocities.count() == 0) return;
        int motion = 0;
        check(cg_arbitrary_motion_write(handle_, base_, zone, "Motion", CGNS_ENUMV(DeformingGrid),
                                        &motion));
        check(cg_goto(handle_, base_, "Zone_t", zone, "ArbitraryGridMotion_t", motion, "end"));
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
            check(cg_1to1_write(handle_, base_, zone, fmt::format("to {}", ++count).c_str(),
                                zone_names_[std::size_t(i.donor)].c_str(), own.data(), donor.data(),
                                transform, &number));
        }
    }
    void condition(int zone, const std::string& name, CGNS_ENUMT(BCType_t) type,
                   const std::array<cgsize_t, 6>& points, const std::string& family) {
        int number = 0;
        check(cg_boco_write(handle_, base_, zone, name.c_str(), type, CGNS_ENUMV(PointRange), 2,
                            points.data(), &number));
        if (family.empty()) return;
        check(cg_goto(handle_, base_, "Zone_t", zone, "ZoneBC_t", 1, "BC_t", number, "end"));
        check(cg_famname_write(family.c_str()));
    }
    void write_conditions(int block, int zone, const std::array<int, 3>& size) {
        const auto [ni, nj, nk] = size;
        if (dimension_ == 3) {
            condition(zone, "wall", CGNS_ENUMV(FamilySpecified), {1, 1, 1, ni, nj, 1},
                      family_of(block));
            condition(zone, "outer", CGNS_ENUMV(BCGeneral), {1, 1, nk, ni, nj, nk}, "");
        }
        int count = 0;
        for (const FreeSide& side : interfaces_.free) {
            if (side.block != block) continue;
            condition(zone, fmt::format("free {}", ++count), CGNS_ENUMV(BCGeneral),
                      range(side.begin, side.end, nk), "");
        }
    }

    const BlockSource& grid_;
    std::filesystem::path file_;
    std::filesystem::path pending_;
    int dimension_;
    int handle_ = 0, base_ = 0;
    bool open_ = false;
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
