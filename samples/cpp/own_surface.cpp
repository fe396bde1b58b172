// A surface of one's own as what a cage is fitted to: it only has to know its nearest points. Here
// a torus, whose nearest points are a formula.
#include <patchwright/fit/fit.h>
#include <patchwright/geom/reference_surface.h>
#include <patchwright/mesh/cage.h>
#include <patchwright/occ/assemble.h>
#include <patchwright/patch/extract.h>

#include <cmath>
#include <iostream>
#include <numbers>

namespace pw = patchwright;
using pw::geom::Vec3;

/// Around the z axis. Millimetres.
class Torus final : public pw::geom::ReferenceSurface {
  public:
    Torus(double major, double minor) : major_(major), minor_(minor) {}

    pw::geom::Box3 bounds() const override {
        const Vec3 half(major_ + minor_, major_ + minor_, minor_);
        return {-half, half};
    }
    pw::geom::FootPoint foot_point(const Vec3& query, const std::optional<Vec3>&) const override {
        const Vec3 centre = major_ * Vec3(query.x(), query.y(), 0).normalized();
        const Vec3 normal = (query - centre).normalized();
        const Vec3 point = centre + minor_ * normal;
        return {.point = point, .normal = normal, .distance = (query - point).norm(), .face = 0};
    }

  private:
    double major_, minor_;
};

/// A ring of quads, `around` the axis and `across` the tube, roughly where the torus is.
pw::mesh::Cage ring(int around, int across, double major, double minor) {
    using std::numbers::pi;
    pw::mesh::TopologyInput input{.vertex_count = around * across};
    pw::geom::Points points(around * across, 3);
    for (int i = 0; i < around; ++i) {
        for (int j = 0; j < across; ++j) {
            const double u = 2 * pi * i / around, v = 2 * pi * j / across;
            const double radius = major + minor * std::cos(v);
            points.row(i * across + j) << radius * std::cos(u), radius * std::sin(u),
                minor * std::sin(v);
            const int next_i = (i + 1) % around, next_j = (j + 1) % across;
            input.face_sizes.push_back(4);
            for (const int vertex : {i * across + j, next_i * across + j, next_i * across + next_j,
                                     i * across + next_j})
                input.face_vertices.push_back(vertex);
        }
    }
    return pw::mesh::build_cage(std::move(input), points, "ring").cage;
}

int main(int count, char** arguments) {
    const double tolerance_mm = 0.05;
    const Torus torus(100, 30);
    const auto fitted = pw::fit::fit(ring(8, 6, 100, 30), torus, {.tolerance_mm = tolerance_mm});
    const auto& level = fitted.levels[std::size_t(fitted.best_level)];
    std::cout << level.vertices << " control points, largest distance " << level.max_mm << " mm\n";

    const auto extraction = pw::patch::extract(fitted.cage);
    std::cout << extraction.patches.patches.size() << " patches\n";
    if (count > 1) pw::occ::write_cad(pw::occ::assemble(extraction.patches), arguments[1]);
    return fitted.within_tolerance ? 0 : 3;
}
