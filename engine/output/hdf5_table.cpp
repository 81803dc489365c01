#include "engine/output/hdf5_table.h"

#include "engine/base/error.h"
#include "engine/output/hdf5_file.h"

namespace lithe {

void write_hdf5(const Table& table, const std::string& path) try {
  if (table.columns.empty()) throw SceneError("the table has no columns.", path, "give it columns before writing it.");
  Hdf5Writer file(path);
  // Row-major values are the columns of the transposed matrix: HDF5 sees rows x columns.
  file.write("/values", Eigen::Map<const MatrixX>(table.values.data(), static_cast<Eigen::Index>(table.columns.size()),
                                                  table.row_count()));
  file.write("/columns", table.columns);
  file.attribute("/", "kind", "lithe table");
  file.commit();
} catch (...) {
  rethrow_as_error("writing the file", path, "see what it says; an older file of that name is unharmed");
}

Table read_hdf5_table(const std::string& path) try {
  const Hdf5Reader file(path);
  Table table{.columns = file.texts("/columns")};
  const MatrixX values = file.matrix("/values", static_cast<std::int64_t>(table.columns.size()));
  table.values.assign(values.data(), values.data() + values.size());
  return table;
} catch (...) {
  rethrow_as_error("reading the file", path, "see what it says");
}

}  // namespace lithe
