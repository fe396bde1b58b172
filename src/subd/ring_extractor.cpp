#include "subd/ring_extractor.h"

#include <algorithm>
#include <cmath>

namespace patchwright::subd {

using mesh::CornerId;
using mesh::EdgeId;
using mesh::FaceId;
using mesh::Topology;
using mesh::VertexId;

std::vector<std::uint8_t> smooth_valences(const Topology& topology) {
    std::vector<std::uint8_t> faces_around(std::size_t(topology.vertex_count()), 0);
    // Counts beyond all valences mean "not smooth" and must not wrap around.
    constexpr std::uint8_t never = 100;
    const auto spoil = [&](VertexId v) { faces_around[v.index()] = never; };
    for (const FaceId f : topology.faces()) {
        for (const CornerId c : topology.corners(f)) {
            std::uint8_t& count = faces_around[topology.vertex(c).index()];
            if (count < never) ++count;
        }
    }
    if (!topology.all_quads()) {
        for (const FaceId f : topology.faces()) {
            if (topology.size(f) == 4) continue;
            for (const CornerId c : topology.corners(f)) spoil(topology.vertex(c));
        }
    }
    for (const EdgeId e : topology.edges()) {
        if (topology.tagged_sharpness(e) > 0.0 || topology.is_boundary(e)) {
            spoil(topology.start(e));
            spoil(topology.end(e));
        }
    }
    if (topology.has_edge_shifts()) {
        for (const FaceId f : topology.faces()) {
            for (const CornerId c : topology.corners(f)) {
                if (!topology.is_shifted(c)) continue;
                spoil(topology.vertex(c));
                spoil(topology.vertex(topology.next(c)));
            }
        }
    }
    for (const VertexId v : topology.vertices()) {
        std::uint8_t& valence = faces_around[v.index()];
        if (valence < 3 || valence > 10 || topology.tagged_sharpness(v) > 0.0) valence = 0;
    }
    return faces_around;
}

void RingExtractor::extract(const Topology& topology, FaceId face) {
    line_grid_.reset();
    if (topology.is_near_runout(face)) {
        line_grid_.emplace(topology, face);
        vertices_ = line_grid_->vertices();
        key_ = line_grid_->key();
        return;
    }
    topology_ = &topology;
    own_first_ = topology.corners(face)[0];
    own_ = topology.size(face);
    faces_.clear();
    neighbour_.clear();
    parent_.clear();
    spokes_.clear();
    key_.clear();
    add_face(own_first_);
    for (int i = 0; i < own_; ++i) {
        const CornerId across = topology.twin(own_corner(i));
        neighbour_.push_back(across.valid() ? add_face(across) : -1);
    }
    put_size(own_);
    for (int i = 0; i < own_; ++i) walk(i);
    number_slots();
}

void RingExtractor::extract_smooth(const Topology& topology, FaceId face,
                                   const std::array<std::uint8_t, 4>& valences) {
    // In the order in which extract() numbers slots: own vertices, those of the neighbours across
    // edges, then around each own vertex those of the faces between two neighbours.
    const auto corners = topology.corners(face);
    vertices_.clear();
    const auto add = [&](CornerId c) { vertices_.push_back(topology.vertex(c).value); };
    CornerId across[4];
    for (int i = 0; i < 4; ++i) {
        add(corners[i]);
        across[i] = topology.twin(corners[i]);
    }
    for (int i = 0; i < 4; ++i) {
        // With three faces around a vertex two neighbours share an edge that leaves it.
        const CornerId beyond = topology.next(topology.next(across[i]));
        if (i == 0 || valences[std::size_t(i)] != 3) add(beyond);
        if (i != 3 || valences[0] != 3) add(topology.next(beyond));
    }
    for (int i = 0; i < 4; ++i) {
        CornerId leaving = across[i == 0 ? 3 : i - 1];  // of vertex i, in the face last met
        for (int between = valences[std::size_t(i)] - 3; between > 0; --between) {
            leaving = topology.rotate(leaving);
            const CornerId far = topology.next(topology.next(leaving));
            add(far);
            if (between > 1) add(topology.next(far));
        }
    }
}

std::optional<Eigen::MatrixXd> RingExtractor::control_points() const {
    if (!line_grid_) return std::nullopt;
    return line_grid_->control_points();
}

std::shared_ptr<const Topology> RingExtractor::local_topology() const {
    mesh::TopologyInput input;
    input.vertex_count = static_cast<int>(vertices_.size());
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        input.face_sizes.push_back(faces_[f].size);
        for (int k = 0; k < faces_[f].size; ++k) input.face_vertices.push_back(slot(int(f), k));
    }
    for (const Spoke& s : spokes_) {
        const int start = slot(s.face, s.position);
        const int after = s.position + 1;
        const int end = slot(s.face, after == faces_[std::size_t(s.face)].size ? 0 : after);
        if (s.sharpness > 0.0) input.creases.push_back({start, end, s.sharpness});
        if (topology_->is_shifted(s.leaving)) {
            input.edge_shifts.push_back({start, end, topology_->edge_shift(s.leaving)});
        }
        if (topology_->is_shifted(s.twin)) {
            input.edge_shifts.push_back({end, start, topology_->edge_shift(s.twin)});
        }
    }
    for (int i = 0; i < own_; ++i) {
        const double sharpness = topology_->sharpness(topology_->vertex(own_corner(i)));
        if (sharpness > 0.0) input.corners.push_back({i, sharpness});
    }
    return std::make_shared<const Topology>(input);
}

