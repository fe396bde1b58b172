#include "cage/blocks/crest_cut.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace patchwright::cage {

using geom::Vec3;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Of the diagonal: radii below are too small for faces of a cage.
constexpr double tight_rel = 6e-3;

std::size_t at(int i) { return std::size_t(i); }

class CrestSearch {
  public:
    CrestSearch(const Piece& piece, const PieceMesh& mesh, const geom::ModelSurface& reference)
        : piece_(piece),
          mesh_(mesh),
          tightest_(tight_rel * reference.bounds().diagonal()),
          bend_(piece.vertices.size(), 0.0) {
        for (std::size_t i = at(piece.border_count()); i < bend_.size(); ++i) {
            const int v = piece.vertices[i];
            const auto bend = reference.curvature(
                reference.foot_point(mesh.mesh().point(v), mesh.mesh().vertex_normal(v)));
            if (!bend) continue;
            // Balls are no crests.
            const auto [small, large] =
                std::minmax({std::abs(bend->value[0]), std::abs(bend->value[1])});
            if (3.0 * small < large) bend_[i] = large * tightest_;
        }
    }

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

    /// Border points beside a strip in runs that follow each other; nothing but when there are two.
    struct Run {
        std::vector<int> points;
        double length = 0.0;
    };
    [[nodiscard]] std::vector<Run> contacts(const std::vector<int>& strip) const {
        constexpr int most_gap = 2;
        std::vector<char> touched(at(piece_.border_count()), 0);
        for (const int i : strip)
            for (const auto& [j, length] : piece_.neighbours[at(i)])
                if (j < piece_.border_count()) touched[at(j)] = 1;
        std::vector<Run> runs;
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
                Run& run = runs.back();
                if (!run.points.empty()) run.length += (point(i) - point(run.points.back())).norm();
                run.points.push_back(i);
                since = 0;
            }
            base += n;
        }
        return runs;
    }

    /// The point of a run beside which the strip is bent most tightly.
    [[nodiscard]] int sharpest(const Run& run) const {
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
        constexpr double longest_contact = 0.2, shortest_rel = 5.0, edge = 2.0;
        const std::vector<Run> runs = contacts(strip);
        if (runs.size() != 2) return std::nullopt;
        const int from = sharpest(runs[0]), to = sharpest(runs[1]);
        if (from < 0 || to < 0) return std::nullopt;
        length = (point(to) - point(from)).norm();
        const double contact = std::max(runs[0].length, runs[1].length);
        if (length < shortest_rel * tightest_ || contact > longest_contact * length)
            return std::nullopt;
        std::vector<double> way(bend_.size(), infinity);
        std::vector<int> back(bend_.size(), -1);
        using Item = std::pair<double, int>;
        std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
        way[at(from)] = 0.0;
        queue.emplace(0.0, from);
        while (!queue.empty()) {
            const auto [l, i] = queue.top();
            queue.pop();
            if (l > way[at(i)]) continue;
            for (const auto& [j, step] : piece_.neighbours[at(i)]) {
                if (j != to && bend_[at(j)] <= 1.0) continue;
                const double there = l + step / std::pow(j == to ? 1.0 : bend_[at(j)], edge);
                if (there >= way[at(j)]) continue;
                way[at(j)] = there;
                back[at(j)] = i;
                queue.emplace(there, j);
            }
        }
        if (back[at(to)] < 0) return std::nullopt;
        Cut cut;
        for (int i = to; i >= 0; i = back[at(i)]) cut.path.push_back(i);
        std::reverse(cut.path.begin(), cut.path.end());
        cut.start.angle = 0.5 * piece_.border_point(from).angle;
        cut.end.angle = 0.5 * piece_.border_point(to).angle;
        return cut;
    }

    const Piece& piece_;
    const PieceMesh& mesh_;
    double tightest_;
    std::vector<double> bend_;  ///< times the radius that is too small; 0 on the border
};

}  // namespace

std::optional<Cut> crest_cut(const Piece& piece, const PieceMesh& mesh,
                             const geom::ModelSurface& reference) {
    return CrestSearch(piece, mesh, reference).run();
}

}  // namespace patchwright::cage
