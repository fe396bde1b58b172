#include "fit/match/surface_parts.h"

#include "geom/disjoint_sets.h"

#include <algorithm>
#include <array>
#include <map>

namespace patchwright::fit {

using mesh::CornerId;
using mesh::Topology;
using mesh::VertexId;

namespace {

// Of a curve: what chains may leave out where they meet, and yet follow it all along.
constexpr double left_out_rel = 1e-6;

/// Where nothing is known yet, and where sides say different things.
constexpr int unknown = -1, contradictory = -2;

void agree(int& known, int part) {
    if (part == unknown) return;
    if (known == unknown || known == part)
        known = part;
    else
        known = contradictory;
}

/// Chains whose curves are followed by chains all along.
std::vector<char> whole_chains(const FeatureMatch& match,
                               const std::vector<geom::FeatureCurve>& curves) {
    std::vector<char> whole;
    for (const FeaturePath& path : match.paths) whole.push_back(path.empty() ? 0 : 1);
    for (bool changed = true; changed;) {
        std::map<int, double> followed;
        for (std::size_t c = 0; c < whole.size(); ++c)
            for (const FeaturePiece& piece : match.paths[c])
                if (whole[c] != 0) followed[piece.curve] += piece.range.to - piece.range.from;
        changed = false;
        for (std::size_t c = 0; c < whole.size(); ++c) {
            const bool stays = std::ranges::all_of(match.paths[c], [&](const FeaturePiece& piece) {
                const double length = curves[std::size_t(piece.curve)].length;
                return followed[piece.curve] >= (1.0 - left_out_rel) * length;
            });
            if (whole[c] == 0 || stays) continue;
            whole[c] = 0;
            changed = true;
        }
    }
    return whole;
}

/// The parts of a reference between some of its curves.
class ReferenceParts {
  public:
    /// @param cut  one a curve: whether it parts the faces beside it
    ReferenceParts(const std::vector<geom::FaceBorder>& borders, const std::vector<char>& cut)
        : beside_(cut.size(), {unknown, unknown}) {
        int faces = 0;
        for (const geom::FaceBorder& b : borders)
            faces = std::max({faces, b.left + 1, b.right + 1});
        geom::DisjointSets sets{std::size_t(faces)};
        for (const geom::FaceBorder& b : borders)
            if (b.left >= 0 && b.right >= 0 && (b.curve < 0 || cut[std::size_t(b.curve)] == 0))
                sets.join(b.left, b.right);
        part_of_.resize(std::size_t(faces));
        for (int f = 0; f < faces; ++f) part_of_[std::size_t(f)] = sets.find(f);
        for (const geom::FaceBorder& b : borders) {
            if (b.curve < 0) continue;
            auto& [left, right] = beside_[std::size_t(b.curve)];
            if (b.left >= 0) agree(left, part_of_[std::size_t(b.left)]);
            if (b.right >= 0) agree(right, part_of_[std::size_t(b.right)]);
        }
    }

    /// Least number of its faces; or one of the above.
    [[nodiscard]] int beside(int curve, bool left) const {
        return beside_[std::size_t(curve)][left ? 0 : 1];
    }
    [[nodiscard]] std::vector<char> flags(int part) const {
        std::vector<char> result;
        for (const int p : part_of_) result.push_back(p == part ? 1 : 0);
        return result;
    }

  private:
    std::vector<int> part_of_;                ///< one a face
    std::vector<std::array<int, 2>> beside_;  ///< one a curve: on its left and on its right
};

}  // namespace

SurfaceParts::SurfaceParts(const Topology& topology, const CurveSampling& curves,
                           const FeatureMatch& match, const geom::ReferenceSurface& reference)
    : part_of_face_(std::size_t(topology.face_count()), -1) {
    const std::vector<char> whole = whole_chains(match, reference.features().curves);
    std::vector<char> cut(reference.features().curves.size(), 0);
    // Steps along the chains, with their numbers.
    std::map<std::pair<VertexId, VertexId>, int> steps;
    for (std::size_t c = 0; c < curves.chains.size(); ++c) {
        if (whole[c] == 0) continue;
        for (const FeaturePiece& piece : match.paths[c]) cut[std::size_t(piece.curve)] = 1;
        const auto& vertices = curves.chains[c].vertices;
        const std::size_t count = vertices.size();
        for (std::size_t i = 0; i + (curves.chains[c].closed ? 0 : 1) < count; ++i)
            steps[{vertices[i], vertices[(i + 1) % count]}] = int(c);
    }
    if (steps.empty()) return;
    const ReferenceParts of_reference(reference.face_borders(), cut);
    geom::DisjointSets regions(part_of_face_.size());
    const auto chain_under = [&](VertexId from, VertexId to) {
        const auto found = steps.find({from, to});
        return found == steps.end() ? -1 : found->second;
    };
    const auto each_side = [&](const auto& body) {
        for (const mesh::FaceId f : topology.faces())
            for (const CornerId c : topology.corners(f)) {
                const VertexId a = topology.vertex(c), b = topology.vertex(topology.next(c));
                const int along = chain_under(a, b), against = chain_under(b, a);
                body(f.value, topology.twin(c), std::max(along, against), along >= 0);
            }
    };
    each_side([&](int f, CornerId twin, int chain, bool) {
        if (chain < 0 && twin.valid()) regions.join(f, topology.face(twin).value);
    });
    std::vector<int> part_of_region(part_of_face_.size(), unknown);
    each_side([&](int f, CornerId, int chain, bool along) {
        if (chain < 0) return;
        // A face is on the left of its own sides.
        for (const FeaturePiece& piece : match.paths[std::size_t(chain)])
            agree(part_of_region[std::size_t(regions.find(f))],
                  of_reference.beside(piece.curve, along != piece.reversed));
    });
    std::map<int, int> number;
    for (std::size_t f = 0; f < part_of_face_.size(); ++f) {
        const int part = part_of_region[std::size_t(regions.find(int(f)))];
        if (part < 0) continue;
        const auto [it, added] = number.emplace(part, int(parts_.size()));
        if (added) parts_.push_back(of_reference.flags(part));
        part_of_face_[f] = it->second;
    }
}

const std::vector<char>* SurfaceParts::part_of(mesh::FaceId face) const {
    const int part = part_of_face_[face.index()];
    return part < 0 ? nullptr : &parts_[std::size_t(part)];
}

}  // namespace patchwright::fit