int RingExtractor::add_face(CornerId first) {
    const int begin = static_cast<int>(parent_.size());
    const int size = topology_->size(topology_->face(first));
    for (int k = 0; k < size; ++k) parent_.push_back(begin + k);
    faces_.push_back({first, size, begin});
    return static_cast<int>(faces_.size()) - 1;
}

/// Position of `c` within face copy `f`, counted from the copy's first corner.
int RingExtractor::position(int f, CornerId c) const {
    const FaceCopy& copy = faces_[std::size_t(f)];
    const int offset = c.value - copy.first.value;
    return offset < 0 ? offset + copy.size : offset;
}

int RingExtractor::root(int node) {
    while (parent_[std::size_t(node)] != node) node = parent_[std::size_t(node)];
    return node;
}

void RingExtractor::unite(int f, int k, int g, int l) {
    const FaceCopy& a = faces_[std::size_t(f)];
    const FaceCopy& b = faces_[std::size_t(g)];
    const int x = root(a.begin + (k == a.size ? 0 : k));
    const int y = root(b.begin + (l == b.size ? 0 : l));
    parent_[std::size_t(std::max(x, y))] = std::min(x, y);
}

// The key is a string of bytes that can be read in one way only.
void RingExtractor::put_size(int size) {
    if (size < 255) {
        key_.push_back(static_cast<char>(size));
    } else {
        key_.push_back(static_cast<char>(255));
        key_.append(reinterpret_cast<const char*>(&size), sizeof size);
    }
}

void RingExtractor::put_sharpness(double sharpness) {
    if (sharpness == 0.0) {
        key_.push_back('s');
    } else if (std::isinf(sharpness)) {
        key_.push_back('i');
    } else {
        key_.push_back('f');
        put_number(sharpness);
    }
}

void RingExtractor::put_number(double number) {
    key_.append(reinterpret_cast<const char*>(&number), sizeof number);
}

void RingExtractor::note_spoke(int f, int position, CornerId c) {
    const double sharpness = topology_->sharpness(topology_->edge(c));
    const CornerId twin = topology_->twin(c);
    const bool shifted = topology_->is_shifted(c), shifted_back = topology_->is_shifted(twin);
    if (shifted || shifted_back) {
        key_.push_back(shifted ? (shifted_back ? 'b' : 'm') : 'n');
        if (shifted) put_number(topology_->edge_shift(c));
        if (shifted_back) put_number(topology_->edge_shift(twin));
    }
    spokes_.push_back({f, position, sharpness, c, twin});
    put_sharpness(sharpness);
}

