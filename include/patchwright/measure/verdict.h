// The verdict on a result: every condition that it has to fulfil, made from measured figures.
#pragma once

#include <patchwright/base/units.h>
#include <patchwright/geom/types.h>

#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::measure {

enum class Requirement {
    DistanceToInput,    ///< of the output from the input
    DistanceFromInput,  ///< of the input from the output
    SharpCurves,        ///< long sharp curves of the input are sharp or free ones of the output
    Closed,             ///< no free edges where the input has none
    Valid,              ///< for the CAD kernel
    Bodies,             ///< as many as in the input
    Volume,             ///< of closed bodies: more than that of a film of their area
    Area,               ///< of open shells: more than that of a thread as long as the model
    Folds,              ///< normals of output and input agree, to within 45 degrees
    Normals,            ///< the same to within a limit of the user's
    Kinks,              ///< tangent planes agree across edges that are meant to be smooth
    SelfIntersections,  ///< no face intersects itself
    GridCells,          ///< no cell of a grid is folded or has a negative volume
    Designs             ///< of a family: the verdict on each is met
};

/// What a condition's value and limit are; in mm, mm^2, mm^3.
enum class Quantity { Length, Area, Volume, Angle, Count };

struct Condition {
    Requirement requirement = Requirement::Valid;
    Quantity quantity = Quantity::Count;
    double value = 0.0;  ///< radians for angles
    double limit =
        0.0;  ///< largest value that is allowed; of area and volume: the value exceeds it
    bool met = true;
    std::optional<geom::Vec3> at;  ///< where the value is worst
    std::string remedy;            ///< what to try; empty when met
};

/// Stable, for JSON: "distance_to_input", "sharp_curves", ...
const char* name_of(Requirement requirement);

/// A value with the place where it was found.
struct Worst {
    double value = 0.0;
    std::optional<geom::Vec3> at;
};

/// Of several things the number that fail, and where one of them is.
struct Failures {
    int count = 0;
    std::optional<geom::Vec3> at;
};

/// Measured figures; what was not measured, or does not apply, stays empty and gives no condition.
struct VerdictFigures {
    std::optional<double> tolerance_mm;  ///< needed by the distances
    double diagonal_mm = 0.0;            ///< of the input, or of the output where there is none

    /// The largest of all samples: of the check, and of the fit with its creases.
    std::optional<Worst> output_to_input_mm, input_to_output_mm;
    std::optional<Failures> lost_sharp_curves;
    std::optional<int> free_edges;  ///< of the output, where the input has none
    std::optional<bool> valid;
    std::optional<int> bodies, bodies_of_input;
    std::optional<double> volume_mm3;  ///< of closed bodies
    std::optional<double> area_mm2;    ///< needed by the volume
    std::optional<Worst> fold_rad;     ///< largest angle between the normals of output and input
    /// Largest angle between normals beyond the input's edges, and what is allowed.
    std::optional<Worst> normal_angle_rad;
    std::optional<double> normal_tolerance_rad;
    std::optional<Worst> kink_rad;  ///< beyond the tolerance from vertices without tangent plane
    std::optional<Failures> self_intersecting_faces;
    std::optional<Failures> bad_grid_cells;
    std::optional<Failures> missed_designs;

    std::optional<int> patches;          ///< for the sentence
    std::optional<int> designs;          ///< for the sentence
    bool closed = false;                 ///< for the sentence
    bool stopped_by_time_limit = false;  ///< some remedies are then more time
    bool keeps_cage = false;             ///< of a refit: the remedy is another command
    bool is_grid = false;                ///< of a grid in place of a shape
};

/// Made by assess() only, never edited.
struct Verdict {
    std::vector<Condition> conditions;

    /// Whether all conditions are met.
    [[nodiscard]] bool met() const;
    /// The condition that is missed by the largest factor; none when met.
    [[nodiscard]] const Condition* worst() const;
    /// One line, with coordinates in this unit: "met 1e-4: one closed valid solid, 6 patches,
    /// 5.2e-5 of the diagonal" or "MISSED: ...; try ...".
    [[nodiscard]] std::string sentence(base::LengthUnit unit) const;

    std::string shape;                                   ///< "one closed valid solid, 6 patches"
    std::optional<double> tolerance_rel, deviation_rel;  ///< of the diagonal
};

/// Limits: normals of output and input agree to within 45 degrees, tangent planes across smooth
/// edges to within 1 degree; the other limits are the tolerance, the input's numbers, or zero.
inline constexpr double fold_limit_rad = 0.785398163397448, kink_limit_rad = 0.0174532925199433;

/// Bodies are thicker, and shells wider, than what the CAD kernel tells apart.
inline constexpr double least_thickness_mm = 1e-7;

/// What a closed body of this area has to enclose more than, mm^3: else it is a film.
double film_volume(double area_mm2);

/// The one place where it is decided whether a result is good.
/// @throw InvalidArgument when distances are given without a tolerance, or a volume without area
Verdict assess(const VerdictFigures& figures);

/// How much a condition is missed by: value over limit, for counts the count and one; 1 when met.
double excess(const Condition& condition);

/// Whether `a` is the better result: valid before invalid, then the smaller product of all
/// excesses, then the smaller deviation.
bool better(const Verdict& a, const Verdict& b);

}  // namespace patchwright::measure
#pragma GCC visibility pop
