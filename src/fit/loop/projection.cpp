#include "fit/loop/projection.h"

#include <algorithm>

namespace patchwright::fit {

namespace {

// Where less than this share of a face's area in the given cage is left, it is about to fold.
constexpr double thin_share = 0.1;
// Weight of samples whose foot point is not to be believed.
constexpr double least_trust = 0.1;

}  // namespace

bool Projection::is_thin(Eigen::Index i) const { return extent[i] < thin_share; }

Projection finished(Projection p) {
    for (Eigen::Index i = 0; i < p.limit.rows(); ++i)
        p.distances.add((p.limit.row(i) - p.target.row(i)).norm());
    return p;
}

double trust(const Projection& p, const Projection* last, Eigen::Index row, double cosine,
             double tolerance_mm) {
    const double agreement = std::clamp(2.0 * cosine, least_trust, 1.0);
    if (last == nullptr) return agreement;
    const double moved = (p.limit.row(row) - last->limit.row(row)).norm();
    const double jump = (p.target.row(row) - last->target.row(row)).norm();
    const double usual = 3.0 * moved + tolerance_mm;
    return agreement * std::clamp(usual / std::max(jump, 1e-300), least_trust, 1.0);
}

bool hold_folds(FormStiffness& form, const std::vector<std::int32_t>& rows, const Projection& now,
                const Projection& next, double slack_mm,
                const std::function<bool(std::int32_t first, std::int32_t end)>& may_hold) {
    std::int64_t more = 0;
    const double miss = now.distances.rms() / slack_mm;
    for (std::size_t site = 0; site + 1 < rows.size(); ++site) {
        bool thin = false;
        for (auto i = rows[site]; i < rows[site + 1]; ++i) {
            thin = thin || next.is_thin(i);
            if (next.folds(i) == now.folds(i)) continue;
            // Where only the foot point has changed sides, nothing has folded.
            if (next.sense.row(i).dot(now.sense.row(i)) < 0.0) more += next.folds(i) ? 1 : -1;
        }
        if (thin && may_hold(rows[site], rows[site + 1])) form.hold(site, miss);
    }
    return more > 0;
}

}  // namespace patchwright::fit
