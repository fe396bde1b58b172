// The errors patchwright throws. Every message is one line: file, element, value, what to do.
#pragma once

#include <stdexcept>
#include <string>

namespace patchwright::base {

/// Base of all errors thrown on purpose. Anything else that escapes is a bug.
class Error : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// A caller broke a documented precondition (library misuse, bad option value).
class InvalidArgument : public Error {
  public:
    using Error::Error;
};

/// A file or its content cannot be used: missing, unreadable, malformed, unsuitable.
class InputError : public Error {
  public:
    using Error::Error;
};

/// A result could not be written; the file that was there before is intact.
class OutputError : public Error {
  public:
    using Error::Error;
};

/// The time limit of a run was reached; see Budget.
class TimeLimitReached : public Error {
  public:
    TimeLimitReached() : Error("the time limit was reached") {}
};

/// The progress callback asked to stop.
class Cancelled : public Error {
  public:
    Cancelled() : Error("cancelled") {}
};

}  // namespace patchwright::base
