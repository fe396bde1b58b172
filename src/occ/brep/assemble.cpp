#include "occ/brep/bodies.h"
#include "occ/exchange/cad_model_impl.h"
#include "occ/kernel_guard.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/occ/assemble.h>

#include <BRep_Builder.hxx>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom2d_Line.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Precision.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TColgp_Array1OfPnt.hxx>
#include <TColgp_Array1OfPnt2d.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopoDS_Wire.hxx>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <numeric>

namespace patchwright::occ {

namespace {

gp_Pnt to_point(const geom::Vec3& p) { return {p.x(), p.y(), p.z()}; }

/// Distinct knots with their multiplicities.
struct KnotTable {
    explicit KnotTable(const std::vector<double>& flat)
        : values(1, count(flat)), multiplicities(1, count(flat)) {
        int k = 0;
        for (std::size_t i = 0; i < flat.size(); ++i) {
            if (i == 0 || flat[i] != flat[i - 1]) {
                values(++k) = flat[i];
                multiplicities(k) = 0;
            }
            ++multiplicities(k);
        }
    }
    static int count(const std::vector<double>& flat) {
        int distinct = 1;
        for (std::size_t i = 1; i < flat.size(); ++i) distinct += flat[i] != flat[i - 1] ? 1 : 0;
        return distinct;
    }
    TColStd_Array1OfReal values;
    TColStd_Array1OfInteger multiplicities;
};

Handle(Geom_BSplineCurve) to_kernel(const geom::BsplineCurve& curve) {
    TColgp_Array1OfPnt poles(1, static_cast<int>(curve.points.rows()));
    for (int i = 1; i <= poles.Length(); ++i)
        poles(i) = to_point(curve.points.row(i - 1).transpose());
    const KnotTable knots(curve.knots);
    return new Geom_BSplineCurve(poles, knots.values, knots.multiplicities, 3);
}

Handle(Geom_BSplineSurface) to_kernel(const geom::BsplineSurface& surface) {
    TColgp_Array2OfPnt poles(1, static_cast<int>(surface.rows()), 1,
                             static_cast<int>(surface.columns()));
    for (int i = 1; i <= poles.ColLength(); ++i) {
        for (int j = 1; j <= poles.RowLength(); ++j) {
            poles(i, j) = to_point(surface.point(i - 1, j - 1).transpose());
        }
    }
    const KnotTable u(surface.knots_u);
    const KnotTable v(surface.knots_v);
    return new Geom_BSplineSurface(poles, u.values, v.values, u.multiplicities, v.multiplicities, 3,
                                   3);
}

Handle(Geom2d_Curve) segment(const gp_Pnt2d& from, const gp_Pnt2d& to, double begin, double end) {
    TColgp_Array1OfPnt2d poles(1, 2);
    poles(1) = from;
    poles(2) = to;
    TColStd_Array1OfReal knots(1, 2);
    knots(1) = begin;
    knots(2) = end;
    TColStd_Array1OfInteger multiplicities(1, 2);
    multiplicities.Init(2);
    return new Geom2d_BSplineCurve(poles, knots, multiplicities, 1);
}

GeomAbs_Shape kernel_continuity(patch::EdgeContinuity continuity) {
    switch (continuity) {
        case patch::EdgeContinuity::Position: return GeomAbs_C0;
        case patch::EdgeContinuity::TangentPlane: return GeomAbs_G1;
        case patch::EdgeContinuity::Curvature: return GeomAbs_C2;
    }
    return GeomAbs_C0;
}

/// One use of an edge by a patch, along a piece of the patch's side.
struct Use {
    int patch;
    bool reversed;
};

/// Refuses what is no manifold; tells which patches hang together and whether each part is closed.
class Connectivity {
  public:
    explicit Connectivity(const patch::PatchSet& set)
        : uses_(set.edges.size()), part_(set.patches.size()) {
        for (std::size_t p = 0; p < set.patches.size(); ++p) {
            for (const auto& side : set.patches[p].sides) {
                for (const patch::EdgeUse& use : side) add(use, static_cast<int>(p));
            }
        }
        std::iota(part_.begin(), part_.end(), 0);
        for (const auto& uses : uses_) {
            if (uses.size() == 2) part_[std::size_t(root(uses[0].patch))] = root(uses[1].patch);
        }
    }

    [[nodiscard]] const std::vector<Use>& uses(std::size_t edge) const { return uses_[edge]; }

    /// Patches of each connected part, parts in the order of their first patch.
    [[nodiscard]] std::vector<std::vector<int>> parts() {
        std::map<int, std::size_t> number;
        std::vector<std::vector<int>> parts;
        for (std::size_t p = 0; p < part_.size(); ++p) {
            const auto [entry, added] = number.try_emplace(root(static_cast<int>(p)), parts.size());
            if (added) parts.emplace_back();
            parts[entry->second].push_back(static_cast<int>(p));
        }
        return parts;
    }

