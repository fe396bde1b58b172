#include "cage/blocks/crest_cut.h"

#include "cage/tight_radius.h"
#include "geom/shortest_paths.h"

#include <patchwright/base/numbers.h>

#include <algorithm>
#include <cmath>

namespace patchwright::cage {

using base::at;
using geom::Vec3;

namespace {

// Times as much a surface must bend across a crest as along it: balls are no crests.
constexpr double least_ratio = 3.0;
// A crest is at least this long, in radii that are just too tight, and its strip touches borders on
// at most this share of its length: else it is a small fillet or a blend all around.
constexpr double shortest_crest = 5.0, longest_contact = 0.2;
// Points of a border that may be missing in a contact.
constexpr int most_gap = 2;
// Power of the curvature that makes ways shorter.
constexpr double follows_bend = 2.0;

class CrestSearch {
  public:
    /// @param bend  by point of the piece, times the radius that is too small; 0 on the border
    CrestSearch(const CutPiece& piece, const PieceMesh& mesh, double tightest,
                std::vector<double> bend)
        : piece_(piece), mesh_(mesh), tightest_(tightest), bend_(std::move(bend)) {}

    std::optional<Cut> run() {
        std::vector<char> seen(bend_.size(), 0);
        std::optional<Cut> longest;
        double most = 0.0;
        for (std::size_t i = 0; i < bend_.size(); ++i) {
            if (bend_[i] <= 1.0 || seen[i] != 0) continue;
            std::vector<int> strip{int(i)};
            seen[i] = 1;
            for (std::size_t k = 0; k < strip.size(); ++k)
                for (const auto& [j, length] : piece_.neighbours[at(strip[k])]) {
                    if (bend_[at(j)] <= 1.0 || seen[at(j)] != 0) continue;
                    seen[at(j)] = 1;
                    strip.push_back(j);
                }
            double length = 0.0;
            auto cut = along(strip, length);
            if (!cut || length <= most) continue;
            most = length;
            longest = std::move(cut);
        }
        return longest;
    }

  private:
    [[nodiscard]] const Vec3& point(int i) const {
        return mesh_.mesh().point(piece_.vertices[at(i)]);
    }

    /// Border points next to a strip, as runs of consecutive points.
    struct ContactRun {
        std::vector<int> points;
        double length = 0.0;
    };
    [[nodiscard]] std::vector<ContactRun> contacts(const std::vector<int>& strip) const {
        std::vector<char> touched(at(piece_.border_count()), 0);
        for (const int i : strip)
            for (const auto& [j, length] : piece_.neighbours[at(i)])
                if (j < piece_.border_count()) touched[at(j)] = 1;
        std::vector<ContactRun> runs;
        int base = 0;
        for (const Border& border : piece_.borders) {
            const int n = int(border.size());
            // Begins after a gap.
            int start = -1;
            for (int i = 0; i < n && start < 0; ++i) {
                bool gap = true;
                for (int k = 0; k <= most_gap; ++k)
                    gap = gap && touched[at(base + (i + k) % n)] == 0;
                if (gap) start = i;
            }
            int since = most_gap + 1;
            for (int k = 0; k < n; ++k) {
                const int i = base + (std::max(start, 0) + k) % n;
                if (touched[at(i)] == 0) {
                    ++since;
                    continue;
                }
                if (since > most_gap) runs.emplace_back();
                ContactRun& run = runs.back();
                if (!run.points.empty()) run.length += (point(i) - point(run.points.back())).norm();
                run.points.push_back(i);
                since = 0;
            }
            base += n;
        }
        return runs;
    }

    /// The point of a run next to which the strip is bent most tightly.
    [[nodiscard]] int sharpest(const ContactRun& run) const {
        int best = -1;
        double most = 0.0;
        for (const int i : run.points) {
            double bend = 0.0;
            for (const auto& [j, length] : piece_.neighbours[at(i)])
                bend = std::max(bend, bend_[at(j)]);
            if (bend <= most || piece_.border_point(i).faces != 2) continue;
            most = bend;
            best = i;
        }
        return best;
    }

    /// Along a strip from border to border, where it is bent most.
    [[nodiscard]] std::optional<Cut> along(const std::vector<int>& strip, double& length) const {
        const std::vector<ContactRun> runs = contacts(strip);
        if (runs.size() != 2) return std::nullopt;
        const int from = sharpest(runs[0]), to = sharpest(runs[1]);
        if (from < 0 || to < 0) return std::nullopt;
        length = (point(to) - point(from)).norm();
        const double contact = std::max(runs[0].length, runs[1].length);
        if (length < shortest_crest * tightest_ || contact > longest_contact * length)
            return std::nullopt;
        // Tightly bent points are near to each other: the path follows the crest.
        const auto visit = [&](int i, double way, const auto& reach) {
            for (const auto& [j, step] : piece_.neighbours[at(i)]) {
                if (j != to && bend_[at(j)] <= 1.0) continue;
                reach(j, way + step / std::pow(j == to ? 1.0 : bend_[at(j)], follows_bend));
            }
        };
        const geom::ShortestPaths paths = geom::shortest_paths(bend_.size(), {{from, 0.0}}, visit);
        if (paths.from[at(to)] < 0) return std::nullopt;
        Cut cut;
        cut.path = paths.path_to(to);
        cut.start.angle = 0.5 * piece_.border_point(from).angle;
        cut.end.angle = 0.5 * piece_.border_point(to).angle;
        return cut;
    }

    const CutPiece& piece_;
    const PieceMesh& mesh_;
    double tightest_;
    std::vector<double> bend_;
};

}  // namespace

CrestCuts::CrestCuts(const PieceMesh& mesh, const geom::ModelSurface& reference, Poll& poll)
    : mesh_(mesh),
      reference_(reference),
      poll_(poll),
      tightest_(tight_radius_rel * reference.size()) {}

double CrestCuts::bend_at(int vertex) {
    bend_.resize(at(mesh_.mesh().vertex_count()), -1.0);
    double& bend = bend_[at(vertex)];
    if (bend >= 0.0) return bend;
    poll_();
    bend = 0.0;
    const auto curvature = reference_.curvature(
        reference_.foot_point(mesh_.mesh().point(vertex), mesh_.mesh().vertex_normal(vertex)));
    if (!curvature) return bend;
    const auto [small, large] =
        std::minmax({std::abs(curvature->value[0]), std::abs(curvature->value[1])});
    if (least_ratio * small < large) bend = large * tightest_;
    return bend;
}

std::optional<Cut> CrestCuts::longest(const CutPiece& piece) {
    std::vector<double> bend(piece.vertices.size(), 0.0);
    for (std::size_t i = at(piece.border_count()); i < bend.size(); ++i)
        bend[i] = bend_at(piece.vertices[i]);
    return CrestSearch(piece, mesh_, tightest_, std::move(bend)).run();
}

}  // namespace patchwright::cage
