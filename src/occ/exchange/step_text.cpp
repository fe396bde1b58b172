#include "occ/exchange/step_text.h"

#include <patchwright/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

namespace patchwright::occ {

namespace {

constexpr std::size_t line_length = 80;
/// The context of p-curves, of which the kernel writes one for each.
constexpr std::string_view plane_context =
    "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()";

bool is_space(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

/// Takes a data section apart into statements, without white space and comments outside strings.
class Statements {
  public:
    explicit Statements(std::string_view text) : text_(text) {}

    /// False at the end; `statement` without its semicolon otherwise.
    bool next(std::string& statement) {
        statement.clear();
        bool in_string = false;
        for (; at_ < text_.size(); ++at_) {
            const char c = text_[at_];
            if (c == '\'') in_string = !in_string;
            if (!in_string && text_.substr(at_, 2) == "/*") {
                at_ = std::min(text_.find("*/", at_ + 2), text_.size() - 2) + 1;
                continue;
            }
            if (c == ';' && !in_string) {
                ++at_;
                return true;
            }
            if (in_string || !is_space(c)) statement += c;
        }
        return false;
    }

  private:
    std::string_view text_;
    std::size_t at_ = 0;
};

/// Appends statements, breaking lines between parameters.
class LineWriter {
  public:
    explicit LineWriter(std::string& out) : out_(out) {}

    void put(std::string_view token) {
        if (column_ > 0 && column_ + token.size() > line_length) {
            out_ += '\n';
            column_ = 0;
        }
        out_ += token;
        column_ += token.size();
    }
    void end_line() {
        out_ += '\n';
        column_ = 0;
    }

  private:
    std::string& out_;
    std::size_t column_ = 0;
};

struct Instance {
    std::int64_t number = 0;         ///< as read
    std::int64_t meaning = 0;        ///< as written; that of its twin when it is omitted
    std::size_t begin = 0, end = 0;  ///< of the text behind '=', in the pool
    bool omitted = false;
};

class Compactor {
  public:
    std::string run(std::string_view text) {
        constexpr std::string_view data = "\nDATA;", end_section = "\nENDSEC;";
        const std::size_t begin = text.find(data);
        const std::size_t end = text.find(end_section, begin);
        if (begin == std::string_view::npos || end == std::string_view::npos) {
            throw base::OutputError("the CAD kernel wrote a STEP file without data");
        }
        const std::size_t first = begin + data.size();
        collect(text.substr(first, end - first));
        std::string out(text.substr(0, first));
        out += '\n';
        out.reserve(pool_.size() + pool_.size() / 8 + text.size() - end);
        for (const Instance& instance : instances_) {
            if (!instance.omitted) write(instance, out);
        }
        out += text.substr(end + 1);
        return out;
    }

  private:
    void collect(std::string_view section) {
        pool_.reserve(section.size());
        Statements statements(section);
        std::string statement;
        while (statements.next(statement)) {
            const std::size_t equals = statement.find('=');
            Instance instance;
            if (statement.empty() || statement[0] != '#' || equals == std::string::npos) {
                throw base::OutputError("the CAD kernel wrote a STEP file that is not understood");
            }
            std::from_chars(statement.data() + 1, statement.data() + equals, instance.number);
            instance.begin = pool_.size();
            pool_.append(statement, equals + 1);
            instance.end = pool_.size();
            if (meaning_.size() <= std::size_t(instance.number)) {
                meaning_.resize(std::size_t(instance.number) + 1 + meaning_.size() / 2);
            }
            meaning_[std::size_t(instance.number)] = instance.number;
            instances_.push_back(instance);
        }
        // Each kind refers to those before it only, so that twins have equal texts by then.
        for (const std::string_view kind : std::initializer_list<std::string_view>{
                 "CARTESIAN_POINT(", "DIRECTION(", "VECTOR(", "LINE(", plane_context,
                 "DEFINITIONAL_REPRESENTATION("}) {
            share(kind);
        }
        written_as_.resize(meaning_.size());
        std::int64_t written = 0;
        for (const Instance& instance : instances_) {
            if (!instance.omitted) written_as_[std::size_t(instance.number)] = ++written;
        }
    }

    /// Lets all instances of a kind with the same text stand for the first of them.
    void share(std::string_view kind) {
        std::unordered_map<std::string_view, std::int64_t> known;
        std::deque<std::string> renumbered;  // what the map's keys look at
        for (Instance& instance : instances_) {
            std::string_view text = body_of(instance);
            if (!text.starts_with(kind)) continue;
            if (text.find('#') != std::string_view::npos) {
                std::string& own = renumbered.emplace_back();
                rewrite(
                    text, [&](std::int64_t n) { return meaning_[std::size_t(n)]; },
                    [&](const std::string& token) { own += token; });
                text = own;
            }
            const auto [twin, added] = known.try_emplace(text, instance.number);
            instance.omitted = !added;
            meaning_[std::size_t(instance.number)] = twin->second;
        }
    }

    [[nodiscard]] std::string_view body_of(const Instance& instance) const {
        return std::string_view(pool_).substr(instance.begin, instance.end - instance.begin);
    }

    /// Hands over the body in pieces that lines may be broken between, references renumbered.
    template <class Number, class Put>
    static void rewrite(std::string_view body, Number&& number, Put&& put) {
        std::string token;
        for (std::size_t k = 0; k < body.size(); ++k) {
            const char c = body[k];
            if (c == '\'') {
                const std::size_t close = body.find('\'', k + 1);
                token += body.substr(k, close - k + 1);
                k = close;
            } else if (c == '#') {
                std::int64_t referred = 0;
                const char* start = body.data() + k + 1;
                const char* stop = std::from_chars(start, body.data() + body.size(), referred).ptr;
                token += '#' + std::to_string(number(referred));
                k += std::size_t(stop - start);
            } else {
                token += c;
                if (c == ',') {
                    put(token);
                    token.clear();
                }
            }
        }
        put(token);
    }

    void write(const Instance& instance, std::string& out) const {
        LineWriter line(out);
        line.put('#' + std::to_string(written_as_[std::size_t(instance.number)]) + '=');
        const auto number = [&](std::int64_t n) {
            return written_as_[std::size_t(meaning_[std::size_t(n)])];
        };
        rewrite(body_of(instance), number, [&](const std::string& token) { line.put(token); });
        line.put(";");
        line.end_line();
    }

    std::string pool_;
    std::vector<Instance> instances_;
    std::vector<std::int64_t> meaning_;     // by number as read: the twin that stays
    std::vector<std::int64_t> written_as_;  // by number as read
};

/// The character that starts `text` in UTF-8, which is shortened by it; a byte that starts none
/// stands for itself.
char32_t take_character(std::string_view& text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const std::size_t length = byte(0) >= 0xF0 ? 4 : byte(0) >= 0xE0 ? 3 : byte(0) >= 0xC0 ? 2 : 1;
    constexpr unsigned lead_bits[] = {0, 0xFF, 0x1F, 0x0F, 0x07};
    char32_t character = byte(0) & lead_bits[length];
    for (std::size_t i = 1; i < length; ++i) {
        if (i >= text.size() || (byte(i) & 0xC0) != 0x80) {
            character = byte(0);
            text.remove_prefix(1);
            return character;
        }
        character = (character << 6) | (byte(i) & 0x3F);
    }
    text.remove_prefix(length);
    return character;
}

bool is_ascii(char c) { return static_cast<unsigned char>(c) < 0x80; }

}  // namespace

std::string compact_step(std::string_view text) { return Compactor().run(text); }

std::string encode_step_text(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    while (!text.empty()) {
        const auto plain = std::find_if_not(text.begin(), text.end(), is_ascii);
        out.append(text.begin(), plain);
        text.remove_prefix(std::size_t(plain - text.begin()));
        while (!text.empty() && !is_ascii(text.front())) {
            const char32_t character = take_character(text);
            const bool wide = character > 0xFFFF;
            out += fmt::format(fmt::runtime(wide ? "\\X4\\{:08X}\\X0\\" : "\\X2\\{:04X}\\X0\\"),
                               std::uint32_t(character));
        }
    }
    return out;
}

StepInstances step_instances(std::string_view text, const std::set<int>& numbers) {
    StepInstances result;
    Statements statements(text);
    std::string statement;
    while (statements.next(statement)) {
        const std::size_t equals = statement.find('=');
        if (statement.empty() || statement[0] != '#' || equals == std::string::npos) continue;
        int number = 0;
        std::from_chars(statement.data() + 1, statement.data() + equals, number);
        if (numbers.count(number) > 0) result[number] = statement.substr(equals + 1);
    }
    return result;
}

std::vector<int> step_references(std::string_view instance) {
    std::vector<int> result;
    bool in_string = false;
    for (std::size_t i = 0; i < instance.size(); ++i) {
        if (instance[i] == '\'') in_string = !in_string;
        if (in_string || instance[i] != '#') continue;
        std::from_chars(instance.data() + i + 1, instance.data() + instance.size(),
                        result.emplace_back(0));
    }
    return result;
}

std::string step_type(std::string_view instance) {
    const std::size_t open = instance.find('(');
    if (open != 0) return std::string(instance.substr(0, open));
    std::string result;
    int depth = 0;
    bool in_string = false;
    for (const char c : instance) {
        if (c == '\'') in_string = !in_string;
        if (in_string) continue;
        if (c == ')') --depth;
        if (c != '(' && c != ')' && depth == 1) result += c;
        if (c == '(' && ++depth == 2) result += '+';
    }
    if (!result.empty()) result.pop_back();
    return result;
}

}  // namespace patchwright::occ
