#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>
#include <patchwright/subd/stencils.h>

#include <algorithm>
#include <numeric>
#include <utility>

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

Stencils Stencils::transposed() const {
    Stencils result;
    result.columns = rows();
    result.begin.assign(std::size_t(columns) + 1, 0);
    for (const std::int32_t i : index) ++result.begin[std::size_t(i) + 1];
    std::partial_sum(result.begin.begin(), result.begin.end(), result.begin.begin());
    result.index.resize(index.size());
    result.weight.resize(index.size());
    std::vector<std::int64_t> next(result.begin.begin(), result.begin.end() - 1);
    for (int row = 0; row < rows(); ++row) {
        for (auto k = begin[std::size_t(row)]; k < begin[std::size_t(row) + 1]; ++k) {
            const auto to = std::size_t(next[std::size_t(index[std::size_t(k)])]++);
            result.index[to] = row;
            result.weight[to] = weight[std::size_t(k)];
        }
    }
    return result;
}

Stencils multiply(const Stencils& fine, const Stencils& coarse) {
    if (fine.columns != coarse.rows()) {
        throw base::InvalidArgument("stencils to multiply differ in size");
    }
    Stencils result;
    result.columns = coarse.columns;
    std::vector<double> sum(std::size_t(coarse.columns), 0.0);
    std::vector<std::int32_t> touched;
    std::vector<char> is_touched(sum.size(), 0);
    for (int row = 0; row < fine.rows(); ++row) {
        touched.clear();
        for (auto k = fine.begin[std::size_t(row)]; k < fine.begin[std::size_t(row) + 1]; ++k) {
            const auto middle = std::size_t(fine.index[std::size_t(k)]);
            for (auto l = coarse.begin[middle]; l < coarse.begin[middle + 1]; ++l) {
                const auto column = std::size_t(coarse.index[std::size_t(l)]);
                if (is_touched[column] == 0) touched.push_back(static_cast<std::int32_t>(column));
                is_touched[column] = 1;
                sum[column] += fine.weight[std::size_t(k)] * coarse.weight[std::size_t(l)];
            }
        }
        std::sort(touched.begin(), touched.end());
        for (const std::int32_t column : touched) {
            result.index.push_back(column);
            result.weight.push_back(std::exchange(sum[std::size_t(column)], 0.0));
            is_touched[std::size_t(column)] = 0;
        }
        result.begin.push_back(static_cast<std::int64_t>(result.index.size()));
    }
    return result;
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
