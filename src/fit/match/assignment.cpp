#include "fit/match/assignment.h"

#include <limits>

namespace patchwright::fit {

std::vector<int> assign(const Eigen::MatrixXd& cost, const Eigen::VectorXd& unassigned,
                        const std::function<void()>& poll) {
    const auto rows = static_cast<int>(cost.rows());
    const auto real = static_cast<int>(cost.cols());
    const int columns = real + rows;  // as many more as rows: unassigned, at that cost
    const auto price = [&](int row, int column) {
        return column < real ? cost(row, column) : unassigned[row];
    };
    // Rows and columns count from 1; column 0 holds the row that is being added.
    std::vector<double> row_potential(std::size_t(rows) + 1, 0.0);
    std::vector<double> column_potential(std::size_t(columns) + 1, 0.0);
    std::vector<int> owner(std::size_t(columns) + 1, 0), before(owner.size(), 0);
    for (int row = 1; row <= rows; ++row) {
        owner[0] = row;
        std::vector<double> slack(owner.size(), std::numeric_limits<double>::infinity());
        std::vector<char> seen(owner.size(), 0);
        int at = 0;
        while (owner[std::size_t(at)] != 0) {
            poll();
            seen[std::size_t(at)] = 1;
            const int i = owner[std::size_t(at)];
            double least = std::numeric_limits<double>::infinity();
            int next = 0;
            for (int j = 1; j <= columns; ++j) {
                const auto k = std::size_t(j);
                if (seen[k] != 0) continue;
                const double reduced =
                    price(i - 1, j - 1) - row_potential[std::size_t(i)] - column_potential[k];
                if (reduced < slack[k]) {
                    slack[k] = reduced;
                    before[k] = at;
                }
                if (slack[k] < least) {
                    least = slack[k];
                    next = j;
                }
            }
            for (std::size_t k = 0; k < owner.size(); ++k) {
                if (seen[k] != 0) {
                    row_potential[std::size_t(owner[k])] += least;
                    column_potential[k] -= least;
                } else {
                    slack[k] -= least;
                }
            }
            at = next;
        }
        for (; at != 0; at = before[std::size_t(at)]) {
            owner[std::size_t(at)] = owner[std::size_t(before[std::size_t(at)])];
        }
    }
    std::vector<int> column(std::size_t(rows), -1);
    for (int j = 1; j <= real; ++j) {
        if (owner[std::size_t(j)] > 0) column[std::size_t(owner[std::size_t(j)] - 1)] = j - 1;
    }
    return column;
}

}  // namespace patchwright::fit
