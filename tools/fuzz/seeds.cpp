// Writes the first inputs of the targets whose files are binary, one sound file each, into tests/data/fuzz/TARGET/seed:
//   seeds tests/data/fuzz
#include <filesystem>

#include "bodies/flexible/basis_file.h"
#include "engine/output/binary.h"
#include "engine/output/csv.h"
#include "engine/output/hdf5_table.h"

namespace lithe {
namespace {

Table table() {
  Table made{.columns = {"t", "tip, \"x\""}};
  made.add_row({0, 1.5});
  made.add_row({0.1, -2e-300});
  return made;
}

SparseMatrix unit(int n) {
  SparseMatrix E(n, n);
  E.setIdentity();
  return E;
}

/// Two nodes and one mode; its numbers mean nothing.
ModalBasis basis() {
  ModalBasis b;
  b.name = "seed";
  b.node_ids = {7, 9};
  b.node_sets = {{"both", {7, 9}}};
  b.elements = {{"C3D8", {{0, 1}}, {1, 0.3, 1}}};
  b.nodes = Matrix3X::Identity(3, 2);
  b.rotations = {{1, 2}};
  b.nodal_mass = unit(2);
  b.modes = MatrixX::Ones(7, 1);
  b.stiffness = b.modal_mass = unit(1);
  b.diagonal = true;
  InertiaIntegrals& I = b.integrals;
  I.mass = 1, I.s0.setZero(), I.J0.setOnes();
  I.Ct = Matrix3X::Zero(3, 1), I.J1 = MatrixX::Zero(6, 1), I.J2 = MatrixX::Zero(6, 1);
  I.C0 = Matrix3X::Zero(3, 1), I.C1 = MatrixX::Zero(3, 1), I.Mff = MatrixX::Identity(1, 1);
  b.frequencies = VectorX::Ones(1);
  return b;
}

}  // namespace
}  // namespace lithe

int main(int count, char** arguments) {
  const std::filesystem::path folder = count > 1 ? arguments[1] : ".";
  lithe::write_csv(lithe::table(), (folder / "csv/seed").string());
  lithe::write_binary(lithe::table(), (folder / "binary/seed").string());
  lithe::write_hdf5(lithe::table(), (folder / "hdf5_table/seed").string());
  lithe::write_modal_basis(lithe::basis(), (folder / "basis/seed").string());
}
