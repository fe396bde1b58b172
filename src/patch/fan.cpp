#include "patch/fan.h"

#include <algorithm>
#include <cmath>

namespace patchwright::patch {

using mesh::CornerId;
using mesh::Topology;
using mesh::VertexId;

bool Fan::is_regular() const {
    switch (kind) {
        case FanKind::Ring: return size() == 4;
        case FanKind::Crease: return size() == 2;
        case FanKind::Corner: return size() == 1;
        case FanKind::Dart:
        case FanKind::Fold:
        case FanKind::Spike: return false;
    }
    return false;
}

std::vector<Fan> fans_around(const Topology& t, VertexId v) {
    std::vector<CornerId> around;
    CornerId c = t.corner(v);
    do {
        around.push_back(c);
        c = t.rotate(c);
    } while (c.valid() && c != around.front());
    // A boundary starts with a sharp edge; its other one closes the last fan.
    const bool boundary = t.is_boundary(v);
    const auto sharp = [&](CornerId corner) { return is_sharp(t, t.edge(corner)); };
    const auto first = std::find_if(around.begin(), around.end(), sharp);
    const auto sharp_edges =
        std::count_if(around.begin(), around.end(), sharp) + (boundary ? 1 : 0);
    if (first != around.end()) std::rotate(around.begin(), first, around.end());

    const bool corner = std::isinf(t.sharpness(v));
    FanKind kind = FanKind::Corner;
    if (sharp_edges == 0) kind = corner ? FanKind::Spike : FanKind::Ring;
    if (sharp_edges == 1) kind = corner ? FanKind::Fold : FanKind::Dart;
    if (sharp_edges == 2 && !corner) kind = FanKind::Crease;
    std::vector<Fan> fans;
    for (const CornerId at : around) {
        if (fans.empty() || sharp(at)) fans.push_back({v, kind, false, {}});
        fans.back().corners.push_back(at);
        if (t.is_shifted(at)) fans.back().is_controlled = true;
    }
    return fans;
}

int position(const Topology& t, CornerId c) { return c.value - t.corners(t.face(c))[0].value; }

}  // namespace patchwright::patch
