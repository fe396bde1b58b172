// CAD whose surface is the limit surface of a cage.
#pragma once

#include <patchwright/occ/assemble.h>
#include <patchwright/occ/cad_reference.h>
#include <patchwright/patch/extract.h>

namespace patchwright::test {

struct Shape {
    occ::CadModel model;
    occ::CadReference reference;
};

inline Shape shape_of(const mesh::Cage& cage) {
    occ::CadModel model = occ::assemble(patch::extract(cage).patches);
    occ::CadReference reference(model);
    return {std::move(model), std::move(reference)};
}

}  // namespace patchwright::test