  private:
    void add(const patch::EdgeUse& use, int p) {
        if (use.edge < 0 || std::size_t(use.edge) >= uses_.size()) {
            throw base::InvalidArgument(
                fmt::format("patch {} uses edge {}, which is none", p, use.edge));
        }
        auto& uses = uses_[std::size_t(use.edge)];
        if (uses.size() == 2) {
            throw base::InvalidArgument(
                fmt::format("edge {} is used by more than two patches ({}, {}, {})", use.edge,
                            uses[0].patch, uses[1].patch, p));
        }
        if (uses.size() == 1 && uses[0].reversed == use.reversed) {
            throw base::InvalidArgument(
                fmt::format("edge {} runs the same way in patches {} and {}; turn one", use.edge,
                            uses[0].patch, p));
        }
        if (uses.size() == 1 && uses[0].patch == p) {
            throw base::InvalidArgument(fmt::format(
                "patch {} closes onto itself in edge {}; split the patch", p, use.edge));
        }
        uses.push_back({p, use.reversed});
    }

    int root(int p) {
        while (part_[std::size_t(p)] != p) {
            part_[std::size_t(p)] = part_[std::size_t(part_[std::size_t(p)])];
            p = part_[std::size_t(p)];
        }
        return p;
    }

    std::vector<std::vector<Use>> uses_;
    std::vector<int> part_;
};

class Assembler {
  public:
    explicit Assembler(const patch::PatchSet& set) : set_(set), connectivity_(set) {}

    CadModel run() {
        make_vertices_and_edges();
        faces_.reserve(set_.patches.size());
        for (const patch::Patch& patch : set_.patches) faces_.push_back(make_face(patch));
        mark_smooth_edges();

        TopoDS_Compound compound;
        builder_.MakeCompound(compound);
        std::vector<ShellPart> parts;
        for (const auto& part : connectivity_.parts()) parts.push_back(make_part(part));
        const std::vector<TopoDS_Shape> bodies = make_bodies(parts);
        for (const TopoDS_Shape& body : bodies) builder_.Add(compound, body);

        auto impl = std::make_shared<CadModel::Impl>();
        impl->shape = bodies.size() == 1 ? bodies.front() : TopoDS_Shape(compound);
        describe_faces(*impl);
        return CadModel(std::move(impl));
    }

  private:
    void make_vertices_and_edges() {
        for (Eigen::Index v = 0; v < set_.vertices.rows(); ++v) {
            TopoDS_Vertex vertex;
            builder_.MakeVertex(vertex, to_point(set_.vertices.row(v).transpose()),
                                Precision::Confusion());
            vertices_.push_back(vertex);
        }
        for (const patch::PatchEdge& edge : set_.edges) {
            TopoDS_Edge made;
            builder_.MakeEdge(made, to_kernel(edge.curve), Precision::Confusion());
            builder_.Add(made, vertices_[std::size_t(edge.start)].Oriented(TopAbs_FORWARD));
            builder_.Add(made, vertices_[std::size_t(edge.end)].Oriented(TopAbs_REVERSED));
            builder_.Range(made, edge.curve.begin(), edge.curve.end());
            edges_.push_back(made);
        }
    }

    TopoDS_Face make_face(const patch::Patch& patch) {
        TopoDS_Face face;
        const Handle(Geom_BSplineSurface) surface = to_kernel(patch.surface);
        builder_.MakeFace(face, surface, Precision::Confusion());
        TopoDS_Wire wire;
        builder_.MakeWire(wire);
        for (int side = 0; side < 4; ++side) add_side(patch, side, face, wire);
        wire.Closed(true);
        builder_.Add(face, wire);
        builder_.NaturalRestriction(face, true);
        return face;
    }

    /// The p-curves of a side are straight; an edge's curve has the side's own parameter, or runs
    /// against it, over a share of the side that is as long as the edge's range. Those of parts of
    /// a side are bounded: readers project an edge's ends onto all of a line over the surface.
    void add_side(const patch::Patch& patch, int side, const TopoDS_Face& face, TopoDS_Wire& wire) {
        const auto& s = patch.surface;
        const double u0 = s.knots_u.front(), u1 = s.knots_u.back();
        const double v0 = s.knots_v.front(), v1 = s.knots_v.back();
        const gp_Pnt2d corners[4] = {{u0, v0}, {u1, v0}, {u1, v1}, {u0, v1}};
        const gp_Dir2d along = gp_Dir2d(gp_Vec2d(corners[side], corners[(side + 1) % 4]));
        double done = 0.0;
        for (const patch::EdgeUse& use : patch.sides[std::size_t(side)]) {
            const patch::PatchEdge& edge = set_.edges[std::size_t(use.edge)];
            const double length = edge.curve.end() - edge.curve.begin();
            const gp_Dir2d direction = use.reversed ? along.Reversed() : along;
            // The point of the side at the edge's own start, moved back to parameter 0.
            const double start = use.reversed ? done + length : done;
            const gp_Pnt2d at = corners[side].Translated(gp_Vec2d(along) * start);
            Handle(Geom2d_Curve) line;
            if (patch.sides[std::size_t(side)].size() > 1) {
                line = segment(at, at.Translated(gp_Vec2d(direction) * length), edge.curve.begin(),
                               edge.curve.end());
            } else {
                line = new Geom2d_Line(at.Translated(gp_Vec2d(direction) * -edge.curve.begin()),
                                       direction);
            }
            TopoDS_Edge& made = edges_[std::size_t(use.edge)];
            builder_.UpdateEdge(made, line, face, Precision::Confusion());
            builder_.Range(made, face, edge.curve.begin(), edge.curve.end());
            builder_.Add(wire, made.Oriented(use.reversed ? TopAbs_REVERSED : TopAbs_FORWARD));
            done += length;
        }
        const double side_length = side % 2 == 0 ? u1 - u0 : v1 - v0;
        if (std::abs(done - side_length) > 1e-9 * side_length) {
            throw base::InvalidArgument(
                fmt::format("patch '{}': the edges of side {} cover {} of {}", patch.name, side,
                            done, side_length));
        }
    }

