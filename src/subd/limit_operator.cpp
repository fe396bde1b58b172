#include "subd/ring_extractor.h"
#include "subd/solver_products.h"
#include "subd/template_kernels.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/subd/limit_operator.h>

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace patchwright::subd {

namespace {

// Enough chunks to keep a few cores evenly busy, and as many as there are bits in a mask.
constexpr std::size_t max_chunks = 64;
constexpr std::size_t min_sites_a_chunk = 64;
// Equal sites that are handled together: few enough that their samples stay in the cache for what
// is done to them next.
constexpr std::size_t longest_run = 32;

std::size_t chunk_size(std::size_t sites) {
    return std::max(min_sites_a_chunk, (sites + max_chunks - 1) / max_chunks);
}

void check_sites(const mesh::Topology& topology, const std::vector<ParameterSet>& sets,
                 std::span<const Site> sites, int rows_a_sample) {
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
        rows += rows_a_sample * static_cast<std::int64_t>(sets[std::size_t(site.set)].size());
    }
    if (rows > std::numeric_limits<std::int32_t>::max()) {
        throw base::InvalidArgument(fmt::format("{} samples are more than fit an operator", rows));
    }
}

void set_zero(geom::Points& x, Eigen::Index rows) {
    x.resize(rows, 3);
    base::parallel_for(std::size_t(rows), 16384, [&](std::size_t first, std::size_t last) {
        x.middleRows(Eigen::Index(first), Eigen::Index(last - first)).setZero();
    });
}

/// Squared norms of the columns, four rows at a time.
Eigen::Array3d column_norms(const LimitOperator::Rows& rows) {
    using Four = Eigen::Array<double, 12, 1>;
    Four sum = Four::Zero();
    const Eigen::Index whole = rows.rows() / 4 * 4;
    for (Eigen::Index i = 0; i < whole; i += 4) {
        sum += Eigen::Map<const Four>(rows.data() + 3 * i).square();
    }
    Eigen::Array3d result =
        sum.segment<3>(0) + sum.segment<3>(3) + sum.segment<3>(6) + sum.segment<3>(9);
    for (Eigen::Index i = whole; i < rows.rows(); ++i) {
        result += rows.row(i).transpose().array().square();
    }
    return result;
}

/// Which template a site needs; the same for all sites of one kind, sector and parameter set.
struct TemplateKey {
    const RingKind* kind = nullptr;
    int sector = 0;
    int set = 0;

    bool operator==(const TemplateKey&) const = default;
};

/// Numbers keys in the order in which they are met.
class TemplateIndex {
  public:
    std::int32_t find(const TemplateKey& key) {
        if (last_ >= 0 && key == keys_[std::size_t(last_)]) return last_;
        const auto kind = std::size_t(key.kind->number());
        if (known_.size() <= kind) known_.resize(kind + 1);
        for (const std::int32_t number : known_[kind]) {
            if (keys_[std::size_t(number)] == key) return last_ = number;
        }
        known_[kind].push_back(static_cast<std::int32_t>(keys_.size()));
        keys_.push_back(key);
        return last_ = known_[kind].back();
    }
    [[nodiscard]] const std::vector<TemplateKey>& keys() const { return keys_; }

  private:
    std::vector<std::vector<std::int32_t>> known_;  // by number of kind
    std::vector<TemplateKey> keys_;
    std::int32_t last_ = -1;
};

}  // namespace

struct LimitOperator::Template {
    MaskTable position, du, dv;
    MaskTable squares;                     // of position's weights
    std::vector<double> position_squares;  // of each slot

