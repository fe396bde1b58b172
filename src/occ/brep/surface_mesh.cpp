#include "occ/brep/surface_mesh.h"

#include "geom/disjoint_sets.h"
#include "occ/exchange/cad_model_impl.h"
#include "occ/kernel_guard.h"
#include "occ/kernel_mesh.h"

#include <patchwright/geom/nearest.h>

#include <BRep_Tool.hxx>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Vertex.hxx>

#include <algorithm>
#include <limits>
#include <map>
#include <set>

namespace patchwright::occ {

using geom::DisjointSets;
using geom::FeatureSide;
using geom::SurfaceMesh;

namespace {

constexpr double angular_deflection_rad = 0.35;

/// Collects the triangulations of the faces and glues them along edges and vertices.
class Gluing {
  public:
    Gluing(const TopoDS_Shape& shape, const EdgeNetwork& network) {
        TopExp::MapShapes(shape, TopAbs_EDGE, edges_);
        TopExp::MapShapes(shape, TopAbs_VERTEX, vertices_);
        // Vertices are nodes of their own, the first ones.
        for (int i = 1; i <= vertices_.Extent(); ++i) {
            classes_.add();
            points_.push_back(vec(BRep_Tool::Pnt(TopoDS::Vertex(vertices_(i)))));
        }
        pieces_.resize(std::size_t(edges_.Extent()));
        for (std::size_t i = 0; i < network.edges.size(); ++i)
            pieces_[std::size_t(network.edges[i].shape_edge)].push_back(int(i));
        nodes_.resize(std::size_t(edges_.Extent()));
    }

    /// False when the kernel has no triangles for the face.
    bool add(const TopoDS_Face& face, int number) {
        TopLoc_Location location;
        const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(face, location);
        if (mesh.IsNull() || mesh->NbTriangles() == 0) return false;
        const int base = int(classes_.size()) - 1;  // the kernel's nodes count from 1
        const gp_Trsf transform = location.Transformation();
        for (int i = 1; i <= mesh->NbNodes(); ++i) {
            classes_.add();
            points_.push_back(vec(mesh->Node(i).Transformed(transform)));
        }
        for (TopExp_Explorer it(face, TopAbs_EDGE); it.More(); it.Next())
            glue(TopoDS::Edge(it.Current()), mesh, location, base);
        const bool reversed = face.Orientation() == TopAbs_REVERSED;
        for (int i = 1; i <= mesh->NbTriangles(); ++i) {
            std::array<int, 3> t{};
            mesh->Triangle(i).Get(t[0], t[1], t[2]);
            if (reversed) std::swap(t[1], t[2]);
            for (int& v : t) v += base;
            triangles_.push_back(t);
            faces_.push_back(number);
        }
        return true;
    }

    SurfaceMesh result(const SearchModel& model) {
        part_parallel_edges();
        part_half_sharp_edges(model.network);
        SurfaceMesh mesh;
        number_.assign(classes_.size(), -1);
        std::map<std::array<int, 3>, std::size_t> seen;
        std::vector<char> dropped(triangles_.size(), 0);
        for (std::size_t i = 0; i < triangles_.size(); ++i) {
            auto& t = triangles_[i];
            for (int& v : t) v = classes_.find(v);
            if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) dropped[i] = 1;
            if (dropped[i] != 0) continue;
            // Two triangles on the same vertices are a flap without volume.
            auto key = t;
            std::sort(key.begin(), key.end());
            const auto [at, first] = seen.emplace(key, i);
            if (first) continue;
            dropped[i] = dropped[at->second] = 1;
            seen.erase(at);
        }
        std::vector<geom::Vec3> points;
        for (std::size_t i = 0; i < triangles_.size(); ++i) {
            if (dropped[i] != 0) continue;
            std::array<int, 3> t{};
            for (std::size_t k = 0; k < 3; ++k) {
                int& n = number_[std::size_t(triangles_[i][k])];
                if (n < 0) {
                    n = int(points.size());
                    points.push_back(points_[std::size_t(triangles_[i][k])]);
                }
                t[k] = n;
            }
            mesh.triangles.push_back(t);
            mesh.faces.push_back(faces_[i]);
        }
        mesh.points.resize(Eigen::Index(points.size()), 3);
        for (std::size_t i = 0; i < points.size(); ++i)
            mesh.points.row(Eigen::Index(i)) = points[i].transpose();
        add_features(mesh, model);
        return mesh;
    }

