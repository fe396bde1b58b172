#include "vtu_bytes.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>

namespace patchwright::cli {

namespace {

bool is_space(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

/// Value of a letter of base64, or -1.
int base64_value(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

class VtuHeaders {
  public:
    VtuHeaders(VtuBytes& from, const VtuEncoding& encoding) : from_(from), encoding_(encoding) {}

    std::uint64_t next() {
        std::uint8_t bytes[8];
        from_.read(bytes, encoding_.header_bytes);
        return vtu_number(bytes, encoding_.header_bytes, encoding_.is_big_endian);
    }

  private:
    VtuBytes& from_;
    const VtuEncoding& encoding_;
};

void require_length(double found, double expected) {
    if (found != expected)
        throw VtuDataError(
            fmt::format("has {:.0f} bytes of data where {:.0f} are expected", found, expected));
}

void require_held(double wanted, double most) {
    if (wanted > most)
        throw VtuDataError(fmt::format(
            "ends early: {:.0f} bytes are expected, and at most {:.0f} are there", wanted, most));
}

std::vector<std::uint8_t> inflated(VtuBytes& from, const VtuEncoding& encoding, double expected) {
    VtuHeaders header(from, encoding);
    const std::uint64_t count = header.next(), size = header.next(), last = header.next();
    require_held(double(count) * double(encoding.header_bytes), double(from.bound()));
    require_length(
        count == 0 ? 0.0 : double(size) * double(count - (last == 0 ? 0 : 1)) + double(last),
        expected);
    require_held(expected, most_inflation * double(from.bound()));
    if (last > size) throw VtuDataError(fmt::format("has a last block of {} bytes", last));
    std::vector<std::uint64_t> packed(count);
    double sum = 0.0;
    for (std::uint64_t& bytes : packed) sum += double(bytes = header.next());
    require_held(sum, double(from.bound()));

    std::vector<std::uint8_t> result(static_cast<std::size_t>(expected)), block;
    std::size_t begin = 0;
    for (std::size_t b = 0; b < packed.size(); ++b) {
        block.resize(packed[b]);
        from.read(block.data(), block.size());
        const uLong wanted = b + 1 == packed.size() && last != 0 ? last : size;
        uLongf made = wanted;
        if (::uncompress(result.data() + begin, &made, block.data(), block.size()) != Z_OK ||
            made != wanted)
            throw VtuDataError(fmt::format("its compressed block {} of {} cannot be unpacked",
                                           b + 1, packed.size()));
        begin += wanted;
    }
    return result;
}

}  // namespace

char VtuBytes::next_character() {
    while (!text_.empty() && is_space(text_.front())) text_.remove_prefix(1);
    if (text_.empty()) throw VtuDataError("ends early");
    const char c = text_.front();
    text_.remove_prefix(1);
    return c;
}

void VtuBytes::decode_quartet() {
    std::uint32_t bits = 0;
    group_size_ = 3;
    for (int k = 0; k < 4; ++k) {
        const char c = next_character();
        const int value = base64_value(c);
        const bool is_padding = c == '=' && k >= 2;
        if ((value < 0 && !is_padding) || (value >= 0 && group_size_ < 3))
            throw VtuDataError(
                fmt::format("the byte {} stands where base64 is expected", int(std::uint8_t(c))));
        if (is_padding) --group_size_;
        bits = bits << 6 | static_cast<std::uint32_t>(is_padding ? 0 : value);
    }
    for (int k = 0; k < 3; ++k) group_[k] = static_cast<std::uint8_t>(bits >> (16 - 8 * k));
    held_ = group_size_;
}

void VtuBytes::read(std::uint8_t* to, std::size_t count) {
    require_held(double(count), double(bound()));
    if (!is_base64_) {
        if (count > 0) std::memcpy(to, text_.data(), count);
        text_.remove_prefix(count);
        return;
    }
    for (std::size_t done = 0; done < count; ++done, --held_) {
        if (held_ == 0) decode_quartet();
        to[done] = group_[group_size_ - held_];
    }
}

std::uint64_t vtu_number(const std::uint8_t* from, std::size_t bytes, bool is_big_endian) {
    std::uint64_t value = 0;
    for (std::size_t k = 0; k < bytes; ++k)
        value = value << 8 | from[is_big_endian ? k : bytes - 1 - k];
    return value;
}

std::vector<std::uint8_t> read_vtu_bytes(VtuBytes from, const VtuEncoding& encoding,
                                         double expected) {
    if (expected == 0.0) return {};
    if (encoding.is_compressed) return inflated(from, encoding, expected);
    const auto length = double(VtuHeaders(from, encoding).next());
    require_length(length, expected);
    require_held(length, double(from.bound()));
    std::vector<std::uint8_t> result(static_cast<std::size_t>(expected));
    from.read(result.data(), result.size());
    return result;
}

}  // namespace patchwright::cli
