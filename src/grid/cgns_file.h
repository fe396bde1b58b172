// What all CGNS files have in common.
#pragma once

#include "grid/writer.h"

#include <cgnslib.h>

#include <set>
#include <span>

namespace patchwright::grid {

/// Names of CGNS nodes: up to 32 characters, no slash, different from each other.
class CgnsNames {
  public:
    std::string make(std::string name);

  private:
    std::set<std::string> used_{"DataClass", "DimensionalUnits"};  ///< nodes of the base as well
};

/// HDF5 prints its own errors, in each thread anew, unless told not to; CGNS has no call for that.
void mute_hdf5();

/// A file with one base in a unit of length, under construction.
/// Source: CGNS standard interface data structures, version 3.4; index ranges count from 1.
class CgnsFile {
  public:
    /// @param dimension  of the cells
    /// @throw OutputError as all of these
    CgnsFile(const base::PendingFile& file, int dimension, base::LengthUnit unit);
    ~CgnsFile();
    CgnsFile(const CgnsFile&) = delete;
    CgnsFile& operator=(const CgnsFile&) = delete;

    [[nodiscard]] int handle() const { return handle_; }
    [[nodiscard]] int base() const { return base_; }
    [[nodiscard]] const std::filesystem::path& name() const { return name_; }
    /// Of a call of the library.
    void check(int status) const;
    /// @return its node's name and number
    std::pair<std::string, int> write_family(CgnsNames& names, const std::string& family);
    void write_coordinates(int zone, const std::array<std::vector<double>, 3>& coordinates);
    /// As the user's data, for which the standard has no names.
    /// @param sizes  of the places' array
    void write_places(int zone, const BlockPlaces& places, std::span<const cgsize_t> sizes);
    /// Closes the file and reads back how many zones it has.
    void finish(int zones);

  private:
    void close();

    std::filesystem::path name_, pending_;
    int handle_ = 0, base_ = 0;
    bool open_ = false;
};

}  // namespace patchwright::grid
