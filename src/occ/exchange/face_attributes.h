// Names and colours of faces in STEP and IGES files.
#pragma once

#include <patchwright/occ/cad_model.h>

#include <TopoDS_TShape.hxx>

#include <optional>
#include <string>
#include <unordered_map>

class IGESControl_Reader;
class IGESControl_Writer;
class STEPControl_Reader;
class STEPControl_Writer;

namespace patchwright::occ {

struct FaceAttributes {
    std::string name;
    std::optional<Colour> colour;
    Handle(TopoDS_TShape) face;  ///< kept, so that nothing else gets its address
};

/// By the kernel's face data; instances of a part share theirs.
using FaceAttributeMap = std::unordered_map<const TopoDS_TShape*, FaceAttributes>;

/// Of the faces transferred. A face's own colour goes before that of its shell, solid or part.
FaceAttributeMap step_attributes(STEPControl_Reader& reader);
FaceAttributeMap iges_attributes(IGESControl_Reader& reader);

/// Gives the faces that were transferred to a writer the model's names and colours.
void write_step_attributes(STEPControl_Writer& writer, const CadModel& model);
/// @pre before the writer computes its model; names are cut to the format's eight characters
void write_iges_attributes(IGESControl_Writer& writer, const CadModel& model);

}  // namespace patchwright::occ
