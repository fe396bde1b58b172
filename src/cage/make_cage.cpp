#include "cage/blocks/brep_cage.h"
#include "cage/poll.h"
#include "cage/remesh/mesh_part.h"
#include "cage/remesh/quads.h"
#include "cage/remesh/remesh.h"
#include "cage/sections/recognise.h"
#include "cage/tight_radius.h"

#include <patchwright/base/error.h>
#include <patchwright/cage/make_cage.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace patchwright::cage {

namespace {

// Largest distance of the triangles from the model, of the diagonal. Remeshed cages take their
// points from the model itself; sections of wings are read off the triangles.
constexpr double remeshing_deflection_rel = 1e-3, sections_deflection_rel = 1e-4;

/// One a face, as groups of the cage are named.
std::vector<std::string> group_names(const geom::ModelSurface& model) {
    std::vector<std::string> names = model.face_names();
    const char* kind = model.has_cad_faces() ? "face" : "region";
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i].empty()) names[i] = fmt::format("{}_{}", kind, i + 1);
        for (char& c : names[i])
            if (c == ' ' || c == '\t' || c == '\n' || c == '\r') c = '_';
    }
    return names;
}

/// Whether the surface is rounded too tightly across a curve for faces of a cage, on most of it.
bool runs_along_tight_rounding(int curve, const geom::ModelSurface& reference, Poll& poll) {
    constexpr int samples = 9;
    const double length = reference.features().curves[std::size_t(curve)].length;
    const double tightest = tight_radius_rel * reference.bounds().diagonal();
    int tight = 0;
    for (int k = 0; k < samples; ++k) {
        poll();
        const auto at = reference.point_on_curve(curve, length * (k + 0.5) / samples);
        const auto bend = reference.curvature(reference.foot_point(at.point));
        if (!bend) continue;
        double across = 0.0;
        for (std::size_t j = 0; j < 2; ++j) {
            const double along = bend->direction[j].dot(at.tangent);
            across += bend->value[j] * (1.0 - along * along);
        }
        tight += std::abs(across) * tightest > 1.0 ? 1 : 0;
    }
    return 2 * tight > samples;
}

/// Curves that cages keep as lines: all sharp and free ones, and smooth ones along edges that are
/// rounded too tightly for faces of a cage, as those of blades are; in cages from triangles also
/// smooth ones at which the normal turns by a few degrees.
enum class Lines { OfTriangles, OfBlocks };

std::vector<char> kept_curves(const geom::ModelSurface& reference, Lines lines, Poll& poll) {
    // 6 degrees, a third of what is sharp: triangles across such a curve would smooth it away.
    constexpr double slight_bend_rad = 0.1;
    // Of the diagonal: shorter smooth curves are seams between small faces.
    constexpr double shortest_smooth_rel = 0.02;
    const double diagonal = reference.bounds().diagonal();
    const auto& curves = reference.features().curves;
    std::vector<char> kept;
    for (std::size_t i = 0; i < curves.size(); ++i) {
        const geom::FeatureCurve& curve = curves[i];
        const bool is_long = curve.length > shortest_smooth_rel * diagonal;
        const bool bends =
            lines == Lines::OfTriangles && curve.greatest_angle_rad > slight_bend_rad;
        kept.push_back(curve.kind != geom::FeatureKind::Smooth ||
                       (is_long && (bends || runs_along_tight_rounding(int(i), reference, poll))));
    }
    return kept;
}

/// One cage of all parts.
mesh::Cage joined(const std::vector<Blocks>& parts) {
    mesh::TopologyInput input;
    std::map<std::string, int> groups;
    std::vector<geom::Vec3> points;
    for (const Blocks& part : parts) {
        const int base = int(points.size());
        points.insert(points.end(), part.points.begin(), part.points.end());
        for (std::size_t i = 0; i < part.faces.size(); ++i) {
            input.face_sizes.push_back(int(part.faces[i].size()));
            for (const int v : part.faces[i]) input.face_vertices.push_back(base + v);
            const auto [group, added] =
                groups.emplace(part.groups[i], int(input.group_names.size()));
            if (added) input.group_names.push_back(part.groups[i]);
            input.face_group.push_back(group->second);
        }
        for (const auto& [a, b] : part.creases)
            input.creases.push_back({base + a, base + b, mesh::infinite_sharpness});
        for (const int v : part.corners)
            input.corners.push_back({base + v, mesh::infinite_sharpness});
    }
    input.vertex_count = int(points.size());
    geom::Points rows(Eigen::Index(points.size()), 3);
    for (std::size_t i = 0; i < points.size(); ++i) rows.row(Eigen::Index(i)) = points[i];
    // Shells of hollows face inward, as the reference does there.
    return mesh::build_cage(std::move(input), std::move(rows), "layout", mesh::Facing::AsGiven)
        .cage;
}

