#include "report/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace patchwright::report {

namespace {

class SectionWriter {
  public:
    explicit SectionWriter(const RunReport& report)
        : report_(report), scale_(1.0 / base::millimetres_per(report.unit)) {
        if (report.input) diagonal_ = report.input->diagonal;
        if (diagonal_ == 0.0 && report.solid) diagonal_ = report.solid->bounds.diagonal();
    }

    std::vector<Section> write() {
        if (report_.verdict) verdict(*report_.verdict);
        if (report_.input) input(*report_.input);
        if (report_.cage) cage(*report_.cage);
        if (report_.polylines) polylines(*report_.polylines);
        if (report_.fit) fit(*report_.fit);
        if (report_.morph) morph(*report_.morph);
        if (report_.family) family(*report_.family);
        if (report_.patches) patches(*report_.patches);
        if (report_.solid) solid(*report_.solid);
        if (report_.details) details(*report_.details);
        if (report_.deviation) deviation(*report_.deviation);
        if (report_.continuity) continuity(*report_.continuity);
        if (report_.grid) grid(*report_.grid);
        times();
        return std::move(sections_);
    }

  private:
    template <class... Args>
    void row(std::string label, fmt::format_string<Args...> format, Args&&... args) {
        sections_.back().rows.emplace_back(std::move(label),
                                           fmt::format(format, std::forward<Args>(args)...));
    }
    /// Of the row that was added last.
    void brief() { sections_.back().brief.push_back(sections_.back().rows.size() - 1); }
    std::string unit(int power = 1) const {
        return fmt::format("{}{}", base::short_name(report_.unit),
                           power == 2   ? "^2"
                           : power == 3 ? "^3"
                                        : "");
    }
    std::string length(double mm) const { return fmt::format("{:.4g} {}", mm * scale_, unit()); }
    std::string relative(double mm) const {
        if (diagonal_ <= 0.0) return length(mm);
        return fmt::format("{} ({:.2g} of the diagonal)", length(mm), mm / diagonal_);
    }
    std::string place(const geom::Vec3& p) const {
        return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x() * scale_, p.y() * scale_,
                           p.z() * scale_);
    }
    void verdict(const measure::Verdict& v) {
        sections_.push_back({"Verdict", {}});
        for (const measure::Condition& c : v.conditions) {
            row(measure::name_of(c.requirement), "{} {}", c.met ? "met" : "MISSED:", value(c));
            if (!c.met) brief();
        }
    }
    std::string value(const measure::Condition& c) const {
        std::string text;
        switch (c.quantity) {
            case measure::Quantity::Length:
                text = fmt::format("{}, limit {}", relative(c.value), length(c.limit));
                break;
            case measure::Quantity::Area:
                text = fmt::format("{:.6g} {}", c.value * scale_ * scale_, unit(2));
                break;
            case measure::Quantity::Volume:
                text = fmt::format("{:.6g} {}", c.value * scale_ * scale_ * scale_, unit(3));
                break;
            case measure::Quantity::Angle:
                text = fmt::format("{:.3g} degrees, limit {:.3g}", c.value * 180.0 / M_PI,
                                   c.limit * 180.0 / M_PI);
                break;
            case measure::Quantity::Count:
                text = fmt::format("{:.0f}, limit {:.0f}", c.value, c.limit);
                break;
        }
        return c.at ? fmt::format("{} at {}", text, place(*c.at)) : text;
    }
    void input(const InputFigures& i) {
        sections_.push_back({"Input", {}});
        row("file", "{}", i.file);
        row("format", "{}, unit {}", i.schema.empty() ? i.format : i.schema,
            base::short_name(i.unit));
        if (!i.originating_system.empty()) row("written by", "{}", i.originating_system);
        row("content", "{} solids, {} faces, {} free edges", i.solids, i.faces, i.free_edges);
        brief();
        if (i.sewing_tolerance)
            row("sewn", "gaps up to {}, tolerance {}", length(i.largest_gap_closed.value_or(0.0)),
                length(*i.sewing_tolerance));
        if (i.holes_left_out > 0) row("narrow holes left out", "{}", i.holes_left_out);
        row("diagonal", "{}", length(i.diagonal));
    }
    void cage(const mesh::CageSummary& c) {
        sections_.push_back({"Cage", {}});
        row("size", "{} vertices, {} faces", c.vertices, c.faces);
        brief();
        row("features",
            "{} creases, {} corners, {} extraordinary vertices, {} boundary edges, {} pins",
            c.creases, c.corners, c.extraordinary, c.boundary_edges, c.pins);
        constexpr std::size_t most_bodies = 5;
        for (std::size_t i = 0; i < std::min(most_bodies, report_.layout.size()); ++i)
            row("layout", "{}", report_.layout[i]);
        if (report_.layout.size() > most_bodies)
            row("layout", "and {} bodies more", report_.layout.size() - most_bodies);
    }
    void polylines(const mesh::PolylineSummary& p) {
        sections_.push_back({"Polylines", {}});
        row("size", "{}, {} of them closed, {} points", p.count, p.closed, p.points);
        brief();
    }
    void fit(const FitFigures& f) {
        sections_.push_back({"Fit", {}});
        row("tolerance", "{}", relative(f.tolerance));
        for (std::size_t i = 0; i < f.levels.size(); ++i) {
            const fit::FitLevel& l = f.levels[i];
            row(fmt::format("level {}", i),
                "{} vertices, {} projections, {} CGLS steps: max {} and {} the other way, rms {}, "
                "{:.2f} s",
                l.vertices, l.projections, l.cgls_steps, length(l.max_mm), length(l.reverse_max_mm),
                length(l.rms_mm), l.seconds);
        }
        if (f.levels.empty()) return;
        sections_.back().brief.push_back(1 + std::size_t(f.best_level));
        const fit::FitLevel& best = f.levels[std::size_t(f.best_level)];
        if (f.best_level + 1 < int(f.levels.size()))
            row("taken", "level {}: later ones were no better", f.best_level);
        if (best.chains_on_features > 0)
            row("sharp chains", "{} on the input's, {} from them at most", best.chains_on_features,
                relative(best.curve_max_mm));
        if (const auto& to = best.interpolated_mm)
            row("interpolated", "all vertices' limit points to {}", length(*to));
        if (f.symmetry_axis) row("symmetry", "plane {} = 0 kept", "xyz"[*f.symmetry_axis]);
        if (const auto& off = f.off_catmull_clark_mm)
            row("crease rule", "runout, {} off Catmull-Clark", relative(*off));
        for (const fit::WarpStage& s : f.carried)
            row("carried", "{}: {} steps to max {}, rms {}, {:.2f} s",
                s.cells == 0 ? "affine map" : fmt::format("lattice of {} cells", s.cells), s.steps,
                length(s.max_mm), length(s.rms_mm), s.seconds);
        row("fairness",
            "curvature variation {:.4g} to {:.4g}, skew {:.3f} to {:.3f}, uneven {:.3f} "
            "to {:.3f}, least angle {:.1f} to {:.1f} degrees",
            f.before.curvature_variation, f.after.curvature_variation, f.before.skew, f.after.skew,
            f.before.uneven_spacing, f.after.uneven_spacing,
            f.before.least_angle_rad * 180.0 / M_PI, f.after.least_angle_rad * 180.0 / M_PI);
    }
    void morph(const MorphFigures& m) {
        sections_.push_back({"Morph", {}});
        const auto largest = [&](double MorphFigures::Step::*figure) {
            double value = 0.0;
            for (const MorphFigures::Step& s : m.steps) value = std::max(value, s.*figure);
            return length(value);
        };
        row("displaced", "{} points by up to {}, control points by up to {}", m.points,
            largest(&MorphFigures::Step::largest_displacement),
            largest(&MorphFigures::Step::largest_moved));
        brief();
        row("extrapolation", "{:.3g}", m.extrapolation);
        for (std::size_t i = 0; m.steps.size() > 1 && i < m.steps.size(); ++i)
            row(i == 0 ? "steps" : "", "{}: control points by up to {}", m.steps[i].file,
                length(m.steps[i].largest_moved));
        if (!m.forces) return;
        const geom::Vec3& f = m.forces->given.force;
        row("forces", "{} places, sum ({:.4g}, {:.4g}, {:.4g}), conserved to {:.1g}",
            m.forces->places, f.x(), f.y(), f.z(), m.forces->force_error);
        brief();
        row("moment", "{} about the origin, conserved to {:.1g}", place(m.forces->given.moment),
            m.forces->moment_error);
        brief();
    }
    void family(const FamilyFigures& f) {
        sections_.push_back({"Family", {}});
        for (const FamilyFigures::Member& m : f.members) {
            row(m.file, "{}, {:.2f} s", m.sentence, m.seconds);
            if (!m.met) brief();
        }
        for (std::size_t k = 0; k < f.modes.size(); ++k) {
            row(fmt::format("mode {}", k + 1),
                "standard deviation {} (root mean square of the surface), {:.4g} % of the variance "
                "with those before",
                length(f.modes[k].deviation), 100.0 * f.modes[k].share);
            brief();
        }
    }
    void patches(const PatchFigures& p) {
        sections_.push_back({"Patches", {}});
        row("count", "{} bicubic patches ({}), {} control points", p.count, p.covering,
            p.control_points);
        brief();
        if (p.caps.empty()) return;
        patch::CapReport worst;
        int depth = 0, kinked = 0, planeless = 0;
        for (const patch::CapReport& cap : p.caps) {
            if (cap.distance_mm >= worst.distance_mm) worst = cap;
            depth = std::max(depth, cap.depth);
            kinked += cap.smooth ? 0 : 1;
            planeless += cap.limit_has_plane ? 0 : 1;
        }
        row("caps", "{} at extraordinary vertices ({}), {} knot levels at most", p.caps.size(),
            p.continuity, depth);
        row("  off the limit", "{} at most, at vertex {} with {} faces",
            relative(worst.distance_mm), worst.vertex.value, worst.faces);
        if (p.continuity == "g1" && kinked > 0)
            row("  not smooth", "{}, of those {} where the limit surface has no tangent plane",
                kinked, planeless);
    }
    void solid(const SolidFigures& s) {
        sections_.push_back({"Model as read back", {}});
        row("file", "{}", s.file);
        row("content", "{} solids, {} shells, {} faces, {} edges, {} vertices", s.solids,
            s.shells_closed + s.shells_open, s.faces, s.edges, s.vertices);
        brief();
        for (const auto& [kind, count] : s.faces_by_kind)
            row(fmt::format("  {}", kind), "{}", count);
        row("state", "{}, {}",
            s.closed ? "closed" : fmt::format("open ({} free edges)", s.free_edges),
            s.valid ? "valid" : "NOT VALID");
        if (report_.details) brief();
        if (s.nonmanifold_edges > 0) row("non-manifold", "{} edges", s.nonmanifold_edges);
        row("area", "{:.6g} {}", s.area * scale_ * scale_, unit(2));
        if (report_.details) brief();
        if (s.solids > 0) row("volume", "{:.6g} {}", s.volume * scale_ * scale_ * scale_, unit(3));
        row("tolerance", "{}", length(s.max_tolerance));
        row("box", "{} to {}", place(s.bounds.min), place(s.bounds.max));
        if (report_.details) brief();
    }
    void details(const DetailFigures& d) {
        sections_.push_back({"Details", {}});
        row("smallest face", "number {}, {:.4g} {}", d.smallest_face,
            d.smallest_area * scale_ * scale_, unit(2));
        brief();
        if (d.narrowest_face)
            row("narrowest face", "number {}, {} wide", *d.narrowest_face,
                length(d.narrowest_width));
        if (d.shortest_edge)
            row("shortest edge", "{} at {}", relative(*d.shortest_edge), place(d.shortest_edge_at));
        row("tolerances", "vertices {}, edges {}, faces {}", length(d.vertex_tolerance),
            length(d.edge_tolerance), length(d.face_tolerance));
        if (d.smallest_open_gap && d.largest_open_gap)
            row("free edges", "{} to {} from the next one", relative(*d.smallest_open_gap),
                relative(*d.largest_open_gap));
        row("edges", "{} sharp, {} smooth", d.sharp_edges, d.smooth_edges);
        row("features", "{} sharp curves, {} free curves, {} corners", d.sharp_curves,
            d.free_curves, d.corners);
        brief();
        row("kinks", "{} faces with kinks inside; across smooth edges up to {:.3g} degrees at {}",
            d.kinked_faces, d.largest_kink_rad * 180.0 / M_PI, place(d.largest_kink_at));
        brief();
        row("centre of mass", "{} of the {}", place(d.centre_of_mass),
            d.moments_of_volume ? "volume" : "surface");
        const int power = d.moments_of_volume ? 5 : 4;
        const double moment = std::pow(scale_, power);
        row("moments", "{:.4g}, {:.4g}, {:.4g} {}^{}", d.principal_moments[0] * moment,
            d.principal_moments[1] * moment, d.principal_moments[2] * moment,
            base::short_name(report_.unit), power);
        if (d.named_faces + d.coloured_faces > 0)
            row("faces", "{} with names, {} with colours", d.named_faces, d.coloured_faces);
        if (d.duplicates_dropped + d.slivers_dropped + d.faces_turned > 0)
            row("healed", "{} duplicates and {} slivers left out, {} faces turned",
                d.duplicates_dropped, d.slivers_dropped, d.faces_turned);
        for (const auto& [a, b] : d.overlapping_solids) row("overlap", "solids {} and {}", a, b);
    }
    void deviation(const DeviationFigures& d) {
        sections_.push_back({"Deviation", {}});
        const auto one = [&](const char* label, const measure::Deviation& side) {
            row(label, "max {} at {}, rms {}, 95 % {}, 99 % {}", relative(side.max), place(side.at),
                length(side.rms), length(side.p95), length(side.p99));
            brief();
            if (side.bound) row("  anywhere", "at most {}", relative(*side.bound));
            for (std::size_t i = 1; i < side.worst.size(); ++i) {
                row(i == 1 ? "  then" : "", "{} at {}, face {}", length(side.worst[i].distance),
                    place(side.worst[i].point), side.worst[i].face);
            }
        };
        one("output to input", d.output_to_input);
        one("input to output", d.input_to_output);
        if (d.fairness) fairness(*d.fairness);
        if (d.sharp_curves_input + d.sharp_curves_output == 0) return;
        row("sharp curves", "{} in the input, {} in the output", d.sharp_curves_input,
            d.sharp_curves_output);
        const auto curves = [&](const char* label, const std::optional<measure::Deviation>& side) {
            if (side)
                row(label, "max {} at {}, rms {}", relative(side->max), place(side->at),
                    length(side->rms));
        };
        curves("  output to input", d.sharp_output_to_input);
        curves("  input to output", d.sharp_input_to_output);
        if (!d.long_sharp) return;
        const auto& l = *d.long_sharp;
        row("  kept", "{} of {} longer than {} lie within {} of edges of the output",
            l.count - int(l.missed.size()), l.count, length(l.longer_than), length(l.tolerance));
        for (std::size_t i = 0; i < std::min<std::size_t>(l.missed.size(), 5); ++i)
            row("  missed", "{} of {} at {}", length(l.missed[i].distance),
                length(l.missed[i].length), place(l.missed[i].at));
    }
    void fairness(const measure::RelativeFairness& f) {
        if (f.samples == 0) return;
        const measure::Distribution &n = f.normal_angle_rad, &c = f.curvature_difference;
        constexpr double degrees = 180.0 / M_PI;
        row("normals", "max {:.3g} degrees at {}, rms {:.3g}, 95 % {:.3g}, 99 % {:.3g}",
            n.max * degrees, place(n.at), n.rms * degrees, n.p95 * degrees, n.p99 * degrees);
        brief();
        row("mean curvature",
            "max {:.3g} over the diagonal at {}, rms {:.3g}, 95 % {:.3g}, "
            "99 % {:.3g}",
            c.max, place(c.at), c.rms, c.p95, c.p99);
        if (f.lines > 0)
            row("inflections", "{} in the input, {:+} in the output, along {} lines", f.inflections,
                f.extra_inflections, f.lines);
    }
    void continuity(const patch::Continuity& c) {
        sections_.push_back({"Continuity", {}});
        row("gap", "{}", relative(c.max_gap_mm));
        row("kink", "{:.3g} degrees at {} over {} smooth edges", c.max_kink_rad * 180.0 / M_PI,
            place(c.kink_at), c.smooth_edges);
        brief();
        if (c.near_singular_kink_rad > 0.0)
            row("  within reach", "{:.3g} degrees at {}, beside a vertex without a tangent plane",
                c.near_singular_kink_rad * 180.0 / M_PI, place(c.near_singular_kink_at));
        row("creases", "{} edges", c.crease_edges);
    }
    void grid(const GridFigures& g) {
        const grid::GridQuality& q = g.quality;
        constexpr double degrees = 180.0 / M_PI;
        sections_.push_back({"Grid", {}});
        row("file", "{}", g.file);
        if (g.local)
            row("size", "{} points, {} cells, {} hanging nodes, {} levels", q.points, q.cells,
                g.local->hanging_nodes, g.local->levels);
        else
            row("size", "{} blocks, {} interfaces, {} points, {} cells", q.blocks, q.interfaces,
                q.points, q.cells);
        brief();
        const auto one = [&](const char* label, const grid::Spread& s, double factor,
                             const char* unit) {
            if (s.count == 0) return;
            row(label, "{:.4g}{} at {}, mean {:.4g}", s.worst * factor, unit, place(s.at),
                s.mean * factor);
        };
        one("smallest angle", q.min_angle, degrees, " degrees");
        if (q.min_angle.count > 0) brief();
        one("skewness", q.skewness, 1.0, "");
        one("aspect ratio", q.aspect, 1.0, "");
        one("stretching", q.stretching, 1.0, "");
        one("off orthogonal", q.orthogonality, degrees, " degrees");
        one("block edges turn", q.turning, degrees, " degrees");
        one("  cells jump", q.jump, 1.0, "");
        if (!q.extraordinary.empty()) {
            double low = M_PI, high = 0.0, jump = 1.0;
            for (const grid::VertexQuality& v : q.extraordinary) {
                low = std::min(low, v.min_angle_rad);
                high = std::max(high, v.max_angle_rad);
                jump = std::max(jump, v.size_ratio);
            }
            row("extraordinary", "{} vertices, angles {:.4g} to {:.4g} degrees, cells jump {:.4g}",
                q.extraordinary.size(), low * degrees, high * degrees, jump);
        }
        row("folded cells", "{}", q.folded);
        brief();
        if (q.scaled_jacobian) {
            one("scaled Jacobian", *q.scaled_jacobian, 1.0, "");
            row("negative volumes", "{}", q.negative);
            brief();
        }
    }
    void times() {
        if (report_.seconds.empty()) return;
        sections_.push_back({"Time", {}});
        double total = 0.0;
        std::string parts;
        for (const auto& [stage, seconds] : report_.seconds) {
            total += seconds;
            parts += fmt::format("{}{} {:.2f}", parts.empty() ? "" : ", ", stage, seconds);
        }
        row("seconds", "{:.2f} ({})", total, parts);
        brief();
        row("peak memory", "{:.0f} MB", report_.peak_memory_mb);
    }

    const RunReport& report_;
    double scale_;
    double diagonal_ = 0.0;
    std::vector<Section> sections_;
};

}  // namespace

std::vector<Section> sections(const RunReport& report) { return SectionWriter(report).write(); }

}  // namespace patchwright::report
