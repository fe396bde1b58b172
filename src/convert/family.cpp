#include <patchwright/base/about_input.h>
#include <patchwright/base/parallel.h>
#include <patchwright/convert/family.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <iterator>

namespace patchwright::convert {

namespace {

FamilyMember fit_member(const mesh::Cage& cage, const std::filesystem::path& file,
                        const FamilyOptions& options, const base::Budget& budget) {
    const auto start = std::chrono::steady_clock::now();
    FamilyMember member{.file = file};
    const auto fit = [&] {
        SourceOptions reading = options.reading;
        reading.progress = budget.limited();
        const Source source = read_source(file, reading);
        if (source.is_control_mesh)
            throw base::InputError("this is a control mesh, as its tags tell, and no design");
        member.tolerance_mm = options.tolerance.in_millimetres(source.input.diagonal);
        member.notices = source.notices;
        Conversion fitted = fit_only(source,
                                     {.tolerance_mm = member.tolerance_mm,
                                      .cage = cage,
                                      .symmetry = options.symmetry,
                                      .refit = true,
                                      .earlier = options.earlier},
                                     budget);
        member.attempt = std::move(fitted.attempts.front());
        std::move(fitted.notices.begin(), fitted.notices.end(), std::back_inserter(member.notices));
    };
    try {
        base::about_input(file.string(), fit);
    } catch (const base::TimeLimitReached&) {
        member.notices.emplace_back("the time limit came before there was a result");
    }
    member.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return member;
}

}  // namespace

std::vector<FamilyMember> fit_family(const mesh::Cage& cage,
                                     const std::vector<std::filesystem::path>& designs,
                                     const FamilyOptions& options, const base::Budget& budget) {
    std::vector<FamilyMember> members(designs.size());
    std::atomic<bool> cancelled{false};
    std::atomic<std::size_t> done{0};
    const base::Budget of_tasks =
        budget.with([&cancelled](std::string_view, double) { return !cancelled; });
    const auto poll = [&] {
        try {
            base::report_progress(budget.unlimited(), "fit designs",
                                  double(done) / double(designs.size()));
        } catch (...) {
            cancelled = true;
            throw;
        }
    };
    const auto task = [&](std::size_t i) {
        try {
            members[i] = fit_member(cage, designs[i], options, of_tasks);
            ++done;
        } catch (...) {
            cancelled = true;
            throw;
        }
    };
    base::run_tasks(designs.size(), task, poll);
    return members;
}

}  // namespace patchwright::convert
