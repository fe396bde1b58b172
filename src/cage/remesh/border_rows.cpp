#include "cage/remesh/border_rows.h"

#include <algorithm>
#include <map>
#include <utility>

namespace patchwright::cage {

namespace {

// Share of the way from the border to the middle of the polygons there: those keep most of it.
constexpr double width = 0.4;

class BorderRow {
  public:
    BorderRow(PolygonMesh& polygons, std::vector<int> region)
        : polygons_(polygons), region_(std::move(region)) {
        std::sort(region_.begin(), region_.end());
    }

    /// A triangle becomes three patches, a quad one; merged, two triangles are a quad.
    [[nodiscard]] bool is_worth_it() const {
        int triangles = 0, border = 0;
        for (const int polygon : region_) {
            triangles += polygons_.corners(polygon).size() == 3 ? 1 : 0;
            for_each_border_edge(polygon, [&](int, int) { ++border; });
        }
        return 5 * (triangles / 2) > border;
    }

    /// Does nothing where a vertex would have too few faces, or where the border of the region is
    /// in part an open end of the model, along which a row would have no end.
    bool add() {
        if (!is_closed()) return false;
        std::vector<std::pair<int, std::vector<int>>> before;
        std::vector<std::vector<int>> row;
        std::vector<int> vertices;
        std::map<int, int> flaws;
        for (const int polygon : region_) {
            before.emplace_back(polygon, polygons_.corners(polygon));
            for_each_border_edge(polygon, [&](int a, int) { vertices.push_back(a); });
        }
        for (const int v : vertices) {
            add_inner_vertices(v);
            flaws[v] = polygons_.flaws(v);
        }
        for (const auto& [polygon, corners] : before)
            for_each_border_edge(polygon, [&, p = polygon](int a, int b) {
                row.push_back({a, b, inner_.at({b, p}), inner_.at({a, p})});
            });
        for (auto [polygon, corners] : before) {
            for (int& v : corners) {
                const auto inner = inner_.find({v, polygon});
                if (inner != inner_.end()) v = inner->second;
            }
            polygons_.replace(polygon, std::move(corners));
        }
        std::vector<int> made;
        for (std::vector<int>& quad : row)
            made.push_back(polygons_.add(std::move(quad), region_.front()));
        const bool holds = std::all_of(flaws.begin(), flaws.end(), [&](const auto& one) {
            return polygons_.flaws(one.first) <= one.second;
        });
        if (holds) return true;
        for (const int polygon : made) polygons_.replace(polygon, {});
        for (auto& [polygon, corners] : before) polygons_.replace(polygon, std::move(corners));
        return false;
    }

  private:
    [[nodiscard]] bool is_closed() const {
        std::map<int, int> begins_less_ends;
        for (const int polygon : region_)
            for_each_border_edge(polygon, [&](int a, int b) {
                ++begins_less_ends[a];
                --begins_less_ends[b];
            });
        return std::all_of(begins_less_ends.begin(), begins_less_ends.end(),
                           [](const auto& vertex) { return vertex.second == 0; });
    }

    template <class Visit>
    void for_each_border_edge(int polygon, const Visit& visit) const {
        const auto& c = polygons_.corners(polygon);
        for (std::size_t k = 0; k < c.size(); ++k) {
            const int a = c[k], b = c[(k + 1) % c.size()];
            if (polygons_.is_feature(a, b)) visit(a, b);
        }
    }

    /// One for each sector of the region at a vertex of its border.
    void add_inner_vertices(int v) {
        for (const std::vector<int>& sector : polygons_.sectors(v)) {
            if (!std::binary_search(region_.begin(), region_.end(), sector.front())) continue;
            if (inner_.count({v, sector.front()}) > 0) continue;
            geom::Vec3 middle = geom::Vec3::Zero();
            double count = 0.0;
            for (const int polygon : sector)
                for (const int w : polygons_.corners(polygon)) {
                    middle += polygons_.mesh().point(w);
                    ++count;
                }
            const geom::Vec3 here = polygons_.mesh().point(v);
            const int made = polygons_.add_vertex(here + width * (middle / count - here));
            for (const int polygon : sector) inner_[{v, polygon}] = made;
        }
    }

    PolygonMesh& polygons_;
    std::vector<int> region_;
    std::map<std::pair<int, int>, int> inner_;  ///< by vertex of the border and polygon
};

}  // namespace

bool add_border_rows(PolygonMesh& polygons) {
    const std::vector<int> region = polygons.regions();
    std::map<int, std::vector<int>> members;
    for (int i = 0; i < polygons.count(); ++i)
        if (region[std::size_t(i)] >= 0) members[region[std::size_t(i)]].push_back(i);
    bool any = false;
    for (auto& [number, list] : members) {
        BorderRow row(polygons, std::move(list));
        if (row.is_worth_it() && row.add()) any = true;
    }
    return any;
}

}  // namespace patchwright::cage