  private:
    void glue(const TopoDS_Edge& edge, const Handle(Poly_Triangulation) & mesh,
              const TopLoc_Location& location, int base) {
        const Handle(Poly_PolygonOnTriangulation) polygon =
            BRep_Tool::PolygonOnTriangulation(edge, mesh, location);
        if (polygon.IsNull()) return;
        const auto& nodes = polygon->Nodes();
        std::vector<int> chain;
        for (int i = nodes.Lower(); i <= nodes.Upper(); ++i) chain.push_back(base + nodes(i));
        const TopoDS_Edge forward = TopoDS::Edge(edge.Oriented(TopAbs_FORWARD));
        const TopoDS_Vertex start = TopExp::FirstVertex(forward), end = TopExp::LastVertex(forward);
        if (!start.IsNull()) classes_.join(vertices_.FindIndex(start) - 1, chain.front());
        if (!end.IsNull()) classes_.join(vertices_.FindIndex(end) - 1, chain.back());
        if (BRep_Tool::Degenerated(edge)) {
            for (const int node : chain) classes_.join(chain.front(), node);
            return;
        }
        const auto number = std::size_t(edges_.FindIndex(edge)) - 1;
        auto& known = nodes_[number];
        if (chain.size() == 2) chords_[number].push_back({chain[0], chain[1]});
        if (known.empty()) {
            known = chain;
        } else if (known.size() == chain.size()) {
            for (std::size_t i = 0; i < chain.size(); ++i) classes_.join(known[i], chain[i]);
        }
    }

    /// Two edges of the model between the same vertices, each one chord, would be one edge of the
    /// mesh: they get a node in the middle.
    void part_parallel_edges() {
        std::map<std::pair<int, int>, std::vector<std::size_t>> by_ends;
        for (const auto& [edge, chords] : chords_) {
            const auto [a, b] = chords.front();
            by_ends[std::minmax({classes_.find(a), classes_.find(b)})].push_back(edge);
        }
        for (const auto& [ends, edges] : by_ends) {
            if (edges.size() < 2 || ends.first == ends.second) continue;
            for (const std::size_t edge : edges) {
                const int middle = classes_.add();
                points_.push_back(0.5 * (points_[std::size_t(chords_[edge][0].first)] +
                                         points_[std::size_t(chords_[edge][0].second)]));
                for (const auto& [a, b] : chords_[edge]) split_side(a, b, middle);
                nodes_[edge] = {nodes_[edge].front(), middle, nodes_[edge].back()};
            }
        }
    }

    /// @param a, b  nodes of one face: at most one triangle has them as a side
    void split_side(int a, int b, int middle) {
        for (std::size_t i = 0; i < triangles_.size(); ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
                const auto& t = triangles_[i];
                if (std::minmax(t[k], t[(k + 1) % 3]) != std::minmax(a, b)) continue;
                split_side(i, k, middle);
                return;
            }
        }
    }

    /// Edges that are sharp on part of their length are several in the network: a node is put, or
    /// moved, to where each of them ends.
    void part_half_sharp_edges(const EdgeNetwork& network) {
        parting_.assign(network.vertices.size(), -1);
        for (std::size_t edge = 0; edge < pieces_.size(); ++edge) {
            for (std::size_t i = 0; i + 1 < pieces_[edge].size() && nodes_[edge].size() > 1; ++i) {
                const int vertex = network.edges[std::size_t(pieces_[edge][i])].end;
                parting_[std::size_t(vertex)] =
                    node_at(edge, network.vertices[std::size_t(vertex)]);
            }
        }
    }

