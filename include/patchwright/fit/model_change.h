// How a model has changed, where both states have the same faces.
#pragma once

#include <patchwright/geom/model_surface.h>

#include <memory>
#include <optional>
#include <string>

#pragma GCC visibility push(default)
namespace patchwright::fit {

/// Maps points of an earlier state of a model to a later one, as parametric CAD leaves them: onto
/// the face of the same name, or number where names do not tell faces apart, at the same share of
/// its range of parameters.
class ModelChange {
  public:
    /// @param name  of the earlier model, in messages
    /// @throw InputError where the models have no CAD faces, other numbers of them, or faces that
    ///        belong together are beside different ones: then nothing is known of the change
    ModelChange(std::shared_ptr<const geom::ModelSurface> earlier,
                std::shared_ptr<const geom::ModelSurface> later, const std::string& name);
    ~ModelChange();

    [[nodiscard]] const geom::ModelSurface& earlier() const { return *earlier_; }
    /// Where the earlier model's point nearest to this one has gone. Thread-safe.
    [[nodiscard]] geom::Vec3 operator()(const geom::Vec3& point) const;

  private:
    struct Faces;
    std::shared_ptr<const geom::ModelSurface> earlier_, later_;
    std::unique_ptr<const Faces> faces_;
};

}  // namespace patchwright::fit
#pragma GCC visibility pop
