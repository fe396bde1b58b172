#include "grid/hdf5_headers.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <fstream>
#include <string_view>
#include <vector>

namespace patchwright::grid {

namespace {

constexpr std::string_view signature = "OHDR";
constexpr std::size_t piece = std::size_t(1) << 20;
constexpr std::size_t times_at = 6, times_size = 16;
constexpr std::size_t longest_prefix = 34;  // signature, version, flags, times, phases, size
constexpr std::uint8_t times_are_stored = 0x20, phases_are_stored = 0x10, order_is_stored = 0x04;
constexpr std::uint8_t attribute = 0x0c, continuation = 0x10;  // kinds of messages
constexpr int string_class = 3;
// Chunks have a few messages; larger sizes are something else that looks like one.
constexpr std::uint64_t largest_chunk = 1 << 16;

std::uint32_t little_endian(const std::uint8_t* bytes) {
    return bytes[0] | std::uint32_t(bytes[1]) << 8 | std::uint32_t(bytes[2]) << 16 |
           std::uint32_t(bytes[3]) << 24;
}

/// Bob Jenkins' lookup3 (hashlittle, 2006), started from 0.
std::uint32_t checksum(const std::uint8_t* bytes, std::size_t size) {
    std::uint32_t a = 0xdeadbeef + std::uint32_t(size), b = a, c = a;
    std::array<std::uint8_t, 12> last{};
    while (size > 12) {
        a += little_endian(bytes);
        b += little_endian(bytes + 4);
        c += little_endian(bytes + 8);
        a -= c, a ^= std::rotl(c, 4), c += b;
        b -= a, b ^= std::rotl(a, 6), a += c;
        c -= b, c ^= std::rotl(b, 8), b += a;
        a -= c, a ^= std::rotl(c, 16), c += b;
        b -= a, b ^= std::rotl(a, 19), a += c;
        c -= b, c ^= std::rotl(b, 4), b += a;
        bytes += 12;
        size -= 12;
    }
    if (size == 0) return c;
    std::copy_n(bytes, size, last.begin());
    a += little_endian(last.data());
    b += little_endian(last.data() + 4);
    c += little_endian(last.data() + 8);
    c ^= b, c -= std::rotl(b, 14);
    a ^= c, a -= std::rotl(c, 11);
    b ^= a, b -= std::rotl(a, 25);
    c ^= b, c -= std::rotl(b, 16);
    a ^= c, a -= std::rotl(c, 4);
    b ^= a, b -= std::rotl(a, 14);
    c ^= b, c -= std::rotl(b, 24);
    return c;
}

using Bytes = std::vector<std::uint8_t>;

std::uint64_t number(const Bytes& bytes, std::size_t at, std::size_t size) {
    std::uint64_t value = 0;
    for (std::size_t k = size; k-- > 0;) value = value << 8 | bytes[at + k];
    return value;
}

/// Bytes of the file; empty when it ends before.
Bytes read(std::fstream& stream, std::uint64_t at, std::size_t size) {
    Bytes bytes(size);
    stream.clear();
    stream.seekg(std::streamoff(at));
    stream.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(size));
    if (!stream) bytes.clear();
    stream.clear();
    return bytes;
}

bool is_whole(const Bytes& chunk) {
    const std::size_t end = chunk.size() - 4;
    return checksum(chunk.data(), end) == little_endian(chunk.data() + end);
}

void write(std::fstream& stream, std::uint64_t at, Bytes& chunk) {
    const std::size_t end = chunk.size() - 4;
    const std::uint32_t sum = checksum(chunk.data(), end);
    for (std::size_t k = 0; k < 4; ++k) chunk[end + k] = std::uint8_t(sum >> (8 * k));
    stream.seekp(std::streamoff(at));
    stream.write(reinterpret_cast<const char*>(chunk.data()), std::streamsize(chunk.size()));
}

/// What lies behind the end of the string that an attribute holds.
void clear_string(Bytes& chunk, std::size_t at, std::size_t size) {
    if (size < 9 || chunk[at] != 3) return;
    const std::size_t type = at + 9 + number(chunk, at + 2, 2);
    const std::size_t data = type + number(chunk, at + 4, 2) + number(chunk, at + 6, 2);
    if (type + 8 > at + size || (chunk[type] & 15) != string_class) return;
    const std::size_t end = std::min(at + size, data + number(chunk, type + 4, 4));
    if (data >= end) return;
    const auto first = chunk.begin() + std::ptrdiff_t(data),
               last = chunk.begin() + std::ptrdiff_t(end);
    std::fill(std::find(first, last, 0), last, std::uint8_t(0));
}

struct Range {
    std::uint64_t at = 0, size = 0;
};

/// Cleans the messages of a chunk.
/// @return where further chunks of the header are
std::vector<Range> clear_messages(Bytes& chunk, std::size_t begin, std::size_t prefix) {
    std::vector<Range> more;
    const std::size_t end = chunk.size() - 4;
    for (std::size_t at = begin; at + prefix <= end;) {
        const std::uint8_t kind = chunk[at];
        const std::size_t size = number(chunk, at + 1, 2);
        at += prefix;
        if (at + size > end) break;
        if (kind == attribute) clear_string(chunk, at, size);
        if (kind == continuation && size >= 16) {
            more.push_back({number(chunk, at, 8), number(chunk, at + 8, 8)});
        }
        at += size;
    }
    return more;
}

/// Cleans the header that begins here, if it is one.
bool clear_header(std::fstream& stream, std::uint64_t at) {
    const Bytes start = read(stream, at, longest_prefix);
    if (start.empty() || start[4] != 2) return false;
    const std::uint8_t flags = start[5];
    const bool has_times = (flags & times_are_stored) != 0;
    const std::size_t size_at =
        times_at + (has_times ? times_size : 0) + ((flags & phases_are_stored) != 0 ? 4 : 0);
    const std::size_t begin = size_at + (std::size_t(1) << (flags & 3));
    const std::uint64_t messages = number(start, size_at, begin - size_at);
    if (messages > largest_chunk) return false;
    Bytes header = read(stream, at, begin + messages + 4);
    if (header.empty() || !is_whole(header)) return false;
    if (has_times) std::fill_n(header.begin() + times_at, times_size, std::uint8_t(0));
    const std::size_t prefix = (flags & order_is_stored) != 0 ? 6 : 4;
    std::vector<Range> open = clear_messages(header, begin, prefix);
    write(stream, at, header);
    while (!open.empty()) {
        const Range range = open.back();
        open.pop_back();
        if (range.size < 8 || range.size > largest_chunk) continue;
        Bytes chunk = read(stream, range.at, range.size);
        if (chunk.empty() || !is_whole(chunk)) continue;
        const std::vector<Range> more = clear_messages(chunk, 4, prefix);
        open.insert(open.end(), more.begin(), more.end());
        write(stream, range.at, chunk);
    }
    return true;
}

}  // namespace

int make_reproducible(const std::filesystem::path& file) {
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    int changed = 0;
    std::vector<char> bytes(piece + signature.size() - 1);
    for (std::uint64_t begin = 0; stream; begin += piece) {
        stream.clear();
        stream.seekg(std::streamoff(begin));
        stream.read(bytes.data(), std::streamsize(bytes.size()));
        const auto count = std::size_t(stream.gcount());
        const bool is_last = count < bytes.size();
        const std::string_view text(bytes.data(), count);
        for (std::size_t k = text.find(signature); k != text.npos;
             k = text.find(signature, k + 1)) {
            if (clear_header(stream, begin + k)) ++changed;
        }
        stream.clear();
        if (is_last) break;
    }
    stream.flush();
    if (!stream) throw base::OutputError(fmt::format("{}: cannot be changed", file.string()));
    return changed;
}

}  // namespace patchwright::grid
