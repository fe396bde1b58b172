// How much memory there is to work with.
#pragma once

namespace patchwright::base {

/// Bytes that this process may have at most: the machine's memory, or its limit of addresses where
/// that is less.
double memory_bytes();

}  // namespace patchwright::base
