// The bodies of a model, each as a source of its own.
#pragma once

#include <patchwright/convert/convert.h>

#include <vector>

namespace patchwright::convert {

/// Faces that hang together.
struct Body {
    Source source;
    ConvertOptions options;  ///< the model's, with the body's share of samples and faces
};

/// Whether a model is converted body by body: one of several bodies whose cages are made.
bool by_bodies(const Source& source, const ConvertOptions& options);

/// Faces without a name are named by their number in the model. Bodies without triangles are left
/// out. @pre by_bodies()
std::vector<Body> bodies_of(const Source& source, const ConvertOptions& options,
                            const base::Progress& progress);

}  // namespace patchwright::convert
