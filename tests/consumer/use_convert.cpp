#include <patchwright/convert/convert.h>

#include <iostream>

int main(int, char** files) {
    using namespace patchwright;
    const convert::Source source = convert::read_source(files[1]);
    const auto result = convert::convert(source, files[2], {.tolerance_mm = 0.3});
    if (!result.kept) return 3;
    const auto& verdict = result.attempts[*result.kept].verdict;
    std::cout << verdict.sentence(base::LengthUnit::Millimetre) << "\n";
    return verdict.met() ? 0 : 3;
}
