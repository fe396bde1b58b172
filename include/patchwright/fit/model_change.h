// How a model has changed, where both states have the same faces.
#pragma once

#include <patchwright/geom/model_surface.h>

#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::fit {

struct ModelState {
    const geom::ModelSurface& surface;
    std::string name;  ///< in messages
};

/// Displacements of points from an earlier state of a model to a later one, as parametric CAD
/// leaves them: onto the face of the same name, or number where names do not tell faces apart, at
/// the same share of its range of parameters. Faces whose border comes to lie elsewhere than their
/// neighbours' does, as planes with other axes, move with the neighbours' border in place of that.
class ModelChange {
  public:
    /// Refers to both models.
    /// @throw InputError where the models have no CAD faces, other numbers of them, or more than
    ///        half of the faces' borders do not fit: then nothing is known of the change
    ModelChange(const ModelState& earlier, const ModelState& later);
    ~ModelChange();
    ModelChange(const ModelChange&) = delete;
    ModelChange& operator=(const ModelChange&) = delete;

    /// Displacement of the earlier model's point nearest to this one. Thread-safe.
    [[nodiscard]] geom::Vec3 displacement_at(const geom::Vec3& point) const;

  private:
    struct FaceMap;
    const geom::ModelSurface &earlier_, &later_;
    std::vector<FaceMap> faces_;
};

}  // namespace patchwright::fit
#pragma GCC visibility pop
