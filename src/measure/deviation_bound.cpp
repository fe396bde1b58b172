#include "measure/second_order.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/measure/deviation.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <vector>

namespace patchwright::measure {

using geom::Vec3;

namespace {

/// Of what is estimated or seen at one point to lie between samples: what lies there may be half as
/// large again, as where curvature changes within a piece (deviation_bound_test.cpp, the bump).
constexpr double safety = 1.5;
/// The largest distance of a triangle's points from the nearest corner, in longest sides: 1 /
/// sqrt(3), rounded up.
constexpr double reach_of_triangle = 0.5774;
/// A bound that is a tenth, or a hundred thousandth of the diagonal, above what was found is not
/// refined further: that is what the report's readers can use.
constexpr double slack_rel = 0.1, slack_of_diagonal = 1e-5;
/// A round refines what is above this share of the largest bound, so that a budget that ends
/// leaves pieces of about the same bound.
constexpr double round_share = 0.8;
/// Triangulations of ruled surfaces are long and thin; pieces that are longer than this are halved.
constexpr double long_in_shortest_sides = 2.0;
/// Feature curves are first looked at in pieces of a hundredth of the diagonal, at least two.
constexpr double span_of_diagonal = 0.01;
constexpr int least_spans = 2;
/// The quarter of the budget that curves may take at most.
constexpr int share_of_curves = 4;
constexpr std::size_t feet_a_task = 64, feet_a_block = 8192;

/// A piece of a face over a triangle of the parameter plane.
struct Piece {
    int face = 0;
    std::array<int, 3> corner{};  ///< numbers of samples
    int middle = 0;               ///< the same
    double bound = std::numeric_limits<double>::infinity();
};

struct Sample {
    int face = 0;
    Eigen::Vector2d uv = Eigen::Vector2d::Zero();
    ShapePair pair;
};

struct CurveProbe {
    double arc_length = 0.0;     ///< mm
    Vec3 offset = Vec3::Zero();  ///< from its foot point
};

/// A piece of a feature curve with samples at its start, in its middle and at its end.
struct Span {
    int curve = 0;
    std::array<CurveProbe, 3> sample;
    double bound = std::numeric_limits<double>::infinity();
};

class Bounding {
  public:
    Bounding(const geom::ModelSurface& from, const geom::ModelSurface& to,
             const BoundOptions& options)
        : from_(from),
          to_(to),
          options_(options),
          slack_mm_(slack_of_diagonal * from.bounds().diagonal()),
          found_(options.found_mm) {}

    double bound() {
        const double curves = bound_curves();
        return std::max(curves, bound_faces());
    }

  private:
    [[nodiscard]] double goal() const { return found_ + std::max(slack_rel * found_, slack_mm_); }

    /// Calls `work` for all numbers from `first` on, in parallel, with progress in between.
    template <class Work>
    void in_blocks(std::size_t first, std::size_t end, const Work& work) {
        for (std::size_t start = first; start < end; start += feet_a_block) {
            base::report_progress(options_.progress, "bound",
                                  feet_ < limit_ ? double(feet_) / double(limit_) : 0.0);
            const std::size_t count = std::min(feet_a_block, end - start);
            base::parallel_for(count, feet_a_task, [&](std::size_t a, std::size_t b) {
                for (std::size_t i = start + a; i < start + b; ++i) work(i);
            });
        }
    }

    int sample(int face, const Eigen::Vector2d& uv) {
        const auto [it, is_new] = known_.try_emplace({face, uv[0], uv[1]}, int(samples_.size()));
        if (is_new) samples_.push_back({face, uv, {}});
        return it->second;
    }

    Piece piece(int face, const std::array<int, 3>& corner) {
        const auto uv = [&](std::size_t k) { return samples_[std::size_t(corner[k])].uv; };
        return {face, corner, sample(face, (uv(0) + uv(1) + uv(2)) / 3.0)};
    }

    void evaluate_samples(std::size_t first) {
        const auto shape = [](const geom::ModelSurface& surface, const geom::FootPoint& at) {
            return SurfaceShape{at.point, at.normal,
                                at.face >= 0 ? surface.curvature(at) : std::nullopt};
        };
        in_blocks(first, samples_.size(), [&](std::size_t i) {
            Sample& s = samples_[i];
            const geom::FootPoint point = from_.point_on_face(s.face, s.uv);
            s.pair = {shape(from_, point), shape(to_, to_.foot_point(point.point))};
        });
        for (std::size_t i = first; i < samples_.size(); ++i)
            found_ = std::max(found_, samples_[i].pair.distance());
        feet_ += std::int64_t(samples_.size() - first);
    }

