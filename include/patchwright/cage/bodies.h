// The bodies of a model by themselves, for parts of a cage that each lie on one of them.
#pragma once

#include <patchwright/mesh/cage.h>
#include <patchwright/occ/cad_model.h>
#include <patchwright/occ/cad_reference.h>

#include <vector>

namespace patchwright::cage {

/// Faces of a model that hang together, as a reference of their own. Where bodies overlap or touch,
/// nearest points of all of them would be the wrong one's.
struct ModelBody {
    std::vector<int> faces;  ///< of the model
    occ::CadReference reference;
};

/// One a body, but for those that cannot be triangulated.
std::vector<ModelBody> model_bodies(const occ::CadModel& model,
                                    const occ::ReferenceOptions& options = {});

/// For each part of a cage the body that it lies on, or else the whole model: a part lies on a body
/// when its vertices are hardly farther from that than from the whole.
/// @param parts  as mesh::connected_parts gives them
std::vector<const geom::ReferenceSurface*> references_of_parts(const std::vector<mesh::Cage>& parts,
                                                               const std::vector<ModelBody>& bodies,
                                                               const geom::ModelSurface& whole);

}  // namespace patchwright::cage
