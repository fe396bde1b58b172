#include "adapt/write_local.h"

#include <fmt/format.h>

#include <bit>

namespace patchwright::adapt {

namespace {

/// Arrays that are appended to a file one after the other.
/// Source: VTK file formats (Kitware), XML, unstructured grids with raw appended data.
class Arrays {
  public:
    /// @return the element that stands for the array
    template <class T>
    std::string add(const std::string& name, const std::vector<T>& values, int components = 1) {
        const char* type = std::is_same_v<T, double>         ? "Float64"
                           : std::is_same_v<T, float>        ? "Float32"
                           : std::is_same_v<T, std::int64_t> ? "Int64"
                           : std::is_same_v<T, std::uint8_t> ? "UInt8"
                                                             : "Int32";
        const std::uint64_t bytes = sizeof(T) * values.size();
        arrays_.push_back({values.data(), bytes});
        const std::string text = fmt::format(
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" "
            "offset=\"{}\"/>\n",
            type, name, components, offset_);
        offset_ += sizeof bytes + bytes;
        return text;
    }
    void write(grid::OutputStream& stream) const {
        for (const auto& [values, bytes] : arrays_) {
            stream.write(&bytes, sizeof bytes);
            stream.write(values, bytes);
        }
    }

  private:
    std::vector<std::pair<const void*, std::uint64_t>> arrays_;
    std::uint64_t offset_ = 0;
};

struct VtkCells {
    std::vector<std::int64_t> corners, ends;
    std::vector<std::uint8_t> types;
    std::vector<std::int32_t> blocks, levels;
};

VtkCells cells_of(const LocalFile& content) {
    constexpr std::uint8_t polygon = 7, quad = 9;
    VtkCells cells;
    std::vector<std::int32_t> corners;
    for (const std::int32_t number : content.order) {
        const LocalCell& cell = content.grid.cells[std::size_t(number)];
        corners.clear();
        content.add_corners(number, corners);
        cells.corners.insert(cells.corners.end(), corners.begin(), corners.end());
        cells.ends.push_back(static_cast<std::int64_t>(cells.corners.size()));
        cells.types.push_back(corners.size() == 4 ? quad : polygon);
        cells.blocks.push_back(cell.block);
        cells.levels.push_back(cell.level);
    }
    return cells;
}

}  // namespace

void write_local_vtk(const LocalFile& content, base::PendingFile& file) {
    const LocalGrid& grid = content.grid;
    std::vector<double> points;
    for (std::size_t n = 0; n < content.coordinates[0].size(); ++n)
        for (const auto& coordinate : content.coordinates) points.push_back(coordinate[n]);
    const VtkCells cells = cells_of(content);
    Arrays arrays;
    std::string text = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
        "byte_order=\"{}\" header_type=\"UInt64\">\n<UnstructuredGrid>\n"
        "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
        std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian",
        grid.points.rows(), grid.cells.size());
    text += "<Points>\n" + arrays.add("Points", points, 3) + "</Points>\n<Cells>\n";
    text += arrays.add("connectivity", cells.corners);
    text += arrays.add("offsets", cells.ends);
    text += arrays.add("types", cells.types) + "</Cells>\n<PointData>\n";
    text += arrays.add("cage face", grid.places.faces);
    text += arrays.add("cage u", grid.places.u);
    text += arrays.add("cage v", grid.places.v);
    if (!grid.places.sectors.empty()) text += arrays.add("cage sector", grid.places.sectors);
    text += "</PointData>\n<CellData>\n";
    text += arrays.add("block", cells.blocks);
    text += arrays.add("level", cells.levels);
    text += arrays.add("minimum angle [degrees]", content.fields.min_angle_deg);
    text += arrays.add("skewness", content.fields.skewness);
    text += arrays.add("aspect ratio", content.fields.aspect);
    text += "</CellData>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
    grid::OutputStream stream(file.path(), file.target().given);
    stream.write(text);
    arrays.write(stream);
    stream.write("\n</AppendedData>\n</VTKFile>\n");
    stream.close();
}

}  // namespace patchwright::adapt
