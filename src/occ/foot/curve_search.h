// Nearest points on edge curves.
#pragma once

#include "geom/bvh.h"
#include "occ/foot/model_edges.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace patchwright::occ {

struct CurveHit {
    int edge = -1;
    double t = 0.0;
    geom::Vec3 point = geom::Vec3::Zero();
    double distance = 0.0;
};

/// Hierarchy over the chords of some edges; nearest points by Newton on the true curves.
/// @pre the edges given on construction outlive the search
class CurveSearch {
  public:
    CurveSearch() = default;
    /// @param deflection  how far a chord may be from its piece of curve
    CurveSearch(const std::vector<ModelEdge>& edges, const std::vector<int>& subset,
                double deflection, double size);

    [[nodiscard]] bool empty() const { return chords_.empty(); }

    /// Calls `visit(hit, bound)` with nearest points of pieces of curves that may lie within
    /// `bound` (plus the edge's tolerance); it returns the bound to go on with.
    template <class Visit>
    void visit(const geom::Vec3& query, double bound, Visit&& visit_hit) const {
        tree_.nearest(query, bound, [&](int item, double limit) {
            const Chord& chord = chords_[std::size_t(item)];
            const double s = chord_parameter(chord, query);
            const geom::Vec3 on_chord = chord.start + s * (chord.end - chord.start);
            if ((on_chord - query).norm() - chord.error > limit) return limit;
            return visit_hit(nearest_on(chord, query, s), limit);
        });
    }

    /// The same with only the parts of each edge that `parts(edge)` lists as parameter ranges.
    template <class Parts, class Visit>
    void visit_within(const geom::Vec3& query, double bound, Parts&& parts,
                      Visit&& visit_hit) const {
        tree_.nearest(query, bound, [&](int item, double limit) {
            const Chord& whole = chords_[std::size_t(item)];
            for (const auto& [from, to] : parts(whole.edge)) {
                Chord chord = whole;
                chord.t0 = std::max(whole.t0, from);
                chord.t1 = std::min(whole.t1, to);
                if (chord.t0 > chord.t1) continue;
                chord.start = at(chord, chord.t0);
                chord.end = at(chord, chord.t1);
                const double s = chord_parameter(chord, query);
                limit = visit_hit(nearest_on(chord, query, s), limit);
            }
            return limit;
        });
    }

    /// No edge (with its tolerance) is nearer to `query` than this, nor is its nearest point known
    /// to be nearer than `bound`; negative inside a tolerance.
    [[nodiscard]] double clearance(const geom::Vec3& query, double bound) const {
        return tree_.nearest(query, bound, [&](int item, double limit) {
            const Chord& chord = chords_[std::size_t(item)];
            const double s = chord_parameter(chord, query);
            const geom::Vec3 on_chord = chord.start + s * (chord.end - chord.start);
            return std::min(limit, (on_chord - query).norm() - chord.error);
        });
    }

  private:
    /// A piece of curve as powers of (t - middle) * scale, -1 to 1 within the piece.
    struct Polynomial {
        double middle = 0.0, scale = 0.0;
        std::int32_t first = 0, degree = -1;  ///< the first of its powers; -1: not a polynomial
    };
    struct Chord {
        geom::Vec3 start, end;
        double t0 = 0.0, t1 = 0.0;
        double error = 0.0;  ///< largest distance of the piece of curve, with the edge's tolerance
        int edge = -1;
        Polynomial polynomial;
    };

    [[nodiscard]] geom::Vec3 at(const Chord& chord, double t) const {
        return (*edges_)[std::size_t(chord.edge)].at(t);
    }
    static double chord_parameter(const Chord& chord, const geom::Vec3& query);
    [[nodiscard]] CurveHit nearest_on(const Chord& chord, const geom::Vec3& query, double s) const;
    /// Point and two derivatives of a chord's curve.
    void evaluate(const Chord& chord, double t, geom::Vec3& p, geom::Vec3& d, geom::Vec3& dd) const;
    [[nodiscard]] CurveHit descend(const Chord& chord, const geom::Vec3& query, double s) const;
    void add_edge(int edge, double deflection);
    [[nodiscard]] Polynomial polynomial_on(const ModelEdge& edge, double from, double to);
    void sort_powers();
    void split(Chord chord, double deflection, int depth);

    const std::vector<ModelEdge>* edges_ = nullptr;
    std::vector<Chord> chords_;
    std::vector<geom::Vec3> powers_;
    geom::Bvh tree_;
    double size_ = 0.0;
};

}  // namespace patchwright::occ
