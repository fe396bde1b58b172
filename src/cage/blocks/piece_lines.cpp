#include "cage/blocks/piece_mesh.h"

#include <algorithm>

namespace patchwright::cage {

void PieceMesh::add_lines(const FieldLines& made) {
    std::map<int, int> walls_at;
    for (const auto& line : made.lines) {
        if (line.empty()) continue;
        for (std::size_t i = 0; i + 1 < line.size(); ++i) walls_.insert(line[i], line[i + 1]);
        make_node(line.front());
        make_node(line.back());
        cuts_.push_back(line);
    }
    for (const auto& [a, b] : walls_.sorted()) {
        ++walls_at[a];
        ++walls_at[b];
    }
    for (const auto& [v, count] : walls_at)
        if (count > 2) make_node(v);
    for (const FieldSector& s : made.sectors) {
        if (s.quads != 2) make_node(s.vertex);
        sectors_[{s.vertex, s.next}] = {s.angle, s.quads};
    }
}

}  // namespace patchwright::cage