    void mark_smooth_edges() {
        for (std::size_t e = 0; e < set_.edges.size(); ++e) {
            const auto& uses = connectivity_.uses(e);
            if (uses.size() == 2) {
                builder_.Continuity(edges_[e], faces_[std::size_t(uses[0].patch)],
                                    faces_[std::size_t(uses[1].patch)],
                                    kernel_continuity(set_.edges[e].continuity));
            }
        }
    }

    ShellPart make_part(const std::vector<int>& patches) {
        ShellPart part{.closed = is_closed(patches)};
        if (part.closed) part.volume = volume(patches);
        builder_.MakeShell(part.shell);
        for (const int p : patches) {
            builder_.Add(part.shell, faces_[std::size_t(p)]);
            part.box.add(geom::bounding_box(set_.patches[std::size_t(p)].surface.points));
        }
        part.shell.Closed(part.closed);
        constexpr std::size_t most_points = 64;
        const std::size_t step = patches.size() / most_points + 1;
        for (std::size_t i = 0; i < patches.size(); i += step)
            part.points.emplace_back(
                set_.patches[std::size_t(patches[i])].surface.points.row(0).transpose());
        return part;
    }

    [[nodiscard]] bool is_closed(const std::vector<int>& part) const {
        for (const int p : part) {
            for (const auto& side : set_.patches[std::size_t(p)].sides) {
                for (const patch::EdgeUse& use : side) {
                    if (connectivity_.uses(std::size_t(use.edge)).size() != 2) return false;
                }
            }
        }
        return true;
    }

    /// Inside the surfaces, which a cage may contain the other way round.
    [[nodiscard]] double volume(const std::vector<int>& part) const {
        const geom::Vec3 origin = set_.vertices.row(0).transpose();
        std::vector<double> shares(part.size());
        base::parallel_for(part.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k)
                shares[k] =
                    geom::moments(set_.patches[std::size_t(part[k])].surface, origin).volume;
        });
        return std::accumulate(shares.begin(), shares.end(), 0.0);
    }

    void describe_faces(CadModel::Impl& impl) const {
        TopTools_IndexedMapOfShape order;
        TopExp::MapShapes(impl.shape, TopAbs_FACE, order);
        impl.face_names.resize(std::size_t(order.Extent()));
        impl.face_colours.resize(impl.face_names.size());
        for (std::size_t p = 0; p < faces_.size(); ++p) {
            // Faces of a turned shell are found whatever their orientation: IsSame is the map's
            // rule.
            const auto face = std::size_t(order.FindIndex(faces_[p])) - 1;
            impl.face_names[face] = set_.patches[p].name;
            impl.face_colours[face] = set_.patches[p].colour;
        }
    }

    const patch::PatchSet& set_;
    Connectivity connectivity_;
    BRep_Builder builder_;
    std::vector<TopoDS_Vertex> vertices_;
    std::vector<TopoDS_Edge> edges_;
    std::vector<TopoDS_Face> faces_;
};

}  // namespace

void check_size(const geom::Box3& box, const std::string& source) {
    const double largest = std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
    if (!(largest <= largest_coordinate_mm)) {
        throw base::InputError(fmt::format(
            "{}: coordinates up to {:.3g} mm are beyond {:g} mm, where the CAD kernel's "
            "resolution of {:g} mm is lost in rounding; move the model to the origin, "
            "or see --cage-unit",
            source, largest, largest_coordinate_mm, Precision::Confusion()));
    }
    if (!(box.diagonal() >= least_diagonal_mm)) {
        throw base::InputError(
            fmt::format("{}: the model is {:.3g} mm across, less than {:g} mm, which the CAD "
                        "kernel's resolution of {:g} mm needs; scale it, or see --cage-unit",
                        source, box.diagonal(), least_diagonal_mm, Precision::Confusion()));
    }
}

CadModel assemble(const patch::PatchSet& patches) {
    if (patches.patches.empty()) throw base::InvalidArgument("there are no patches to assemble");
    return guard_kernel<base::InvalidArgument>("assembling the patches",
                                               [&] { return Assembler(patches).run(); });
}

}  // namespace patchwright::occ
