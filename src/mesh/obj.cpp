#include "mesh/raw_obj.h"

#include <patchwright/base/error.h>
#include <patchwright/mesh/obj.h>

#include <fmt/format.h>

#include <cmath>
#include <map>

namespace patchwright::mesh {

namespace {

constexpr std::string_view runout_rule = "runout", catmull_clark_rule = "catmull-clark";

class ObjParser {
  public:
    ObjParser(std::istream& stream, const std::string& source) : stream_(stream), source_(source) {}

    RawObj parse() {
        std::string line;
        while (std::getline(stream_, line)) {
            ++line_number_;
            while (line.ends_with('\\')) continue_line(line);
            statement(line);
        }
        if (!stream_.eof()) fail("cannot be read to its end");
        input_.vertex_count = static_cast<int>(coordinates_.size() / 3);
        if (input_.vertex_count == 0) throw base::InputError(source_ + ": holds no vertices");
        if (input_.group_names.empty()) input_.face_group.clear();
        geom::Points points =
            Eigen::Map<const geom::Points>(coordinates_.data(), input_.vertex_count, 3);
        std::vector<RawObj::LineElement> lines = line_elements();
        return {std::move(input_), std::move(points), is_tagged_, std::move(lines)};
    }

  private:
    template <class... Args>
    [[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args) const {
        throw base::InputError(fmt::format("{}: line {}: {}", source_, line_number_,
                                           fmt::format(format, std::forward<Args>(args)...)));
    }

    void continue_line(std::string& line) {
        line.pop_back();
        std::string more;
        if (!std::getline(stream_, more)) return;
        ++line_number_;
        line += ' ' + more;
    }

    void statement(std::string_view line) {
        const auto words = words_of(line);
        if (words.empty()) return;
        const std::string_view keyword = words[0];
        if (keyword == "v") {
            vertex(words);
        } else if (keyword == "f") {
            face(words);
        } else if (keyword == "l") {
            lines_.push_back(
                {std::string(line), line_number_, static_cast<int>(coordinates_.size() / 3)});
        } else if (keyword == "g" || keyword == "o") {
            group(line, words);
        } else if (keyword == "t") {
            is_tagged_ = true;
            tag(words);
        } else if (keyword == "#patchwright" && words.size() >= 2 && words[1] == "pin") {
            is_tagged_ = true;
            for (std::size_t i = 2; i < words.size(); ++i) {
                input_.pins.push_back(integer(words[i]));
                input_.lines.pins.push_back(line_number_);
            }
        } else if (keyword == "#patchwright" && words.size() >= 2 && words[1] == "sector") {
            is_tagged_ = true;
            sector(words);
        } else if (keyword == "#patchwright" && words.size() >= 2 && words[1] == "crease-rule") {
            is_tagged_ = true;
            crease_rule(words);
        }
    }

    void crease_rule(const std::vector<std::string_view>& words) {
        const std::string_view rule = words.size() == 3 ? words[2] : std::string_view();
        if (rule != runout_rule && rule != catmull_clark_rule)
            fail("crease-rule must be {} or {}", runout_rule, catmull_clark_rule);
        input_.crease_rule =
            rule == runout_rule ? CreaseRule::ParabolicRunout : CreaseRule::CatmullClark;
    }

    void sector(const std::vector<std::string_view>& words) {
        if (words.size() != 5 && words.size() != 8) {
            fail("a sector needs a vertex, a face, an angle and perhaps the three of a normal");
        }
        SectorTagInput tag{integer(words[2]), integer(words[3]), real(words[4]) * M_PI / 180.0, {}};
        for (std::size_t k = 5; k < words.size(); ++k) tag.normal[k - 5] = real(words[k]);
        input_.sectors.push_back(tag);
        input_.lines.sectors.push_back(line_number_);
    }

    int integer(std::string_view word) const {
        if (const auto value = number_of<int>(word)) return *value;
        fail("'{}' is not an integer", word);
    }

    double real(std::string_view word) const {
        if (const auto value = number_of<double>(word)) return *value;
        fail("'{}' is not a number", word);
    }

    void vertex(const std::vector<std::string_view>& words) {
        if (words.size() < 4) fail("a vertex needs three coordinates");
        for (std::size_t i = 1; i <= 3; ++i) {
            const double value = real(words[i]);
            if (!(std::abs(value) <= geom::largest_coordinate)) {
                fail("vertex {} has the coordinate '{}', which is not a length up to {:g}",
                     input_.lines.vertices.size() + 1, words[i], geom::largest_coordinate);
            }
            coordinates_.push_back(value);
        }
        input_.lines.vertices.push_back(line_number_);
    }

    void face(const std::vector<std::string_view>& words) {
        const int known = static_cast<int>(coordinates_.size() / 3);
        for (std::size_t i = 1; i < words.size(); ++i) {
            input_.face_vertices.push_back(
                vertex_of(words[i], known, "face", input_.face_sizes.size() + 1));
        }
        if (words.size() < 4) {
            fail("face {} has {} vertices; at least 3 are needed", input_.face_sizes.size() + 1,
                 words.size() - 1);
        }
        input_.face_sizes.push_back(static_cast<int>(words.size()) - 1);
        input_.face_group.push_back(group_);
        input_.lines.faces.push_back(line_number_);
    }

    /// @param known  vertices before the element
    int vertex_of(std::string_view word, int known, std::string_view kind, std::size_t number) {
        const int index = integer(word.substr(0, word.find('/')));
        const int v = index < 0 ? known + index : index - 1;
        if (v < 0 || v >= known)
            fail("{} {} names vertex {}, but {} vertices stand before it", kind, number, index,
                 known);
        return v;
    }

    /// Beside faces lines mean nothing, and nobody looks at them.
    std::vector<RawObj::LineElement> line_elements() {
        std::vector<RawObj::LineElement> elements;
        if (!input_.face_sizes.empty()) return elements;
        for (const auto& [text, number, known] : lines_) {
            line_number_ = number;
            const auto words = words_of(text);
            RawObj::LineElement& element = elements.emplace_back();
            element.line = number;
            for (std::size_t i = 1; i < words.size(); ++i)
                element.vertices.push_back(vertex_of(words[i], known, "polyline", elements.size()));
        }
        return elements;
    }

    void group(std::string_view line, const std::vector<std::string_view>& words) {
        if (words.size() < 2) {
            group_ = -1;
            return;
        }
        const auto begin = static_cast<std::size_t>(words[1].data() - line.data());
        const auto end =
            static_cast<std::size_t>(words.back().data() - line.data()) + words.back().size();
        const std::string name(line.substr(begin, end - begin));
        const auto [entry, added] =
            group_numbers_.try_emplace(name, static_cast<int>(input_.group_names.size()));
        if (added) input_.group_names.push_back(name);
        group_ = entry->second;
    }

    void tag(const std::vector<std::string_view>& words) {
        if (words.size() < 3) fail("a tag needs a name and its argument counts");
        const std::string_view counts = words[2];
        const std::size_t first = counts.find('/');
        const std::size_t second = counts.find('/', first + 1);
        if (first == std::string_view::npos || second == std::string_view::npos) {
            fail("'{}' are no argument counts such as 2/1/0", counts);
        }
        const int integers = integer(counts.substr(0, first));
        const int reals = integer(counts.substr(first + 1, second - first - 1));
        if (integers < 0 || reals < 0 ||
            words.size() < 3 + std::size_t(integers) + std::size_t(reals)) {
            fail("tag '{}' has fewer arguments than {} says", words[1], counts);
        }
        std::vector<int> i;
        std::vector<double> r;
        for (int k = 0; k < integers; ++k) i.push_back(integer(words[std::size_t(3 + k)]));
        for (int k = 0; k < reals; ++k) r.push_back(real(words[std::size_t(3 + integers + k)]));
        apply_tag(words[1], i, r);
    }

    void apply_tag(std::string_view name, const std::vector<int>& i, const std::vector<double>& r) {
        const auto sharpness = [&](std::size_t k, std::size_t elements) {
            if (r.size() != 1 && r.size() != elements) {
                fail("tag '{}' has {} sharpness values for {} elements", name, r.size(), elements);
            }
            return r.size() == 1 ? r[0] : r[k];
        };
        if (name == "crease") {
            if (i.empty() || i.size() % 2 != 0) fail("a crease needs pairs of vertices");
            for (std::size_t k = 0; 2 * k < i.size(); ++k) {
                input_.creases.push_back({i[2 * k], i[2 * k + 1], sharpness(k, i.size() / 2)});
                input_.lines.creases.push_back(line_number_);
            }
        } else if (name == "corner") {
            for (std::size_t k = 0; k < i.size(); ++k) {
                input_.corners.push_back({i[k], sharpness(k, i.size())});
                input_.lines.corners.push_back(line_number_);
            }
        } else if (name == "interpolateboundary") {
            if (i.size() != 1 || (i[0] != 1 && i[0] != 2)) {
                fail("interpolateboundary must be 1 (edges) or 2 (edges and corners)");
            }
            input_.boundary_rule = static_cast<BoundaryRule>(i[0]);
        }
    }

    std::istream& stream_;
    const std::string& source_;
    int line_number_ = 0;
    int group_ = -1;
    bool is_tagged_ = false;
    std::map<std::string, int> group_numbers_;
    std::vector<double> coordinates_;
    struct LineStatement {
        std::string text;
        int line, known_vertices;
    };
    std::vector<LineStatement> lines_;
    TopologyInput input_;
};

/// Infinite sharpness is written as the least value that reads as infinite.
double written_sharpness(double sharpness) { return std::min(sharpness, sharpness_limit); }

}  // namespace

RawObj read_raw_obj(std::istream& stream, const std::string& source) {
    return ObjParser(stream, source).parse();
}

std::ifstream open_mesh_file(const std::filesystem::path& path) {
    if (std::filesystem::is_directory(path)) {
        throw base::InputError(path.string() + ": is a folder; give a file");
    }
    std::ifstream stream(path, std::ios::binary);
    if (!stream) throw base::InputError(path.string() + ": cannot be opened; does it exist?");
    return stream;
}

BuildResult read_obj(std::istream& stream, const std::string& source) {
    RawObj raw = read_raw_obj(stream, source);
    return build_cage(std::move(raw.input), std::move(raw.points), source);
}

BuildResult read_obj(const std::filesystem::path& path) {
    std::ifstream stream = open_mesh_file(path);
    return read_obj(stream, path.string());
}

std::string obj_text(const Cage& cage) {
    const Topology& topology = *cage.topology;
    fmt::memory_buffer out;
    const auto print = [&]<class... Args>(fmt::format_string<Args...> format, Args&&... args) {
        fmt::format_to(std::back_inserter(out), format, std::forward<Args>(args)...);
    };
    for (Eigen::Index v = 0; v < cage.points.rows(); ++v) {
        print("v {} {} {}\n", cage.points(v, 0), cage.points(v, 1), cage.points(v, 2));
    }
    int group = -1;
    for (const FaceId f : topology.faces()) {
        if (topology.group(f) != group) {
            group = topology.group(f);
            print("g{}{}\n", group >= 0 ? " " : "",
                  group >= 0 ? topology.group_names()[std::size_t(group)] : "");
        }
        print("f");
        for (const CornerId c : topology.corners(f)) print(" {}", topology.vertex(c).value + 1);
        print("\n");
    }
    print("t interpolateboundary 1/0/0 {}\n", static_cast<int>(topology.boundary_rule()));
    if (topology.crease_rule() == CreaseRule::ParabolicRunout)
        print("#patchwright crease-rule {}\n", runout_rule);
    for (const EdgeId e : topology.edges()) {
        if (topology.tagged_sharpness(e) > 0.0) {
            print("t crease 2/1/0 {} {} {}\n", topology.start(e).value, topology.end(e).value,
                  written_sharpness(topology.tagged_sharpness(e)));
        }
    }
    for (const VertexId v : topology.vertices()) {
        if (topology.tagged_sharpness(v) > 0.0) {
            print("t corner 1/1/0 {} {}\n", v.value,
                  written_sharpness(topology.tagged_sharpness(v)));
        }
        if (topology.is_pinned(v)) print("#patchwright pin {}\n", v.value);
    }
    for (const SectorTagInput& tag : topology.sectors()) {
        print("#patchwright sector {} {} {}", tag.vertex, tag.face, tag.angle * 180.0 / M_PI);
        if (tag.normal != std::array<double, 3>{}) {
            print(" {} {} {}", tag.normal[0], tag.normal[1], tag.normal[2]);
        }
        print("\n");
    }
    return fmt::to_string(out);
}

}  // namespace patchwright::mesh
