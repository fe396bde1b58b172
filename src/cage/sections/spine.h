// The way along which bodies are cut into sections: straight, or a fan of planes that bends.
#pragma once

#include <patchwright/geom/types.h>

#include <vector>

namespace patchwright::cage {

/// Plane sections by height. Those between two planes of a fan are of the pencil of both.
class Spine {
  public:
    struct Plane {
        geom::Vec3 point, normal;  ///< unit, along the way
    };

    /// Heights along a unit vector.
    explicit Spine(const geom::Vec3& axis);
    /// @param planes     one after another; neighbours do not cross within the body
    /// @param chordwise  unit; the way runs across it, bodies are flat along it
    /// @pre there are at least two planes
    Spine(const std::vector<Plane>& planes, const geom::Vec3& chordwise);

    [[nodiscard]] double height(const geom::Vec3& p) const;
    /// Normal of the section at a height.
    [[nodiscard]] geom::Vec3 direction(double height) const;
    /// Positive above the section's plane; linear in `p`, and 0 on the plane.
    [[nodiscard]] double offset(const geom::Vec3& p, double height) const;
    /// Of the planes between the first and the last one.
    [[nodiscard]] std::vector<double> inner_heights() const;
    /// From the first plane's height to the last one's.
    [[nodiscard]] double length() const { return heights_.back() - heights_.front(); }

  private:
    [[nodiscard]] double distance(std::size_t plane, const geom::Vec3& p) const;
    /// The way's segment nearest to a point, along the chord.
    [[nodiscard]] std::size_t segment_near(const geom::Vec3& p) const;
    [[nodiscard]] geom::Vec3 across(const geom::Vec3& v) const;
    /// Planes around a height, equal ones beyond both ends, and the share of the second.
    struct Between {
        std::size_t first, second;
        double share;
    };
    [[nodiscard]] Between between(double height) const;

    std::vector<Plane> planes_;
    std::vector<double> heights_;
    geom::Vec3 chordwise_ = geom::Vec3::Zero();
};

}  // namespace patchwright::cage
