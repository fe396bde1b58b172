// Looks for a wing along one direction.
#pragma once

#include "cage/sections/wing.h"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace patchwright::cage {

// Fractions of the span.
inline constexpr double flat_rel = 2e-4;      ///< twice the triangles' deflection: lies at an end
inline constexpr double inside_rel = 2e-5;    ///< sections at an end are taken this far inside
inline constexpr double in_plane_rel = 3e-3;  ///< curves that span less run around the body
inline constexpr double distinct_rel = 5e-3;  ///< rings nearer to each other are one

class WingFinder {
  public:
    /// @param known_tail  curves of the trailing edge, among others that are looked for
    WingFinder(const SurfaceBody& body, const geom::ModelSurface& reference,
               const WingOptions& options, Spine spine, Poll& poll, std::set<int> known_tail = {})
        : reference_(reference),
          options_(options),
          poll_(poll),
          wing_{.slicer = Slicer(body, std::move(spine))} {
        wing_.lines.tail = std::move(known_tail);
        wing_.span = wing_.slicer.high() - wing_.slicer.low();
        wing_.ends[0].extreme = wing_.slicer.low();
        wing_.ends[1].extreme = wing_.slicer.high();
        wing_.ends[0].outward = -1.0;
    }

    std::optional<Wing> run();

    [[nodiscard]] const std::string& why_not() const { return why_not_; }
    /// How far the search came.
    [[nodiscard]] int sections_found() const { return found_; }

  private:
    using Height = double;
    using SectionCuts = std::map<Height, std::vector<SectionLoop>>;

    [[nodiscard]] std::string percent(double height) const {
        return fmt::format("at {:.0f} % of the span",
                           100.0 * (height - wing_.slicer.low()) / wing_.span);
    }

    bool refuse(std::string why) {
        why_not_ = std::move(why);
        return false;
    }

    [[nodiscard]] const WingSection* known_near(double height) const;

    [[nodiscard]] SectionResult section_at(double height) const {
        poll_();
        return wing_section(wing_.slicer.cut(height), wing_.lines, reference_, known_near(height));
    }

    bool is_wing();
    /// Finds curves that run around the body between its ends and need a crease, as at a bend.
    void find_lines_around();
    /// Finds the curves of the trailing edge on most sections.
    bool find_tail(SectionCuts& cuts);
    /// Finds curves along the nose; a few sections with one are a flaw of the model.
    void find_nose(const SectionCuts& cuts);
    /// Every section has a trailing edge and a nose, of one kind all along.
    bool all_are_sections(const SectionCuts& cuts);

    bool classify(WingEnd& end);
    /// The section that far inside of an end, or nearer where the span is short.
    [[nodiscard]] SectionResult section_beside(const WingEnd& end, double inward) const;

    /// A sharp curve from the end of the trailing edge round the outermost points to the nose.
    void find_ridge(WingEnd& end, const WingSection& near) const;

    /// Of ends that close themselves: where the tip starts.
    bool place_ring(WingEnd& end, const WingSection& near);

    [[nodiscard]] bool on_body(int curve) const;
    [[nodiscard]] bool runs_along_section(int curve, double height) const;
    [[nodiscard]] bool at_an_end(std::pair<double, double> range) const;

    /// Heights at which feature curves of any kind run around the body.
    [[nodiscard]] std::vector<double> lines_around() const;

    [[nodiscard]] std::pair<double, double> range_of(int curve) const;

    /// Whether long sharp lines lie along the trailing edge, near the nose or at flat and sharp
    /// ends: what else is sharp, such as a rib within, the layout would lose.
    bool all_lines_known();

    /// Where lines along the span begin and end within it.
    void find_span_of_lines();

    /// Heights of sections between the ends and of those that the ends are.
    [[nodiscard]] std::vector<double> stations() const;

    /// Halves intervals whose middle section is off the line between both ends' sections.
    void add_where_bent(std::vector<double>& heights) const;

    [[nodiscard]] bool spine_bends(double low, double high) const;

    /// Parts intervals beside short ones in which the span bends.
    void part_beside_bends(std::vector<double>& heights) const;

    /// The end whose rim is the section at this height; nothing where the rim is in the way.
    bool add_section(double height);

    const geom::ModelSurface& reference_;
    const WingOptions& options_;
    Poll& poll_;
    Wing wing_;
    std::map<Height, WingSection> known_;
    std::vector<double> line_ends_;
    std::string why_not_;
    int found_ = 0;
};

}  // namespace patchwright::cage
