// Values as bytes, for another copy of the same program.
#pragma once

#include <patchwright/base/error.h>

#include <cstdint>
#include <istream>
#include <optional>
#include <ostream>
#include <string>
#include <type_traits>
#include <vector>

namespace patchwright::occ {

/// Structs of several fields have a function each_field(archive, struct), which both ways call.
class Packer {
  public:
    explicit Packer(std::ostream& out) : out_(out) {}

    template <class T>
    void operator()(const T& value) {
        if constexpr (std::is_trivially_copyable_v<T>)
            out_.write(reinterpret_cast<const char*>(&value), sizeof value);
        else
            each_field(*this, value);
    }
    void operator()(const std::string& text) {
        (*this)(std::uint64_t(text.size()));
        out_.write(text.data(), std::streamsize(text.size()));
    }
    template <class T>
    void operator()(const std::optional<T>& value) {
        (*this)(value.has_value());
        if (value) (*this)(*value);
    }
    template <class T>
    void operator()(const std::vector<T>& values) {
        (*this)(std::uint64_t(values.size()));
        for (const T& value : values) (*this)(value);
    }

  private:
    std::ostream& out_;
};

class Unpacker {
  public:
    explicit Unpacker(std::istream& in) : in_(in) {}

    /// @throw Error when there are no more bytes
    template <class T>
    void operator()(T& value) {
        if constexpr (std::is_trivially_copyable_v<T>)
            read(reinterpret_cast<char*>(&value), sizeof value);
        else
            each_field(*this, value);
    }
    void operator()(std::string& text) {
        text.resize(size());
        read(text.data(), text.size());
    }
    template <class T>
    void operator()(std::optional<T>& value) {
        bool given = false;
        (*this)(given);
        value.reset();
        if (given) (*this)(value.emplace());
    }
    template <class T>
    void operator()(std::vector<T>& values) {
        values.clear();
        for (auto left = size(); left > 0; --left) (*this)(values.emplace_back());
    }

  private:
    void read(char* bytes, std::size_t count) {
        in_.read(bytes, std::streamsize(count));
        if (!in_) throw base::Error("what another process has sent is cut off");
    }
    std::uint64_t size() {
        std::uint64_t count = 0;
        (*this)(count);
        return count;
    }
    std::istream& in_;
};

}  // namespace patchwright::occ
