#include "patch/layout.h"

#include "patch/fan.h"

#include <patchwright/mesh/regular.h>

#include <algorithm>
#include <deque>
#include <optional>

namespace patchwright::patch {

using mesh::CornerId;
using mesh::EdgeId;
using mesh::FaceId;
using mesh::Topology;
using mesh::VertexId;

namespace {

/// Whether a border goes straight on at the vertex: inside, four faces, nothing sharp.
enum class Passage : char { Straight, Wall };

class Tracer {
  public:
    explicit Tracer(const Topology& t)
        : t_(t),
          border_(std::size_t(t.edge_count()), 0),
          source_(std::size_t(t.corner_count()), 0),
          passage_(std::size_t(t.vertex_count()), Passage::Straight) {
        for (const EdgeId e : t.edges()) border_[e.index()] = is_sharp(t, e) ? 1 : 0;
        for (const VertexId v : t.vertices()) look_at(v);
        lay_connections();
        lay_others();
    }

    [[nodiscard]] bool is_border(CornerId c) const { return border_[t_.edge(c).index()] != 0; }

    /// Makes the whole line through a half-edge a border, both ways to the next one.
    void lay_line(CornerId c) {
        follow(c);
        if (const CornerId back = t_.twin(c); back.valid()) {
            if (const CornerId on = straight(back); on.valid()) {
                if (!is_border(on) && !is_crossed(t_.vertex(t_.next(back)), t_.edge(c))) follow(on);
            }
        }
    }

  private:
    void look_at(VertexId v) {
        const std::vector<Fan> fans = fans_around(t_, v);
        if (fans.size() > 1 || fans[0].kind != FanKind::Ring || fans[0].size() != 4) {
            passage_[v.index()] = Passage::Wall;
        }
        for (const Fan& fan : fans) {
            if (fan.is_regular()) continue;
            for (std::size_t k = fan.is_closed() ? 0 : 1; k < fan.corners.size(); ++k) {
                source_[fan.corners[k].index()] = 1;
                sources_.push_back(fan.corners[k]);
            }
        }
    }

    /// The half-edge that continues `c`; not valid at walls.
    [[nodiscard]] CornerId straight(CornerId c) const {
        const CornerId left = t_.next(c);
        if (passage_[t_.vertex(left).index()] == Passage::Wall) return CornerId{};
        return t_.next(t_.twin(left));
    }

    /// Whether a border other than `own` touches the vertex.
    [[nodiscard]] bool is_crossed(VertexId v, EdgeId own) const {
        CornerId c = t_.corner(v);
        const CornerId first = c;
        do {
            if (is_border(c) && t_.edge(c) != own) return true;
            c = t_.rotate(c);
        } while (c.valid() && c != first);
        return false;
    }

    void lay(CornerId c) { border_[t_.edge(c).index()] = 1; }

    struct Connection {
        int length;
        CornerId start;
    };

    void lay_connections() {
        std::vector<Connection> connections;
        for (const CornerId start : sources_) {
            int length = 1;
            CornerId c = start;
            for (CornerId on = straight(c); on.valid(); on = straight(c), ++length) c = on;
            const CornerId back = t_.twin(c);
            if (back.valid() && source_[back.index()] != 0 && start < back) {
                connections.push_back({length, start});
            }
        }
        std::sort(connections.begin(), connections.end(),
                  [](const Connection& a, const Connection& b) {
                      return std::pair(a.length, a.start) < std::pair(b.length, b.start);
                  });
        for (const Connection& connection : connections) {
            if (is_free(connection.start)) {
                for (CornerId c = connection.start; c.valid(); c = straight(c)) lay(c);
            }
        }
    }

    /// Whether no border touches the line between its ends.
    [[nodiscard]] bool is_free(CornerId start) const {
        if (is_border(start)) return false;
        CornerId c = start;
        for (CornerId on = straight(c); on.valid(); on = straight(c)) {
            if (is_crossed(t_.vertex(on), t_.edge(c))) return false;
            c = on;
        }
        return true;
    }

    /// All at the same speed, so that charts are of like size.
    void lay_others() {
        std::deque<CornerId> ends;
        for (const CornerId c : sources_) {
            if (!is_border(c)) ends.push_back(c);
        }
        while (!ends.empty()) {
            const CornerId c = ends.front();
            ends.pop_front();
            if (is_border(c)) continue;
            lay(c);
            const CornerId on = straight(c);
            if (on.valid() && !is_crossed(t_.vertex(on), t_.edge(c))) ends.push_back(on);
        }
    }