    [[nodiscard]] double bound_of(const Piece& piece) const {
        std::array<const ShapePair*, 3> corner{};
        for (std::size_t k = 0; k < 3; ++k)
            corner[k] = &samples_[std::size_t(piece.corner[k])].pair;
        const ShapePair& middle = samples_[std::size_t(piece.middle)].pair;
        double distance = middle.distance(), side = 0.0;
        Vec3 between = middle.offset();
        for (std::size_t k = 0; k < 3; ++k) {
            distance = std::max(distance, corner[k]->distance());
            const Vec3 way = corner[(k + 1) % 3]->point.point - corner[k]->point.point;
            side = std::max(side, way.norm());
            between -= corner[k]->offset() / 3.0;
        }
        // Distances change no faster than points move.
        double more = reach_of_triangle * side;
        if (const auto error = interpolation_error(corner))
            more = std::min(more, safety * std::max(*error, between.norm()));
        return distance + more;
    }

    void bound_pieces(std::vector<Piece>& pieces, std::size_t first) {
        evaluate_samples(first);
        in_blocks(0, pieces.size(), [&](std::size_t i) { pieces[i].bound = bound_of(pieces[i]); });
    }

    /// Two pieces in place of a long one, four in place of others.
    void split(const Piece& whole, std::vector<Piece>& parts) {
        const auto uv = [&](std::size_t k) { return samples_[std::size_t(whole.corner[k])].uv; };
        const auto middle_of_side = [&](std::size_t k) {
            return sample(whole.face, 0.5 * (uv(k) + uv((k + 1) % 3)));
        };
        std::array<double, 3> length{};
        for (std::size_t k = 0; k < 3; ++k) {
            const auto at = [&](std::size_t c) {
                return samples_[std::size_t(whole.corner[c % 3])].pair.point.point;
            };
            length[k] = (at(k + 1) - at(k)).norm();
        }
        const auto [shortest, longest] = std::minmax_element(length.begin(), length.end());
        if (*longest > long_in_shortest_sides * *shortest) {
            const auto k = std::size_t(longest - length.begin());
            const int half = middle_of_side(k);
            const int opposite = whole.corner[(k + 2) % 3];
            parts.push_back(piece(whole.face, {whole.corner[k], half, opposite}));
            parts.push_back(piece(whole.face, {half, whole.corner[(k + 1) % 3], opposite}));
            return;
        }
        const std::array<int, 3> side{middle_of_side(0), middle_of_side(1), middle_of_side(2)};
        for (std::size_t k = 0; k < 3; ++k)
            parts.push_back(piece(whole.face, {whole.corner[k], side[k], side[(k + 2) % 3]}));
        // Its middle is the whole's, up to rounding.
        parts.push_back({whole.face, side, whole.middle});
    }

    double bound_faces() {
        std::vector<Piece> pieces;
        for (const geom::SurfacePiece& t : from_.pieces()) {
            std::array<int, 3> corner{};
            for (std::size_t k = 0; k < 3; ++k) corner[k] = sample(t.face, t.uv[k]);
            pieces.push_back(piece(t.face, corner));
        }
        bound_pieces(pieces, 0);
        limit_ = feet_ + options_.foot_points - options_.foot_points / share_of_curves;
        return refine(pieces, [&](const std::vector<Piece>& open) {
            const std::size_t first = samples_.size();
            std::vector<Piece> parts;
            for (const Piece& p : open) split(p, parts);
            bound_pieces(parts, first);
            return parts;
        });
    }

    [[nodiscard]] CurveProbe curve_sample(int curve, double arc_length) const {
        const Vec3 point = from_.point_on_curve(curve, arc_length).point;
        return {arc_length, point - to_.foot_point(point).point};
    }

