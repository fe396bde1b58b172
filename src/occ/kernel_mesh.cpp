#include "occ/kernel_mesh.h"

#include <BRepMesh_BoundaryParamsRangeSplitter.hxx>
#include <BRepMesh_Context.hxx>
#include <BRepMesh_DelaunayBaseMeshAlgo.hxx>
#include <BRepMesh_DelaunayDeflectionControlMeshAlgo.hxx>
#include <BRepMesh_FaceDiscret.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepMesh_MeshAlgoFactory.hxx>
#include <BRepMesh_NURBSRangeSplitter.hxx>
#include <IMeshData_Curve.hxx>
#include <IMeshData_Edge.hxx>
#include <IMeshData_Face.hxx>
#include <IMeshData_Model.hxx>
#include <IMeshData_Wire.hxx>
#include <Message_ProgressIndicator.hxx>

#include <algorithm>
#include <utility>

namespace patchwright::occ {

namespace {

/// In each direction, into which the kernel sorts the triangles' circumcircles. It asks for up to
/// 32 on usual models, but for 583,405 on a small face with a control point 2e17 mm out of place,
/// and a circle there was put into 3e11 cells.
constexpr int most_circle_cells = 200;

/// Stops the passes over one face. The kernel asks after a pass's nodes are registered and before
/// the first one has triangles, so what it has is whole.
class RefinementLimit final : public Message_ProgressIndicator {
  public:
    RefinementLimit(const BRepMesh_DataStructureOfDelaun& structure, const BRepMesh_Delaun& mesher,
                    const Message_ProgressRange& outer)
        : structure_(structure), mesher_(mesher), outer_(outer) {}

    Standard_Boolean UserBreak() override {
        if (outer_.UserBreak()) return Standard_True;
        const int nodes = structure_.NbNodes();
        if (nodes != nodes_) {
            nodes_ = nodes;
            stopped_ = nodes > most_face_nodes || border_is_open();
        }
        return stopped_;
    }

  protected:
    void Show(const Message_ProgressScope&, const Standard_Boolean) override {}

  private:
    [[nodiscard]] bool border_is_open() const {
        const Handle(IMeshData::MapOfInteger) border = mesher_.Frontier();
        for (IMeshData::IteratorOfMapOfInteger link(*border); link.More(); link.Next())
            if (structure_.ElementsConnectedTo(link.Key()).IsEmpty()) return true;
        return false;
    }

    const BRepMesh_DataStructureOfDelaun& structure_;
    const BRepMesh_Delaun& mesher_;
    const Message_ProgressRange& outer_;
    int nodes_ = -1;  ///< at the last look
    bool stopped_ = false;
};

template <class RangeSplitter>
class LimitedRefinement final
    : public BRepMesh_DelaunayDeflectionControlMeshAlgo<RangeSplitter,
                                                        BRepMesh_DelaunayBaseMeshAlgo> {
    using Base =
        BRepMesh_DelaunayDeflectionControlMeshAlgo<RangeSplitter, BRepMesh_DelaunayBaseMeshAlgo>;

  protected:
    std::pair<Standard_Integer, Standard_Integer> getCellsCount(
        const Standard_Integer nodes) override {
        const auto [u, v] = Base::getCellsCount(nodes);
        return {std::min(u, most_circle_cells), std::min(v, most_circle_cells)};
    }

    void optimizeMesh(BRepMesh_Delaun& mesher, const Message_ProgressRange& range) override {
        const Handle(RefinementLimit) limit =
            new RefinementLimit(*this->getStructure(), mesher, range);
        Base::optimizeMesh(mesher, limit->Start());
    }
};

/// The kernel's own choice by surface, with refinement that is limited.
class LimitedFactory final : public BRepMesh_MeshAlgoFactory {
  public:
    Handle(IMeshTools_MeshAlgo) GetAlgo(const GeomAbs_SurfaceType type,
                                        const IMeshTools_Parameters& parameters) const override {
        switch (type) {
            case GeomAbs_Plane:
            case GeomAbs_Cylinder:
            case GeomAbs_Cone:
            case GeomAbs_Sphere:
            case GeomAbs_Torus: return BRepMesh_MeshAlgoFactory::GetAlgo(type, parameters);
            case GeomAbs_SurfaceOfRevolution:
                return new LimitedRefinement<BRepMesh_BoundaryParamsRangeSplitter>;
            default: return new LimitedRefinement<BRepMesh_NURBSRangeSplitter>;
        }
    }
};

/// Triangulates no face that has an edge of more than `most_edge_nodes`.
class LimitedFaces final : public BRepMesh_FaceDiscret {
  public:
    LimitedFaces() : BRepMesh_FaceDiscret(new LimitedFactory) {}

  protected:
    Standard_Boolean performInternal(const Handle(IMeshData_Model) & model,
                                     const IMeshTools_Parameters& parameters,
                                     const Message_ProgressRange& range) override {
        for (int f = 0; f < model->FacesNb(); ++f) {
            const IMeshData::IFaceHandle& face = model->GetFace(f);
            for (int w = 0; w < face->WiresNb(); ++w) {
                const IMeshData::IWireHandle& wire = face->GetWire(w);
                for (int e = 0; e < wire->EdgesNb(); ++e)
                    if (wire->GetEdge(e)->GetCurve()->ParametersNb() > most_edge_nodes)
                        face->SetStatus(IMeshData_Failure);
            }
        }
        return BRepMesh_FaceDiscret::performInternal(model, parameters, range);
    }
};

}  // namespace

void mesh_faces(const TopoDS_Shape& shape, const IMeshTools_Parameters& parameters,
                const Message_ProgressRange& range) {
    const Handle(BRepMesh_Context) context = new BRepMesh_Context;
    context->SetFaceDiscret(new LimitedFaces);
    BRepMesh_IncrementalMesh mesher;
    mesher.SetShape(shape);
    mesher.ChangeParameters() = parameters;
    mesher.Perform(context, range);
}

}  // namespace patchwright::occ
