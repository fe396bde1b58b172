// Which face of the file a face of the model came from.
#pragma once

#include <TopoDS_Shape.hxx>
#include <TopoDS_TShape.hxx>

#include <unordered_map>

namespace patchwright::occ {

/// Follows faces through healing by the kernel's shared face data, whatever their place and
/// orientation: instances of one part have the same origin.
class FaceOrigins {
  public:
    void replaced(const TopoDS_Shape& before, const TopoDS_Shape& after) {
        if (before.TShape() != after.TShape()) from_[after.TShape().get()] = before.TShape();
    }
    /// The face as read.
    [[nodiscard]] const TopoDS_TShape* origin(const TopoDS_Shape& face) const {
        const TopoDS_TShape* at = face.TShape().get();
        for (auto it = from_.find(at); it != from_.end(); it = from_.find(at))
            at = it->second.get();
        return at;
    }

  private:
    /// The handles keep the addresses from being used again.
    std::unordered_map<const TopoDS_TShape*, Handle(TopoDS_TShape)> from_;
};

}  // namespace patchwright::occ
