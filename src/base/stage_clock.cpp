#include <patchwright/base/stage_clock.h>

#include <algorithm>

namespace patchwright::base {

double StageClock::end(const std::string& stage) {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
    add(stage, passed.count());
    return passed.count();
}

void StageClock::add(const std::string& stage, double seconds) {
    const auto known = std::find_if(seconds_.begin(), seconds_.end(),
                                    [&](const auto& one) { return one.first == stage; });
    if (known == seconds_.end())
        seconds_.emplace_back(stage, seconds);
    else
        known->second += seconds;
    start_ = std::chrono::steady_clock::now();
}

}  // namespace patchwright::base
