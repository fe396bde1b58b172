// What the formats have in common.
#pragma once

#include <patchwright/grid/write.h>

#include <fstream>

namespace patchwright::grid {

/// What is written of a block.
struct BlockData {
    BlockPoints points;  ///< in the file's unit
    CellFields fields;   ///< where wants_fields()
    BlockPlaces places;  ///< of its surface, where wants_point_data()
    /// In the file's unit a unit of time, where wants_point_data() and the options have them.
    BlockPoints velocities;
};

class GridWriter {
  public:
    virtual ~GridWriter() = default;
    /// Whether write() uses the fields.
    [[nodiscard]] virtual bool wants_fields() const { return false; }
    [[nodiscard]] virtual bool wants_point_data() const { return true; }
    /// Blocks come in order.
    virtual void write(int block, const BlockData& data) = 0;
    /// Ends the file and checks what can be read back.
    virtual void finish() = 0;
};

std::unique_ptr<GridWriter> make_cgns_writer(const BlockSource& grid, base::PendingFile& file,
                                             const GridWriteOptions& options);
std::unique_ptr<GridWriter> make_plot3d_writer(const BlockSource& grid, base::PendingFile& file,
                                               const GridWriteOptions& options);
std::unique_ptr<GridWriter> make_vtk_writer(const BlockSource& grid, base::PendingFile& file,
                                            const GridWriteOptions& options);

/// A stream that throws OutputError, naming `file`, when its content cannot be written.
class OutputStream {
  public:
    /// @param pending  where to write; a new file
    OutputStream(const std::filesystem::path& pending, const std::filesystem::path& file);
    void write(const void* data, std::size_t bytes);
    void write(std::string_view text) { write(text.data(), text.size()); }
    /// Also checks that the file has the size written.
    void close();

  private:
    void check();

    std::filesystem::path pending_, file_;
    std::uintmax_t size_ = 0;
    std::vector<char> buffer_;
    std::ofstream stream_;
};

}  // namespace patchwright::grid
