#include "table.h"

#include "files.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <string_view>

namespace patchwright::cli {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

class Reader {
  public:
    Reader(Table& table, std::size_t least, std::size_t most)
        : table_(table), least_(least), most_(most) {}

    void add_line(std::string_view line) {
        ++number_;
        line = line.substr(0, line.find('#'));
        skip_blanks(line);
        if (line.empty()) return;
        if (table_.lines.empty() && !named_ && is_name(line)) {
            named_ = true;
            return;
        }
        std::size_t count = 0;
        for (bool another = true; another; ++count) another = take_number(line);
        const bool first = table_.lines.empty();
        if (first ? count < least_ || count > most_ : count != table_.columns) refuse_count(count);
        table_.columns = count;
        table_.lines.push_back(number_);
    }

  private:
    static void skip_blanks(std::string_view& line) {
        while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
    }

    /// "nan" and "inf" are none: they must not go unseen.
    static bool is_name(std::string_view line) {
        double ignored = 0.0;
        return std::isalpha(static_cast<unsigned char>(line.front())) != 0 &&
               std::from_chars(line.data(), line.data() + line.size(), ignored).ec != std::errc{};
    }

    /// Moves one number from the line to the table.
    /// @return  whether another one must follow
    bool take_number(std::string_view& line) {
        if (line.starts_with('+')) line.remove_prefix(1);
        double value = 0.0;
        const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
        const auto length = static_cast<std::size_t>(end - line.data());
        const bool ends = length == line.size() || is_blank(line[length]) || line[length] == ',';
        if (error != std::errc{} || !ends || !std::isfinite(value)) {
            const std::string_view word = line.substr(0, line.find_first_of(", \t\r"));
            throw base::InputError(
                fmt::format("{}, line {}: '{}' is no finite number", table_.file, number_, word));
        }
        table_.values.push_back(value);
        line.remove_prefix(length);
        skip_blanks(line);
        if (line.empty()) return false;
        if (line.front() == ',') {
            line.remove_prefix(1);
            skip_blanks(line);
        }
        return true;
    }

    [[noreturn]] void refuse_count(std::size_t count) const {
        const bool first = table_.lines.empty();
        const std::string wanted = !first || least_ == most_
                                       ? fmt::format("{}", first ? least_ : table_.columns)
                                       : fmt::format("{} to {}", least_, most_);
        throw base::InputError(fmt::format("{}, line {}: has {} numbers; {} are expected",
                                           table_.file, number_, count, wanted));
    }

    Table& table_;
    std::size_t least_, most_;
    std::uint32_t number_ = 0;
    bool named_ = false;
};

}  // namespace

std::string Table::place(std::size_t i) const {
    return fmt::format("{}, line {}: ", file, lines[i]);
}

geom::Points Table::points(std::size_t first_column) const {
    geom::Points points(Eigen::Index(rows()), 3);
    for (std::size_t i = 0; i < rows(); ++i)
        points.row(Eigen::Index(i)) = Eigen::Map<const Eigen::RowVector3d>(row(i) + first_column);
    return points;
}

Table read_table(const std::string& file, std::size_t least, std::size_t most) {
    const std::string content = file_content(file);
    Table table;
    table.file = file;
    Reader reader(table, least, most);
    for (std::string_view rest = content; !rest.empty();) {
        const std::size_t end = std::min(rest.find('\n'), rest.size());
        reader.add_line(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    if (table.lines.empty()) throw base::InputError(file + ": has no numbers");
    return table;
}

}  // namespace patchwright::cli
