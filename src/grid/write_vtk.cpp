#include "grid/writer.h"

#include <patchwright/base/error.h>
#include <patchwright/base/markup.h>
#include <patchwright/base/output_set.h>

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace patchwright::grid {

namespace {

namespace fs = std::filesystem;

constexpr const char* byte_order =
    std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";

/// Source: VTK file formats (Kitware), XML, structured grids with raw appended data.
class VtkWriter : public GridWriter {
  public:
    VtkWriter(const BlockSource& grid, base::PendingFile& file)
        : grid_(grid), file_(file), name_(file.target().file.stem().string()) {}

    [[nodiscard]] bool wants_fields() const override { return true; }

    void write(int block, const BlockData& data) override {
        const BlockPoints& points = data.points;
        OutputStream stream(file_.part(block_file(block)), file_.target().given);
        std::vector<Array> at_points{array("cage face", data.places.faces, points.nk),
                                     array("cage u", data.places.u, points.nk),
                                     array("cage v", data.places.v, points.nk)};
        if (!data.places.sectors.empty())
            at_points.push_back(array("cage sector", data.places.sectors, points.nk));
        const std::vector<double> velocities = rows_of(data.velocities, 0, data.velocities.count());
        if (!velocities.empty()) at_points.push_back(array("velocity", velocities, 1, 3));
        std::vector<Array> fields{array("minimum angle [degrees]", data.fields.min_angle_deg),
                                  array("skewness", data.fields.skewness),
                                  array("aspect ratio", data.fields.aspect)};
        if (points.nk > 1) fields.push_back(array("scaled Jacobian", data.fields.scaled_jacobian));
        const std::string extent =
            fmt::format("0 {} 0 {} 0 {}", points.ni - 1, points.nj - 1, points.nk - 1);
        std::uint64_t offset = sizeof(std::uint64_t) + 3 * sizeof(double) * points.count();
        std::string text = fmt::format(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"StructuredGrid\" version=\"1.0\" "
            "byte_order=\"{}\" header_type=\"UInt64\">\n<StructuredGrid WholeExtent=\"{}\">\n"
            "<Piece Extent=\"{}\">\n<Points><DataArray type=\"Float64\" Name=\"Points\" "
            "NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points>\n",
            byte_order, extent, extent);
        text += "<PointData>\n" + heads(at_points, offset) + "</PointData>\n";
        text += "<CellData>\n" + heads(fields, offset) + "</CellData>\n";
        text += "</Piece>\n</StructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
        stream.write(text);
        write_points(stream, points);
        for (const std::vector<Array>* arrays : {&at_points, &fields}) {
            for (const Array& array : *arrays) {
                const std::uint64_t bytes = array.times * array.bytes;
                stream.write(&bytes, sizeof bytes);
                for (std::uint64_t k = 0; k < array.times; ++k)
                    stream.write(array.values, array.bytes);
            }
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
            text +=
                fmt::format("<DataSet index=\"{}\" name=\"{}\" file=\"{}\"/>\n", b,
                            base::escape_markup(grid_.plan().layout.blocks[std::size_t(b)].name),
                            base::escape_markup(block_file(b)));
        }
        text += "</vtkMultiBlockDataSet>\n</VTKFile>\n";
        OutputStream stream(file_.path(), file_.target().given);
        stream.write(text);
        stream.close();
        // What an older grid with more blocks left.
        for (int b = grid_.block_count(); fs::exists(file_.target().folder() / block_file(b)); ++b)
            file_.drop(block_file(b));
    }

  private:
    struct Array {
        const char *type, *name;
        const void* values;
        std::uint64_t bytes, times;  ///< of the values, which are written so often
        int components;
    };
    template <class T>
    static Array array(const char* name, const std::vector<T>& values, int times = 1,
                       int components = 1) {
        const char* type = std::is_same_v<T, double>  ? "Float64"
                           : std::is_same_v<T, float> ? "Float32"
                                                      : "Int32";
        return {type,      name, values.data(), sizeof(T) * values.size(), std::uint64_t(times),
                components};
    }
    /// @param offset  of the first array's values; raised to what follows the last one's
    static std::string heads(const std::vector<Array>& arrays, std::uint64_t& offset) {
        std::string text;
        for (const Array& array : arrays) {
            text += fmt::format(
                "<DataArray type=\"{}\" Name=\"{}\"{} format=\"appended\" offset=\"{}\"/>\n",
                array.type, array.name,
                array.components == 1 ? ""
                                      : fmt::format(" NumberOfComponents=\"{}\"", array.components),
                offset);
            offset += sizeof(std::uint64_t) + array.times * array.bytes;
        }
        return text;
    }
    /// In a folder of the grid's name.
    [[nodiscard]] std::string block_file(int block) const {
        return fmt::format("{0}/{0}_{1}.vts", name_, block);
    }
    /// x, y, z of these points, one after the other.
    static std::vector<double> rows_of(const BlockPoints& points, std::size_t begin,
                                       std::size_t end) {
        std::vector<double> rows(3 * (end - begin));
        for (std::size_t n = begin; n < end; ++n)
            for (std::size_t c = 0; c < 3; ++c)
                rows[3 * (n - begin) + c] = points.coordinates[c][n];
        return rows;
    }
    static void write_points(OutputStream& stream, const BlockPoints& points) {
        const std::uint64_t bytes = 3 * sizeof(double) * points.count();
        stream.write(&bytes, sizeof bytes);
        constexpr std::size_t part = 1 << 15;
        for (std::size_t begin = 0; begin < points.count(); begin += part) {
            const std::vector<double> rows =
                rows_of(points, begin, std::min(points.count(), begin + part));
            stream.write(rows.data(), sizeof(double) * rows.size());
        }
    }

    const BlockSource& grid_;
    base::PendingFile& file_;
    std::string name_;
};

}  // namespace

std::unique_ptr<GridWriter> make_vtk_writer(const BlockSource& grid, base::PendingFile& file,
                                            const GridWriteOptions&) {
    return std::make_unique<VtkWriter>(grid, file);
}

}  // namespace patchwright::grid
