#include "mesh/raw_obj.h"

#include <patchwright/base/error.h>
#include <patchwright/mesh/polylines.h>

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace patchwright::mesh {

namespace {

using Element = RawObj::LineElement;

Polyline polyline_of(const Element& element, const geom::Points& points) {
    const std::vector<int>& v = element.vertices;
    Polyline result{.closed = v.size() > 3 && v.front() == v.back(), .line = element.line};
    const std::size_t count = v.size() - (result.closed ? 1 : 0);
    result.points.resize(Eigen::Index(count), 3);
    for (std::size_t i = 0; i < count; ++i) result.points.row(Eigen::Index(i)) = points.row(v[i]);
    return result;
}

/// Joins elements of one edge each.
class EdgeChains {
  public:
    explicit EdgeChains(const std::vector<Element>& elements)
        : elements_(elements), taken_(elements.size(), false) {
        for (std::size_t e = 0; e < elements.size(); ++e)
            for (const int v : elements[e].vertices) uses_[v].push_back(e);
    }

    /// One that begins with element e, which is taken as it is where it has more edges; nothing
    /// where it has been taken.
    std::vector<int> take(std::size_t e) {
        if (taken_[e]) return {};
        taken_[e] = true;
        std::vector<int> chain = elements_[e].vertices;
        if (chain.size() != 2) return chain;
        extend(chain);
        if (chain.front() == chain.back()) return chain;
        std::reverse(chain.begin(), chain.end());
        extend(chain);
        std::reverse(chain.begin(), chain.end());
        return chain;
    }

  private:
    void extend(std::vector<int>& chain) {
        for (;;) {
            const std::vector<std::size_t>& uses = uses_.at(chain.back());
            if (uses.size() != 2) return;
            const std::size_t next = taken_[uses[0]] ? uses[1] : uses[0];
            const std::vector<int>& edge = elements_[next].vertices;
            if (taken_[next] || edge.size() != 2) return;
            taken_[next] = true;
            chain.push_back(edge[0] == chain.back() ? edge[1] : edge[0]);
        }
    }

    const std::vector<Element>& elements_;
    std::vector<bool> taken_;
    std::map<int, std::vector<std::size_t>> uses_;
};

}  // namespace

std::vector<Polyline> read_polylines(const std::filesystem::path& path) {
    std::ifstream stream = open_mesh_file(path);
    const RawObj raw = read_raw_obj(stream, path.string());
    if (!raw.input.face_sizes.empty()) return {};
    if (raw.lines.empty()) throw base::InputError(path.string() + ": holds no faces and no lines");
    for (const Element& element : raw.lines) {
        const bool repeats = std::adjacent_find(element.vertices.begin(), element.vertices.end()) !=
                             element.vertices.end();
        if (element.vertices.size() < 2 || repeats)
            throw base::InputError(
                fmt::format("{}: line {}: a polyline {}", path.string(), element.line,
                            repeats ? "names a vertex twice in a row" : "needs two vertices"));
    }
    EdgeChains chains(raw.lines);
    std::vector<Polyline> polylines;
    for (std::size_t e = 0; e < raw.lines.size(); ++e) {
        std::vector<int> vertices = chains.take(e);
        if (!vertices.empty())
            polylines.push_back(polyline_of({std::move(vertices), raw.lines[e].line}, raw.points));
    }
    return polylines;
}

std::string polylines_text(const std::vector<Polyline>& polylines) {
    fmt::memory_buffer out;
    const auto print = [&]<class... Args>(fmt::format_string<Args...> format, Args&&... args) {
        fmt::format_to(std::back_inserter(out), format, std::forward<Args>(args)...);
    };
    for (const auto& [points, closed, line] : polylines)
        for (Eigen::Index i = 0; i < points.rows(); ++i)
            print("v {} {} {}\n", points(i, 0), points(i, 1), points(i, 2));
    Eigen::Index first = 1;
    for (const auto& [points, closed, line] : polylines) {
        print("l");
        for (Eigen::Index i = 0; i < points.rows(); ++i) print(" {}", first + i);
        if (closed) print(" {}", first);
        print("\n");
        first += points.rows();
    }
    return fmt::to_string(out);
}

PolylineSummary summarise(const std::vector<Polyline>& polylines) {
    PolylineSummary summary{.count = int(polylines.size())};
    for (const Polyline& polyline : polylines) {
        summary.closed += polyline.closed ? 1 : 0;
        summary.points += int(polyline.points.rows());
    }
    return summary;
}

}  // namespace patchwright::mesh
