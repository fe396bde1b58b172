#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/subd/stencils.h>

namespace patchwright::subd {

geom::Points Stencils::apply(const geom::Points& coarse) const {
    if (coarse.rows() != columns) throw base::InvalidArgument("stencils and points differ in size");
    geom::Points fine(rows(), 3);
    base::parallel_for(std::size_t(rows()), 4096, [&](std::size_t first, std::size_t last) {
        for (std::size_t row = first; row < last; ++row) {
            Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
            for (auto k = begin[row]; k < begin[row + 1]; ++k) {
                sum += weight[std::size_t(k)] * coarse.row(index[std::size_t(k)]);
            }
            fine.row(Eigen::Index(row)) = sum;
        }
    });
    return fine;
}

void StencilRow::add(std::int32_t index, double weight) {
    for (auto& [known, sum] : entries_) {
        if (known == index) {
            sum += weight;
            return;
        }
    }
    entries_.emplace_back(index, weight);
}

void StencilRow::add(const StencilRow& other, double factor) {
    for (const auto& [index, weight] : other.entries_) add(index, factor * weight);
}

void StencilRow::flush(Stencils& to) {
    for (const auto& [index, weight] : entries_) {
        to.index.push_back(index);
        to.weight.push_back(weight);
    }
    to.begin.push_back(static_cast<std::int64_t>(to.index.size()));
    entries_.clear();
}

}  // namespace patchwright::subd
