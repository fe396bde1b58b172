// Binary data of VTK's XML files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace patchwright::cli {

/// Bytes that zlib's format packs into one at most.
inline constexpr double most_inflation = 1032.0;

/// How a file writes its data.
struct VtuEncoding {
    bool is_big_endian = false;
    std::size_t header_bytes = 4;  ///< of each number of the headers: 4 or 8
    bool is_compressed = false;    ///< by zlib
};

/// What is wrong with data; whoever knows the file and the element tells of them.
class VtuDataError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Bytes of the file, or those that text stands for in base64. Streams of base64 may follow each
/// other, each padded on its own, as headers and data do.
class VtuBytes {
  public:
    VtuBytes(std::string_view text, bool is_base64) : text_(text), is_base64_(is_base64) {}

    /// That are left at most.
    [[nodiscard]] std::size_t bound() const { return held_ + text_.size(); }
    /// @throw VtuDataError when there are not as many
    void read(std::uint8_t* to, std::size_t count);

  private:
    void decode_quartet();
    [[nodiscard]] char next_character();

    std::string_view text_;
    bool is_base64_;
    std::uint8_t group_[3] = {};  // decoded; the last held_ are left
    std::size_t held_ = 0, group_size_ = 0;
};

/// The bytes of an array.
/// @param expected  that it must have; nothing is allocated before the data could hold them
/// @throw VtuDataError when it has not, or the data are no such data
/// Source: VTK file formats (Kitware): headers of lengths, compressed data in blocks of their own.
std::vector<std::uint8_t> read_vtu_bytes(VtuBytes from, const VtuEncoding& encoding,
                                         double expected);

/// A number of `bytes` bytes in the file's order.
std::uint64_t vtu_number(const std::uint8_t* from, std::size_t bytes, bool is_big_endian);

}  // namespace patchwright::cli