    void follow(CornerId c) {
        while (c.valid() && !is_border(c)) {
            lay(c);
            const CornerId on = straight(c);
            if (!on.valid() || is_crossed(t_.vertex(on), t_.edge(c))) return;
            c = on;
        }
    }

    const Topology& t_;
    std::vector<char> border_;
    std::vector<char> source_;
    std::vector<Passage> passage_;
    std::vector<CornerId> sources_;
};

/// The rectangle around a cell.
template <class IsBorder>
Chart collect(const Topology& t, const IsBorder& is_border, CornerId seed) {
    CornerId origin = seed;
    while (!is_border(t.previous(origin))) origin = left_of(t, origin);
    while (!is_border(origin)) origin = below(t, origin);
    Chart chart;
    for (CornerId column = origin;; column = right_of(t, column)) {
        ++chart.columns;
        for (CornerId c = column;; c = above(t, c)) {
            chart.cells.push_back(c);
            if (is_border(t.next(t.next(c)))) break;
        }
        if (is_border(t.next(column))) break;
    }
    chart.rows = static_cast<int>(chart.cells.size()) / chart.columns;
    return chart;
}

/// Gathers the rectangles between borders.
class ChartCollector {
  public:
    explicit ChartCollector(const Topology& t)
        : t_(t), tracer_(t), done_(std::size_t(t.face_count()), 0) {}

    std::vector<Chart> run() {
        std::vector<Chart> charts;
        for (const FaceId f : t_.faces()) {
            if (done_[f.index()] != 0) continue;
            const CornerId seed = t_.corners(f)[0];
            cut_ring(seed, t_.previous(seed), mesh::left_of);
            cut_ring(seed, seed, mesh::below);
            charts.push_back(collect(
                t_, [&](CornerId c) { return tracer_.is_border(c); }, seed));
            for (const CornerId c : charts.back().cells) done_[t_.face(c).index()] = 1;
        }
        return charts;
    }

  private:
    using Step = CornerId (*)(const Topology&, CornerId);

    /// Cuts a ring of cells before the seed and halfway around.
    /// @param leading  the seed's half-edge that `step` crosses
    void cut_ring(CornerId seed, CornerId leading, Step step) {
        const auto crossed = [&](CornerId cell) {
            return leading == seed ? cell : t_.previous(cell);
        };
        int around = 0;
        CornerId c = seed;
        do {
            if (tracer_.is_border(crossed(c))) return;
            c = step(t_, c);
            ++around;
        } while (c != seed);
        for (int k = 0; k < around / 2; ++k) c = step(t_, c);
        tracer_.lay_line(crossed(seed));
        tracer_.lay_line(crossed(c));
    }

    const Topology& t_;
    Tracer tracer_;
    std::vector<char> done_;
};

/// Before and from the column or row `at`.
std::pair<Chart, Chart> cut(const Chart& chart, bool by_columns, int at) {
    Chart first, second;
    const int columns = by_columns ? at : chart.columns;
    const int rows = by_columns ? chart.rows : at;
    first.columns = columns;
    first.rows = rows;
    second.columns = by_columns ? chart.columns - columns : columns;
    second.rows = by_columns ? rows : chart.rows - rows;
    for (int i = 0; i < chart.columns; ++i) {
        for (int j = 0; j < chart.rows; ++j) {
            (i < columns && j < rows ? first : second).cells.push_back(chart.cell(i, j));
        }
    }
    return {first, second};
}

/// Halves charts until none uses an edge of its border twice.
void separate(const Topology& t, std::vector<Chart>& charts) {
    std::vector<char> on_side(std::size_t(t.edge_count()), 0);  // 1 + side of the chart at hand
    for (std::size_t k = 0; k < charts.size();) {
        std::vector<EdgeId> seen;
        std::optional<bool> by_columns;
        for (int side = 0; side < 4; ++side) {
            for (const CornerId c : charts[k].side(t, side)) {
                char& first = on_side[t.edge(c).index()];
                if (first == 0) {
                    first = char(1 + side);
                    seen.push_back(t.edge(c));
                } else if (!by_columns) {
                    // A strip that winds round and borders on itself has nothing to halve across.
                    const bool opposite = first - 1 + 2 == side;
                    const Chart& chart = charts[k];
                    by_columns = !opposite   ? chart.columns >= chart.rows
                                 : side == 3 ? chart.columns > 1
                                             : chart.rows == 1;
                }
            }
        }
        for (const EdgeId e : seen) on_side[e.index()] = 0;
        if (!by_columns) {
            ++k;
            continue;
        }
        const int half = (*by_columns ? charts[k].columns : charts[k].rows) / 2;
        auto [first, second] = cut(charts[k], *by_columns, half);
        charts[k] = std::move(first);
        charts.push_back(std::move(second));
    }
}

/// Edges of a chart's sides together. What programs repair and check when they read a face takes
/// time in proportion to the square of their number.
constexpr std::size_t most_edges = 64;

/// Cuts charts whose sides have more edges, where a corner of another chart is.
class EdgeLimiter {
  public:
    EdgeLimiter(const Topology& t, std::vector<Chart>& charts)
        : t_(t), charts_(charts), is_end_(std::size_t(t.vertex_count()), 0) {
        for (const Chart& chart : charts) mark(chart);
    }

