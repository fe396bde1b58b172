#include <patchwright/base/budget.h>
#include <patchwright/base/error.h>

namespace patchwright::base {

Budget::Budget(std::optional<Seconds> limit, Progress on_progress)
    : limit_(limit), on_progress_(std::move(on_progress)) {}

Budget Budget::with(Progress on_progress) const {
    Budget other = *this;
    other.on_progress_ = std::move(on_progress);
    return other;
}

bool Budget::is_used_up() const {
    return limit_ && std::chrono::steady_clock::now() - start_ >= *limit_;
}

Progress Budget::limited() const {
    return [budget = *this](std::string_view stage, double fraction) {
        if (budget.is_used_up()) throw TimeLimitReached();
        return !budget.on_progress_ || budget.on_progress_(stage, fraction);
    };
}

}  // namespace patchwright::base
