#include "cage/blocks/block_borders.h"
#include "cage/blocks/layout_mesh.h"
#include "cage/field/body_blocks.h"
#include "cage/kept_curves.h"
#include "cage/poll.h"
#include "cage/remesh/mesh_part.h"
#include "cage/remesh/quads.h"
#include "cage/remesh/remesh.h"
#include "cage/sections/recognise.h"
#include "cage/symmetry/half_surface.h"

#include <patchwright/base/error.h>
#include <patchwright/cage/make_cage.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

namespace patchwright::cage {

namespace {

// Largest distance of the triangles from the model, of its own diagonal, also where it is one body
// of several: sections of small ones are read off as well as off large ones. Remeshed cages take
// their points from the model itself.
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

/// One cage of all parts.
mesh::Cage joined(const std::vector<Blocks>& parts) {
    mesh::TopologyInput input;
    std::map<std::string, int> groups;
    std::vector<geom::Vec3> points;
    for (const Blocks& part : parts) {
        points.insert(points.end(), part.points.begin(), part.points.end());
        add_to(input, part);
        for (const std::string& name : part.groups) {
            const auto [group, added] = groups.emplace(name, int(input.group_names.size()));
            if (added) input.group_names.push_back(name);
            input.face_group.push_back(group->second);
        }
    }
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
    int known = 0;                                                  ///< bodies that are recognised
    bool from_field = false, from_faces = false, remeshed = false;  ///< some of the others
    bool faces_refused = false;  ///< some have no blocks along their faces
};

/// Feature curves that blocks of one kind keep as lines.
struct BlockBorders {
    std::vector<char> of_field, of_faces;
};

BlockBorders block_borders_of(const geom::SurfaceMesh& mesh, const CageSource& source,
                              const CageOptions& options) {
    BlockBorders borders;
    const auto kept = kept_curves(source.reference, Lines::OfBlocks, source.poll);
    if (options.blocks != BlockWay::Faces) {
        borders.of_field = kept;
        keep_continuations(source.reference, borders.of_field);
    }
    if (options.blocks != BlockWay::Field)
        borders.of_faces = block_borders(mesh, source.reference, kept, source.poll);
    return borders;
}

enum class LaidOut { Not, ByField, AlongFaces };

/// Nothing where there are no blocks, or none that are a cage.
std::optional<int> extraordinary_vertices(BodyBlocks& made) {
    if (!made.blocks) return std::nullopt;
    try {
        return mesh::summarise(*joined({*made.blocks}).topology).extraordinary;
    } catch (const base::InputError& error) {
        // Blocks of two faces may meet twice.
        made = {std::nullopt, error.what()};
        return std::nullopt;
    }
}

/// Lays blocks on bodies that are not recognised.
class BodyLayouts {
  public:
    BodyLayouts(const geom::SurfaceMesh& mesh, const std::vector<SurfaceBody>& bodies,
                const CageSource& source, const CageOptions& options)
        : mesh_(mesh),
          bodies_(bodies),
          source_(source),
          options_(options),
          halves_(bodies.size()) {}

    /// Blocks of a body, into `part` where there are any: those with fewer extraordinary vertices.
    /// @param text           what came of it, for the user
    /// @param faces_refused  set where it has none along its faces
    LaidOut lay_out(std::size_t number, double scale, std::optional<Blocks>& part,
                    std::string& text, bool& faces_refused) {
        if (!source_.reference.has_cad_faces()) {
            text += ", no blocks (triangles have no faces to lay blocks along)";
            return LaidOut::Not;
        }
        if (mesh_.faces_without > 0) {
            text += ", no blocks (faces could not be triangulated)";
            return LaidOut::Not;
        }
        if (!halves_[number]) halves_[number] = half_of(bodies_[number]);
        if (const Half& half = *halves_[number]; half.surface) {
            text += ", its own mirror image";
            const BlockSource from{half.body, *half.surface, source_.names, half.surface.get()};
            const LaidOut way = lay_out(from, half.borders, scale, part, text, faces_refused);
            if (way != LaidOut::Not) return way;
            text += ", as a whole";
            faces_refused = false;
        }
        if (!borders_) borders_ = block_borders_of(mesh_, source_, options_);
        return lay_out({bodies_[number], source_.reference, source_.names}, *borders_, scale, part,
                       text, faces_refused);
    }

  private:
    /// Of a body that is its own mirror image; else without a surface.
    struct Half {
        std::unique_ptr<HalfSurface> surface;
        SurfaceBody body;
        BlockBorders borders;
    };

