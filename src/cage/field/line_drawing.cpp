#include "cage/field/line_drawing.h"

#include "cage/blocks/layout_refused.h"

#include <patchwright/base/numbers.h>

#include <fmt/format.h>

#include <algorithm>

namespace patchwright::cage {

using base::at;

namespace {

// Of a side: nearer to its end the line goes by that vertex, so that no slivers are left.
constexpr double snap_share = 0.15, snap_share_of_end = 0.3;

class Drawing {
  public:
    Drawing(LinedMesh& lined, int from) : lined_(lined), path_{from} {}

    int draw(const TracedLine& traced, int line) {
        for (std::size_t i = 0; i < traced.points.size(); ++i) {
            const bool last = i + 1 == traced.points.size();
            go_to(vertex_at(traced.points[i], last && traced.end == LineEnd::Wall));
        }
        if (traced.end == LineEnd::Vertex && traced.end_vertex == path_.front())
            path_.push_back(traced.end_vertex);  // all around
        else if (traced.end == LineEnd::Vertex)
            go_to(traced.end_vertex);
        for (std::size_t i = 0; i + 1 < path_.size(); ++i) {
            if (is_side(path_[i], path_[i + 1])) continue;
            const geom::Vec3& p = lined_.mesh().point(path_[i]);
            throw LayoutRefused{
                fmt::format("a line of the field cannot be drawn near ({:.4g}, "
                            "{:.4g}, {:.4g})",
                            p.x(), p.y(), p.z())};
        }
        lined_.draw(path_, line);
        return path_.back();
    }

  private:
    [[nodiscard]] bool is_side(int a, int b) const {
        return lined_.mesh().sides(a, b).triangle[0] >= 0;
    }
    [[nodiscard]] bool is_wall(int a, int b) const {
        return lined_.is_line(a, b) || lined_.mesh().is_feature(a, b);
    }

    /// A vertex of the mesh at or near a point of a side.
    int vertex_at(const SidePoint& p, bool ends) {
        const double share = ends ? snap_share_of_end : snap_share;
        for (const auto& [v, way] : {std::pair{p.a, p.t}, {p.b, 1.0 - p.t}}) {
            if (way > share || v == path_.front()) continue;
            const bool free =
                !lined_.on_wall(v) && std::find(path_.begin(), path_.end(), v) == path_.end();
            if (v == path_.back() || free) return v;
            if (ends && is_side(path_.back(), v) && !is_wall(path_.back(), v)) return v;
        }
        if (!is_side(p.a, p.b)) {
            const geom::Vec3 where = lined_.point(p);
            throw LayoutRefused{
                fmt::format("a line of the field crosses itself near ({:.4g}, {:.4g}, {:.4g})",
                            where.x(), where.y(), where.z())};
        }
        return lined_.split(p);
    }

    /// What lies between two visits of a vertex is left out.
    void go_to(int v) {
        const auto known = std::find(path_.begin(), path_.end(), v);
        if (known == path_.end())
            path_.push_back(v);
        else
            path_.erase(known + 1, path_.end());
    }

    LinedMesh& lined_;
    std::vector<int> path_;
};

}  // namespace

int draw_line(LinedMesh& lined, int from, const TracedLine& traced, int line) {
    return Drawing(lined, from).draw(traced, line);
}

}  // namespace patchwright::cage
