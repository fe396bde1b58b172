#include "fit/match/assignment.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <numeric>

using namespace patchwright;

TEST_CASE("an assignment costs no more than any other", "[fit][oracle]") {
    std::srand(3);
    for (int round = 0; round < 40; ++round) {
        const int rows = 1 + round % 4, columns = 1 + round % 5;
        const Eigen::MatrixXd cost = Eigen::MatrixXd::Random(rows, columns).cwiseAbs();
        const Eigen::VectorXd without = 0.7 * Eigen::VectorXd::Random(rows).cwiseAbs();
        const auto price = [&](const std::vector<int>& column) {
            double sum = 0.0;
            for (int i = 0; i < rows; ++i) {
                const int j = column[std::size_t(i)];
                sum += j < 0 ? without[i] : cost(i, j);
            }
            return sum;
        };
        // Every way: orders of the columns and of as many places for rows without a column.
        std::vector<int> order(std::size_t(columns + rows));
        std::iota(order.begin(), order.end(), 0);
        double best = 1e300;
        do {
            std::vector<int> column(order.begin(), order.begin() + rows);
            for (int& j : column) j = j < columns ? j : -1;
            best = std::min(best, price(column));
        } while (std::next_permutation(order.begin(), order.end()));
        CHECK(price(fit::assign(cost, without, [] {})) == Approx(best));
    }
}
