#include "grid/writer.h"

#include <patchwright/base/error.h>
#include <patchwright/base/markup.h>
#include <patchwright/base/pending_file.h>

#include <fmt/format.h>

#include <bit>
#include <system_error>

namespace patchwright::grid {

namespace {

namespace fs = std::filesystem;

constexpr const char* byte_order =
    std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";

/// A folder that goes again when nothing was put there.
class BlockFolder {
  public:
    explicit BlockFolder(const fs::path& file)
        : path_(file.parent_path() / file.stem()), is_new_(!fs::exists(path_)) {
        std::error_code error;
        if (is_new_ && !fs::create_directory(path_, error)) {
            throw base::OutputError(fmt::format("{}: the folder for its blocks cannot be made: {}",
                                                file.string(), error.message()));
        }
    }
    ~BlockFolder() {
        std::error_code ignored;
        if (is_new_) fs::remove(path_, ignored);  // when it is empty
    }
    BlockFolder(const BlockFolder&) = delete;
    BlockFolder& operator=(const BlockFolder&) = delete;

    [[nodiscard]] std::string file_name(int block) const {
        return fmt::format("{}_{}.vts", path_.filename().string(), block);
    }
    [[nodiscard]] fs::path file(int block) const { return path_ / file_name(block); }
    [[nodiscard]] std::string name() const { return path_.filename().string(); }

  private:
    fs::path path_;
    bool is_new_;
};

/// Source: VTK file formats (Kitware), XML, structured grids with raw appended data.
class VtkWriter : public GridWriter {
  public:
    VtkWriter(const BlockSource& grid, const fs::path& file)
        : grid_(grid), file_(file), index_(file), folder_(file) {}

    [[nodiscard]] bool wants_fields() const override { return true; }

    void write(int block, const BlockPoints& points, const CellFields& fields) override {
        blocks_.push_back(std::make_unique<base::PendingFile>(folder_.file(block)));
        OutputStream stream(blocks_.back()->path(), file_);
        struct Array {
            const char* name;
            const std::vector<float>* values;
        };
        std::vector<Array> arrays{{"minimum angle [degrees]", &fields.min_angle_deg},
                                  {"skewness", &fields.skewness},
                                  {"aspect ratio", &fields.aspect}};
        if (points.nk > 1) arrays.push_back({"scaled Jacobian", &fields.scaled_jacobian});
        const std::string extent =
            fmt::format("0 {} 0 {} 0 {}", points.ni - 1, points.nj - 1, points.nk - 1);
        std::string text = fmt::format(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"StructuredGrid\" version=\"1.0\" "
            "byte_order=\"{}\" header_type=\"UInt64\">\n<StructuredGrid WholeExtent=\"{}\">\n"
            "<Piece Extent=\"{}\">\n<Points><DataArray type=\"Float64\" Name=\"Points\" "
            "NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points>\n<CellData>\n",
            byte_order, extent, extent);
        std::uint64_t offset = sizeof(std::uint64_t) + 3 * sizeof(double) * points.count();
        for (const Array& array : arrays) {
            text += fmt::format(
                "<DataArray type=\"Float32\" Name=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
                array.name, offset);
            offset += sizeof(std::uint64_t) + sizeof(float) * array.values->size();
        }
        text += "</CellData>\n</Piece>\n</StructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
        stream.write(text);
        write_points(stream, points);
        for (const Array& array : arrays) {
            const std::uint64_t bytes = sizeof(float) * array.values->size();
            stream.write(&bytes, sizeof bytes);
            stream.write(array.values->data(), bytes);
        }
        stream.write("\n</AppendedData>\n</VTKFile>\n");
        stream.close();
    }

    void finish() override {
        std::string text = fmt::format(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\" "
            "byte_order=\"{}\" header_type=\"UInt64\">\n<vtkMultiBlockDataSet>\n",
            byte_order);
        for (int b = 0; b < grid_.block_count(); ++b) {
            text += fmt::format(
                "<DataSet index=\"{}\" name=\"{}\" file=\"{}/{}\"/>\n", b,
                base::escape_markup(grid_.plan().layout.blocks[std::size_t(b)].name),
                base::escape_markup(folder_.name()), base::escape_markup(folder_.file_name(b)));
        }
        text += "</vtkMultiBlockDataSet>\n</VTKFile>\n";
        OutputStream stream(index_.path(), file_);
        stream.write(text);
        stream.close();
        for (const auto& block : blocks_) block->commit();
        index_.commit();
        // What an older grid with more blocks left.
        std::error_code ignored;
        for (int b = grid_.block_count(); fs::remove(folder_.file(b), ignored); ++b) {
        }
    }

  private:
    static void write_points(OutputStream& stream, const BlockPoints& points) {
        const std::uint64_t bytes = 3 * sizeof(double) * points.count();
        stream.write(&bytes, sizeof bytes);
        std::vector<double> rows;
        constexpr std::size_t part = 1 << 15;
        for (std::size_t begin = 0; begin < points.count(); begin += part) {
            const std::size_t end = std::min(points.count(), begin + part);
            rows.resize(3 * (end - begin));
            for (std::size_t n = begin; n < end; ++n) {
                for (std::size_t c = 0; c < 3; ++c) {
                    rows[3 * (n - begin) + c] = points.coordinates[c][n];
                }
            }
            stream.write(rows.data(), sizeof(double) * rows.size());
        }
    }

    const BlockSource& grid_;
    fs::path file_;
    base::PendingFile index_;
    BlockFolder folder_;
    std::vector<std::unique_ptr<base::PendingFile>> blocks_;
};

}  // namespace

std::unique_ptr<GridWriter> make_vtk_writer(const BlockSource& grid, const fs::path& file,
                                            const GridWriteOptions&) {
    return std::make_unique<VtkWriter>(grid, file);
}

}  // namespace patchwright::grid
