#include <patchwright/base/parallel.h>
#include <patchwright/subd/limit_operator.h>

#include <algorithm>
#include <map>
#include <tuple>

namespace patchwright::subd {

namespace {

// Enough for two cores several times over, few enough that the partial sums stay cheap.
constexpr std::size_t max_chunks = 16;
constexpr std::size_t min_sites_a_chunk = 64;

}  // namespace

LimitOperator::LimitOperator(const mesh::Topology& topology, std::vector<ParameterSet> sets,
                             std::span<const Site> sites)
    : columns_(topology.vertex_count()) {
    RingTable table;
    std::map<std::tuple<const RingKind*, int, int>, std::int32_t> known;
    site_rows_.push_back(0);
    slot_begin_.push_back(0);
    for (const Site& site : sites) {
        const Ring ring = table.ring(topology, site.face);
        const auto [entry, added] = known.try_emplace({ring.kind, site.sector, site.set},
                                                      static_cast<std::int32_t>(templates_.size()));
        if (added) {
            const ParameterSet& set = sets[std::size_t(site.set)];
            Template t;
            for (Table* part : {&t.position, &t.du, &t.dv}) {
                part->resize(Eigen::Index(set.size()), ring.kind->slots());
            }
            for (std::size_t k = 0; k < set.size(); ++k) {
                const RingMask mask = ring_mask(*ring.kind, set[k].x(), set[k].y(), site.sector, 1);
                t.position.row(Eigen::Index(k)) = mask.rows.row(0);
                t.du.row(Eigen::Index(k)) = mask.rows.row(1);
                t.dv.row(Eigen::Index(k)) = mask.rows.row(2);
            }
            templates_.push_back(std::move(t));
        }
        site_template_.push_back(entry->second);
        site_rows_.push_back(site_rows_.back() +
                             static_cast<std::int32_t>(sets[std::size_t(site.set)].size()));
        slot_vertices_.insert(slot_vertices_.end(), ring.vertices.begin(), ring.vertices.end());
        slot_begin_.push_back(static_cast<std::int64_t>(slot_vertices_.size()));
    }
    rows_ = site_rows_.back();
    build_chunks();
}

void LimitOperator::build_chunks() {
    const std::size_t sites = site_template_.size();
    const std::size_t step = std::max(min_sites_a_chunk, (sites + max_chunks - 1) / max_chunks);
    for (std::size_t begin = 0; begin < sites; begin += step) {
        const std::size_t end = std::min(sites, begin + step);
        const auto [low, high] = std::minmax_element(slot_vertices_.begin() + slot_begin_[begin],
                                                     slot_vertices_.begin() + slot_begin_[end]);
        chunks_.push_back({begin, end, *low, *high});
    }
}

void LimitOperator::gather(std::size_t site, const geom::Points& x, geom::Points& local) const {
    const auto begin = slot_begin_[site];
    local.resize(Eigen::Index(slot_begin_[site + 1] - begin), 3);
    for (Eigen::Index k = 0; k < local.rows(); ++k) {
        local.row(k) = x.row(slot_vertices_[std::size_t(begin + k)]);
    }
}

void LimitOperator::apply(const geom::Points& x, geom::Points& y) const {
    y.resize(rows_, 3);
    base::parallel_for(chunks_.size(), 1, [&](std::size_t first, std::size_t last) {
        geom::Points local;
        for (std::size_t c = first; c < last; ++c) {
            for (std::size_t site = chunks_[c].begin; site < chunks_[c].end; ++site) {
                gather(site, x, local);
                const Table& table = templates_[std::size_t(site_template_[site])].position;
                y.middleRows(site_rows_[site], table.rows()).noalias() = table.lazyProduct(local);
            }
        }
    });
}

void LimitOperator::apply_transposed(const geom::Points& y, geom::Points& x) const {
    std::vector<geom::Points> partial(chunks_.size());
    base::parallel_for(chunks_.size(), 1, [&](std::size_t first, std::size_t last) {
        geom::Points local;
        for (std::size_t c = first; c < last; ++c) {
            const Chunk& chunk = chunks_[c];
            partial[c].setZero(chunk.last_vertex - chunk.first_vertex + 1, 3);
            for (std::size_t site = chunk.begin; site < chunk.end; ++site) {
                const Table& table = templates_[std::size_t(site_template_[site])].position;
                local.noalias() =
                    table.transpose().lazyProduct(y.middleRows(site_rows_[site], table.rows()));
                const auto begin = slot_begin_[site];
                for (Eigen::Index k = 0; k < local.rows(); ++k) {
                    partial[c].row(slot_vertices_[std::size_t(begin + k)] - chunk.first_vertex) +=
                        local.row(k);
                }
            }
        }
    });
    // Added in chunk order, whichever thread made the parts: reports must match between runs.
    x.setZero(columns_, 3);
    base::parallel_for(std::size_t(columns_), 8192, [&](std::size_t first, std::size_t last) {
        for (std::size_t c = 0; c < chunks_.size(); ++c) {
            const auto low = std::max<std::int64_t>(std::int64_t(first), chunks_[c].first_vertex);
            const auto high =
                std::min<std::int64_t>(std::int64_t(last), chunks_[c].last_vertex + 1);
            if (low >= high) continue;
            x.middleRows(low, high - low) +=
                partial[c].middleRows(low - chunks_[c].first_vertex, high - low);
        }
    });
}

geom::Points LimitOperator::normals(const geom::Points& x) const {
    geom::Points result(rows_, 3);
    base::parallel_for(chunks_.size(), 1, [&](std::size_t first, std::size_t last) {
        geom::Points local;
        for (std::size_t c = first; c < last; ++c) {
            for (std::size_t site = chunks_[c].begin; site < chunks_[c].end; ++site) {
                gather(site, x, local);
                const Template& t = templates_[std::size_t(site_template_[site])];
                for (Eigen::Index k = 0; k < t.du.rows(); ++k) {
                    const Eigen::RowVector3d du = t.du.row(k) * local;
                    const Eigen::RowVector3d dv = t.dv.row(k) * local;
                    result.row(site_rows_[site] + k) << du.y() * dv.z() - du.z() * dv.y(),
                        du.z() * dv.x() - du.x() * dv.z(), du.x() * dv.y() - du.y() * dv.x();
                }
            }
        }
    });
    return result;
}

}  // namespace patchwright::subd
