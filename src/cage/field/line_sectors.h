// How many quads there are between lines.
#pragma once

#include "cage/field/field_topology.h"
#include "cage/field/lined_mesh.h"

#include <map>
#include <vector>

namespace patchwright::cage {

/// What a field says at features and singularities, before lines are drawn there.
class SectorCounts {
  public:
    SectorCounts(const LinedMesh& lined, const FieldTopology& topology);

    /// See FieldLines::sectors.
    [[nodiscard]] std::vector<FieldSector> sectors(const LinedMesh& lined) const;

  private:
    struct Known {
        geom::Vec3 direction;  ///< of the side that the sector begins with
        int quads;
    };
    std::map<int, std::vector<Known>> at_borders_;  ///< by vertex
    std::map<int, int> valence_;                    ///< of singularities

    [[nodiscard]] int quads_of(const LinedMesh& lined, int v, int next) const;
};

}  // namespace patchwright::cage