    /// The middle's sample and the bound of spans whose ends are known.
    void bound_spans(std::vector<Span>& spans) {
        in_blocks(0, spans.size(), [&](std::size_t i) {
            auto& [start, middle, end] = spans[i].sample;
            const double length = end.arc_length - start.arc_length;
            middle = curve_sample(spans[i].curve, start.arc_length + 0.5 * length);
            const double uneven = (middle.offset - 0.5 * (start.offset + end.offset)).norm();
            spans[i].bound =
                std::max({start.offset.norm(), middle.offset.norm(), end.offset.norm()}) +
                std::min(safety * uneven, 0.25 * length);
        });
        for (const Span& span : spans) found_ = std::max(found_, span.sample[1].offset.norm());
        feet_ += std::int64_t(spans.size());
    }

    /// What lies between a face's boundary curve and its chords is as near as these two but for
    /// what is of second order in its width, which is a thousandth of the pieces'.
    double bound_curves() {
        const auto& curves = from_.features().curves;
        const double longest = span_of_diagonal * from_.bounds().diagonal();
        std::vector<Span> spans;
        for (std::size_t c = 0; c < curves.size(); ++c) {
            const int count = least_spans + int(curves[c].length / longest);
            for (int i = 0; i < count; ++i) {
                spans.push_back({int(c), {}});
                spans.back().sample[0].arc_length = curves[c].length * i / count;
                spans.back().sample[2].arc_length = curves[c].length * (i + 1) / count;
            }
        }
        in_blocks(0, spans.size(), [&](std::size_t i) {
            for (const std::size_t k : {0, 2})
                spans[i].sample[k] = curve_sample(spans[i].curve, spans[i].sample[k].arc_length);
        });
        feet_ += 2 * std::int64_t(spans.size());
        bound_spans(spans);
        limit_ = feet_ + options_.foot_points / share_of_curves;
        return refine(spans, [&](const std::vector<Span>& open) {
            std::vector<Span> halves;
            for (const Span& s : open) {
                halves.push_back({s.curve, {s.sample[0], {}, s.sample[1]}});
                halves.push_back({s.curve, {s.sample[1], {}, s.sample[2]}});
            }
            bound_spans(halves);
            return halves;
        });
    }

    /// Replaces pieces by parts, those with the largest bounds first, until all are near what was
    /// found or the budget or the time is used up.
    /// @return the largest bound that is left
    template <class Part, class Divide>
    double refine(std::vector<Part>& parts, const Divide& divide) {
        for (;;) {
            double largest = found_;
            for (const Part& part : parts) largest = std::max(largest, part.bound);
            if (largest <= goal() || feet_ >= limit_) return largest;
            const double level = std::max(goal(), round_share * largest);
            const auto open = std::stable_partition(
                parts.begin(), parts.end(), [&](const Part& p) { return p.bound <= level; });
            std::stable_sort(open, parts.end(),
                             [](const Part& a, const Part& b) { return a.bound < b.bound; });
            // As many as the budget allows, the worst first; they stand last.
            const auto affordable = (limit_ - feet_) / most_feet_of_parts + 1;
            const auto count = std::min<std::int64_t>(parts.end() - open, affordable);
            const std::vector<Part> divided(parts.end() - count, parts.end());
            parts.resize(parts.size() - std::size_t(count));
            const std::int64_t before = feet_;
            try {
                const std::vector<Part> made = divide(divided);
                parts.insert(parts.end(), made.begin(), made.end());
            } catch (const base::TimeLimitReached&) {
                return largest;
            }
            // Nothing new lies between corners that are next to each other as numbers, as where a
            // surface jumps.
            if (feet_ == before) return largest;
        }
    }

    /// Three on sides and three in the middle.
    static constexpr std::int64_t most_feet_of_parts = 6;

    const geom::ModelSurface& from_;
    const geom::ModelSurface& to_;
    const BoundOptions& options_;
    double slack_mm_;
    double found_;
    std::int64_t feet_ = 0;   ///< looked for until now
    std::int64_t limit_ = 0;  ///< beyond which nothing is refined
    std::vector<Sample> samples_;
    std::map<std::tuple<int, double, double>, int> known_;
};

}  // namespace

double measure_bound(const geom::ModelSurface& from, const geom::ModelSurface& to,
                     const BoundOptions& options) {
    if (options.foot_points < 0 || !(options.found_mm >= 0.0)) {
        throw base::InvalidArgument(
            fmt::format("measure_bound: {} foot points, found {} mm: neither may be negative",
                        options.foot_points, options.found_mm));
    }
    const double bound = Bounding(from, to, options).bound();
    base::report_progress(options.progress, "bound", 1.0);
    return bound;
}

}  // namespace patchwright::measure
