#include <patchwright/base/error.h>
#include <patchwright/fit/model_change.h>

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

namespace patchwright::fit {

namespace {

using geom::ModelSurface;
using geom::Vec3;

struct Range {
    Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Array2d high = -low;
};

/// Of the parameters, one a face.
std::vector<Range> ranges_of(const ModelSurface& model, std::size_t faces) {
    std::vector<Range> ranges(faces);
    for (const geom::SurfacePiece& piece : model.pieces()) {
        Range& range = ranges.at(std::size_t(piece.face));
        for (const Eigen::Vector2d& uv : piece.uv) {
            range.low = range.low.min(uv.array());
            range.high = range.high.max(uv.array());
        }
    }
    return ranges;
}

/// Deflection of the triangles that tell which faces are beside each other.
constexpr double deflection_rel = 1e-2;

/// Pairs of faces with a common side.
std::set<std::pair<int, int>> neighbours(const ModelSurface& model) {
    const geom::SurfaceMesh mesh = model.surface_mesh(deflection_rel * model.bounds().diagonal());
    std::map<std::pair<int, int>, int> face_of_side;
    std::set<std::pair<int, int>> pairs;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const auto side = std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
            const auto [other, first] = face_of_side.emplace(side, mesh.faces[t]);
            if (!first && other->second != mesh.faces[t])
                pairs.insert(std::minmax(other->second, mesh.faces[t]));
        }
    return pairs;
}

/// The later face of each earlier one: by names where each names one face in both models.
std::vector<int> later_faces(const std::vector<std::string>& earlier,
                             const std::vector<std::string>& later) {
    std::map<std::string, int> numbers;
    for (std::size_t i = 0; i < later.size(); ++i) numbers.emplace(later[i], int(i));
    std::vector<int> faces;
    for (const std::string& name : earlier) {
        const auto found = numbers.find(name);
        if (found != numbers.end() && !name.empty()) faces.push_back(found->second);
    }
    const std::set<int> different(faces.begin(), faces.end());
    if (numbers.size() == later.size() && different.size() == earlier.size()) return faces;
    faces.resize(earlier.size());
    std::iota(faces.begin(), faces.end(), 0);
    return faces;
}

}  // namespace

struct ModelChange::Faces {
    std::vector<int> later;  ///< of each face of the earlier model
    std::vector<Range> earlier_ranges, later_ranges;
};

ModelChange::ModelChange(std::shared_ptr<const ModelSurface> earlier,
                         std::shared_ptr<const ModelSurface> later, const std::string& name)
    : earlier_(std::move(earlier)), later_(std::move(later)) {
    const auto refuse = [&](const std::string& why) {
        throw base::InputError(
            fmt::format("{}: {}: how the model has changed cannot be told from "
                        "it; leave it out (--from)",
                        name, why));
    };
    if (!earlier_->has_cad_faces() || !later_->has_cad_faces())
        refuse("triangles do not tell which faces belong together");
    const auto names = earlier_->face_names(), later_names = later_->face_names();
    if (names.size() != later_names.size())
        refuse(
            fmt::format("it has {} faces, and the new model {}", names.size(), later_names.size()));
    std::vector<int> faces = later_faces(names, later_names);
    std::set<std::pair<int, int>> expected;
    for (const auto& [a, b] : neighbours(*earlier_))
        expected.insert(std::minmax(faces[std::size_t(a)], faces[std::size_t(b)]));
    if (expected != neighbours(*later_))
        refuse("its faces are beside others than those of the new model");
    faces_ = std::make_unique<const Faces>(Faces{
        std::move(faces), ranges_of(*earlier_, names.size()), ranges_of(*later_, names.size())});
}

ModelChange::~ModelChange() = default;

Vec3 ModelChange::operator()(const Vec3& point) const {
    const geom::FootPoint foot = earlier_->foot_point(point);
    const auto face = std::size_t(foot.face);
    const auto later = std::size_t(faces_->later.at(face));
    const Range &from = faces_->earlier_ranges[face], &to = faces_->later_ranges[later];
    const Eigen::Array2d share =
        ((foot.uv.array() - from.low) / (from.high - from.low)).max(0.0).min(1.0);
    const Eigen::Vector2d uv = (to.low + share * (to.high - to.low)).matrix();
    return later_->point_on_face(int(later), uv).point;
}

}  // namespace patchwright::fit