    /// A node of the edge's chain at this point of the edge.
    int node_at(std::size_t edge, const geom::Vec3& p) {
        constexpr double near = 0.1;  // of a side
        auto& chain = nodes_[edge];
        const auto at = [&](std::size_t i) {
            return points_[std::size_t(classes_.find(chain[i]))];
        };
        std::size_t best = 0;
        double least = std::numeric_limits<double>::infinity(), share = 0.0;
        for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
            const geom::SegmentPoint foot = geom::nearest_on_segment(p, at(i), at(i + 1));
            const double distance = (foot.point - p).norm();
            if (distance >= least) continue;
            least = distance;
            best = i;
            share = foot.share;
        }
        const std::size_t other = share < near ? best : best + 1;
        if ((share < near || share > 1.0 - near) && other > 0 && other + 1 < chain.size()) {
            points_[std::size_t(classes_.find(chain[other]))] = p;
            return chain[other];
        }
        const int middle = classes_.add();
        points_.push_back(p);
        split_all_sides(chain[best], chain[best + 1], middle);
        chain.insert(chain.begin() + std::ptrdiff_t(best) + 1, middle);
        return middle;
    }

    /// In all triangles that have the side, whatever face they are of.
    void split_all_sides(int a, int b, int middle) {
        const auto wanted = std::minmax({classes_.find(a), classes_.find(b)});
        const std::size_t count = triangles_.size();
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
                const int from = triangles_[i][k], to = triangles_[i][(k + 1) % 3];
                if (std::minmax({classes_.find(from), classes_.find(to)}) != wanted) continue;
                split_side(i, k, middle);
                break;
            }
        }
    }

    void split_side(std::size_t i, std::size_t k, int middle) {
        std::array<int, 3> made = triangles_[i];
        triangles_[i][(k + 1) % 3] = middle;
        made[k] = middle;
        triangles_.push_back(made);
        faces_.push_back(int(faces_[i]));
    }

    void add_features(SurfaceMesh& mesh, const SearchModel& model) {
        mesh.corners.assign(std::size_t(mesh.points.rows()), -1);
        const auto point = [&](int node) { return number_[std::size_t(classes_.find(node))]; };
        for (std::size_t i = 0; i < model.network.corners.size(); ++i) {
            const int vertex = model.network.corners[i].vertex;
            const int node = vertex < vertices_.Extent() ? vertex : parting_[std::size_t(vertex)];
            const int at = node >= 0 ? point(node) : -1;
            if (at >= 0) mesh.corners[std::size_t(at)] = int(i);
        }
        std::set<std::pair<int, int>> taken;
        for (const bool smooth : {false, true}) add_features(mesh, model, smooth, taken);
    }

    void add_features(SurfaceMesh& mesh, const SearchModel& model, bool smooth,
                      std::set<std::pair<int, int>>& taken) {
        const auto point = [&](int node) { return number_[std::size_t(classes_.find(node))]; };
        for (std::size_t i = 0; i < nodes_.size(); ++i) {
            std::size_t piece = 0;
            for (std::size_t k = 0; k + 1 < nodes_[i].size() && !pieces_[i].empty(); ++k) {
                const auto edge = std::size_t(pieces_[i][piece]);
                const int end = model.network.edges[edge].end;
                if (piece + 1 < pieces_[i].size() && nodes_[i][k + 1] == parting_[std::size_t(end)])
                    ++piece;
                if ((model.network.edges[edge].kind == EdgeKind::Smooth) != smooth) continue;
                const auto side = std::minmax({point(nodes_[i][k]), point(nodes_[i][k + 1])});
                if (side.first < 0 || side.first == side.second) continue;
                if (taken.insert(side).second)
                    mesh.features.push_back(
                        {side.first, side.second, model.features.curve_of(int(edge))});
            }
        }
    }

    TopTools_IndexedMapOfShape edges_, vertices_;
    std::vector<std::vector<int>> pieces_;  // of the network, by number of the edge in the shape
    std::vector<int> parting_;              // nodes where an edge is parted, by vertex; or -1
    std::vector<std::vector<int>> nodes_;   // along each edge of the shape
    std::map<std::size_t, std::vector<std::pair<int, int>>> chords_;  // of edges with two nodes
    DisjointSets classes_;  // nodes that are one point of the model
    std::vector<geom::Vec3> points_;
    std::vector<std::array<int, 3>> triangles_;
    std::vector<int> faces_;
    std::vector<int> number_;
};

