#include "occ/step_text.h"

#include <patchwright/base/error.h>

#include <charconv>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace patchwright::occ {

namespace {

constexpr std::size_t line_length = 80;

bool is_space(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

/// Takes a data section apart into statements without white space outside strings.
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
    std::int64_t meaning = 0;        ///< as written; that of its twin when it is left away
    std::size_t begin = 0, end = 0;  ///< of the text behind '=', in the pool
    bool left_away = false;
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
            if (!instance.left_away) write(instance, out);
        }
        out += text.substr(end + 1);
        return out;
    }

  private:
    void collect(std::string_view section) {
        // Twins are found by their text in the pool, which must not move meanwhile.
        pool_.reserve(section.size());
        std::unordered_map<std::string_view, std::int64_t> known;
        Statements statements(section);
        std::string statement;
        std::int64_t written = 0;
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
            const auto body =
                std::string_view(pool_).substr(instance.begin, instance.end - instance.begin);
            if (body.starts_with("CARTESIAN_POINT(") || body.starts_with("DIRECTION(")) {
                const auto [twin, added] = known.try_emplace(body, written + 1);
                instance.left_away = !added;
                instance.meaning = twin->second;
            }
            if (!instance.left_away) instance.meaning = ++written;
            if (meaning_.size() <= std::size_t(instance.number)) {
                meaning_.resize(std::size_t(instance.number) + 1 + meaning_.size() / 2);
            }
            meaning_[std::size_t(instance.number)] = instance.meaning;
            instances_.push_back(instance);
        }
    }

    void write(const Instance& instance, std::string& out) const {
        LineWriter line(out);
        const auto body =
            std::string_view(pool_).substr(instance.begin, instance.end - instance.begin);
        std::string token = '#' + std::to_string(instance.meaning) + '=';
        for (std::size_t k = 0; k < body.size(); ++k) {
            const char c = body[k];
            if (c == '\'') {
                const std::size_t close = body.find('\'', k + 1);
                token += body.substr(k, close - k + 1);
                k = close;
            } else if (c == '#') {
                std::int64_t number = 0;
                const char* start = body.data() + k + 1;
                const char* stop = std::from_chars(start, body.data() + body.size(), number).ptr;
                token += '#' + std::to_string(meaning_[std::size_t(number)]);
                k += std::size_t(stop - start);
            } else {
                token += c;
                if (c == ',' ||
                    (c == ')' && k + 1 < body.size() && body[k + 1] != ',' && body[k + 1] != ')')) {
                    line.put(token);
                    token.clear();
                }
            }
        }
        token += ';';
        line.put(token);
        line.end_line();
    }

    std::string pool_;
    std::vector<Instance> instances_;
    std::vector<std::int64_t> meaning_;  // by number as read
};

}  // namespace

std::string compact_step(std::string_view text) { return Compactor().run(text); }

}  // namespace patchwright::occ
