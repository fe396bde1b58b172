#include "subd/ring_extractor.h"
#include "subd/template_kernels.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/subd/limit_operator.h>

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace patchwright::subd {

namespace {

// Enough chunks to keep a few cores evenly busy, few enough that their borders stay small.
constexpr std::size_t max_chunks = 32;
constexpr std::size_t min_sites_a_chunk = 256;

std::size_t chunk_size(std::size_t sites) {
    return std::max(min_sites_a_chunk, (sites + max_chunks - 1) / max_chunks);
}

void check_sites(const mesh::Topology& topology, const std::vector<ParameterSet>& sets,
                 std::span<const Site> sites) {
    std::int64_t rows = 0;
    for (const Site& site : sites) {
        const bool on_mesh = site.face.valid() && site.face.value < topology.face_count();
        const int sectors = !on_mesh                        ? 0
                            : topology.size(site.face) == 4 ? 1
                                                            : topology.size(site.face);
        if (site.sector < 0 || site.sector >= sectors || site.set < 0 ||
            site.set >= static_cast<int>(sets.size())) {
            throw base::InvalidArgument(
                fmt::format("site (face {}, sector {}, set {}) does not exist", site.face.value,
                            site.sector, site.set));
        }
        rows += static_cast<std::int64_t>(sets[std::size_t(site.set)].size());
    }
    if (rows > std::numeric_limits<std::int32_t>::max()) {
        throw base::InvalidArgument(fmt::format("{} samples are more than fit an operator", rows));
    }
}

/// Finds the template of a site by its kind, sector and set, making it when it is new.
class TemplateIndex {
  public:
    template <class Make>
    std::int32_t find(const RingKind& kind, const Site& site, const Make& make) {
        if (&kind == last_kind_ && site.sector == last_sector_ && site.set == last_set_)
            return last_;
        const auto number = std::size_t(kind.number());
        if (known_.size() <= number) known_.resize(number + 1);
        auto& entries = known_[number];
        auto entry = std::find_if(entries.begin(), entries.end(), [&](const Entry& e) {
            return e.sector == site.sector && e.set == site.set;
        });
        if (entry == entries.end()) {
            entry = entries.insert(entries.end(), {site.sector, site.set, make()});
        }
        last_kind_ = &kind;
        last_sector_ = site.sector;
        last_set_ = site.set;
        return last_ = entry->id;
    }

  private:
    struct Entry {
        int sector, set;
        std::int32_t id;
    };
    std::vector<std::vector<Entry>> known_;  // by number of kind
    const RingKind* last_kind_ = nullptr;
    int last_sector_ = 0, last_set_ = 0;
    std::int32_t last_ = 0;
};

}  // namespace

struct LimitOperator::Template {
    MaskTable position, du, dv;

    Template(const RingKind& kind, const ParameterSet& set, int sector, int order) {
        const auto samples = static_cast<int>(set.size());
        MaskTable* const tables[] = {&position, &du, &dv};
        const int count = order == 0 ? 1 : 3;
        for (int t = 0; t < count; ++t) *tables[t] = MaskTable(samples, kind.slots());
        for (int k = 0; k < samples; ++k) {
            const Eigen::Vector2d& at = set[std::size_t(k)];
            const RingMask mask = ring_mask(kind, at.x(), at.y(), sector, order);
            for (int t = 0; t < count; ++t) {
                for (int slot = 0; slot < kind.slots(); ++slot) {
                    tables[t]->set(k, slot, mask.rows(t, slot));
                }
            }
        }
    }
    [[nodiscard]] std::size_t bytes() const { return position.bytes() + du.bytes() + dv.bytes(); }
};

LimitOperator::LimitOperator(const mesh::Topology& topology, const std::vector<ParameterSet>& sets,
                             std::span<const Site> sites, int order)
    : columns_(topology.vertex_count()) {
    check_sites(topology, sets, sites);
    const std::vector<char> plain = plain_vertices(topology);
    RingTable table;
    RingExtractor ring;
    TemplateIndex index;
    site_template_.resize(sites.size());
    site_rows_.resize(sites.size() + 1);
    slot_vertices_.reserve(16 * sites.size());
    std::int32_t row = 0;
    const std::size_t step = chunk_size(sites.size());
    for (std::size_t i = 0; i < sites.size(); ++i) {
        if (i % step == 0) {
            chunks_.push_back({i, std::min(sites.size(), i + step), slot_vertices_.size(), 0, 0});
        }
        const Site& site = sites[i];
        const RingKind& kind = extract_ring(table, ring, topology, plain, site.face);
        const ParameterSet& set = sets[std::size_t(site.set)];
        site_template_[i] = index.find(kind, site, [&] {
            templates_.emplace_back(kind, set, site.sector, order);
            return static_cast<std::int32_t>(templates_.size()) - 1;
        });
        const auto vertices = ring.vertices();
        slot_vertices_.insert(slot_vertices_.end(), vertices.begin(), vertices.end());
        row += static_cast<std::int32_t>(set.size());
        site_rows_[i + 1] = row;
    }
    find_shared_sites();
}

LimitOperator::~LimitOperator() = default;
LimitOperator::LimitOperator(LimitOperator&&) noexcept = default;
LimitOperator& LimitOperator::operator=(LimitOperator&&) noexcept = default;

void LimitOperator::find_shared_sites() {
    constexpr std::uint8_t nobody = 255, several = 254;
    static_assert(max_chunks < several);
    const auto slots_of = [&](std::size_t site) {
        return std::size_t(templates_[std::size_t(site_template_[site])].position.slots());
    };
    std::vector<std::uint8_t> owner(std::size_t(columns_), nobody);
    for (std::size_t c = 0; c < chunks_.size(); ++c) {
        const std::size_t end =
            c + 1 < chunks_.size() ? chunks_[c + 1].slot_begin : slot_vertices_.size();
        for (std::size_t k = chunks_[c].slot_begin; k < end; ++k) {
            std::uint8_t& o = owner[std::size_t(slot_vertices_[k])];
            if (o != c) o = o == nobody ? static_cast<std::uint8_t>(c) : several;
        }
    }
    if (chunks_.size() < 2) return;
    std::vector<std::int32_t> partial_row(std::size_t(columns_), -1);
    std::vector<std::pair<std::int32_t, std::int32_t>> reduced;  // vertex, row of the partial sums
    std::int32_t rows = 0;
    for (Chunk& chunk : chunks_) {
        chunk.shared_begin = shared_sites_.size();
        chunk.shared_slot_begin = shared_slots_.size();
        chunk.partial_begin = rows;
        std::size_t slot = chunk.slot_begin;
        for (std::size_t site = chunk.begin; site < chunk.end; ++site) {
            const std::size_t end = slot + slots_of(site);
            bool shared = false;
            for (std::size_t k = slot; k < end; ++k) {
                shared = shared || owner[std::size_t(slot_vertices_[k])] == several;
            }
            if (shared) shared_sites_.push_back(static_cast<std::int32_t>(site));
            for (; shared && slot < end; ++slot) {
                std::int32_t& known = partial_row[std::size_t(slot_vertices_[slot])];
                if (known < chunk.partial_begin) {
                    known = rows++;
                    reduced.emplace_back(slot_vertices_[slot], known);
                }
                shared_slots_.push_back(known);
            }
            slot = end;
        }
        chunk.partial_end = rows;
    }
    std::sort(reduced.begin(), reduced.end());  // rows of one vertex in the order of chunks
    for (const auto& [vertex, partial] : reduced) {
        if (reduced_vertex_.empty() || reduced_vertex_.back() != vertex) {
            reduced_vertex_.push_back(vertex);
            reduced_begin_.push_back(static_cast<std::int32_t>(reduced_partial_.size()));
        }
        reduced_partial_.push_back(partial);
    }
    reduced_begin_.push_back(static_cast<std::int32_t>(reduced_partial_.size()));
}

template <class Visit>
void LimitOperator::for_runs(const Chunk& chunk, const Visit& visit) const {
    std::size_t slot = chunk.slot_begin;
    for (std::size_t site = chunk.begin; site < chunk.end;) {
        const std::int32_t id = site_template_[site];
        std::size_t end = site + 1;
        while (end < chunk.end && site_template_[end] == id) ++end;
        const Template& t = templates_[std::size_t(id)];
        visit(t, site, end, slot);
        slot += (end - site) * std::size_t(t.position.slots());
        site = end;
    }
}

void LimitOperator::apply(const geom::Points& x, geom::Points& y) const {
    y.resize(rows(), 3);
    base::parallel_for(chunks_.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t c = first; c < last; ++c) {
            for_runs(chunks_[c],
                     [&](const Template& t, std::size_t begin, std::size_t end, std::size_t slot) {
                         t.position.apply(static_cast<int>(end - begin), &slot_vertices_[slot],
                                          x.data(), y.row(site_rows_[begin]).data());
                     });
        }
    });
}

