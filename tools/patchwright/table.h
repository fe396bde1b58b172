// Tables of numbers as text: one row a line.
#pragma once

#include <patchwright/geom/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace patchwright::cli {

/// Rows of numbers and the lines they stood in.
struct Table {
    std::string file;
    std::size_t columns = 0;
    std::vector<double> values;        ///< row after row
    std::vector<std::uint32_t> lines;  ///< of each row, from 1

    [[nodiscard]] std::size_t rows() const { return lines.size(); }
    [[nodiscard]] const double* row(std::size_t i) const { return values.data() + i * columns; }
    /// Three columns as points, one a row.
    [[nodiscard]] geom::Points points(std::size_t first_column) const;
    /// "FILE, line 7: ", for messages about a row.
    [[nodiscard]] std::string place(std::size_t i) const;
};

/// Reads finite numbers with commas or blanks between them. Empty lines and what follows a '#' are
/// left out, a first line that begins with a letter is one of names.
/// @param least,most  number of columns, equal in all rows
/// @throw InputError when it cannot be read, has no rows, or naming the line that is not so
Table read_table(const std::string& file, std::size_t least, std::size_t most);

}  // namespace patchwright::cli
