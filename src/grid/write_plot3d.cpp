#include "grid/writer.h"

#include <patchwright/base/error.h>
#include <patchwright/base/output_set.h>

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <limits>

namespace patchwright::grid {

namespace {

/// The bytes of a value, or those of a 32- or 64-bit value turned around.
template <class T>
T ordered(T value, bool big_endian) {
    if ((std::endian::native == std::endian::big) == big_endian) return value;
    unsigned char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    for (std::size_t k = 0; k < sizeof(T) / 2; ++k) std::swap(bytes[k], bytes[sizeof(T) - 1 - k]);
    std::memcpy(&value, bytes, sizeof(T));
    return value;
}

/// Source: Walatka, Buning, Pierce, Elson, PLOT3D user's manual (NASA TM-101067, 1990), chapter 8.
class Plot3dWriter : public GridWriter {
  public:
    Plot3dWriter(const BlockSource& grid, const base::PendingFile& file,
                 const GridWriteOptions& options)
        : options_(options.plot3d), stream_(file.path(), file.target().given) {
        check_records(grid, file.target().given);
        if (options_.form == Plot3dOptions::Form::Ascii) {
            std::string text = fmt::format("{}\n", grid.block_count());
            for (int b = 0; b < grid.block_count(); ++b) {
                const auto [ni, nj, nk] = grid.size(b);
                text += fmt::format("{} {} {}\n", ni, nj, nk);
            }
            stream_.write(text);
            return;
        }
        begin_record(sizeof(std::int32_t));
        put(grid.block_count());
        end_record();
        begin_record(3 * sizeof(std::int32_t) * std::size_t(grid.block_count()));
        for (int b = 0; b < grid.block_count(); ++b) {
            for (const int n : grid.size(b)) put(n);
        }
        end_record();
    }

    [[nodiscard]] bool wants_point_data() const override { return false; }

    void write(int, const BlockData& data) override {
        const BlockPoints& points = data.points;
        begin_record(3 * sizeof(double) * points.count());
        for (const std::vector<double>& coordinate : points.coordinates) {
            if (options_.form == Plot3dOptions::Form::Ascii) {
                write_text(coordinate);
            } else if (ordered(std::int32_t{1}, options_.big_endian) == 1) {
                stream_.write(coordinate.data(), sizeof(double) * coordinate.size());
            } else {
                write_swapped(coordinate);
            }
        }
        end_record();
    }

    void finish() override { stream_.close(); }

  private:
    void check_records(const BlockSource& grid, const std::filesystem::path& file) const {
        if (options_.form != Plot3dOptions::Form::Fortran) return;
        for (int b = 0; b < grid.block_count(); ++b) {
            const auto [ni, nj, nk] = grid.size(b);
            const double bytes = 24.0 * ni * nj * nk;
            if (bytes > std::numeric_limits<std::int32_t>::max()) {
                throw base::UsageError(
                    fmt::format("{}: block {} has {:.3g} bytes, too many for a Fortran record; use "
                                "plain binary",
                                file.string(), b, bytes));
            }
        }
    }
    void put(std::int32_t value) {
        value = ordered(value, options_.big_endian);
        stream_.write(&value, sizeof value);
    }
    void begin_record(std::size_t bytes) {
        record_ = bytes;
        end_record();
    }
    void end_record() {
        if (options_.form == Plot3dOptions::Form::Fortran) put(static_cast<std::int32_t>(record_));
    }
    void write_text(const std::vector<double>& values) {
        fmt::memory_buffer text;
        for (std::size_t k = 0; k < values.size(); ++k) {
            fmt::format_to(std::back_inserter(text), "{:.17g}{}", values[k],
                           k % 3 == 2 || k + 1 == values.size() ? '\n' : ' ');
            if (text.size() > (1 << 16)) {
                stream_.write(text.data(), text.size());
                text.clear();
            }
        }
        stream_.write(text.data(), text.size());
    }
    void write_swapped(const std::vector<double>& values) {
        std::vector<double> part;
        for (std::size_t begin = 0; begin < values.size(); begin += part.size()) {
            part.assign(
                values.begin() + std::ptrdiff_t(begin),
                values.begin() + std::ptrdiff_t(std::min(values.size(), begin + (1U << 16))));
            for (double& value : part) value = ordered(value, options_.big_endian);
            stream_.write(part.data(), sizeof(double) * part.size());
        }
    }

    Plot3dOptions options_;
    OutputStream stream_;
    std::size_t record_ = 0;
};

}  // namespace

std::unique_ptr<GridWriter> make_plot3d_writer(const BlockSource& grid, base::PendingFile& file,
                                               const GridWriteOptions& options) {
    return std::make_unique<Plot3dWriter>(grid, file, options);
}

}  // namespace patchwright::grid