    LaidOut lay_out(const BlockSource& from, const BlockBorders& borders, double scale,
                    std::optional<Blocks>& part, std::string& text, bool& faces_refused) {
        std::optional<int> by_field, along_faces;  // their extraordinary vertices
        BodyBlocks of_field, of_faces;
        if (options_.blocks != BlockWay::Faces) {
            of_field = field_blocks(from, borders.of_field, options_, source_.poll, scale);
            by_field = extraordinary_vertices(of_field);
            if (!by_field)
                text += fmt::format(", no blocks by a cross field ({})", of_field.refused);
        }
        if (options_.blocks != BlockWay::Field) {
            of_faces = face_blocks(from, borders.of_faces, options_, source_.poll, scale);
            along_faces = extraordinary_vertices(of_faces);
            if (!along_faces)
                text += fmt::format(", no blocks along its faces ({})", of_faces.refused);
            faces_refused = faces_refused || !along_faces;
        }
        const bool is_field = by_field && (!along_faces || *by_field < *along_faces);
        if (!is_field && !along_faces) return LaidOut::Not;
        BodyBlocks& taken = is_field ? of_field : of_faces;
        text += is_field ? ", blocks by a cross field" : ", blocks along its faces";
        if (taken.closed_strips > 0)
            text += fmt::format(
                " (faces that became lines, as they are narrower than {} of the "
                "tolerance: {})",
                closed_share, taken.closed_strips);
        part = std::move(taken.blocks);
        return is_field ? LaidOut::ByField : LaidOut::AlongFaces;
    }

    [[nodiscard]] Half half_of(const SurfaceBody& body) const {
        Half half;
        const auto plane = mirror_plane(
            body, source_.reference,
            mirrored_within * options_.tolerance_rel * source_.reference.size(), source_.poll);
        if (plane) half.surface = HalfSurface::of(body, source_.reference, *plane, source_.poll);
        if (!half.surface) return half;
        half.body = half.surface->body();
        half.borders = block_borders_of(*half.body.mesh,
                                        {*half.surface, source_.names, source_.poll}, options_);
        return half;
    }

    // Of the tolerance: how near a body must be to its mirror image to be laid out by halves.
    static constexpr double mirrored_within = 0.1;

    const geom::SurfaceMesh& mesh_;
    const std::vector<SurfaceBody>& bodies_;
    const CageSource& source_;
    const CageOptions& options_;
    std::vector<std::optional<Half>> halves_;  ///< those that were looked for
    std::optional<BlockBorders> borders_;      ///< of bodies that are laid out as a whole
};

Aligned aligned(const geom::SurfaceMesh& mesh, const CageSource& source,
                const CageOptions& options) {
    const std::vector<SurfaceBody> bodies = bodies_of(mesh);
    BodyLayouts layouts(mesh, bodies, source, options);
    const double tolerance_mm = options.tolerance_rel * source.reference.size();
    double fineness = options.fineness;
    for (int round = 0;; ++round) {
        // Wings get lines along the span by the root of the fineness and rings by all of it, so
        // that the number of faces goes by its power 3/2: lengths by the power -3/4 do the same.
        const double scale = std::pow(fineness / options.fineness, -0.75);
        Aligned result;
        std::vector<std::optional<Blocks>> found;
        std::vector<std::size_t> laid_out;
        for (const SurfaceBody& body : bodies) {
            Recognised one =
                recognise(body, source.reference,
                          {.fineness = fineness, .tolerance_mm = tolerance_mm}, source.poll);
            if (one.blocks) {
                ++result.known;
            } else if (options.blocks == BlockWay::None) {
                one.text += ", no blocks asked for";
                result.remeshed = true;
            } else if (!result.remeshed) {
                const LaidOut way = layouts.lay_out(found.size(), scale, one.blocks, one.text,
                                                    result.faces_refused);
                if (way != LaidOut::Not) laid_out.push_back(found.size());
                result.from_field = result.from_field || way == LaidOut::ByField;
                result.from_faces = result.from_faces || way == LaidOut::AlongFaces;
                result.remeshed = way == LaidOut::Not;
            }
            result.texts.push_back(std::move(one.text));
            found.push_back(std::move(one.blocks));
        }
        // Blocks start coarse and are refined often, remeshed parts are not: one fit is for either.
        if (result.remeshed) {
            for (const std::size_t i : laid_out) {
                found[i].reset();
                result.texts[i] += ", remeshed with all that are not recognised";
            }
        }
        if (result.remeshed) result.from_field = result.from_faces = false;
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
        result.from_field = found.from_field;
        result.from_faces = found.from_faces;
        result.faces_refused = found.faces_refused;
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
