#pragma once

#include <string>

#include "engine/output/table.h"

namespace lithe {

/// A table as an HDF5 file: "/values", rows x columns, and "/columns", their names as bytes, each closed by a zero (in
/// Python: bytes(f["columns"]).split(b"\0")). The file appears under its name only when complete. Throws FileError if
/// it cannot be written, SceneError for a table without columns.
void write_hdf5(const Table& table, const std::string& path);

/// Reads what write_hdf5() writes; FileError for another file, and for one that is damaged or cut.
Table read_hdf5_table(const std::string& path);

}  // namespace lithe
