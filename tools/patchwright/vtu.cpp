#include "vtu.h"

#include "files.h"
#include "vtu_elements.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <optional>

namespace patchwright::cli {

namespace {

/// A type of VTK's arrays.
struct NumberType {
    const char* name;
    std::size_t bytes;
    double (*number)(std::uint64_t bits);
};

template <class Signed>
double signed_number(std::uint64_t bits) {
    return static_cast<double>(static_cast<Signed>(bits));
}

constexpr NumberType number_types[] = {
    {"Float32", 4,
     [](std::uint64_t bits) {
         return double(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
     }},
    {"Float64", 8, [](std::uint64_t bits) { return std::bit_cast<double>(bits); }},
    {"Int8", 1, signed_number<std::int8_t>},
    {"UInt8", 1, signed_number<std::uint8_t>},
    {"Int16", 2, signed_number<std::int16_t>},
    {"UInt16", 2, signed_number<std::uint16_t>},
    {"Int32", 4, signed_number<std::int32_t>},
    {"UInt32", 4, signed_number<std::uint32_t>},
    {"Int64", 8, signed_number<std::int64_t>},
    {"UInt64", 8, signed_number<std::uint64_t>}};

class VtuReader {
  public:
    VtuReader(const std::string& file, const VtuElements& elements, std::size_t file_bytes)
        : file_(file), elements_(elements), file_bytes_(file_bytes) {}

    VtuValues read(const std::string& wanted, const std::string& usual) const {
        if (elements_.pieces.empty()) throw base::InputError(file_ + ": has no <Piece>: no points");
        const VtuArray& array = choose(wanted, usual);
        VtuValues result{array.name(), array.section == "CellData", {}, {}};
        std::vector<double> points;
        for (const VtuPiece& piece : elements_.pieces) {
            const std::size_t of_points = count(piece.points, "NumberOfPoints");
            const std::vector<double> at = numbers(find(piece, "Points", ""), of_points, 3);
            const std::size_t of_values =
                result.of_cells ? count(piece.cells, "NumberOfCells") : of_points;
            const std::vector<double> values =
                numbers(find(piece, array.section, result.array), of_values, 1);
            result.values.insert(result.values.end(), values.begin(), values.end());
            const std::vector<double> middles =
                result.of_cells ? cell_middles(piece, at, of_values) : std::vector<double>{};
            const std::vector<double>& places = result.of_cells ? middles : at;
            points.insert(points.end(), places.begin(), places.end());
        }
        if (result.values.empty())
            throw base::InputError(
                fmt::format("{}: array '{}' has no values", file_, result.array));
        result.at =
            Eigen::Map<const geom::Points>(points.data(), Eigen::Index(result.values.size()), 3);
        return result;
    }

  private:
    [[noreturn]] void refuse(const VtuArray& array, const std::string& what) const {
        const std::string name = array.name().empty() ? array.section : array.name();
        throw base::InputError(
            fmt::format("{}, line {}: array '{}' {}", file_, array.line, name, what));
    }

    static bool is_scalar(const VtuArray& array) {
        const std::string components = array.attribute("NumberOfComponents");
        return (components.empty() || components == "1") && array.attribute("type") != "String";
    }

    /// Of the first piece; others have the same arrays.
    [[nodiscard]] const VtuArray& choose(const std::string& wanted,
                                         const std::string& usual) const {
        const std::string& name = wanted.empty() ? usual : wanted;
        std::vector<const VtuArray*> scalars;
        std::vector<std::string> names;
        for (const char* section : {"PointData", "CellData"}) {
            for (const VtuArray& array : elements_.pieces.front().arrays) {
                if (array.section != section) continue;
                if (!name.empty() && array.name() == name) return array;
                if (!is_scalar(array)) continue;
                scalars.push_back(&array);
                names.push_back(fmt::format("'{}'", array.name()));
            }
        }
        if (wanted.empty() && scalars.size() == 1) return *scalars.front();
        const std::string there =
            names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
        if (name.empty())
            throw base::InputError(fmt::format(
                "{}: its arrays of one number a point or cell are: {}; name one", file_, there));
        throw base::InputError(
            fmt::format("{}: has no array '{}'; those of one number a point or cell are: {}", file_,
                        name, there));
    }

    /// @param name  empty: the section's only one
    [[nodiscard]] const VtuArray& find(const VtuPiece& piece, const std::string& section,
                                       const std::string& name) const {
        for (const VtuArray& array : piece.arrays)
            if (array.section == section && (name.empty() || array.name() == name)) return array;
        throw base::InputError(fmt::format("{}: piece {} has no array '{}' in <{}>", file_,
                                           &piece - elements_.pieces.data() + 1, name, section));
    }

    [[nodiscard]] static std::optional<std::uint64_t> whole(std::string_view text) {
        std::uint64_t value = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
        return value;
    }
    [[nodiscard]] std::size_t count(const std::string& text, const char* name) const {
        const auto value = whole(text);
        // Each has a byte, however well it is packed.
        if (!value || double(*value) > most_inflation * double(file_bytes_))
            throw base::InputError(fmt::format(
                "{}: <Piece {}=\"{}\">: no number, or more than the file's {} bytes can hold",
                file_, name, text, file_bytes_));
        return *value;
    }

    [[nodiscard]] std::vector<double> numbers(const VtuArray& array, std::size_t rows,
                                              std::size_t components) const {
        const std::string given = array.attribute("NumberOfComponents");
        if (whole(given.empty() ? "1" : given) != components)
            refuse(array, fmt::format("has {} components; {} expected", given.empty() ? "1" : given,
                                      components));
        const std::string type_name = array.attribute("type");
        const auto* type =
            std::find_if(std::begin(number_types), std::end(number_types),
                         [&](const NumberType& known) { return known.name == type_name; });
        if (type == std::end(number_types))
            refuse(array, fmt::format("has the type '{}', which is none of numbers", type_name));
        const std::size_t wanted = rows * components;
        std::vector<double> values;
        try {
            values = array.attribute("format") == "ascii" ? as_text(array, wanted)
                                                          : as_bytes(array, wanted, *type);
        } catch (const VtuDataError& error) {
            refuse(array, error.what());
        }
        for (std::size_t k = 0; k < values.size(); ++k)
            if (!(std::abs(values[k]) <= geom::largest_coordinate))
                refuse(array, fmt::format("has value {} of {}; finite numbers up to {:g} are "
                                          "expected",
                                          k + 1, values[k], geom::largest_coordinate));
        return values;
    }

    [[nodiscard]] std::vector<double> as_bytes(const VtuArray& array, std::size_t wanted,
                                               const NumberType& type) const {
        const std::string format = array.attribute("format");
        VtuBytes from(array.text, true);
        if (format == "appended") {
            const auto offset = whole(array.attribute("offset"));
            if (!offset || *offset > elements_.appended.size())
                refuse(array, fmt::format("has the offset '{}' of {} bytes appended",
                                          array.attribute("offset"), elements_.appended.size()));
            from = VtuBytes(elements_.appended.substr(*offset), elements_.has_appended_base64);
        } else if (format != "binary") {
            refuse(array, fmt::format("has the format '{}'; ascii, binary or appended", format));
        }
        const std::vector<std::uint8_t> bytes =
            read_vtu_bytes(from, elements_.encoding, double(wanted) * double(type.bytes));
        std::vector<double> values(wanted);
        for (std::size_t k = 0; k < wanted; ++k)
            values[k] = type.number(vtu_number(bytes.data() + k * type.bytes, type.bytes,
                                               elements_.encoding.is_big_endian));
        return values;
    }

    [[nodiscard]] static std::vector<double> as_text(const VtuArray& array, std::size_t wanted) {
        constexpr std::string_view spaces = " \t\r\n";
        std::vector<double> values;
        std::string_view rest = array.text;
        for (;;) {
            rest.remove_prefix(std::min(rest.find_first_not_of(spaces), rest.size()));
            if (rest.empty()) break;
            const std::string_view word = rest.substr(0, rest.find_first_of(spaces));
            rest.remove_prefix(word.size());
            double value = 0.0;
            const auto [end, error] =
                std::from_chars(word.data(), word.data() + word.size(), value);
            if (error != std::errc{} || end != word.data() + word.size())
                throw VtuDataError(fmt::format("has '{}' where a number is expected", word));
            values.push_back(value);
        }
        if (values.size() != wanted)
            throw VtuDataError(
                fmt::format("has {} numbers where {} are expected", values.size(), wanted));
        return values;
    }

    /// Means of the points of each cell.
    [[nodiscard]] std::vector<double> cell_middles(const VtuPiece& piece,
                                                   const std::vector<double>& points,
                                                   std::size_t cells) const {
        const VtuArray &ends_array = find(piece, "Cells", "offsets"),
                       &corners_array = find(piece, "Cells", "connectivity");
        const std::vector<double> ends = numbers(ends_array, cells, 1);
        double last = 0.0;
        for (const double end : ends) {
            if (!(end > last) || end != std::floor(end))
                refuse(ends_array, fmt::format("has {} after {}; cells have points", end, last));
            last = end;
        }
        const std::vector<double> corners =
            numbers(corners_array, count(fmt::format("{:.0f}", last), "offsets"), 1);
        std::vector<double> middles(3 * cells, 0.0);
        std::size_t k = 0;
        for (std::size_t cell = 0; cell < cells; ++cell) {
            const auto begin = k, end = static_cast<std::size_t>(ends[cell]);
            for (; k < end; ++k) {
                const double point = corners[k];
                if (!(point >= 0.0 && 3.0 * point < double(points.size())))
                    refuse(corners_array,
                           fmt::format("names point {} of {}", point, points.size() / 3));
                for (std::size_t c = 0; c < 3; ++c)
                    middles[3 * cell + c] += points[3 * static_cast<std::size_t>(point) + c];
            }
            for (std::size_t c = 0; c < 3; ++c) middles[3 * cell + c] /= double(end - begin);
        }
        return middles;
    }

    const std::string& file_;
    const VtuElements& elements_;
    std::size_t file_bytes_;
};

}  // namespace

VtuValues read_vtu(const std::string& file, const std::string& array, const std::string& usual) {
    const std::string content = file_content(file);
    return VtuReader(file, parse_vtu(file, content), content.size()).read(array, usual);
}

}  // namespace patchwright::cli
