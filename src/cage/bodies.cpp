#include <patchwright/base/parallel.h>
#include <patchwright/cage/bodies.h>

#include <algorithm>

namespace patchwright::cage {

namespace {

// Of the diagonal. Vertices of a cage leave a curved surface by some of this; bodies that overlap
// are farther from one another over most of a part.
constexpr double farther_than_whole_rel = 2e-3;

bool lies_on(const mesh::Cage& part, const geom::ModelSurface& body,
             const std::vector<double>& distance_from_whole, double allowed) {
    std::vector<char> near(distance_from_whole.size());
    base::parallel_for(near.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const geom::Vec3 vertex = part.points.row(Eigen::Index(i)).transpose();
            near[i] = body.foot_point(vertex).distance < distance_from_whole[i] + allowed;
        }
    });
    return std::find(near.begin(), near.end(), 0) == near.end();
}

}  // namespace

std::vector<const geom::ReferenceSurface*> references_of_parts(
    const std::vector<mesh::Cage>& parts, const std::vector<geom::BodyReference>& bodies,
    const geom::ModelSurface& whole) {
    const double allowed = farther_than_whole_rel * whole.bounds().diagonal();
    std::vector<int> body_of_face;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        for (const int f : bodies[b].faces) {
            body_of_face.resize(std::max(body_of_face.size(), std::size_t(f) + 1), -1);
            body_of_face[std::size_t(f)] = int(b);
        }
    }
    std::vector<const geom::ReferenceSurface*> result;
    for (const mesh::Cage& part : parts) {
        std::vector<int> votes(bodies.size(), 0);
        std::vector<double> distance;
        for (Eigen::Index i = 0; i < part.points.rows(); ++i) {
            const geom::FootPoint foot = whole.foot_point(part.points.row(i).transpose());
            const auto face = std::size_t(foot.face);
            const int body = face < body_of_face.size() ? body_of_face[face] : -1;
            if (body >= 0) ++votes[std::size_t(body)];
            distance.push_back(foot.distance);
        }
        result.push_back(&whole);
        if (votes.empty()) continue;
        const auto most = std::max_element(votes.begin(), votes.end()) - votes.begin();
        const geom::ModelSurface& body = *bodies[std::size_t(most)].surface;
        if (lies_on(part, body, distance, allowed)) result.back() = &body;
    }
    return result;
}

}  // namespace patchwright::cage
