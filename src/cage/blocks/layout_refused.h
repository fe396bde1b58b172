// Why a model cannot be laid out in blocks.
#pragma once

#include <string>

namespace patchwright::cage {

/// The model is not one for this layout: the text says why.
struct LayoutRefused {
    std::string why;
    bool for_good = false;  ///< shorter edges would not help
};

}  // namespace patchwright::cage
