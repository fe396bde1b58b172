// Evaluates the places of a file: int32 faces, then pairs of double u and v. For bench_evaluate.py.
//   bench_locations CAGE.obj PLACES COUNT ORDER   prints JSON
#include <patchwright/mesh/obj.h>
#include <patchwright/subd/limit_mask.h>

#include <fmt/format.h>

#include <chrono>
#include <fstream>

int main(int argc, char** argv) {
    using namespace patchwright;
    if (argc != 5) return 1;
    const mesh::Cage cage = mesh::read_obj(std::filesystem::path(argv[1])).cage;
    const auto count = std::size_t(std::stoul(argv[3]));
    std::vector<std::int32_t> faces(count);
    std::vector<double> uv(2 * count);
    std::ifstream file(argv[2], std::ios::binary);
    file.read(reinterpret_cast<char*>(faces.data()), std::streamsize(count * sizeof(faces[0])));
    file.read(reinterpret_cast<char*>(uv.data()), std::streamsize(2 * count * sizeof(uv[0])));
    const subd::LimitEvaluator evaluator(cage.topology);
    const auto evaluate = [&] {
        return evaluator.evaluate(cage.points, {faces, uv, {}}, std::stoi(argv[4]));
    };
    evaluate();  // kinds of neighbourhoods and threads are there in Python too, after the first
                 // call
    const auto start = std::chrono::steady_clock::now();
    const geom::Points points = evaluate();
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    fmt::print("{{\"seconds\": {}, \"sum\": {}}}\n", seconds, points.sum());
}
