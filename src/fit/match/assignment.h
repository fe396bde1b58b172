// One-to-one assignment of least cost.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace patchwright::fit {

/// For each row the column it is given, so that the sum of the costs is least; -1 where
/// none, at the cost `unassigned`, is cheaper. No column is given twice.
/// @param poll  called in every loop that may take long; may throw
/// Source: Kuhn, The Hungarian method for the assignment problem (1955), with potentials.
std::vector<int> assign(const Eigen::MatrixXd& cost, const Eigen::VectorXd& unassigned,
                        const std::function<void()>& poll);

}  // namespace patchwright::fit
