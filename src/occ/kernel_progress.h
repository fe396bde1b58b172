// Cancellation for long calls of the kernel.
#pragma once

#include <patchwright/base/error.h>
#include <patchwright/base/progress.h>

#include <Message_ProgressIndicator.hxx>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <utility>

namespace patchwright::occ {

/// Polls a progress callback from within the kernel, on the thread that made this only.
class KernelProgress final : public Message_ProgressIndicator {
  public:
    KernelProgress(const base::Progress& progress, std::string stage, double fraction)
        : progress_(progress), stage_(std::move(stage)), fraction_(fraction) {}

    /// @throw Cancelled when the callback stopped the call, whose result is incomplete then
    void check() const {
        if (stopped_) throw base::Cancelled();
    }

    Standard_Boolean UserBreak() override {
        const auto now = std::chrono::steady_clock::now();
        if (stopped_ || !progress_ || std::this_thread::get_id() != caller_ ||
            now - last_poll_ < poll_interval)
            return stopped_;
        last_poll_ = now;
        stopped_ = !progress_(stage_, fraction_);
        return stopped_;
    }

  protected:
    void Show(const Message_ProgressScope&, const Standard_Boolean) override {}

  private:
    /// The kernel asks up to once per face and edge; a person notices nothing shorter.
    static constexpr std::chrono::milliseconds poll_interval{50};

    base::Progress progress_;
    std::string stage_;
    double fraction_;
    std::thread::id caller_ = std::this_thread::get_id();
    std::chrono::steady_clock::time_point last_poll_;
    std::atomic<bool> stopped_ = false;
};

}  // namespace patchwright::occ
