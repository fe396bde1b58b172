// The neighbourhood of a face that determines its limit surface, up to the numbering of vertices.
#pragma once

#include <patchwright/mesh/topology.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

namespace patchwright::subd {

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
    struct Child {
        const RingKind* kind;
        Eigen::MatrixXd matrix;  ///< child's slots x this kind's slots
    };

    [[nodiscard]] int slots() const { return local_->vertex_count(); }
    /// Number of the face's own vertices, and of its children.
    [[nodiscard]] int size() const { return local_->size(mesh::FaceId{0}); }

    /// Whether the limit surface over the face is one bicubic polynomial.
    [[nodiscard]] bool is_regular() const { return regular_.rows() > 0; }
    /// @pre is_regular()
    /// 16 x slots(): the uniform bicubic B-spline control points (a, b) in row 4 a + b, a along u;
    /// beyond creases and boundaries they are mirrored.
    [[nodiscard]] const Eigen::MatrixXd& regular() const { return regular_; }

    /// The neighbourhood of child `i` after one subdivision step (see Refinement for the order).
    [[nodiscard]] const Child& child(int i) const;

    /// Masks at one of the face's own vertices, as seen from the face.
    struct Corner {
        Eigen::RowVectorXd limit;  ///< of the position: 1 x slots
        /// Of two directions that span the tangent plane, along the face's u and v up to positive
        /// factors: 2 x slots; zero where there is no tangent plane.
        Eigen::MatrixXd tangents;
        double eigenvalue = 0.0;  ///< subdominant, of the direction along u; 0 without tangents
    };
    [[nodiscard]] const Corner& corner(int i) const;

    /// Whether child `i` is of this very kind again: an extraordinary vertex that stays.
    [[nodiscard]] bool is_stationary(int i) const { return child(i).kind == this; }
    /// (child(i).matrix - 1 l)^(2^exponent) with l = corner(i).limit: what is left of many steps
    /// beside the limit. Without the part of eigenvalue 1, whose rounding would outlive everything
    /// else, differences from the limit keep all their digits however many the steps.
    /// @pre is_stationary(i)
    [[nodiscard]] const Eigen::MatrixXd& contraction_power(int i, int exponent) const;

    /// The neighbourhood as a mesh of its own; the face is number 0, slots are vertices. Tags are
    /// complete for the edges and vertices that act on the face only.
    [[nodiscard]] const mesh::Topology& local() const { return *local_; }

  private:
    friend class RingTable;
    RingKind(class RingTable& table, std::shared_ptr<const mesh::Topology> local);

    RingTable& table_;
    std::shared_ptr<const mesh::Topology> local_;
    Eigen::MatrixXd regular_;
    mutable std::vector<Child> children_;
    mutable std::vector<Corner> corners_;
    // Deques, as references to their entries must last.
    mutable std::vector<std::deque<Eigen::MatrixXd>> powers_;
};

/// Where corner i of a quad lies in the parameter square.
constexpr bool at_end_u(int i) { return i == 1 || i == 2; }
constexpr bool at_end_v(int i) { return i >= 2; }

/// All kinds met so far. Thread-safe; kinds live as long as their table.
class RingTable {
  public:
    RingTable();
    ~RingTable();
    RingTable(const RingTable&) = delete;
    RingTable& operator=(const RingTable&) = delete;

    /// The neighbourhood of face `f`.
    [[nodiscard]] Ring ring(const mesh::Topology& topology, mesh::FaceId f);

    [[nodiscard]] int kind_count() const;

  private:
    friend class RingKind;
    mutable std::recursive_mutex mutex_;
    std::unordered_map<std::string, std::unique_ptr<RingKind>> kinds_;
};

}  // namespace patchwright::subd
