// The errors patchwright throws. Every message is one line: file, element, value, what to do.
#pragma once

#include <stdexcept>
#include <string>

#pragma GCC visibility push(default)
namespace patchwright::base {

/// Base of all errors thrown on purpose. Anything else that escapes is a bug.
class Error : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// A caller broke a documented precondition. Where the caller is this project, a bug.
class InvalidArgument : public Error {
  public:
    using Error::Error;
};

/// What a user asked for is impossible: a value of an option is out of range, or does not suit the
/// model. The message names the option's value.
class UsageError : public InvalidArgument {
  public:
    using InvalidArgument::InvalidArgument;
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
#pragma GCC visibility pop