// How often lengths are scaled towards CageOptions::target_faces; the number is met where the
// logarithm of its ratio is less. Every scaling makes a whole cage.
constexpr int scalings = 4;
constexpr double log_ratio_met = 0.2;
// Blocks along faces that need more quads than this are no simple layout any more, and remeshing
// makes better shaped ones.
constexpr std::size_t most_quads_along_faces = 4000;

bool is_met(double ratio) { return std::abs(std::log(ratio)) < log_ratio_met; }

/// What a cage is made from.
struct CageSource {
    const geom::ModelSurface& reference;
    std::vector<std::string> names;  ///< one a face, for groups
    Poll& poll;
};

Blocks remeshed(const SurfaceBody& body, const CageSource& source, const CageOptions& options,
                double scale) {
    geom::EditableMesh mesh(
        part_of(body, kept_curves(source.reference, Lines::OfTriangles, source.poll)));
    RemeshOptions remeshing;
    remeshing.size.tolerance_rel = options.tolerance_rel;
    remeshing.size.fineness = options.fineness;
    remeshing.size.scale = scale;
    remeshing.size.finer_at = options.finer_at;
    remesh(mesh, source.reference, remeshing, source.poll);
    return quad_blocks(mesh, source.reference, source.names, source.poll);
}

std::vector<Blocks> all_remeshed(const geom::SurfaceMesh& surface, const CageSource& source,
                                 const CageOptions& options, double scale) {
    std::vector<Blocks> parts;
    for (const SurfaceBody& body : bodies_of(surface))
        parts.push_back(remeshed(body, source, options, scale));
    return parts;
}

std::size_t face_count(const std::vector<Blocks>& parts) {
    std::size_t count = 0;
    for (const Blocks& part : parts) count += part.faces.size();
    return count;
}

/// Blocks of every body that is recognised; of the others blocks along their faces, or if one of
/// them has none, remeshed ones, but only where at least one is recognised and `remesh` allows it.
/// Else there are no parts, only texts.
struct Aligned {
    std::vector<Blocks> parts;
    std::vector<std::string> texts;
    int known = 0;                              ///< bodies that are recognised
    bool from_faces = false, remeshed = false;  ///< some of the others
};

/// Blocks along the faces of a body, into `part` where there are any.
/// @return what came of it, for the user
std::string lay_out_blocks(const SurfaceBody& body, const std::vector<char>& borders,
                           const CageSource& source, const CageOptions& options, double scale,
                           std::optional<Blocks>& part) {
    if (!source.reference.has_cad_faces())
        return "no blocks (triangles have no faces to lay blocks along)";
    if (body.mesh->faces_without > 0) return "no blocks (faces could not be triangulated)";
    BodyBlocks made =
        brep_blocks(body, borders, source.reference, source.names, options, source.poll, scale);
    if (!made.blocks) return fmt::format("no blocks ({})", made.refused);
    try {
        joined({*made.blocks});
    } catch (const base::InputError& error) {
        // Blocks of two faces may meet twice: then they are no cage.
        return fmt::format("no blocks ({})", error.what());
    }
    part = std::move(*made.blocks);
    return "blocks along its faces";
}

