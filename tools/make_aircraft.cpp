// Writes an aircraft-like model for tests; the same bytes on every run.
#include "make_aircraft.h"

#include "make_files.h"

#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>

using namespace aircraft;

namespace {

constexpr const char* usage =
    "usage: make_aircraft KIND SEED OUT.step [--open] [--untrimmed] [--iges]\n"
    "KIND: flying_wing, blended_wing_body, wing_body_tails, wing_body_nacelles or components\n"
    "  --open       the right half, open at the plane of symmetry; else a closed solid\n"
    "  --untrimmed  one skin of faces with natural borders; else parts that are fused, but for\n"
    "               components, which stay solids of their own\n"
    "  --iges       faces one by one, unsewn, in OUT\n";

struct Options {
    std::string kind, out;
    unsigned seed = 0;
    Borders borders = Borders::Trimmed;
    Extent extent = Extent::Whole;
    bool iges = false;
};

Options options_of(int argc, char** argv) {
    if (argc < 4) throw std::invalid_argument("too few arguments");
    Options options{.kind = argv[1], .out = argv[3], .seed = unsigned(std::stoul(argv[2]))};
    for (int i = 4; i < argc; ++i) {
        const std::string flag = argv[i];
        if (flag == "--open") {
            options.extent = Extent::OpenHalf;
        } else if (flag == "--untrimmed") {
            options.borders = Borders::Untrimmed;
        } else if (flag == "--iges") {
            options.iges = true;
        } else {
            throw std::invalid_argument("unknown option " + flag);
        }
    }
    return options;
}

void write(const Options& options) {
    const TopoDS_Shape shape =
        make_aircraft(options.kind, options.seed, options.borders, options.extent);
    const cad_files::Header header{std::filesystem::path(options.out).filename(), options.kind,
                                   "make_aircraft"};
    if (!options.iges) return cad_files::write_step(shape, options.out, header);
    TopTools_IndexedMapOfShape found;
    TopExp::MapShapes(shape, TopAbs_FACE, found);
    std::vector<TopoDS_Face> faces;
    for (int i = 1; i <= found.Extent(); ++i) faces.push_back(TopoDS::Face(found(i)));
    cad_files::write_iges(faces, options.out, header, "MM");
}

}  // namespace

int main(int argc, char** argv) {
    try {
        cad_files::silence_kernel();
        write(options_of(argc, argv));
        return 0;
    } catch (const std::invalid_argument& error) {
        std::fprintf(stderr, "make_aircraft: %s\n%s", error.what(), usage);
        return 1;
    } catch (const Standard_Failure& failure) {
        std::fprintf(stderr, "make_aircraft: %s\n", failure.GetMessageString());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "make_aircraft: %s\n", error.what());
    }
    return 5;
}