/// Glues the faces around own vertex `i` along its edges and writes what is met into the key.
void RingExtractor::walk(int i) {
    const CornerId start = own_corner(i);
    const int before = i == 0 ? own_ - 1 : i - 1;
    put_sharpness(topology_->sharpness(topology_->vertex(start)));
    note_spoke(0, i, start);
    // Counter-clockwise from the face: first across the edge that arrives at the vertex.
    int f = 0;
    CornerId c = start;
    for (int step = 0;; ++step) {
        const CornerId arriving = topology_->previous(c);
        const CornerId next = topology_->twin(arriving);
        note_spoke(f, position(f, arriving), arriving);
        if (!next.valid()) {
            put_size(0);
            walk_clockwise(i, start);
            return;
        }
        if (next == start) return;
        const bool last = topology_->twin(topology_->previous(next)) == start;
        const int g = step == 0 ? neighbour_[std::size_t(before)]
                      : last    ? neighbour_[std::size_t(i)]
                                : add_face(next);
        put_size(faces_[std::size_t(g)].size);
        glue(f, arriving, g, next);
        if (last) glue(g, topology_->previous(next), 0, start);
        f = g;
        c = next;
    }
}

void RingExtractor::walk_clockwise(int i, CornerId start) {
    int f = 0;
    CornerId c = start;
    for (int step = 0;; ++step) {
        const CornerId arriving = topology_->twin(c);
        if (!arriving.valid()) {
            put_size(0);
            return;
        }
        const CornerId next = topology_->next(arriving);
        const int g = step == 0 ? neighbour_[std::size_t(i)] : add_face(next);
        put_size(faces_[std::size_t(g)].size);
        glue(g, arriving, f, c);
        note_spoke(g, position(g, next), next);
        f = g;
        c = next;
    }
}

/// Identifies the ends of an edge that `f` runs as `arriving` and `g` as its twin `leaving`.
void RingExtractor::glue(int f, CornerId arriving, int g, CornerId leaving) {
    const int k = position(f, arriving);
    const int l = position(g, leaving);
    unite(f, k, g, l + 1);
    unite(f, k + 1, g, l);
}

void RingExtractor::number_slots() {
    slot_.assign(parent_.size(), -1);
    vertices_.clear();
    for (const FaceCopy& f : faces_) {
        CornerId c = f.first;
        for (int k = 0; k < f.size; ++k, c = topology_->next(c)) {
            const int node = f.begin + k;
            // A root is the lowest node of its set: it is met, and numbered, first.
            const int number_of = root(node);
            if (number_of == node) {
                slot_[std::size_t(node)] = static_cast<int>(vertices_.size());
                vertices_.push_back(topology_->vertex(c).value);
            } else {
                slot_[std::size_t(node)] = slot_[std::size_t(number_of)];
            }
        }
    }
}

const RingKind& extract_ring(RingTable& table, RingExtractor& ring, const Topology& topology,
                             const std::vector<std::uint8_t>& smooth, FaceId face) {
    const auto corners = topology.corners(face);
    if (corners.size() == 4 && !topology.is_near_runout(face)) {
        std::array<std::uint8_t, 4> valences;
        bool all = true;
        for (int i = 0; i < 4; ++i) {
            valences[std::size_t(i)] = smooth[topology.vertex(corners[i]).index()];
            all = all && valences[std::size_t(i)] != 0;
        }
        if (all) {
            if (const RingKind* kind = table.smooth_kind(valences)) {
                ring.extract_smooth(topology, face, valences);
                return *kind;
            }
            ring.extract(topology, face);
            return table.add_smooth_kind(valences, table.kind(ring));
        }
    }
    ring.extract(topology, face);
    return table.kind(ring);
}

}  // namespace patchwright::subd
