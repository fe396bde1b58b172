// What a leaf of the tree over the triangulation says of its parts of the faces.
#pragma once

#include "occ/foot/reference_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace patchwright::occ {

/// A triangle that may hold the nearest point.
struct SeedCandidate {
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

inline void store(const Lanes& value, FloatArray& to) {
    std::memcpy(to.data(), &value, sizeof value);
}

/// A leaf's triangles: bounds for the distance of their parts of the faces.
struct LeafBounds {
    Lanes lower, upper;
    /// -1 where the query can lie on a normal of the triangle's part of the surface, else 0.
    Mask may_hold_foot;

    LeafBounds(const geom::TriangleTree::Near& near, const SeedBlock& seeds, float extent) {
        const Lanes distance = load(near.distance), height = load(near.height);
        // How far the face may be from the triangle, and what is measured from what is true: a
        // little more than the tree's slack, as these sums round too.
        const Lanes off = load(seeds.error) + 1.25e-6f * (extent + distance);
        lower = distance - off;
        upper = distance + off + load(seeds.overhang);
        const Lanes above = height < 0.0f ? -height : height;
        may_hold_foot = load(near.aside) - off <= load(seeds.spread) * (above + off);
    }
    [[nodiscard]] float least_upper() const {
        return std::min(std::min(upper[0], upper[1]), std::min(upper[2], upper[3]));
    }
};

/// The triangles of a leaf that count, written one after the other; room for all is needed.
/// @return how many
inline std::size_t write_candidates(const LeafBounds& leaf, const geom::TriangleTree::Near& near,
                                    std::int32_t slot, const Mask& counts, SeedCandidate* to) {
    const Lanes slots = reinterpret_cast<Lanes>(slot + Mask{0, 1, 2, 3});
    const Lanes distance = load(near.distance), height = load(near.height);
    // Lane by lane from four rows. Written whether it counts or not: cheaper than to foresee which
    // do, and whole, as pieces just written would be waited for.
    const Lanes a = __builtin_shufflevector(leaf.lower, slots, 0, 4, 1, 5);
    const Lanes b = __builtin_shufflevector(distance, height, 0, 4, 1, 5);
    const Lanes c = __builtin_shufflevector(leaf.lower, slots, 2, 6, 3, 7);
    const Lanes d = __builtin_shufflevector(distance, height, 2, 6, 3, 7);
    SeedCandidate* end = to;
    const auto write = [&](const Lanes& candidate, std::size_t lane) {
        static_assert(sizeof(SeedCandidate) == sizeof candidate);
        std::memcpy(static_cast<void*>(end), &candidate, sizeof candidate);
        end -= counts[lane];
    };
    write(__builtin_shufflevector(a, b, 0, 1, 4, 5), 0);
    write(__builtin_shufflevector(a, b, 2, 3, 6, 7), 1);
    write(__builtin_shufflevector(c, d, 0, 1, 4, 5), 2);
    write(__builtin_shufflevector(c, d, 2, 3, 6, 7), 3);
    return std::size_t(end - to);
}

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
