// Typed indices: a vertex number cannot be passed where a face number is expected.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>

#pragma GCC visibility push(default)
namespace patchwright::base {

/// An index into one kind of element; a default-constructed one names nothing.
template <class Tag>
struct Id {
    std::int32_t value = -1;

    constexpr Id() = default;
    constexpr explicit Id(std::int32_t number) : value(number) {}
    [[nodiscard]] constexpr bool valid() const { return value >= 0; }
    [[nodiscard]] constexpr std::size_t index() const { return static_cast<std::size_t>(value); }
    constexpr auto operator<=>(const Id&) const = default;
};

/// The ids first, first + 1, ..., last - 1, for range-based loops.
template <class IdType>
class IdRange {
  public:
    struct Iterator {
        IdType id;
        constexpr IdType operator*() const { return id; }
        constexpr Iterator& operator++() {
            ++id.value;
            return *this;
        }
        constexpr bool operator!=(const Iterator& other) const { return id != other.id; }
    };

    constexpr IdRange(std::int32_t first, std::int32_t last) : first_(first), last_(last) {}
    [[nodiscard]] constexpr Iterator begin() const { return {IdType{first_}}; }
    [[nodiscard]] constexpr Iterator end() const { return {IdType{last_}}; }
    [[nodiscard]] constexpr int size() const { return last_ - first_; }
    [[nodiscard]] constexpr IdType operator[](int i) const { return IdType{first_ + i}; }

  private:
    std::int32_t first_;
    std::int32_t last_;
};

}  // namespace patchwright::base
#pragma GCC visibility pop