void LimitOperator::apply_transposed(const geom::Points& y, geom::Points& x) const {
    geom::Points partial(chunks_.empty() ? 0 : chunks_.back().partial_end, 3);
    x.resize(columns_, 3);
    base::parallel_for(std::size_t(columns_), 16384, [&](std::size_t first, std::size_t last) {
        x.middleRows(Eigen::Index(first), Eigen::Index(last - first)).setZero();
    });
    base::parallel_for(chunks_.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t c = first; c < last; ++c) {
            const Chunk& chunk = chunks_[c];
            partial.middleRows(chunk.partial_begin, chunk.partial_end - chunk.partial_begin)
                .setZero();
            std::size_t shared = chunk.shared_begin;
            const std::size_t shared_end =
                c + 1 < chunks_.size() ? chunks_[c + 1].shared_begin : shared_sites_.size();
            std::size_t shared_slot = chunk.shared_slot_begin;
            for_runs(chunk, [&](const Template& t, std::size_t begin, std::size_t end,
                                std::size_t slot) {
                const auto slots = std::size_t(t.position.slots());
                while (begin < end) {
                    const bool any =
                        shared < shared_end && std::size_t(shared_sites_[shared]) < end;
                    const std::size_t stop = any ? std::size_t(shared_sites_[shared]) : end;
                    if (stop > begin) {
                        t.position.add_transposed(static_cast<int>(stop - begin),
                                                  &slot_vertices_[slot],
                                                  y.row(site_rows_[begin]).data(), x.data());
                        slot += (stop - begin) * slots;
                    }
                    begin = stop;
                    if (any) {
                        t.position.add_transposed(1, &shared_slots_[shared_slot],
                                                  y.row(site_rows_[begin]).data(), partial.data());
                        ++shared;
                        shared_slot += slots;
                        slot += slots;
                        ++begin;
                    }
                }
            });
        }
    });
    reduce_partials(partial, x);
}

