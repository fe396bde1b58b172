// The points of a surface grid while they slide.
#pragma once

#include "grid/front.h"
#include "grid/smooth_cells.h"
#include "grid/surface_walk.h"

#include <variant>

namespace patchwright::grid {

/// All points of a plan as numbered by a FrontMesh, and where they are.
class SlidingPoints {
  public:
    /// @pre plan and mesh outlive this
    SlidingPoints(const Plan& plan, const FrontMesh& mesh);

    [[nodiscard]] subd::Location location(std::size_t point) const {
        return location_of(places_[point]);
    }
    /// Per point the number of directions that it can go.
    [[nodiscard]] std::vector<int> freedom() const;
    /// @param normals  one row a point
    void measure_bases(const geom::Points& normals, std::vector<SmoothCells::Basis>& bases);

    struct Fixed {
        subd::Location at;
    };
    /// In the order of the directions that the point can go: none, one, two.
    using Place = std::variant<Fixed, LinePlace, subd::Location>;
    struct Moved {
        std::vector<Place> places;
        geom::Points points;
    };
    /// Where all points come to, nearly `by` off where they are.
    void move(const geom::Points& by, Moved& result);
    void accept(Moved& moved) { places_.swap(moved.places); }

  private:
    template <class Visit>
    void for_walks(const Visit& visit);
    [[nodiscard]] subd::Location location_of(const Place& place) const;
    void place_in_blocks(const Plan& plan, const FrontMesh& mesh);
    void place_on_features(const Plan& plan, const FrontMesh& mesh);
    [[nodiscard]] std::optional<Place> place_at_vertex(mesh::CornerId edge, double t);

    const mesh::Topology& topology_;
    subd::RingTable table_;
    std::vector<std::unique_ptr<SurfaceWalk>> walks_;  ///< one for so many points each
    std::vector<Place> places_;
};

}  // namespace patchwright::grid
