#include <patchwright/report/mesh_drawing.h>

#include <Eigen/Geometry>
#include <algorithm>

namespace patchwright::report {

namespace {

using geom::Vec3;

/// OBJ files' sharpness that is infinite.
constexpr double sharp = 10.0;

PictureLine::Kind kind_of(const mesh::Topology& topology, mesh::EdgeId edge) {
    if (topology.is_boundary(edge)) return PictureLine::Kind::Border;
    const double sharpness = topology.tagged_sharpness(edge);
    return sharpness >= sharp ? PictureLine::Kind::Crease
           : sharpness > 0.0  ? PictureLine::Kind::SemiSharp
                              : PictureLine::Kind::Plain;
}

/// Its length is twice the polygon's area (Newell's sum).
Vec3 polygon_normal(const mesh::Cage& cage, mesh::FaceId face) {
    const mesh::Topology& topology = *cage.topology;
    Vec3 sum = Vec3::Zero();
    for (const mesh::CornerId c : topology.corners(face)) {
        const Vec3 a = cage.points.row(topology.vertex(c).value);
        const Vec3 b = cage.points.row(topology.vertex(topology.next(c)).value);
        sum += a.cross(b);
    }
    return sum.normalized();
}

/// The points of a line of a block: those from `first` on, `step` apart.
PictureLine grid_line(const geom::Points& points, Eigen::Index first, Eigen::Index step,
                      Eigen::Index count, bool is_side) {
    PictureLine line{geom::Points(count, 3),
                     is_side ? PictureLine::Kind::Border : PictureLine::Kind::Plain};
    for (Eigen::Index k = 0; k < count; ++k) line.points.row(k) = points.row(first + k * step);
    return line;
}

/// A block's points and the normals by its neighbours in the grid.
void add_points(const grid::BlockPoints& block, Eigen::Index first, measure::Field& field) {
    for (int j = 0; j < block.nj; ++j) {
        for (int i = 0; i < block.ni; ++i) {
            const Vec3 along_i =
                block.at(std::min(i + 1, block.ni - 1), j) - block.at(std::max(i - 1, 0), j);
            const Vec3 along_j =
                block.at(i, std::min(j + 1, block.nj - 1)) - block.at(i, std::max(j - 1, 0));
            const Eigen::Index row = first + Eigen::Index(block.index(i, j));
            field.points.row(row) = block.at(i, j).transpose();
            field.normals.row(row) = along_i.cross(along_j).normalized().transpose();
        }
    }
}

}  // namespace

MeshDrawing draw_mesh(const mesh::Cage& cage) {
    const mesh::Topology& topology = *cage.topology;
    MeshDrawing drawing;
    measure::Field& field = drawing.field;
    field.points.resize(topology.corner_count(), 3);
    field.normals.resize(topology.corner_count(), 3);
    for (const mesh::FaceId face : topology.faces()) {
        const Vec3 normal = polygon_normal(cage, face);
        const auto corners = topology.corners(face);
        for (const mesh::CornerId c : corners) {
            field.points.row(c.value) = cage.points.row(topology.vertex(c).value);
            field.normals.row(c.value) = normal.transpose();
        }
        for (int k = 2; k < corners.size(); ++k) {
            field.triangles.push_back({corners[0].value, corners[k - 1].value, corners[k].value});
            field.faces.push_back(std::max(topology.group(face), 0));
        }
    }
    for (const mesh::EdgeId edge : topology.edges()) {
        PictureLine line{geom::Points(2, 3), kind_of(topology, edge)};
        line.points.row(0) = cage.points.row(topology.start(edge).value);
        line.points.row(1) = cage.points.row(topology.end(edge).value);
        drawing.edges.push_back(std::move(line));
    }
    return drawing;
}

MeshDrawing draw_grid(const grid::BlockSource& grid) {
    MeshDrawing drawing;
    measure::Field& field = drawing.field;
    Eigen::Index count = 0;
    for (int b = 0; b < grid.block_count(); ++b)
        count += Eigen::Index(grid.size(b)[0]) * grid.size(b)[1];
    field.points.resize(count, 3);
    field.normals.resize(count, 3);
    Eigen::Index first = 0;
    grid::BlockPoints block;
    for (int b = 0; b < grid.block_count(); ++b) {
        grid.evaluate(b, block);
        add_points(block, first, field);
        for (int j = 0; j + 1 < block.nj; ++j) {
            for (int i = 0; i + 1 < block.ni; ++i) {
                const int at = int(first) + int(block.index(i, j)), up = at + block.ni;
                field.triangles.push_back({at, at + 1, up + 1});
                field.triangles.push_back({at, up + 1, up});
                field.faces.insert(field.faces.end(), 2, b);
            }
        }
        for (int j = 0; j < block.nj; ++j)
            drawing.edges.push_back(grid_line(field.points, first + Eigen::Index(j) * block.ni, 1,
                                              block.ni, j == 0 || j + 1 == block.nj));
        for (int i = 0; i < block.ni; ++i)
            drawing.edges.push_back(grid_line(field.points, first + i, block.ni, block.nj,
                                              i == 0 || i + 1 == block.ni));
        first += Eigen::Index(block.ni) * block.nj;
    }
    return drawing;
}

MeshDrawing draw_grid(const adapt::LocalGrid& grid) {
    MeshDrawing drawing;
    measure::Field& field = drawing.field;
    field.points = grid.points;
    field.normals = geom::Points::Zero(grid.points.rows(), 3);
    const auto add_line = [&](std::int32_t a, std::int32_t b, PictureLine::Kind kind) {
        PictureLine line{geom::Points(2, 3), kind};
        line.points << grid.points.row(a), grid.points.row(b);
        drawing.edges.push_back(std::move(line));
    };
    std::vector<int> corners;
    for (const adapt::LocalCell& cell : grid.cells) {
        corners.clear();
        for (std::size_t k = 0; k < 4; ++k) {
            corners.push_back(cell.corners[k]);
            if (cell.hanging[k] >= 0) corners.push_back(cell.hanging[k]);
        }
        Vec3 normal = Vec3::Zero();  // Newell's sum
        for (std::size_t k = 0; k < corners.size(); ++k) {
            const int a = corners[k], b = corners[(k + 1) % corners.size()];
            const Vec3 from = grid.points.row(a), to = grid.points.row(b);
            normal += from.cross(to);
            add_line(a, b, PictureLine::Kind::Plain);
        }
        for (const int corner : corners) field.normals.row(corner) += normal.transpose();
        for (std::size_t k = 2; k < corners.size(); ++k) {
            field.triangles.push_back({corners[0], corners[k - 1], corners[k]});
            field.faces.push_back(cell.block);
        }
    }
    for (const auto& [a, b] : grid.free_sides) add_line(a, b, PictureLine::Kind::Border);
    field.normals.rowwise().normalize();
    return drawing;
}

}  // namespace patchwright::report
