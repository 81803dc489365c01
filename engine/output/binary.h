#pragma once

#include <string>

#include "engine/output/table.h"

namespace lithe {

/// A table as a small binary file: exact, and quick to load for long runs. All little-endian, no padding:
///
///   8 bytes   "LITHETBL"
///   uint32    version, 1
///   uint32    column count
///   uint64    row count
///   names     for each column: uint32 length, then so many bytes of UTF-8
///   values    float64, row-major, row count × column count
///   uint64    FNV-1a hash of all bytes above
///
/// Parent folders are created; the file appears under its name only when complete. Throws FileError if it cannot be
/// written.
void write_binary(const Table& table, const std::string& path);

/// Reads what write_binary() writes; throws FileError for another format or version, a truncated or a damaged file.
Table read_binary(const std::string& path);

}  // namespace lithe