void LimitOperator::reduce_partials(const geom::Points& partial, geom::Points& x) const {
    base::parallel_for(reduced_vertex_.size(), 4096, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            for (auto k = reduced_begin_[i]; k < reduced_begin_[i + 1]; ++k) {
                x.row(reduced_vertex_[i]) += partial.row(reduced_partial_[std::size_t(k)]);
            }
        }
    });
}

geom::Points LimitOperator::normals(const geom::Points& x) const {
    geom::Points du(rows(), 3), dv(rows(), 3);
    base::parallel_for(chunks_.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t c = first; c < last; ++c) {
            for_runs(chunks_[c], [&](const Template& t, std::size_t begin, std::size_t end,
                                     std::size_t slot) {
                if (t.du.samples() != t.position.samples()) {
                    throw base::InvalidArgument("normals: the operator was made with order 0");
                }
                const auto sites = static_cast<int>(end - begin);
                const auto row = site_rows_[begin];
                t.du.apply(sites, &slot_vertices_[slot], x.data(), du.row(row).data());
                t.dv.apply(sites, &slot_vertices_[slot], x.data(), dv.row(row).data());
                for (auto i = row; i < site_rows_[end]; ++i) {
                    const geom::Vec3 a = du.row(i), b = dv.row(i);
                    du.row(i) << a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(),
                        a.x() * b.y() - a.y() * b.x();
                }
            });
        }
    });
    return du;
}

int LimitOperator::template_count() const { return static_cast<int>(templates_.size()); }

std::size_t LimitOperator::site_bytes() const {
    const auto bytes = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
    return bytes(site_template_) + bytes(site_rows_) + bytes(slot_vertices_) + bytes(chunks_) +
           bytes(shared_sites_) + bytes(shared_slots_) + bytes(reduced_vertex_) +
           bytes(reduced_begin_) + bytes(reduced_partial_);
}

std::size_t LimitOperator::template_bytes() const {
    std::size_t sum = 0;
    for (const Template& t : templates_) sum += t.bytes();
    return sum;
}

}  // namespace patchwright::subd