Aligned aligned(const geom::SurfaceMesh& mesh, const CageSource& source,
                const CageOptions& options) {
    const std::vector<SurfaceBody> bodies = bodies_of(mesh);
    std::vector<char> borders;
    double fineness = options.fineness;
    for (int round = 0;; ++round) {
        // Wings get lines along the span by the root of the fineness and rings by all of it, so
        // that the number of faces goes by its power 3/2: lengths by the power -3/4 do the same.
        const double scale = std::pow(fineness / options.fineness, -0.75);
        Aligned result;
        std::vector<std::optional<Blocks>> found;
        std::vector<std::size_t> along_faces;
        for (const SurfaceBody& body : bodies) {
            Recognised one = recognise(body, source.reference, fineness, source.poll);
            if (one.blocks) {
                ++result.known;
            } else if (!result.remeshed) {
                if (borders.empty() && source.reference.has_cad_faces())
                    borders = block_borders(
                        mesh, source.reference,
                        kept_curves(source.reference, Lines::OfBlocks, source.poll), source.poll);
                one.text +=
                    ", " + lay_out_blocks(body, borders, source, options, scale, one.blocks);
                if (one.blocks) along_faces.push_back(found.size());
                result.remeshed = !one.blocks;
            }
            result.texts.push_back(std::move(one.text));
            found.push_back(std::move(one.blocks));
        }
        std::size_t faces = 0;
        for (const std::size_t i : along_faces) faces += found[i]->faces.size();
        if (faces > most_quads_along_faces && options.method == Method::Auto &&
            !options.target_faces) {
            result.remeshed = true;
            result.texts[along_faces.back()] += fmt::format(" ({} quads, too many)", faces);
        }
        // Blocks start coarse and are refined often, remeshed parts are not: one fit is for either.
        if (result.remeshed) {
            for (const std::size_t i : along_faces) {
                found[i].reset();
                result.texts[i] += ", remeshed with all that are not recognised";
            }
        }
        result.from_faces = !result.remeshed && !along_faces.empty();
        const bool none =
            std::none_of(found.begin(), found.end(), [](const auto& b) { return b.has_value(); });
        if (none || (result.remeshed && options.method == Method::Aligned)) return result;
        for (std::size_t i = 0; i < found.size(); ++i)
            result.parts.push_back(found[i] ? std::move(*found[i])
                                            : remeshed(bodies[i], source, options, scale));
        if (!options.target_faces || round == scalings) return result;
        const double ratio = *options.target_faces / double(face_count(result.parts));
        if (is_met(ratio)) return result;
        fineness *= std::pow(ratio, 2.0 / 3.0);
    }
}

std::string problem_with(const CageOptions& options) {
    if (!(options.tolerance_rel > 0.0)) return "CageOptions::tolerance_rel must be positive";
    if (!(options.fineness > 0.0)) return "CageOptions::fineness must be positive";
    if (options.target_faces && *options.target_faces <= 0)
        return "CageOptions::target_faces must be positive";
    for (const FinerRegion& region : options.finer_at)
        if (!(region.edge_length_factor > 0.0))
            return "FinerRegion::edge_length_factor must be positive";
    return {};
}

}  // namespace

CageResult make_cage(const geom::ModelSurface& model, const CageOptions& options) {
    if (const std::string problem = problem_with(options); !problem.empty())
        throw base::InvalidArgument(problem);
    Poll poll(options.progress);
    poll();
    const CageSource source{model, group_names(model), poll};
    const double diagonal = model.bounds().diagonal();
    CageResult result;
    std::vector<Blocks> parts;
    if (options.method != Method::Remesh) {
        const geom::SurfaceMesh fine = model.surface_mesh(sections_deflection_rel * diagonal);
        Aligned found = aligned(fine, source, options);
        parts = std::move(found.parts);
        if (!parts.empty()) result.recognised = found.known;
        result.layout = std::move(found.texts);
        result.from_faces = found.from_faces;
        if (!found.remeshed) result.method = Method::Aligned;
        if (parts.empty() && options.method == Method::Aligned)
            throw base::InputError(
                fmt::format("no layout was recognised for the model ({}); use --layout remesh or "
                            "auto",
                            fmt::join(result.layout, "; ")));
        if (parts.empty()) result.notices.push_back("remeshed, as no layout of blocks was found");
    }
    if (parts.empty()) {
        const geom::SurfaceMesh surface = model.surface_mesh(remeshing_deflection_rel * diagonal);
        parts = all_remeshed(surface, source, options, 1.0);
        double scale = 1.0;
        for (int round = 0; round < scalings && options.target_faces; ++round) {
            const double ratio = double(face_count(parts)) / *options.target_faces;
            if (is_met(ratio)) break;
            scale *= std::sqrt(ratio);
            parts = all_remeshed(surface, source, options, scale);
        }
        if (surface.faces_without > 0)
            result.notices.push_back(
                fmt::format("{} faces could not be triangulated and are holes in the cage",
                            surface.faces_without));
    }
    result.cage = joined(parts);
    return result;
}

}  // namespace patchwright::cage
