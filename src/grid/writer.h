// What the formats have in common.
#pragma once

#include <patchwright/grid/write.h>

#include <fstream>

namespace patchwright::grid {

class GridWriter {
  public:
    virtual ~GridWriter() = default;
    /// Whether write() uses the fields.
    [[nodiscard]] virtual bool wants_fields() const { return false; }
    /// Blocks come in order, coordinates in the file's unit.
    virtual void write(int block, const BlockPoints& points, const CellFields& fields) = 0;
    /// Puts the file in its place.
    virtual void finish() = 0;
};

std::unique_ptr<GridWriter> make_cgns_writer(const BlockSource& grid,
                                             const std::filesystem::path& file,
                                             const GridWriteOptions& options);
std::unique_ptr<GridWriter> make_plot3d_writer(const BlockSource& grid,
                                               const std::filesystem::path& file,
                                               const GridWriteOptions& options);
std::unique_ptr<GridWriter> make_vtk_writer(const BlockSource& grid,
                                            const std::filesystem::path& file,
                                            const GridWriteOptions& options);

/// A stream that throws OutputError, naming `file`, when its content cannot be written.
class OutputStream {
  public:
    OutputStream(const std::filesystem::path& temporary, const std::filesystem::path& file);
    void write(const void* data, std::size_t bytes);
    void write(std::string_view text) { write(text.data(), text.size()); }
    void close();

  private:
    void check();

    std::filesystem::path file_;
    std::vector<char> buffer_;
    std::ofstream stream_;
};

}  // namespace patchwright::grid
