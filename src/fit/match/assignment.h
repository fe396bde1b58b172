// One-to-one assignment of least cost.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace patchwright::fit {

/// For each row the column it is given, so that the sum of the costs is least; -1 where leaving the
/// row alone, at its price `without`, is cheaper. No column is given twice.
/// Source: Kuhn, The Hungarian method for the assignment problem (1955), with potentials.
std::vector<int> assign(const Eigen::MatrixXd& cost, const Eigen::VectorXd& without);

}  // namespace patchwright::fit
