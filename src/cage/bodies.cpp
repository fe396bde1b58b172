#include <patchwright/base/error.h>
#include <patchwright/cage/bodies.h>

#include <algorithm>

namespace patchwright::cage {

std::vector<ModelBody> model_bodies(const occ::CadModel& model,
                                    const occ::ReferenceOptions& options) {
    std::vector<ModelBody> bodies;
    for (std::vector<int>& faces : occ::connected_faces(model)) {
        try {
            occ::CadReference reference(occ::part_of(model, faces), options);
            bodies.push_back({std::move(faces), std::move(reference)});
        } catch (const base::InputError&) {
            continue;  // no triangles, and so no part of a cage
        }
    }
    return bodies;
}

std::vector<const geom::ReferenceSurface*> references_of_parts(const std::vector<mesh::Cage>& parts,
                                                               const std::vector<ModelBody>& bodies,
                                                               const geom::ModelSurface& whole) {
    // Of the diagonal: vertices of a cage need not lie on the surface.
    constexpr double slack_rel = 2e-3;
    const double slack = slack_rel * whole.bounds().diagonal();
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
        const occ::CadReference& body = bodies[std::size_t(most)].reference;
        const auto own = body.foot_points(part.points);
        bool lies_on = true;
        for (std::size_t i = 0; i < own.size(); ++i)
            lies_on = lies_on && own[i].distance < distance[i] + slack;
        if (lies_on) result.back() = &body;
    }
    return result;
}

}  // namespace patchwright::cage
