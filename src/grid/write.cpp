#include "grid/memory.h"
#include "grid/writer.h"

#include <patchwright/base/error.h>
#include <patchwright/base/parallel.h>

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <future>
#include <optional>

namespace patchwright::grid {

namespace {

void scale(BlockPoints& points, double factor) {
    if (factor == 1.0) return;
    for (auto& coordinate : points.coordinates) {
        base::parallel_for(coordinate.size(), 1 << 16, [&](std::size_t first, std::size_t last) {
            for (std::size_t n = first; n < last; ++n) coordinate[n] *= factor;
        });
    }
}

}  // namespace

GridFormat grid_format(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".cgns") return GridFormat::Cgns;
    if (extension == ".xyz" || extension == ".p3d") return GridFormat::Plot3d;
    if (extension == ".vtm") return GridFormat::Vtk;
    throw base::UsageError(
        fmt::format("{}: unknown extension '{}'; use .cgns, .xyz, .p3d or .vtm{}", file.string(),
                    extension, extension == ".vtu" ? ", or --hanging-nodes" : ""));
}

GridQuality write_grid(const BlockSource& grid, const std::filesystem::path& file,
                       base::OutputSet& outputs, const GridWriteOptions& options) {
    const GridFormat format = grid_format(file);
    if (options.velocities != nullptr && grid.layers() > 1)
        throw base::InvalidArgument("velocities are those of surface grids");
    require_memory(grid.plan(), grid.layers(), 0);
    const auto pending = std::make_shared<base::PendingFile>(file);
    const auto writer = format == GridFormat::Cgns     ? make_cgns_writer(grid, *pending, options)
                        : format == GridFormat::Plot3d ? make_plot3d_writer(grid, *pending, options)
                                                       : make_vtk_writer(grid, *pending, options);
    const double factor = 1.0 / base::millimetres_per(options.unit);
    QualityMeter meter(grid);
    const BlockEvaluator evaluator(grid.plan());
    std::optional<BlockEvaluator> velocity;
    if (options.velocities != nullptr) velocity.emplace(*options.velocities);
    BlockData buffers[2];  // while one is written the next is evaluated
    std::future<void> writing;
    const int count = grid.block_count();
    for (int b = 0; b < count; ++b) {
        base::report_progress(options.progress, "grid", double(b) / count);
        BlockData& buffer = buffers[b % 2];
        grid.evaluate(b, buffer.points);
        meter.add(b, buffer.points, writer->wants_fields() ? &buffer.fields : nullptr);
        if (writer->wants_point_data()) {
            evaluator.places(b, buffer.places);
            if (velocity) velocity->evaluate(b, buffer.velocities);
            scale(buffer.velocities, factor);
        }
        scale(buffer.points, factor);
        if (writing.valid()) writing.get();
        writing =
            std::async(std::launch::async, [&writer, &buffer, b] { writer->write(b, buffer); });
    }
    if (writing.valid()) writing.get();
    writer->finish();
    outputs.add(pending);
    return meter.result();
}

GridQuality write_grid(const BlockSource& grid, const std::filesystem::path& file,
                       const GridWriteOptions& options) {
    base::OutputSet outputs;
    GridQuality quality = write_grid(grid, file, outputs, options);
    outputs.commit();
    return quality;
}

OutputStream::OutputStream(const std::filesystem::path& pending, const std::filesystem::path& file)
    : pending_(pending), file_(file), buffer_(1 << 20) {
    stream_.rdbuf()->pubsetbuf(buffer_.data(), std::streamsize(buffer_.size()));
    stream_.open(pending, std::ios::binary);
    check();
}

void OutputStream::write(const void* data, std::size_t bytes) {
    stream_.write(static_cast<const char*>(data), std::streamsize(bytes));
    size_ += bytes;
    check();
}

void OutputStream::close() {
    stream_.close();
    check();
    std::error_code error;
    if (std::filesystem::file_size(pending_, error) != size_)
        throw base::OutputError(
            fmt::format("{}: has not the size that was written; disk failure?", file_.string()));
}

void OutputStream::check() {
    if (!stream_) {
        throw base::OutputError(
            fmt::format("{}: cannot be written: {}", file_.string(), std::strerror(errno)));
    }
}

}  // namespace patchwright::grid
