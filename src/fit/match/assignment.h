// One-to-one assignment of least cost.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace patchwright::fit {

/// For each row the column it is given, so that the sum of the costs is least; -1 where
/// none, at the cost `unassigned`, is cheaper. No column is given twice.
/// Source: Kuhn, The Hungarian method for the assignment problem (1955), with potentials.
std::vector<int> assign(const Eigen::MatrixXd& cost, const Eigen::VectorXd& unassigned);

}  // namespace patchwright::fit
