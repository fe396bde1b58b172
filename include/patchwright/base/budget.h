// The time that a run may take, and its progress callback.
#pragma once

#include <patchwright/base/progress.h>

#include <chrono>
#include <optional>

#pragma GCC visibility push(default)
namespace patchwright::base {

/// Counts from its construction. Loops do not see it: they call the progress callback that it
/// hands out, which also ends them when the time is up.
class Budget {
  public:
    using Seconds = std::chrono::duration<double>;

    /// @param limit  none: the run may take as long as it takes
    /// @param on_progress  called from the thread that calls the library; false cancels the run
    explicit Budget(std::optional<Seconds> limit = std::nullopt, Progress on_progress = {});

    /// The same limit, from the same start, with another callback.
    [[nodiscard]] Budget with(Progress on_progress) const;

    /// For work that may be cut short.
    /// @throw TimeLimitReached from the callback once the limit is reached
    [[nodiscard]] Progress limited() const;
    /// For what finishes a result that exists: checking and writing it.
    [[nodiscard]] Progress unlimited() const { return on_progress_; }

    [[nodiscard]] bool is_used_up() const;
    [[nodiscard]] std::optional<Seconds> limit() const { return limit_; }

  private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    std::optional<Seconds> limit_;
    Progress on_progress_;
};

}  // namespace patchwright::base
#pragma GCC visibility pop
