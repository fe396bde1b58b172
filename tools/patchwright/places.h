// Places on a cage by the million.
#pragma once

#include "table.h"

#include <patchwright/subd/limit_mask.h>

#include <string>
#include <vector>

namespace patchwright::cli {

/// Places as arrays.
class Places {
  public:
    void add(const subd::Location& at);
    /// Adds one a line: FACE,U,V or FACE,U,V,SECTOR.
    /// @throw InputError naming the line that is no place on the mesh
    void read(const std::string& file, const mesh::Topology& topology);
    /// Adds the place that a row begins with.
    /// @throw InputError naming the line of what is no place on the mesh
    void add(const Table& table, std::size_t i, bool has_sector, const mesh::Topology& topology);

    [[nodiscard]] subd::Locations locations() const { return {faces_, uv_, sectors_}; }

  private:
    std::vector<std::int32_t> faces_;
    std::vector<double> uv_;
    std::vector<std::int32_t> sectors_;
};

/// Where masks are to be all that points depend on.
/// @param options  that ask for it, for the message
/// @throw InputError when sectors have tags
void refuse_sectors(const std::string& cage, const mesh::Topology& topology,
                    const std::string& options);

}  // namespace patchwright::cli