    Template(const RingKind& kind, const ParameterSet& set, int sector, SampleRows rows) {
        const auto samples = static_cast<int>(set.size());
        const bool bending = rows == SampleRows::Bending;
        const bool tangents = rows == SampleRows::PointsAndTangents;
        position = MaskTable(bending ? 3 * samples : samples, kind.slots());
        if (tangents) du = dv = MaskTable(samples, kind.slots());
        for (int k = 0; k < samples; ++k) {
            const Eigen::Vector2d& at = set[std::size_t(k)];
            const RingMask mask = ring_mask(kind, at.x(), at.y(), sector,
                                            bending    ? 2
                                            : tangents ? 1
                                                       : 0);
            for (int slot = 0; slot < kind.slots(); ++slot) {
                if (bending) {
                    position.set(3 * k, slot, mask.rows(3, slot));
                    position.set(3 * k + 1, slot, std::sqrt(2.0) * mask.rows(4, slot));
                    position.set(3 * k + 2, slot, mask.rows(5, slot));
                } else {
                    position.set(k, slot, mask.rows(0, slot));
                }
                if (tangents) {
                    du.set(k, slot, mask.rows(1, slot));
                    dv.set(k, slot, mask.rows(2, slot));
                }
            }
        }
        position_squares = position.column_squares();
        squares = position.squared();
    }
    [[nodiscard]] std::size_t bytes() const {
        return position.bytes() + du.bytes() + dv.bytes() + squares.bytes();
    }
};

LimitOperator::LimitOperator(const mesh::Topology& topology, const std::vector<ParameterSet>& sets,
                             std::span<const Site> sites, SampleRows rows)
    : columns_(topology.vertex_count()) {
    const int rows_a_sample = rows == SampleRows::Bending ? 3 : 1;
    check_sites(topology, sets, sites, rows_a_sample);
    const std::vector<std::uint8_t> smooth = smooth_valences(topology);
    RingTable table;
    site_template_.resize(sites.size());
    site_rows_.resize(sites.size() + 1);
    const std::size_t step = chunk_size(sites.size());
    chunks_.resize((sites.size() + step - 1) / step);
    std::vector<TemplateIndex> met(chunks_.size());  // numbers within a chunk
    base::parallel_for(chunks_.size(), 1, [&](std::size_t first, std::size_t last) {
        RingExtractor ring;
        std::vector<std::int32_t> slot_vertices;
        for (std::size_t c = first; c < last; ++c) {
            Chunk& chunk = chunks_[c];
            chunk.begin = c * step;
            chunk.end = std::min(sites.size(), chunk.begin + step);
            slot_vertices.clear();
            slot_vertices.reserve(20 * (chunk.end - chunk.begin));
            for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
                const Site& site = sites[i];
                const RingKind& kind = extract_ring(table, ring, topology, smooth, site.face);
                site_template_[i] = met[c].find({&kind, site.sector, site.set});
                const auto vertices = ring.vertices();
                slot_vertices.insert(slot_vertices.end(), vertices.begin(), vertices.end());
            }
            chunk.slot_vertices = slot_vertices;  // of just the size it needs
        }
    });
    TemplateIndex all;
    std::int32_t row = 0;
    for (std::size_t c = 0; c < chunks_.size(); ++c) {
        std::vector<std::int32_t> number;  // of a chunk's template among all
        for (const TemplateKey& key : met[c].keys()) number.push_back(all.find(key));
        for (std::size_t i = chunks_[c].begin; i < chunks_[c].end; ++i) {
            site_template_[i] = number[std::size_t(site_template_[i])];
            row +=
                rows_a_sample * static_cast<std::int32_t>(sets[std::size_t(sites[i].set)].size());
            site_rows_[i + 1] = row;
        }
    }
    for (const TemplateKey& key : all.keys()) {
        templates_.emplace_back(*key.kind, sets[std::size_t(key.set)], key.sector, rows);
    }
    colour_chunks();
}

LimitOperator::~LimitOperator() = default;
LimitOperator::LimitOperator(LimitOperator&&) noexcept = default;
LimitOperator& LimitOperator::operator=(LimitOperator&&) noexcept = default;

