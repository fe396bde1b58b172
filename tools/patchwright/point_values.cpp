#include "point_values.h"

#include "files.h"
#include "table.h"
#include "vtu.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <utility>

namespace patchwright::cli {

PointValues read_point_values(const std::string& file, const PointValuesOptions& options) {
    PointValues result;
    const auto check = [&](double value, const auto& place) {
        if (options.must_be_positive && !(value > 0.0))
            throw base::InputError(
                fmt::format("{}the size is {}; it must be positive", place(), value));
    };
    if (has_extension(file, ".vtu")) {
        VtuValues read = read_vtu(file, options.array, options.usual_array);
        for (std::size_t i = 0; i < read.values.size(); ++i)
            check(read.values[i], [&] {
                return fmt::format("{}: array '{}', {} {} (from 0): ", file, read.array,
                                   read.of_cells ? "cell" : "point", i);
            });
        result = {std::move(read.at), std::move(read.values)};
    } else {
        if (!options.array.empty())
            throw base::UsageError(fmt::format("{}: array '{}' is asked for, which .vtu files have",
                                               file, options.array));
        const Table table = read_table(file, 4, 4);
        for (std::size_t i = 0; i < table.rows(); ++i) {
            check(table.row(i)[3], [&] { return table.place(i); });
            result.values.push_back(table.row(i)[3]);
        }
        result.at = table.points(0);
    }
    result.at *= base::millimetres_per(options.unit);
    return result;
}

}  // namespace patchwright::cli
