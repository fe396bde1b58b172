// The data exchange part of the kernel keeps process-wide state; this keeps it in bounds.
#pragma once

#include <Message_SequenceOfPrinters.hxx>
#include <XSAlgo_AlgoContainer.hxx>

#include <mutex>
#include <streambuf>
#include <string>
#include <vector>

namespace patchwright::occ {

/// While it lives, this thread alone uses the kernel's readers and writers, the kernel prints
/// nothing (std::cout is mute), and parameters set through it hold; all is restored at the end. The
/// kernel's internal length unit is the millimetre meanwhile.
class ExchangeSession {
  public:
    ExchangeSession();
    ~ExchangeSession();
    ExchangeSession(const ExchangeSession&) = delete;
    ExchangeSession& operator=(const ExchangeSession&) = delete;

    /// @throw InvalidArgument when the kernel does not know the parameter or refuses the value
    void set(const std::string& parameter, const std::string& value);
    void set(const std::string& parameter, int value);
    /// What is read stays as it is translated: the kernel's fixes (ShapeFix) are left out, which
    /// take time in proportion to the square of the edges of a face.
    void leave_shapes();

  private:
    struct Saved {
        std::string parameter, value;
    };
    void save(const std::string& parameter);

    std::unique_lock<std::mutex> lock_;
    struct MutedOutput {
        MutedOutput();
        ~MutedOutput();
        std::streambuf* buffer;
        Message_SequenceOfPrinters printers;
    } muted_;
    std::vector<Saved> saved_;
    Handle(XSAlgo_AlgoContainer) algorithms_;  ///< the kernel's
};

}  // namespace patchwright::occ
