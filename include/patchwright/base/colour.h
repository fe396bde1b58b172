// A colour.
#pragma once

#pragma GCC visibility push(default)
namespace patchwright::base {

/// sRGB, 0 to 1.
struct Colour {
    double red = 0.5, green = 0.5, blue = 0.5;
    bool operator==(const Colour&) const = default;
};

}  // namespace patchwright::base
#pragma GCC visibility pop
