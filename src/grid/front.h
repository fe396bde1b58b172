// A surface grid as one mesh: points that blocks share are one.
#pragma once

#include <patchwright/base/parallel.h>
#include <patchwright/grid/source.h>

#include <span>

namespace patchwright::grid {

/// Per point the corners of cells there.
class FrontMesh {
  public:
    explicit FrontMesh(const Plan& plan);

    /// A cell's corner: the points before and after it, counter-clockwise.
    struct Corner {
        std::int32_t next, previous;
    };

    [[nodiscard]] std::size_t size() const { return begin_.size() - 1; }
    [[nodiscard]] std::span<const Corner> corners(std::size_t point) const {
        return {corners_.data() + begin_[point], corners_.data() + begin_[point + 1]};
    }
    /// Of a point's corners, among those of all points one after the other.
    [[nodiscard]] std::size_t first_corner(std::size_t point) const { return begin_[point]; }
    [[nodiscard]] std::size_t corner_count() const { return corners_.size(); }
    /// Number of each point of a block, i fastest.
    [[nodiscard]] const std::vector<std::int32_t>& numbers(int block) const {
        return numbers_[std::size_t(block)];
    }
    /// The points of every cell, block by block: counter-clockwise from the lowest i and j.
    [[nodiscard]] std::vector<std::array<std::int32_t, 4>> cells(const Plan& plan) const;
    /// Of the points of a block edge, along it.
    [[nodiscard]] const std::vector<std::int32_t>& on_edge(int edge) const {
        return on_edge_[std::size_t(edge)];
    }
    [[nodiscard]] const geom::Points& surface() const { return surface_; }
    /// Unit normal of the plane that the point must stay in; zero for others.
    [[nodiscard]] const geom::Vec3& plane(std::size_t point) const { return planes_[point]; }

  private:
    void number_points(const Plan& plan);
    void gather_corners(const Plan& plan);
    void find_planes(const Plan& plan);

    std::vector<std::vector<std::int32_t>> numbers_;
    std::vector<std::vector<std::int32_t>> on_edge_;
    std::vector<std::size_t> begin_;
    std::vector<Corner> corners_;
    geom::Points surface_;
    std::vector<geom::Vec3> planes_;
};

/// Calls visit(point) for so many points, on all threads.
template <class Visit>
void for_points(std::size_t count, const Visit& visit) {
    constexpr std::size_t grain = 4096;
    base::parallel_for(count, grain, [&](std::size_t first, std::size_t last) {
        for (std::size_t p = first; p < last; ++p) visit(p);
    });
}

}  // namespace patchwright::grid