void LimitOperator::colour_chunks() {
    // Which chunks touch each vertex, and from that which chunks touch each other.
    std::vector<std::uint64_t> touching(std::size_t(columns_), 0);
    for (std::size_t c = 0; c < chunks_.size(); ++c) {
        const std::uint64_t bit = std::uint64_t{1} << c;
        for (const std::int32_t v : chunks_[c].slot_vertices) touching[std::size_t(v)] |= bit;
    }
    std::vector<std::uint64_t> neighbours(chunks_.size(), 0);
    for (const std::uint64_t mask : touching) {
        if ((mask & (mask - 1)) == 0) continue;  // one chunk at most
        for (std::uint64_t rest = mask; rest != 0; rest &= rest - 1) {
            neighbours[std::size_t(std::countr_zero(rest))] |= mask;
        }
    }
    std::vector<std::uint64_t> members;  // of each colour
    for (std::size_t c = 0; c < chunks_.size(); ++c) {
        const auto free = std::find_if(members.begin(), members.end(),
                                       [&](std::uint64_t m) { return (m & neighbours[c]) == 0; });
        const auto colour = std::size_t(free - members.begin());
        if (free == members.end()) {
            members.push_back(0);
            colours_.emplace_back();
        }
        members[colour] |= std::uint64_t{1} << c;
        colours_[colour].push_back(static_cast<std::int32_t>(c));
    }
}

template <class Visit>
void LimitOperator::for_runs(const Chunk& chunk, const Visit& visit) const {
    const std::int32_t* vertices = chunk.slot_vertices.data();
    for (std::size_t site = chunk.begin; site < chunk.end;) {
        const std::int32_t id = site_template_[site];
        std::size_t end = site + 1;
        while (end < chunk.end && end - site < longest_run && site_template_[end] == id) ++end;
        const Template& t = templates_[std::size_t(id)];
        visit(t, site, end, vertices);
        vertices += (end - site) * std::size_t(t.position.slots());
        site = end;
    }
}

void LimitOperator::apply(const geom::Points& x, geom::Points& y) const {
    y.resize(rows(), 3);
    base::parallel_for(chunks_.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t c = first; c < last; ++c) {
            for_runs(chunks_[c], [&](const Template& t, std::size_t begin, std::size_t end,
                                     const std::int32_t* vertices) {
                t.position.apply(static_cast<int>(end - begin), vertices, x.data(),
                                 y.row(site_rows_[begin]).data());
            });
        }
    });
}

template <class VisitChunk>
void LimitOperator::by_colour(const VisitChunk& visit) const {
    for (const auto& colour : colours_) {
        base::parallel_for(colour.size(), 1, [&](std::size_t first, std::size_t last) {
            for (std::size_t c = first; c < last; ++c) visit(std::size_t(colour[c]));
        });
    }
}

void LimitOperator::apply_transposed(const geom::Points& y, geom::Points& x) const {
    set_zero(x, columns_);
    by_colour([&](std::size_t c) {
        for_runs(chunks_[c], [&](const Template& t, std::size_t begin, std::size_t end,
                                 const std::int32_t* vertices) {
            t.position.add_transposed(static_cast<int>(end - begin), vertices,
                                      y.row(site_rows_[begin]).data(), x.data());
        });
    });
}

void LimitOperator::run_normals(const Template& t, std::size_t begin, std::size_t end,
                                const std::int32_t* vertices, const geom::Points& x,
                                geom::Points& dv, Rows to) const {
    const auto sites = static_cast<int>(end - begin);
    if (dv.rows() < to.rows()) dv.resize(to.rows(), 3);
    t.du.apply(sites, vertices, x.data(), to.data());
    t.dv.apply(sites, vertices, x.data(), dv.data());
    for (Eigen::Index i = 0; i < to.rows(); ++i) {
        const geom::Vec3 a = to.row(i), b = dv.row(i);
        to.row(i) << a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(),
            a.x() * b.y() - a.y() * b.x();
    }
}

geom::Points LimitOperator::normals(const geom::Points& x) const {
    geom::Points result(rows(), 3);
    base::parallel_for(chunks_.size(), 1, [&](std::size_t first, std::size_t last) {
        geom::Points dv;
        for (std::size_t c = first; c < last; ++c) {
            for_runs(chunks_[c], [&](const Template& t, std::size_t begin, std::size_t end,
                                     const std::int32_t* vertices) {
                if (t.du.samples() != t.position.samples()) {
                    throw base::InvalidArgument("normals: the operator was made without tangents");
                }
                const auto row = site_rows_[begin], count = site_rows_[end] - row;
                run_normals(t, begin, end, vertices, x, dv, Rows(result.row(row).data(), count, 3));
            });
        }
    });
    return result;
}

