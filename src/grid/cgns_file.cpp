#include "grid/cgns_file.h"

#include <patchwright/base/error.h>

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdint>

namespace patchwright::grid {

namespace {

constexpr std::size_t longest_name = 32;

CGNS_ENUMT(LengthUnits_t) cgns_unit(base::LengthUnit unit) {
    switch (unit) {
        case base::LengthUnit::Millimetre: return CGNS_ENUMV(Millimeter);
        case base::LengthUnit::Centimetre: return CGNS_ENUMV(Centimeter);
        case base::LengthUnit::Metre: return CGNS_ENUMV(Meter);
        case base::LengthUnit::Inch: return CGNS_ENUMV(Inch);
        default: return CGNS_ENUMV(Foot);
    }
}

}  // namespace

std::string CgnsNames::make(std::string name) {
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

void mute_hdf5() {
    using SetAuto = int (*)(std::int64_t, void*, void*);
    static const auto set_auto = reinterpret_cast<SetAuto>(::dlsym(RTLD_DEFAULT, "H5Eset_auto2"));
    if (set_auto != nullptr) set_auto(0, nullptr, nullptr);
}

CgnsFile::CgnsFile(const base::PendingFile& file, int dimension, base::LengthUnit unit)
    : name_(file.target().given), pending_(file.path()) {
    mute_hdf5();
    check(cg_set_file_type(CG_FILE_HDF5));
    check(cg_open(pending_.c_str(), CG_MODE_WRITE, &handle_));
    open_ = true;
    try {
        check(cg_base_write(handle_, "Base", dimension, 3, &base_));
        check(cg_goto(handle_, base_, "end"));
        check(cg_dataclass_write(CGNS_ENUMV(Dimensional)));
        check(cg_units_write(CGNS_ENUMV(MassUnitsNull), cgns_unit(unit), CGNS_ENUMV(TimeUnitsNull),
                             CGNS_ENUMV(TemperatureUnitsNull), CGNS_ENUMV(AngleUnitsNull)));
    } catch (...) {
        cg_close(handle_);
        throw;
    }
}

CgnsFile::~CgnsFile() {
    if (open_) cg_close(handle_);
}

void CgnsFile::check(int status) const {
    if (status == CG_OK) return;
    throw base::OutputError(
        fmt::format("{}: cannot be written: {}", name_.string(), cg_get_error()));
}

std::pair<std::string, int> CgnsFile::write_family(CgnsNames& names, const std::string& family) {
    int number = 0;
    const std::string node = names.make(family);
    check(cg_family_write(handle_, base_, node.c_str(), &number));
    return {node, number};
}

void CgnsFile::write_coordinates(int zone, const std::array<std::vector<double>, 3>& coordinates) {
    constexpr const char* names[] = {"CoordinateX", "CoordinateY", "CoordinateZ"};
    for (std::size_t c = 0; c < 3; ++c) {
        int coordinate = 0;
        check(cg_coord_write(handle_, base_, zone, CGNS_ENUMV(RealDouble), names[c],
                             coordinates[c].data(), &coordinate));
        check(cg_goto(handle_, base_, "Zone_t", zone, "GridCoordinates_t", 1, "DataArray_t",
                      coordinate, "end"));
        // Of mass, length, time, temperature and angle.
        constexpr float exponents[] = {0.0f, 1.0f, 0.0f, 0.0f, 0.0f};
        check(cg_exponents_write(CGNS_ENUMV(RealSingle), exponents));
    }
}

void CgnsFile::write_places(int zone, const BlockPlaces& places, std::span<const cgsize_t> sizes) {
    check(cg_goto(handle_, base_, "Zone_t", zone, "end"));
    check(cg_user_data_write("CagePlaces"));
    check(cg_goto(handle_, base_, "Zone_t", zone, "UserDefinedData_t", 1, "end"));
    check(cg_dataclass_write(CGNS_ENUMV(NondimensionalParameter)));
    const auto write = [&](const char* name, CGNS_ENUMT(DataType_t) type, const void* values) {
        check(cg_array_write(name, type, int(sizes.size()), sizes.data(), values));
    };
    write("Face", CGNS_ENUMV(Integer), places.faces.data());
    write("U", CGNS_ENUMV(RealDouble), places.u.data());
    write("V", CGNS_ENUMV(RealDouble), places.v.data());
    if (!places.sectors.empty()) write("Sector", CGNS_ENUMV(Integer), places.sectors.data());
}

void CgnsFile::finish(int zones) {
    close();
    check(cg_open(pending_.c_str(), CG_MODE_READ, &handle_));
    open_ = true;
    int there = 0;
    check(cg_nzones(handle_, 1, &there));
    close();
    if (there != zones)
        throw base::OutputError(fmt::format("{}: has {} of {} blocks when it is read back",
                                            name_.string(), there, zones));
}

void CgnsFile::close() {
    open_ = false;
    check(cg_close(handle_));
}

}  // namespace patchwright::grid
