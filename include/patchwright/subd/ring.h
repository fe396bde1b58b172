// The neighbourhood of a face that determines its limit surface, up to the numbering of vertices.
#pragma once

#include <patchwright/mesh/topology.h>
#include <patchwright/subd/stencils.h>

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <shared_mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::subd {

class RingExtractor;
class RingKind;

/// A face with all faces around its vertices: its kind and which vertex fills each of the kind's
/// slots. The first slots are the face's own vertices in order; a vertex may fill several slots.
struct Ring {
    const RingKind* kind = nullptr;
    std::vector<std::int32_t> vertices;  ///< kind->slots() entries
};

/// Everything about a neighbourhood that does not depend on positions: sizes of the faces,
/// valences, sharpnesses, boundary. Computed once a kind; a mesh of a million faces has a few
/// dozen.
class RingKind {
  public:
    ~RingKind();
    RingKind(const RingKind&) = delete;
    RingKind& operator=(const RingKind&) = delete;

    struct Child {
        const RingKind* kind;
        Stencils matrix;  ///< child's slots x this kind's slots
    };

    [[nodiscard]] int slots() const {
        return local_ ? local_->vertex_count() : static_cast<int>(regular_.cols());
    }
    /// Number of the face's own vertices, and of its children.
    [[nodiscard]] int size() const { return local_ ? local_->size(mesh::FaceId{0}) : 4; }

    /// Whether the limit surface over the face is one bicubic polynomial.
    [[nodiscard]] bool is_regular() const { return regular_.rows() > 0; }
    /// @pre is_regular()
    /// 16 x slots(): the uniform bicubic B-spline control points (a, b) in row 4 a + b, a along u;
    /// beyond creases and boundaries they are mirrored, or as parabolic runouts.
    [[nodiscard]] const Eigen::MatrixXd& regular() const { return regular_; }

    /// The neighbourhood of child `i` after one subdivision step (see Refinement for the order).
    /// @pre no parabolic runout acts on the face
    [[nodiscard]] const Child& child(int i) const;

    /// Masks at one of the face's own vertices, as seen from the face.
    struct Corner {
        Eigen::RowVectorXd limit;  ///< of the position: 1 x slots
    };
    [[nodiscard]] const Corner& corner(int i) const;

    /// The tangent plane at one of the face's own vertices, as seen from the face.
    struct TangentPlane {
        /// Of two directions that span the plane, along the face's u and v up to positive factors;
        /// where both sides leave on one line, only their cross product is right. 2 x slots; zero
        /// where there is no tangent plane.
        Eigen::MatrixXd rows;
        double eigenvalue = 0.0;  ///< subdominant, of the direction along u; 0 without a plane
    };
    [[nodiscard]] const TangentPlane& tangent_plane(int i) const;

    /// Whether child `i` is of this very kind again: an extraordinary vertex that stays.
    [[nodiscard]] bool is_stationary(int i) const { return child(i).kind == this; }

    /// Kinds of a table are numbered from 0 as they are met.
    [[nodiscard]] int number() const { return number_; }

  private:
    friend class RingTable;
    RingKind(class RingTable& table, int number, const RingExtractor& extracted);

    Corner make_corner(int i) const;
    TangentPlane make_tangent_plane(int i) const;
    [[nodiscard]] bool is_smooth_ring(int i) const;
    [[nodiscard]] TangentPlane smooth_tangent_plane(int i) const;

    // What is computed when first asked for.
    struct Lazy;

    RingTable& table_;
    int number_;
    /// The neighbourhood as a mesh of its own: the face is number 0, slots are vertices; tags are
    /// complete for the edges and vertices that act on the face only. None where regular_ alone
    /// tells all.
    std::shared_ptr<const mesh::Topology> local_;
    Eigen::MatrixXd regular_;
    std::unique_ptr<Lazy> lazy_;
};

/// Where corner i of a quad lies in the parameter square.
constexpr bool at_end_u(int i) { return i == 1 || i == 2; }
constexpr bool at_end_v(int i) { return i >= 2; }

/// Place (a, b) of each corner of a quad among its 16 control points, see RingKind::regular().
inline constexpr std::array<std::array<int, 2>, 4> own_places{{{1, 1}, {2, 1}, {2, 2}, {1, 2}}};

/// All kinds met so far. Thread-safe; kinds live as long as their table.
class RingTable {
  public:
    RingTable();
    ~RingTable();
    RingTable(const RingTable&) = delete;
    RingTable& operator=(const RingTable&) = delete;

    /// The neighbourhood of face `f`.
    [[nodiscard]] Ring ring(const mesh::Topology& topology, mesh::FaceId f);
    /// The kind of the neighbourhood that was extracted last; the ring's vertices are the
    /// extractor's.
    [[nodiscard]] const RingKind& kind(const RingExtractor& extracted);
    /// The kind of a quad among quads without features whose vertices have these valences, 3 to 10
    /// each; null until it was added.
    [[nodiscard]] const RingKind* smooth_kind(const std::array<std::uint8_t, 4>& valences) const {
        return smooth_[smooth_index(valences)].load(std::memory_order_acquire);
    }
    const RingKind& add_smooth_kind(const std::array<std::uint8_t, 4>& valences,
                                    const RingKind& kind) {
        smooth_[smooth_index(valences)].store(&kind, std::memory_order_release);
        return kind;
    }

    [[nodiscard]] int kind_count() const;

  private:
    struct KeyHash {
        using is_transparent = void;
        std::size_t operator()(std::string_view key) const {
            return std::hash<std::string_view>{}(key);
        }
    };
    mutable std::shared_mutex mutex_;
    std::unordered_map<std::string, std::unique_ptr<RingKind>, KeyHash, std::equal_to<>> kinds_;
    // Most faces are of these kinds: found without key or lock.
    static std::size_t smooth_index(const std::array<std::uint8_t, 4>& valences) {
        std::size_t index = 0;
        for (const std::uint8_t valence : valences) index = 8 * index + (valence - 3U);
        return index;
    }
    std::array<std::atomic<const RingKind*>, 4096> smooth_{};
};

}  // namespace patchwright::subd
#pragma GCC visibility pop