    void run() {
        bool is_changed = true;  // cuts give neighbours more edges
        while (is_changed) {
            is_changed = false;
            for (std::size_t k = 0; k < charts_.size(); ++k) is_changed |= limit(k);
        }
    }

  private:
    void mark(const Chart& chart) {
        for (int side = 0; side < 4; ++side)
            is_end_[t_.vertex(chart.side(t_, side).front()).index()] = 1;
    }

    /// Places along the side, in faces.
    [[nodiscard]] std::vector<int> inner_ends(const Chart& chart, int side) const {
        const std::vector<CornerId> half_edges = chart.side(t_, side);
        std::vector<int> ends;
        for (std::size_t k = 1; k < half_edges.size(); ++k)
            if (is_end_[t_.vertex(half_edges[k]).index()] != 0) ends.push_back(int(k));
        return ends;
    }

    bool limit(std::size_t k) {
        int fullest = 0;
        std::vector<int> most;
        std::size_t edges = 0;
        for (int side = 0; side < 4; ++side) {
            std::vector<int> ends = inner_ends(charts_[k], side);
            edges += ends.size() + 1;
            if (ends.size() <= most.size()) continue;
            fullest = side;
            most = std::move(ends);
        }
        if (edges <= most_edges) return false;
        const bool by_columns = fullest % 2 == 0;
        const int length = by_columns ? charts_[k].columns : charts_[k].rows;
        const int middle = most[most.size() / 2];
        auto [first, second] = cut(charts_[k], by_columns, fullest < 2 ? middle : length - middle);
        mark(second);
        mark(first);
        charts_[k] = std::move(first);
        charts_.push_back(std::move(second));
        return true;
    }

    const Topology& t_;
    std::vector<Chart>& charts_;
    std::vector<char> is_end_;  ///< corners of charts, by vertex
};

}  // namespace

std::vector<CornerId> Chart::side(const Topology& t, int side) const {
    std::vector<CornerId> edges;
    const int length = side % 2 == 0 ? columns : rows;
    for (int k = 0; k < length; ++k) {
        switch (side) {
            case 0: edges.push_back(cell(k, 0)); break;
            case 1: edges.push_back(t.next(cell(columns - 1, k))); break;
            case 2: edges.push_back(t.next(t.next(cell(columns - 1 - k, rows - 1)))); break;
            default: edges.push_back(t.previous(cell(0, rows - 1 - k))); break;
        }
    }
    return edges;
}

std::vector<Chart> rectangles(const Topology& t, const std::vector<char>& is_border) {
    std::vector<char> done(std::size_t(t.face_count()), 0);
    std::vector<Chart> charts;
    for (const FaceId f : t.faces()) {
        if (done[f.index()] != 0) continue;
        charts.push_back(collect(
            t, [&](CornerId c) { return is_border[t.edge(c).index()] != 0; }, t.corners(f)[0]));
        for (const CornerId c : charts.back().cells) done[t.face(c).index()] = 1;
    }
    return charts;
}

CornerId straight_on(const Topology& t, CornerId c) {
    const VertexId v = t.vertex(t.next(c));
    if (t.face_valence(v) != (t.is_boundary(v) ? 2 : 4)) return CornerId{};
    const CornerId across = t.twin(t.next(c));
    if (across.valid()) return t.next(across);
    return CornerId{};
}

std::vector<Chart> cover(const Topology& t, Covering covering) {
    std::vector<Chart> charts;
    if (covering == Covering::Faces) {
        for (const FaceId f : t.faces()) charts.push_back({1, 1, {t.corners(f)[0]}});
        return charts;
    }
    charts = ChartCollector(t).run();
    separate(t, charts);
    EdgeLimiter(t, charts).run();
    return charts;
}

}  // namespace patchwright::patch
