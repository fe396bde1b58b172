// How the loops of this room ask whether they are to go on.
#pragma once

#include <patchwright/base/progress.h>

namespace patchwright::cage {

/// Called in every loop that may take long: at least once for each nearest point that is asked for,
/// on the thread that called make_cage().
class Poll {
  public:
    Poll() = default;
    explicit Poll(base::Progress progress) : progress_(std::move(progress)) {}

    /// @throw what the callback throws, and Cancelled when it returns false
    void operator()() { base::report_progress(progress_, "cage", fraction_); }
    /// The same with another fraction done, 0 to 1.
    void reached(double fraction) {
        fraction_ = fraction;
        (*this)();
    }

  private:
    base::Progress progress_;
    double fraction_ = 0.0;
};

}  // namespace patchwright::cage
