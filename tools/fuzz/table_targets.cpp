// Tables and reduced bodies: what is accepted can be written and is then read alike.
#include <cstring>
#include <fstream>
#include <iterator>

#include "bodies/flexible/basis_file.h"
#include "engine/output/binary.h"
#include "engine/output/csv.h"
#include "engine/output/hdf5_table.h"
#include "tools/fuzz/targets.h"

namespace lithe::fuzz {
namespace {

void check(const Table& table) {
  demand(!table.columns.empty() || table.values.empty(), "a table has values and no columns");
  demand(table.columns.empty() || table.values.size() % table.columns.size() == 0, "a row is incomplete");
}

/// Bit for bit; any NaN for any other.
bool same(const Table& a, const Table& b) {
  if (a.columns != b.columns || a.values.size() != b.values.size()) return false;
  for (std::size_t i = 0; i < a.values.size(); ++i)
    if (std::memcmp(&a.values[i], &b.values[i], sizeof(double)) != 0 &&
        !(a.values[i] != a.values[i] && b.values[i] != b.values[i]))
      return false;
  return true;
}

void csv(std::string_view input, const std::filesystem::path& folder) {
  const Table table = read_csv(file_of(input, folder, "table.csv"));
  check(table);
  const std::string again = (folder / "again.csv").string();
  write_csv(table, again);
  demand(same(read_csv(again), table), "what is written again is read otherwise");
}

void binary(std::string_view input, const std::filesystem::path& folder) {
  const Table table = read_binary(file_of(input, folder, "table.bin"));
  check(table);
  const std::string again = (folder / "again.bin").string();
  write_binary(table, again);
  std::ifstream stream(again, std::ios::binary);
  demand(std::string(std::istreambuf_iterator<char>(stream), {}) == input, "the file is not what its content makes");
}

void hdf5_table(std::string_view input, const std::filesystem::path& folder) {
  const Table table = read_hdf5_table(file_of(input, folder, "table.h5"));
  check(table);
  if (table.columns.empty()) return;
  const std::string again = (folder / "again.h5").string();
  write_hdf5(table, again);
  demand(same(read_hdf5_table(again), table), "what is written again is read otherwise");
}

void basis(std::string_view input, const std::filesystem::path& folder) {
  const auto basis = read_modal_basis(file_of(input, folder, "body.basis"));
  const std::string again = (folder / "again.basis").string();
  write_modal_basis(*basis, again);
  const auto twice = read_modal_basis(again);
  demand(twice->nodes == basis->nodes && twice->modes == basis->modes && twice->node_ids == basis->node_ids,
         "what is written again is read otherwise");
  demand(basis->nodes.allFinite() && basis->modes.allFinite() && basis->frequencies.allFinite() &&
             basis->integrals.Mff.allFinite() && basis->rotation.allFinite() && basis->origin.allFinite(),
         "a basis has a value that is not finite");
  for (const SparseMatrix* A : {&basis->stiffness, &basis->modal_mass, &basis->nodal_mass})
    demand(A->nonZeros() == 0 || A->coeffs().allFinite(), "a matrix has an entry that is not finite");
}

}  // namespace

std::vector<Target> table_targets() {
  return {{"csv", csv}, {"binary", binary}, {"hdf5_table", hdf5_table}, {"basis", basis}};
}

}  // namespace lithe::fuzz