void LimitOperator::visit_sites(const geom::Points& x, const SiteVisit& visit) const {
    base::parallel_for(chunks_.size(), 1, [&](std::size_t first, std::size_t last) {
        geom::Points points, normals, dv;
        for (std::size_t c = first; c < last; ++c) {
            for_runs(chunks_[c], [&](const Template& t, std::size_t begin, std::size_t end,
                                     const std::int32_t* vertices) {
                const Eigen::Index count = site_rows_[end] - site_rows_[begin];
                if (points.rows() < count) points.resize(count, 3);
                t.position.apply(static_cast<int>(end - begin), vertices, x.data(), points.data());
                const bool directed = t.du.samples() == t.position.samples();
                if (directed) {
                    if (normals.rows() < count) normals.resize(count, 3);
                    run_normals(t, begin, end, vertices, x, dv, Rows(normals.data(), count, 3));
                }
                visit(begin, end, Rows(points.data(), count, 3),
                      Rows(normals.data(), directed ? count : 0, 3));
            });
        }
    });
}

Eigen::Array3d SolverProducts::normal_product(const geom::Points& x, geom::Points& t,
                                              const RowVisit& visit) const {
    set_zero(t, m_.columns_);
    std::vector<Eigen::Array3d> partial(m_.chunks_.size());
    m_.by_colour([&](std::size_t c) {
        geom::Points buffer;
        Eigen::Array3d sum = Eigen::Array3d::Zero();
        m_.for_runs(m_.chunks_[c], [&](const LimitOperator::Template& table, std::size_t begin,
                                       std::size_t end, const std::int32_t* vertices) {
            const auto row = m_.site_rows_[begin], count = m_.site_rows_[end] - row;
            if (buffer.rows() < count) buffer.resize(count, 3);
            const auto sites = static_cast<int>(end - begin);
            table.position.apply(sites, vertices, x.data(), buffer.data());
            sum += visit(row, Rows(buffer.data(), count, 3));
            table.position.add_transposed(sites, vertices, buffer.data(), t.data());
        });
        partial[c] = sum;
    });
    Eigen::Array3d sum = Eigen::Array3d::Zero();
    for (const Eigen::Array3d& part : partial) sum += part;
    return sum;
}

Eigen::Array3d SolverProducts::normal_product(const geom::Points& x, geom::Points& t) const {
    return normal_product(x, t, [](Eigen::Index, Rows rows) { return column_norms(rows); });
}

Eigen::VectorXd SolverProducts::column_squares(const Eigen::VectorXd& weights) const {
    Eigen::VectorXd sums = Eigen::VectorXd::Zero(m_.columns_);
    for (const LimitOperator::Chunk& chunk : m_.chunks_) {
        m_.for_runs(chunk, [&](const LimitOperator::Template& t, std::size_t begin, std::size_t end,
                               const std::int32_t* vertices) {
            for (; begin < end; ++begin, vertices += t.position.slots()) {
                const double weight = weights.size() > 0 ? weights[Eigen::Index(begin)] : 1.0;
                for (int k = 0; k < t.position.slots(); ++k) {
                    sums[vertices[k]] += weight * t.position_squares[std::size_t(k)];
                }
            }
        });
    }
    return sums;
}

void SolverProducts::apply_squares_transposed(const geom::Points& y, geom::Points& x) const {
    set_zero(x, m_.columns_);
    m_.by_colour([&](std::size_t c) {
        m_.for_runs(m_.chunks_[c], [&](const LimitOperator::Template& t, std::size_t begin,
                                       std::size_t end, const std::int32_t* vertices) {
            t.squares.add_transposed(static_cast<int>(end - begin), vertices,
                                     y.row(m_.site_rows_[begin]).data(), x.data());
        });
    });
}

int LimitOperator::template_count() const { return static_cast<int>(templates_.size()); }

std::size_t LimitOperator::site_bytes() const {
    const auto bytes = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
    std::size_t sum = bytes(site_template_) + bytes(site_rows_) + bytes(chunks_);
    for (const Chunk& chunk : chunks_) sum += bytes(chunk.slot_vertices);
    return sum;
}

std::size_t LimitOperator::template_bytes() const {
    std::size_t sum = 0;
    for (const Template& t : templates_) sum += t.bytes();
    return sum;
}

}  // namespace patchwright::subd
