#include "report/json_deviation.h"

#include <patchwright/base/version.h>
#include <patchwright/report/run_report.h>

#include <algorithm>
#include <cmath>

namespace patchwright::report {

namespace {

constexpr double degrees = 180.0 / M_PI;

/// Converts millimetres to the report's unit.
class Writer {
  public:
    explicit Writer(const RunReport& report)
        : report_(report), scale_(1.0 / base::millimetres_per(report.unit)) {}

    Json write() const {
        Json json;
        json["schema_version"] = schema_version;
        json["tool"] = {{"name", "patchwright"}, {"version", base::version()}};
        json["unit"] = base::short_name(report_.unit);
        json["options"] = Json::object();
        for (const auto& [name, value] : report_.options) json["options"][name] = value;
        if (report_.error)
            json["error"] = {{"exit_code", report_.error->exit_code},
                             {"message", report_.error->message}};
        if (report_.verdict) json["verdict"] = verdict(*report_.verdict);
        if (report_.input) json["input"] = input(*report_.input);
        if (report_.cage) json["cage"] = cage(*report_.cage);
        if (report_.polylines)
            json["polylines"] = {{"count", report_.polylines->count},
                                 {"closed", report_.polylines->closed},
                                 {"points", report_.polylines->points}};
        if (report_.cage && !report_.layout.empty()) json["cage"]["layout"] = report_.layout;
        if (report_.fit) json["fit"] = fit(*report_.fit);
        if (report_.morph) json["morph"] = morph(*report_.morph);
        if (report_.family) json["family"] = family(*report_.family);
        if (report_.patches) json["patches"] = patches(*report_.patches);
        if (report_.solid) json["solid"] = solid(*report_.solid);
        if (report_.details) json["details"] = details(*report_.details);
        if (report_.deviation) {
            json["deviation"] = deviation_json(*report_.deviation, scale_);
            if (report_.deviation->fairness)
                json["fairness"] = fairness_json(*report_.deviation->fairness, scale_);
            json["sharp_curves"] = sharp_curves_json(*report_.deviation, scale_);
        }
        if (report_.continuity) json["continuity"] = continuity(*report_.continuity);
        if (report_.grid) json["grid"] = grid(*report_.grid);
        if (!report_.notices.empty()) json["notices"] = report_.notices;
        double total = 0.0;
        for (const auto& [stage, seconds] : report_.seconds) {
            json["seconds"][stage] = seconds;
            total += seconds;
        }
        json["seconds"]["total"] = total;
        json["peak_memory_mb"] = report_.peak_memory_mb;
        return json;
    }

  private:
    Json length(double mm) const { return mm * scale_; }
    Json point(const geom::Vec3& p) const {
        return {p.x() * scale_, p.y() * scale_, p.z() * scale_};
    }

