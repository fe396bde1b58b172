#include "mesh/raw_obj.h"

#include <patchwright/base/error.h>
#include <patchwright/mesh/read_triangles.h>

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <set>
#include <span>
#include <unordered_set>

namespace patchwright::mesh {

namespace {

constexpr std::size_t header_size = 84, record_size = 50;

std::string lower_extension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    for (char& c : extension) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
    return extension;
}

std::uint32_t little_endian(const char* bytes) {
    std::uint32_t value = 0;
    for (int k = 3; k >= 0; --k) value = value << 8 | static_cast<unsigned char>(bytes[k]);
    return value;
}

geom::TriangleMesh binary_stl(const std::string& bytes, const std::string& source) {
    const std::size_t count = little_endian(bytes.data() + header_size - 4);
    const std::size_t wanted = header_size + record_size * count;
    if (bytes.size() < wanted)
        throw base::InputError(
            fmt::format("{}: a binary STL file of {} triangles has {} bytes, this one {}: it is "
                        "truncated, or no STL file",
                        source, count, wanted, bytes.size()));
    geom::TriangleMesh mesh;
    mesh.points.resize(Eigen::Index(3 * count), 3);
    for (std::size_t t = 0; t < count; ++t) {
        const char* at = bytes.data() + header_size + record_size * t + 12;  // after the normal
        for (std::size_t i = 0; i < 9; ++i)
            mesh.points(Eigen::Index(3 * t + i / 3), Eigen::Index(i % 3)) =
                std::bit_cast<float>(little_endian(at + 4 * i));
        mesh.triangles.push_back({int(3 * t), int(3 * t + 1), int(3 * t + 2)});
    }
    return mesh;
}

class AsciiStl {
  public:
    AsciiStl(const std::string& text, const std::string& source) : text_(text), source_(source) {}

    geom::TriangleMesh parse() {
        std::size_t at = 0;
        while (at < text_.size()) {
            const std::size_t end = std::min(text_.find('\n', at), text_.size());
            ++line_number_;
            cut_off_ = end == text_.size();
            statement(std::string_view(text_).substr(at, end - at));
            at = end + 1;
        }
        cut_off_ = true;
        if (open_) fail("'endsolid' is missing");
        mesh_.points = Eigen::Map<const geom::Points>(coordinates_.data(),
                                                      Eigen::Index(coordinates_.size() / 3), 3);
        return std::move(mesh_);
    }

  private:
    template <class... Args>
    [[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args) const {
        throw base::InputError(
            fmt::format("{}: line {}: {}{}", source_, line_number_,
                        fmt::format(format, std::forward<Args>(args)...),
                        cut_off_ ? "; the file ends here: it is truncated" : ""));
    }

    void statement(std::string_view line) {
        const auto words = words_of(line);
        if (words.empty()) return;
        std::string keyword(words[0]);
        for (char& c : keyword) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
        if (keyword == "solid") {
            open_ = true;
            part_ = -1;
            if (words.size() < 2) return;
            part_ = int(mesh_.part_names.size());
            const auto begin = std::size_t(words[1].data() - line.data());
            mesh_.part_names.emplace_back(
                line.substr(begin, line.find_last_not_of(" \t\r") + 1 - begin));
        } else if (keyword == "endsolid") {
            open_ = false;
        } else if (keyword == "vertex") {
            vertex(words);
        } else if (keyword == "endloop") {
            if (corners_ != 3) fail("a facet has {} vertices, not 3", corners_);
            const int last = int(coordinates_.size() / 3);
            mesh_.triangles.push_back({last - 3, last - 2, last - 1});
            mesh_.part.push_back(part_);
            corners_ = 0;
        } else if (keyword != "facet" && keyword != "outer" && keyword != "endfacet") {
            fail("'{}' is no word of an STL file", words[0]);
        }
    }

    void vertex(const std::vector<std::string_view>& words) {
        if (words.size() != 4) fail("a vertex needs three coordinates");
        for (std::size_t k = 1; k <= 3; ++k) {
            const auto value = number_of<double>(words[k]);
            if (!value || !(std::abs(*value) <= geom::largest_coordinate))
                fail("the coordinate '{}' is not a length up to {:g}", words[k],
                     geom::largest_coordinate);
            coordinates_.push_back(*value);
        }
        ++corners_;
    }

    const std::string& text_;
    const std::string& source_;
    int line_number_ = 0, part_ = -1, corners_ = 0;
    bool open_ = false, cut_off_ = false;
    std::vector<double> coordinates_;
    geom::TriangleMesh mesh_;
};

/// Many binary files begin with "solid" too; sizes and bytes that no text has tell them apart.
bool is_ascii_stl(const std::string& bytes) {
    const std::size_t first = bytes.find_first_not_of(" \t\r\n");
    if (first == std::string::npos || bytes.compare(first, 5, "solid") != 0) return false;
    if (bytes.size() >= header_size) {
        const std::size_t count = little_endian(bytes.data() + header_size - 4);
        if (bytes.size() == header_size + record_size * count) return false;
    }
    return bytes.find('\0') == std::string::npos;
}

/// Cuts polygons along lines that nothing else uses, so that no side gets more than two triangles.
class Triangulator {
  public:
    explicit Triangulator(RawObj raw) : raw_(std::move(raw)) {
        mesh_.points = std::move(raw_.points);
        mesh_.part_names = std::move(raw_.input.group_names);
    }

