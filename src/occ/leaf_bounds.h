// What a leaf of the tree over the triangulation says of its parts of the faces.
#pragma once

#include "reference_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace patchwright::occ {

/// A triangle that may hold the nearest point.
struct Candidate {
    float lower;  ///< the triangle's part of the face is no nearer
    std::int32_t slot;
    float distance, height;  ///< of the triangle; the latter with a sign
};

/// One register's lanes: GCC's and Clang's vectors.
using Lanes [[gnu::vector_size(4 * geom::TriangleTree::lanes)]] = float;
using Mask [[gnu::vector_size(4 * geom::TriangleTree::lanes)]] = std::int32_t;
using FloatArray = std::array<float, geom::TriangleTree::lanes>;

inline Lanes load(const FloatArray& from) {
    Lanes value;
    std::memcpy(&value, from.data(), sizeof value);
    return value;
}

/// A leaf's triangles: bounds for the distance of their parts of the faces.
struct LeafBounds {
    FloatArray lower, upper;
    /// -1 where the query can lie on a normal of the triangle's part of the surface, else 0.
    std::array<std::int32_t, geom::TriangleTree::lanes> may_hold_foot;

    LeafBounds(const geom::TriangleTree::Near& near, const SeedBlock& seeds, float extent) {
        const Lanes distance = load(near.distance), height = load(near.height);
        // How far the face may be from the triangle, and what is measured from what is true: a
        // little more than the tree's slack, as these sums round too.
        const Lanes off = load(seeds.error) + 1.25e-6f * (extent + distance);
        const Lanes low = distance - off, high = distance + off + load(seeds.overhang);
        const Lanes above = height < 0.0f ? -height : height;
        const Mask may = load(near.aside) - off <= load(seeds.spread) * (above + off);
        std::memcpy(lower.data(), &low, sizeof low);
        std::memcpy(upper.data(), &high, sizeof high);
        std::memcpy(may_hold_foot.data(), &may, sizeof may);
    }
    [[nodiscard]] float least_upper() const {
        return std::min(std::min(upper[0], upper[1]), std::min(upper[2], upper[3]));
    }
};

/// The triangles of a leaf that a search has passed.
struct PassedLeaf {
    FloatArray lower;  ///< their parts of the faces are no nearer
    std::int32_t slot;
};

/// Whether a normal of the triangle's part of the surface can have a positive product with
/// `side`.
inline bool may_face(const MeshTriangle& t, const geom::Vec3& side) {
    const double along = t.normal.dot(side);
    if (along > 0.0 || std::isinf(t.spread)) return true;
    // tan(90 degrees - angle to the plane of normals that look aside)
    const double across = std::sqrt(std::max(0.0, 1.0 - along * along));
    return -along <= t.spread * across;
}

}  // namespace patchwright::occ
