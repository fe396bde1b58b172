// What HDF5 files of equal contents differ in.
#pragma once

#include <filesystem>

namespace patchwright::grid {

/// Clears what the CGNS library leaves to the clock and to chance, so that equal contents are equal
/// bytes: the four times of every object header, and what lies behind the end of fixed-length
/// strings in attributes (it writes 33 bytes of a buffer that it did not fill). Checksums are made
/// anew; only headers whose checksum was right are touched.
/// Source: HDF5 File Format Specification 3.0, IV.A.1.b (object headers, version 2), IV.A.2.m
/// (attributes, version 3), IV.A.2.q (continuations).
/// @return how many headers there are
/// @throw OutputError when the file cannot be read or written
int make_reproducible(const std::filesystem::path& file);

}  // namespace patchwright::grid
