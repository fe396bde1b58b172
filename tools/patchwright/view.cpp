#include "view.h"

#include <patchwright/report/field_file.h>

#include <algorithm>

namespace patchwright::cli {

namespace {

double largest(const std::vector<double>& values) {
    return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

}  // namespace

void add_views(Run& run, const View& view) {
    if (view.field.empty() && !run.writes_page()) return;
    const measure::FieldOptions options{.progress = run.progress()};
    measure::Field output = measure::measure_field(*view.output, view.input, options);
    const double farthest = largest(output.distance_mm);
    const double scale = view.scale_mm.value_or(farthest > 0.0 ? farthest : 1.0);
    if (!view.field.empty())
        run.outputs.add(view.field, has_extension(view.field, ".vtp")
                                        ? report::to_vtp(output, run.report.unit)
                                        : report::to_glb(output, scale));
    if (run.writes_page()) {
        report::Scene scene{.output = std::move(output), .scale_mm = scale};
        if (view.input != nullptr)
            scene.input = measure::measure_field(*view.input, view.output, options);
        if (view.cage != nullptr) scene.cage = *view.cage;
        run.report.scene = std::move(scene);
    }
    run.end_stage("view");
}

}  // namespace patchwright::cli
