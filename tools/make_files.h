// STEP and IGES files that are the same, byte by byte, on every run.
#pragma once

#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>

#include <string>
#include <vector>

namespace cad_files {

/// What the header of a file says beside fixed dates and authors.
struct Header {
    std::string file, product, program;
};

/// AP214, millimetres.
/// @throw runtime_error when the file cannot be written
void write_step(const TopoDS_Shape& shape, const std::string& path, const Header& header);

/// Trimmed surfaces one by one, no B-rep: unsewn faces as older systems leave them.
/// @param unit  as IGES names it: IN, MM
/// @throw runtime_error when the file cannot be written
void write_iges(const std::vector<TopoDS_Face>& faces, const std::string& path,
                const Header& header, const char* unit);

/// Keeps the kernel's chatter off the terminal.
void silence_kernel();

}  // namespace cad_files
