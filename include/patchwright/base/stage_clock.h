// How long the stages of a run take.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::base {

/// Seconds by stage, in the order of their first end; a stage that runs again adds up.
class StageClock {
  public:
    /// Ends the stage that ran since the last end, or since the start, under this name.
    /// @return its seconds
    double end(const std::string& stage);
    /// Adds seconds that another clock has measured and starts the next stage now.
    void add(const std::string& stage, double seconds);

    [[nodiscard]] const std::vector<std::pair<std::string, double>>& seconds() const {
        return seconds_;
    }

  private:
    std::vector<std::pair<std::string, double>> seconds_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace patchwright::base
#pragma GCC visibility pop
