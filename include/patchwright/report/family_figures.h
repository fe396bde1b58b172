// What fitting one cage to many designs gave.
#pragma once

#include <optional>
#include <string>
#include <vector>

#pragma GCC visibility push(default)
namespace patchwright::report {

/// Lengths are millimetres; the writers convert.
struct FamilyFigures {
    struct Member {
        std::string file;
        bool met = false;
        std::string sentence;  ///< of its verdict
        double tolerance = 0.0;
        std::optional<double> distance;  ///< fit::FitLevel::largest; none: there is no result
        double seconds = 0.0;            ///< of one thread
        std::vector<double> weights;     ///< one a mode; see fit::Modes
        /// Largest distance of a control point from where mean and modes put it.
        std::optional<double> off_modes;
    };
    struct Mode {
        double deviation = 0.0;  ///< standard deviation of the members' weights
        double share = 0.0;      ///< of the variance, in this mode and those before
    };
    std::vector<Member> members;
    std::vector<Mode> modes;
};

}  // namespace patchwright::report
#pragma GCC visibility pop