    /// @param duplicates  becomes the number of triangles of polygons that have another's vertices
    ///                    and were left out
    geom::TriangleMesh run(int& duplicates) {
        find_sides();
        std::size_t at = 0;
        for (std::size_t f = 0; f < raw_.input.face_sizes.size(); ++f) {
            const auto size = std::size_t(raw_.input.face_sizes[f]);
            part_ = raw_.input.face_group.empty() ? -1 : raw_.input.face_group[f];
            const auto face = std::span<const int>(raw_.input.face_vertices).subspan(at, size);
            at += size;
            if (is_duplicate(face))
                duplicates += int(size) - 2;
            else
                cut(face);
        }
        const Eigen::Index before = mesh_.points.rows();
        mesh_.points.conservativeResize(before + Eigen::Index(middles_.size()), 3);
        for (std::size_t k = 0; k < middles_.size(); ++k)
            mesh_.points.row(before + Eigen::Index(k)) = middles_[k];
        return std::move(mesh_);
    }

  private:
    static std::uint64_t key(int a, int b) {
        return std::uint64_t(std::min(a, b)) << 32 | std::uint64_t(std::max(a, b));
    }

    void find_sides() {
        const auto& sizes = raw_.input.face_sizes;
        if (std::all_of(sizes.begin(), sizes.end(), [](int size) { return size == 3; })) return;
        std::size_t at = 0;
        for (const int size : sizes) {
            for (std::size_t k = 0; k < std::size_t(size); ++k)
                lines_.insert(key(raw_.input.face_vertices[at + k],
                                  raw_.input.face_vertices[at + (k + 1) % std::size_t(size)]));
            at += std::size_t(size);
        }
    }

    /// Of a polygon: triangles come later.
    bool is_duplicate(std::span<const int> face) {
        if (face.size() == 3) return false;
        std::vector<int> sorted(face.begin(), face.end());
        std::sort(sorted.begin(), sorted.end());
        return !polygons_.insert(std::move(sorted)).second;
    }

    /// In a fan around its first vertex, of a quad the nearer to the one across; else the second;
    /// else around a point in its middle.
    void cut(std::span<const int> face) {
        const auto gap = [&](std::size_t a, std::size_t b) {
            return (mesh_.points.row(face[a]) - mesh_.points.row(face[b])).norm();
        };
        const std::size_t first = face.size() == 4 && gap(1, 3) < gap(0, 2) ? 1 : 0;
        if (fan(face, first) || fan(face, 1 - first)) return;
        Eigen::RowVector3d middle = Eigen::RowVector3d::Zero();
        for (const int v : face) middle += mesh_.points.row(v) / double(face.size());
        const int number = int(mesh_.points.rows()) + int(middles_.size());
        middles_.push_back(middle);
        for (std::size_t k = 0; k < face.size(); ++k)
            add({number, face[k], face[(k + 1) % face.size()]});
    }

    bool fan(std::span<const int> face, std::size_t first) {
        const auto v = [&](std::size_t k) { return face[(first + k) % face.size()]; };
        for (std::size_t k = 2; k + 1 < face.size(); ++k)
            if (lines_.contains(key(v(0), v(k)))) return false;
        for (std::size_t k = 1; k + 1 < face.size(); ++k) {
            if (k > 1) lines_.insert(key(v(0), v(k)));
            add({v(0), v(k), v(k + 1)});
        }
        return true;
    }

    void add(const std::array<int, 3>& triangle) {
        mesh_.triangles.push_back(triangle);
        mesh_.part.push_back(part_);
    }

    RawObj raw_;
    int part_ = -1;
    std::unordered_set<std::uint64_t> lines_;  ///< sides of polygons and cuts; of triangles none
    std::set<std::vector<int>> polygons_;      ///< vertices of each, rising
    std::vector<Eigen::RowVector3d> middles_;
    geom::TriangleMesh mesh_;
};

void describe_repair(TriangleFile& file, const std::string& source) {
    const geom::MeshRepair& r = file.repair;
    const auto note = [&](int count, const char* what) {
        if (count > 0) file.notices.push_back(fmt::format("{}: {} {}", source, count, what));
    };
    note(r.degenerate, "triangles with two equal points were left out");
    note(r.duplicates, "triangles were left out, as others have the same points");
    note(r.turned, "triangles were turned to face outward like their neighbours");
}

}  // namespace

bool is_triangle_file(const std::filesystem::path& path) {
    const std::string extension = lower_extension(path);
    return extension == ".stl" || extension == ".obj";
}

TriangleFile read_triangles(const std::filesystem::path& path, double scale) {
    const std::string source = path.string();
    std::ifstream stream = open_mesh_file(path);
    TriangleFile file;
    int duplicates = 0;
    if (lower_extension(path) == ".obj") {
        file.format = "OBJ";
        RawObj raw = read_raw_obj(stream, source);
        file.is_control_mesh = raw.is_tagged;
        file.mesh = Triangulator(std::move(raw)).run(duplicates);
    } else {
        const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
        const bool ascii = is_ascii_stl(bytes);
        if (!ascii && bytes.size() < header_size)
            throw base::InputError(fmt::format(
                "{}: {} bytes are too few for an STL file: it is truncated", source, bytes.size()));
        file.format = ascii ? "STL ASCII" : "STL binary";
        file.mesh = ascii ? AsciiStl(bytes, source).parse() : binary_stl(bytes, source);
    }
    file.mesh.points *= scale;
    file.repair = geom::make_sound(file.mesh, source);
    file.repair.duplicates += duplicates;
    describe_repair(file, source);
    return file;
}

}  // namespace patchwright::mesh
