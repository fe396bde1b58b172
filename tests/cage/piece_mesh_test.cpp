// Pieces of a triangle mesh between walls.
#include "cage/blocks/piece_mesh.h"

#include "geom/shortest_paths.h"

#include <patchwright/base/numbers.h>
#include <patchwright/geom/mesh_reference.h>

#include <catch2/catch.hpp>

namespace patchwright {
namespace {

using base::at;

/// The square [0, side]^2 in triangles, two a unit square.
geom::TriangleMesh square(int side) {
    geom::TriangleMesh mesh;
    const int row = side + 1;
    mesh.points.resize(row * row, 3);
    for (int i = 0; i < row; ++i)
        for (int j = 0; j < row; ++j) mesh.points.row(row * i + j) << i, j, 0;
    for (int i = 0; i < side; ++i) {
        for (int j = 0; j < side; ++j) {
            const int a = row * i + j, b = a + row;
            mesh.triangles.push_back({a, b, b + 1});
            mesh.triangles.push_back({a, b + 1, a + 1});
        }
    }
    mesh.part.assign(mesh.triangles.size(), -1);
    return mesh;
}

/// Number of the border point at (x, y).
int border_point_at(const cage::CutPiece& piece, const cage::PieceMesh& pieces, double x,
                    double y) {
    for (int i = 0; i < piece.border_count(); ++i) {
        const geom::Vec3 p = pieces.mesh().point(piece.vertices[at(i)]);
        if ((p - geom::Vec3(x, y, 0)).norm() < 1e-12) return i;
    }
    FAIL("no border point");
    return -1;
}

/// Makes the shortest way through the inside a wall.
void cut_between(cage::PieceMesh& pieces, const cage::CutPiece& piece, int from, int to) {
    const auto paths = geom::shortest_paths(
        piece.vertices.size(), {{from, 0.0}}, [&](int i, double length, const auto& reach) {
            if (i < piece.border_count() && i != from) return;
            for (const auto& [j, step] : piece.neighbours[at(i)]) reach(j, length + step);
        });
    const cage::Parting half{.angle = 0.5 * M_PI};
    pieces.cut(piece, paths.path_to(to), half, half);
}

/// What can be reached from the first triangle without crossing a wall, edge by edge.
std::vector<int> flood(const cage::PieceMesh& pieces, int triangle) {
    const geom::EditableMesh& mesh = pieces.mesh();
    std::set<int> reached{triangle};
    std::vector<int> pending{triangle};
    while (!pending.empty()) {
        const auto corners = mesh.triangle(pending.back());
        pending.pop_back();
        for (std::size_t k = 0; k < 3; ++k) {
            if (pieces.is_wall(corners[k], corners[(k + 1) % 3])) continue;
            for (const int t : mesh.sides(corners[k], corners[(k + 1) % 3]).triangle)
                if (t >= 0 && reached.insert(t).second) pending.push_back(t);
        }
    }
    return {reached.begin(), reached.end()};
}

}  // namespace

TEST_CASE("pieces are what walls leave, after cuts and splits too", "[layout]") {
    constexpr int side = 6;
    const geom::MeshReference reference(square(side));
    geom::EditableMesh mesh(reference.surface_mesh(1e-3));
    cage::PieceMesh pieces(mesh, reference);
    REQUIRE(pieces.seeds().size() == 1);
    const cage::CutPiece whole = pieces.piece(0);
    // The edges across two of its corners are split, and one piece of a disc it stays.
    CHECK(mesh.vertex_count() > reference.surface_mesh(1e-3).points.rows());
    CHECK(whole.is_final);
    CHECK(whole.triangles == flood(pieces, 0));
    CHECK(whole.euler == 1);
    CHECK(whole.area == Approx(side * side));
    CHECK(whole.borders.size() == 1);

    cut_between(pieces, whole, border_point_at(whole, pieces, 3, 0),
                border_point_at(whole, pieces, 3, side));
    const std::vector<int> seeds = pieces.seeds();
    REQUIRE(seeds.size() == 2);
    double area = 0.0;
    for (const int seed : seeds) {
        const cage::CutPiece half = pieces.piece(seed);
        CHECK(half.triangles == flood(pieces, seed));
        CHECK(half.euler == 1);
        area += half.area;
    }
    CHECK(area == Approx(side * side));

    // Both halves get the new point of the wall between them.
    const auto corner_count = [&] {
        int count = 0;
        for (const int seed : pieces.seeds()) count += pieces.piece(seed).border_count();
        return count;
    };
    const int before = corner_count();
    const cage::CutPiece half = pieces.piece(seeds[0]);
    const auto& border = half.borders[0];
    const auto inner = std::find_if(border.begin(), border.end(), [&](const auto& p) {
        return mesh.sides(p.vertex, p.next).triangle[1] >= 0;
    });
    REQUIRE(inner != border.end());
    pieces.split_wall(inner->vertex, inner->next);
    CHECK(corner_count() == before + 2);
    for (const int seed : pieces.seeds())
        CHECK(pieces.piece(seed).triangles == flood(pieces, seed));
}

}  // namespace patchwright
