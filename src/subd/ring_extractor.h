// Reads the neighbourhood of a face off a mesh, in the numbering that kinds are made in.
#pragma once

#include "subd/line_grid.h"

#include <patchwright/mesh/topology.h>
#include <patchwright/subd/ring.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace patchwright::subd {

/// One entry a vertex: its valence where it is smooth, inside, has quads and no sharp edge around
/// it and 3 to 10 of them; 0 elsewhere.
std::vector<std::uint8_t> smooth_valences(const mesh::Topology& topology);

/// Gathers the faces around one face as if nothing else of the mesh existed: places where the mesh
/// closes up outside the face's own vertices are not glued, so that equal kinds give equal slots.
/// Reusable: allocates only until its buffers have grown to the largest neighbourhood. One a
/// thread.
class RingExtractor {
  public:
    /// Reads the neighbourhood of `face`; what the other functions return belongs to it until the
    /// next call.
    void extract(const mesh::Topology& topology, mesh::FaceId face);

    /// The same for a quad whose vertices all have smooth_valences(), given in order; key() and
    /// local_topology() are not set.
    void extract_smooth(const mesh::Topology& topology, mesh::FaceId face,
                        const std::array<std::uint8_t, 4>& valences);

    /// Equal for neighbourhoods of one kind, different for others.
    [[nodiscard]] const std::string& key() const { return key_; }
    /// The vertex in each slot.
    [[nodiscard]] std::span<const std::int32_t> vertices() const { return vertices_; }
    /// The neighbourhood as a mesh of its own: the face is number 0, slots are vertices.
    /// @pre not control_points()
    [[nodiscard]] std::shared_ptr<const mesh::Topology> local_topology() const;
    /// RingKind::regular() near parabolic runouts, where it does not follow from a topology of its
    /// own; elsewhere nothing.
    [[nodiscard]] std::optional<Eigen::MatrixXd> control_points() const;

  private:
    struct FaceCopy {
        mesh::CornerId first;
        int size;
        int begin;  // of its nodes, one a corner
    };
    struct Spoke {
        int face, position;
        double sharpness;
        mesh::CornerId leaving, twin;
    };

    [[nodiscard]] mesh::CornerId own_corner(int i) const {
        return mesh::CornerId{own_first_.value + i};
    }
    int add_face(mesh::CornerId first);
    [[nodiscard]] int position(int f, mesh::CornerId c) const;
    int root(int node);
    void unite(int f, int k, int g, int l);
    void put_size(int size);
    void put_sharpness(double sharpness);
    void put_number(double number);
    void note_spoke(int f, int position, mesh::CornerId c);
    void walk(int i);
    void walk_clockwise(int i, mesh::CornerId start);
    void glue(int f, mesh::CornerId arriving, int g, mesh::CornerId leaving);
    void number_slots();
    [[nodiscard]] int slot(int f, int k) const {
        return slot_[std::size_t(faces_[std::size_t(f)].begin + k)];
    }

    const mesh::Topology* topology_ = nullptr;
    mesh::CornerId own_first_;
    int own_ = 0;
    std::vector<FaceCopy> faces_;
    std::vector<int> neighbour_;  // per own edge: face copy across it, -1 at a boundary
    std::vector<int> parent_;     // union-find over nodes
    std::vector<int> slot_;
    std::vector<Spoke> spokes_;
    std::vector<std::int32_t> vertices_;
    std::string key_;
    std::optional<LineGrid> line_grid_;
};

/// Extracts the neighbourhood of a face, the short way where it can.
/// @param smooth  smooth_valences() of the topology
const RingKind& extract_ring(RingTable& table, RingExtractor& ring, const mesh::Topology& topology,
                             const std::vector<std::uint8_t>& smooth, mesh::FaceId face);

}  // namespace patchwright::subd