/// Edges that more than two triangles use; which of them belong together would be a guess, so all
/// of them part there.
std::set<std::pair<int, int>> crowded_edges(const SurfaceMesh& mesh) {
    std::map<std::pair<int, int>, std::array<int, 2>> uses;  // in either direction
    for (const auto& t : mesh.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const int a = t[k], b = t[(k + 1) % 3];
            ++uses[std::minmax(a, b)][a < b ? 0 : 1];
        }
    }
    std::set<std::pair<int, int>> crowded;
    for (const auto& [edge, count] : uses)
        if (count[0] > 1 || count[1] > 1) crowded.insert(edge);
    return crowded;
}

/// Gives every fan of triangles at a vertex a vertex of its own.
void split_fans(SurfaceMesh& mesh) {
    const auto crowded = crowded_edges(mesh);
    const auto count = mesh.triangles.size();
    DisjointSets wedges(3 * count);  // corner k of triangle t is 3 t + k
    std::map<std::pair<int, int>, std::size_t> half;
    for (std::size_t t = 0; t < count; ++t)
        for (std::size_t k = 0; k < 3; ++k)
            half[{mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]}] = 3 * t + k;
    for (const auto& [edge, wedge] : half) {
        const auto twin = half.find({edge.second, edge.first});
        if (twin == half.end() || crowded.contains(std::minmax(edge.first, edge.second))) continue;
        const auto next = [](std::size_t w) { return int(w / 3 * 3 + (w % 3 + 1) % 3); };
        wedges.join(int(wedge), next(twin->second));
        wedges.join(next(wedge), int(twin->second));
    }
    std::map<int, int> vertex_of;  // by class
    std::vector<char> used(std::size_t(mesh.points.rows()), 0);
    std::vector<int> origin;
    std::map<int, std::vector<int>> copies;
    for (std::size_t t = 0; t < count; ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const int old = mesh.triangles[t][k];
            const int wedge = wedges.find(int(3 * t + k));
            auto found = vertex_of.find(wedge);
            if (found == vertex_of.end()) {
                int v = old;
                if (used[std::size_t(old)] != 0) {
                    v = int(mesh.points.rows()) + int(origin.size());
                    origin.push_back(old);
                }
                used[std::size_t(old)] = 1;
                copies[old].push_back(v);
                found = vertex_of.emplace(wedge, v).first;
            }
            mesh.triangles[t][k] = found->second;
        }
    }
    if (origin.empty()) return;
    const Eigen::Index before = mesh.points.rows();
    mesh.points.conservativeResize(before + Eigen::Index(origin.size()), 3);
    for (std::size_t i = 0; i < origin.size(); ++i) {
        mesh.points.row(before + Eigen::Index(i)) = mesh.points.row(origin[i]).eval();
        mesh.corners.push_back(mesh.corners[std::size_t(origin[i])]);
    }
    std::set<std::pair<int, int>> sides;
    for (const auto& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) sides.insert(std::minmax(t[k], t[(k + 1) % 3]));
    std::vector<FeatureSide> features;
    for (const FeatureSide& f : mesh.features)
        for (const int a : copies[f.v0])
            for (const int b : copies[f.v1])
                if (sides.contains(std::minmax(a, b)))
                    features.push_back({std::min(a, b), std::max(a, b), f.curve});
    mesh.features = std::move(features);
}

}  // namespace

SurfaceMesh surface_mesh(const CadModel& model, const SearchModel& search, double deflection_mm) {
    return guard_kernel<base::InputError>("triangulating", [&] {
        const SearchableShape copy = make_searchable(model.impl().shape);
        IMeshTools_Parameters parameters;
        parameters.Deflection = deflection_mm;
        parameters.Angle = angular_deflection_rad;
        parameters.InParallel = Standard_True;
        mesh_faces(copy.shape, parameters);
        Gluing gluing(copy.shape, search.network);
        int without = 0;
        for (std::size_t i = 0; i < copy.faces.size(); ++i)
            if (!gluing.add(copy.faces[i], int(i))) ++without;
        SurfaceMesh mesh = gluing.result(search);
        mesh.faces_without = without;
        if (mesh.triangles.empty())
            throw base::InputError("CAD model: no face can be triangulated; heal the file");
        split_fans(mesh);
        return mesh;
    });
}

}  // namespace patchwright::occ
