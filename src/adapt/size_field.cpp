#include "adapt/nearest_point.h"

#include <patchwright/adapt/size_field.h>
#include <patchwright/base/error.h>

#include <fmt/format.h>

namespace patchwright::adapt {

struct SizeField::State {
    geom::Points at;
    std::vector<double> sizes;
    geom::Bvh tree;
};

SizeField::SizeField(geom::Points at, std::vector<double> sizes_mm) {
    if (sizes_mm.empty() || at.rows() != static_cast<Eigen::Index>(sizes_mm.size()))
        throw base::InvalidArgument(
            fmt::format("{} points with {} sizes", at.rows(), sizes_mm.size()));
    for (std::size_t i = 0; i < sizes_mm.size(); ++i)
        if (!(sizes_mm[i] > 0.0))
            throw base::InvalidArgument(
                fmt::format("size {} is {}; it must be positive", i + 1, sizes_mm[i]));
    geom::Bvh tree = tree_of_points(at);
    state_ = std::make_shared<State>(State{std::move(at), std::move(sizes_mm), std::move(tree)});
}

double SizeField::operator()(const geom::Vec3& p) const {
    return state_->sizes[std::size_t(nearest_point(state_->tree, state_->at, p))];
}

}  // namespace patchwright::adapt