    double factor_of(measure::Quantity quantity) const {
        switch (quantity) {
            case measure::Quantity::Length: return scale_;
            case measure::Quantity::Area: return scale_ * scale_;
            case measure::Quantity::Volume: return scale_ * scale_ * scale_;
            case measure::Quantity::Angle: return degrees;
            case measure::Quantity::Count: break;
        }
        return 1.0;
    }
    Json verdict(const measure::Verdict& v) const {
        Json conditions = Json::array();
        for (const measure::Condition& c : v.conditions) {
            const double factor = factor_of(c.quantity);
            conditions.push_back({{"name", measure::name_of(c.requirement)},
                                  {"value", c.value * factor},
                                  {"limit", c.limit * factor},
                                  {"at", c.at ? point(*c.at) : Json()},
                                  {"met", c.met},
                                  {"remedy", c.remedy}});
        }
        return {
            {"met", v.met()}, {"sentence", v.sentence(report_.unit)}, {"conditions", conditions}};
    }
    Json input(const InputFigures& i) const {
        return {{"file", i.file},
                {"format", i.format},
                {"schema", i.schema},
                {"originating_system", i.originating_system},
                {"unit", base::short_name(i.unit)},
                {"solids", i.solids},
                {"faces", i.faces},
                {"free_edges", i.free_edges},
                {"diagonal", length(i.diagonal)},
                {"largest_gap_closed", length(i.largest_gap_closed.value_or(0.0))},
                {"sewing_tolerance", length(i.sewing_tolerance.value_or(0.0))},
                {"holes_left_out", i.holes_left_out}};
    }
    static Json cage(const mesh::CageSummary& c) {
        return {{"vertices", c.vertices},
                {"faces", c.faces},
                {"extraordinary", c.extraordinary},
                {"creases", c.creases},
                {"corners", c.corners},
                {"boundary_edges", c.boundary_edges},
                {"pins", c.pins},
                {"non_quads", c.non_quads}};
    }
    Json family(const FamilyFigures& f) const {
        Json members = Json::array(), modes = Json::array();
        for (const FamilyFigures::Member& m : f.members) {
            Json json = {{"file", m.file},
                         {"met", m.met},
                         {"sentence", m.sentence},
                         {"tolerance", length(m.tolerance)},
                         {"seconds", m.seconds}};
            if (m.distance) json["distance"] = length(*m.distance);
            for (const double weight : m.weights) json["weights"].push_back(length(weight));
            if (m.off_modes) json["off_modes"] = length(*m.off_modes);
            members.push_back(std::move(json));
        }
        for (const FamilyFigures::Mode& mode : f.modes)
            modes.push_back({{"deviation", length(mode.deviation)}, {"share", mode.share}});
        return {{"members", members}, {"modes", modes}};
    }
    Json morph(const MorphFigures& m) const {
        double displacement = 0.0, moved = 0.0;
        Json steps = Json::array();
        for (const MorphFigures::Step& s : m.steps) {
            displacement = std::max(displacement, s.largest_displacement);
            moved = std::max(moved, s.largest_moved);
            Json step = {{"file", s.file},
                         {"largest_displacement", length(s.largest_displacement)},
                         {"largest_moved", length(s.largest_moved)}};
            if (s.verdict) step["verdict"] = verdict(*s.verdict);
            if (s.solid) step["solid"] = solid(*s.solid);
            if (s.grid) step["grid"] = grid(*s.grid);
            steps.push_back(step);
        }
        Json json = {{"points", m.points},
                     {"largest_displacement", length(displacement)},
                     {"largest_moved", length(moved)},
                     {"extrapolation", m.extrapolation},
                     {"steps", steps}};
        if (!m.forces) return json;
        const geom::Vec3& f = m.forces->given.force;
        json["forces"] = {{"places", m.forces->places},
                          {"force", {f.x(), f.y(), f.z()}},
                          {"moment", point(m.forces->given.moment)},
                          {"force_error", m.forces->force_error},
                          {"moment_error", m.forces->moment_error}};
        return json;
    }
    Json fit(const FitFigures& f) const {
        Json levels = Json::array();
        for (const fit::FitLevel& l : f.levels) {
            levels.push_back({{"vertices", l.vertices},
                              {"faces", l.faces},
                              {"samples", l.samples},
                              {"projections", l.projections},
                              {"cgls_steps", l.cgls_steps},
                              {"solves_ended",
                               {{"by_residual", l.projections - l.solves_by_step_tolerance -
                                                    l.solves_by_max_iterations},
                                {"by_length", l.solves_by_step_tolerance},
                                {"by_steps", l.solves_by_max_iterations}}},
                              {"rms", length(l.rms_mm)},
                              {"max", length(l.max_mm)},
                              {"reverse_max", length(l.reverse_max_mm)},
                              {"curve_max", length(l.curve_max_mm)},
                              {"chains_on_features", l.chains_on_features},
                              {"local", l.local},
                              {"seconds", l.seconds}});
            if (l.interpolated_mm) levels.back()["interpolated_max"] = length(*l.interpolated_mm);
        }
        const auto fairness = [](const measure::Fairness& fair) {
            return Json{{"curvature_variation", fair.curvature_variation},
                        {"skew", fair.skew},
                        {"least_angle_deg", fair.least_angle_rad * 180.0 / M_PI},
                        {"uneven_spacing", fair.uneven_spacing}};
        };
        Json carried = Json::array();
        for (const fit::WarpStage& s : f.carried)
            carried.push_back({{"cells", s.cells},
                               {"steps", s.steps},
                               {"rms", length(s.rms_mm)},
                               {"max", length(s.max_mm)},
                               {"seconds", s.seconds}});
        Json json{{"tolerance", length(f.tolerance)},
                  {"carried", carried},
                  {"met", report_.verdict && report_.verdict->met()},
                  {"symmetry", f.symmetry_axis ? std::string(1, "xyz"[*f.symmetry_axis]) : "none"},
                  {"levels", levels},
                  {"best_level", f.best_level},
                  {"fairness", {{"before", fairness(f.before)}, {"after", fairness(f.after)}}}};
        if (f.off_catmull_clark_mm) json["off_catmull_clark"] = length(*f.off_catmull_clark_mm);
        return json;
    }
    Json spread(const grid::Spread& s, double factor = 1.0) const {
        return {{"worst", s.worst * factor}, {"mean", s.mean * factor},  {"count", s.count},
                {"block", s.block},          {"index", {s.i, s.j, s.k}}, {"at", point(s.at)}};
    }
    Json grid(const GridFigures& g) const {
        const grid::GridQuality& q = g.quality;
        Json vertices = Json::array();
        for (const grid::VertexQuality& v : q.extraordinary) {
            vertices.push_back({{"vertex", v.vertex.value},
                                {"cells", v.cells},
                                {"min_angle_deg", v.min_angle_rad * degrees},
                                {"max_angle_deg", v.max_angle_rad * degrees},
                                {"size_ratio", v.size_ratio},
                                {"at", point(v.at)}});
        }
        Json json{{"file", g.file},
                  {"blocks", q.blocks},
                  {"interfaces", q.interfaces},
                  {"points", q.points},
                  {"cells", q.cells},
                  {"folded", q.folded},
                  {"min_angle_deg", spread(q.min_angle, degrees)},
                  {"skewness", spread(q.skewness)},
                  {"aspect_ratio", spread(q.aspect)},
                  {"stretching", spread(q.stretching)},
                  {"orthogonality_deg", spread(q.orthogonality, degrees)},
                  {"turning_deg", spread(q.turning, degrees)},
                  {"size_jump", spread(q.jump)},
                  {"extraordinary", vertices}};
        if (g.local) {
            json["levels"] = g.local->levels;
            json["hanging_nodes"] = g.local->hanging_nodes;
        }
        if (q.scaled_jacobian) {
            json["scaled_jacobian"] = spread(*q.scaled_jacobian);
            json["negative_volumes"] = q.negative;
        }
        return json;
    }
    Json patches(const PatchFigures& p) const {
        Json caps = Json::array();
        for (const patch::CapReport& cap : p.caps) {
            caps.push_back({{"vertex", cap.vertex.value},
                            {"faces", cap.faces},
                            {"depth", cap.depth},
                            {"distance", length(cap.distance_mm)},
                            {"smooth", cap.smooth},
                            {"limit_has_plane", cap.limit_has_plane}});
        }
        return {{"count", p.count},
                {"charts", p.covering == "charts" ? p.count : 0},
                {"control_points", p.control_points},
                {"caps", p.caps.size()},
                {"continuity", p.continuity},
                {"extraordinary", caps}};
    }
    Json solid(const SolidFigures& s) const {
        Json json = {{"file", s.file},
                     {"solids", s.solids},
                     {"shells_closed", s.shells_closed},
                     {"shells_open", s.shells_open},
                     {"faces", s.faces},
                     {"edges", s.edges},
                     {"vertices", s.vertices},
                     {"free_edges", s.free_edges},
                     {"nonmanifold_edges", s.nonmanifold_edges},
                     {"closed", s.closed},
                     {"valid", s.valid},
                     {"all_bicubic", s.all_bicubic},
                     {"volume", s.volume * scale_ * scale_ * scale_},
                     {"area", s.area * scale_ * scale_},
                     {"max_tolerance", length(s.max_tolerance)},
                     {"faces_by_kind", s.faces_by_kind}};
        if (!s.bounds.empty()) {
            json["bounds"] = {{"min", point(s.bounds.min)}, {"max", point(s.bounds.max)}};
        }
        return json;
    }
    Json details(const DetailFigures& d) const {
        const double moment = std::pow(scale_, d.moments_of_volume ? 5 : 4);
        Json moments = Json::array();
        for (const double m : d.principal_moments) moments.push_back(m * moment);
        Json json{{"smallest_face",
                   {{"face", d.smallest_face}, {"area", d.smallest_area * scale_ * scale_}}},
                  {"tolerances",
                   {{"vertex", length(d.vertex_tolerance)},
                    {"edge", length(d.edge_tolerance)},
                    {"face", length(d.face_tolerance)}}},
                  {"open_gaps",
                   {{"smallest", length(d.smallest_open_gap.value_or(0.0))},
                    {"largest", length(d.largest_open_gap.value_or(0.0))}}},
                  {"sharp_edges", d.sharp_edges},
                  {"smooth_edges", d.smooth_edges},
                  {"sharp_curves", d.sharp_curves},
                  {"free_curves", d.free_curves},
                  {"corners", d.corners},
                  {"kinked_faces", d.kinked_faces},
                  {"largest_kink_deg", d.largest_kink_rad * 180.0 / M_PI},
                  {"largest_kink_at", point(d.largest_kink_at)},
                  {"centre_of_mass", point(d.centre_of_mass)},
                  {"principal_moments", moments},
                  {"named_faces", d.named_faces},
                  {"coloured_faces", d.coloured_faces},
                  {"overlapping_solids", d.overlapping_solids},
                  {"duplicates_dropped", d.duplicates_dropped},
                  {"slivers_dropped", d.slivers_dropped},
                  {"faces_turned", d.faces_turned}};
        if (d.narrowest_face)
            json["narrowest_face"] = {{"face", *d.narrowest_face},
                                      {"width", length(d.narrowest_width)}};
        if (d.shortest_edge)
            json["shortest_edge"] = {{"length", length(*d.shortest_edge)},
                                     {"at", point(d.shortest_edge_at)}};
        return json;
    }
    Json continuity(const patch::Continuity& c) const {
        return {{"max_gap", length(c.max_gap_mm)},
                {"gap_at", point(c.gap_at)},
                {"max_kink_deg", c.max_kink_rad * 180.0 / M_PI},
                {"kink_at", point(c.kink_at)},
                {"near_singular_kink_deg", c.near_singular_kink_rad * 180.0 / M_PI},
                {"near_singular_kink_at", point(c.near_singular_kink_at)},
                {"creases", c.crease_edges},
                {"smooth_edges", c.smooth_edges}};
    }

    const RunReport& report_;
    double scale_;
};

}  // namespace

std::string to_json(const RunReport& report) {
    // Names of files are bytes: what is not UTF-8 becomes U+FFFD.
    return Writer(report).write().dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace patchwright::report
