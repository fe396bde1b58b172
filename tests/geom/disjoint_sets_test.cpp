#include "geom/disjoint_sets.h"

#include <catch2/catch.hpp>

namespace patchwright::geom {
namespace {

TEST_CASE("joined numbers are one set under their least member", "[geom]") {
    DisjointSets sets(6);
    sets.join(5, 3);
    sets.join(3, 1);
    sets.join(4, 0);
    CHECK(sets.find(5) == 1);
    CHECK(sets.find(4) == 0);
    CHECK(sets.add() == 6);
    sets.join(6, 2);
    CHECK(sets.sets() == std::vector<std::vector<int>>{{0, 4}, {1, 3, 5}, {2, 6}});
}

}  // namespace
}  // namespace patchwright::geom
