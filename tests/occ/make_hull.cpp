// Writes a ship's hull of loose faces as IGES: input for the cost of reading by the number of
// faces.
//
// Usage: make_hull FILE.igs STATIONS WATERLINES [GAP_MM]
#include "occ/hull.h"

#include <IGESControl_Writer.hxx>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
    if (argc < 4) {
        std::fprintf(stderr, "usage: make_hull FILE.igs STATIONS WATERLINES [GAP_MM]\n");
        return 1;
    }
    IGESControl_Writer writer("MM", 0);
    const double gap_mm = argc > 4 ? std::atof(argv[4]) : 0.0;
    for (const TopoDS_Face& face :
         patchwright::test::hull_faces(std::atoi(argv[2]), std::atoi(argv[3]), gap_mm))
        writer.AddShape(face);
    writer.ComputeModel();
    if (!writer.Write(argv[1])) {
        std::fprintf(stderr, "%s cannot be written\n", argv[1]);
        return 4;
    }
    return 0;
}
