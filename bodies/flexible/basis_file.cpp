#include "bodies/flexible/basis_file.h"

#include <algorithm>
#include <cmath>

#include "bodies/flexible/drawn_skin.h"
#include "engine/base/error.h"
#include "engine/output/hdf5_file.h"

namespace lithe {
namespace {

constexpr std::int64_t kVersion = 1;
constexpr const char* kKind = "lithe modal basis";

// ---- parts, each written and read side by side ----

void write_sparse(Hdf5Writer& file, const std::string& name, const SparseMatrix& A) {
  std::vector<int> rows, starts{0};
  std::vector<double> values;
  for (int column = 0; column < A.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator entry(A, column); entry; ++entry) {
      rows.push_back(static_cast<int>(entry.row()));
      values.push_back(entry.value());
    }
    starts.push_back(static_cast<int>(rows.size()));
  }
  file.write(name + "/size", std::vector<int>{static_cast<int>(A.rows()), static_cast<int>(A.cols())});
  file.write(name + "/column_starts", starts);
  file.write(name + "/rows", rows);
  file.write(name + "/values", values);
}

SparseMatrix read_sparse(const Hdf5Reader& file, const std::string& name, Eigen::Index size) {
  const std::vector<int> extent = file.integers(name + "/size", 2);
  if (extent[0] != size || extent[1] != size)
    file.refuse(name, "is " + std::to_string(extent[0]) + " x " + std::to_string(extent[1]) + " instead of " +
                          std::to_string(size) + " x " + std::to_string(size));
  const std::vector<int> starts = file.integers(name + "/column_starts", size + 1);
  const std::vector<int> rows = file.integers(name + "/rows");
  const std::vector<double> values = file.numbers(name + "/values", static_cast<std::int64_t>(rows.size()));
  const auto refuse = [&] { file.refuse(name, "has entries out of order or out of place"); };
  if (starts.front() != 0 || starts.back() != static_cast<int>(rows.size())) refuse();
  for (Eigen::Index column = 0; column < size; ++column) {
    const int from = starts[static_cast<size_t>(column)], to = starts[static_cast<size_t>(column) + 1];
    if (from > to || from < 0 || to > static_cast<int>(rows.size())) refuse();
    for (int k = from; k < to; ++k) {
      const int row = rows[static_cast<size_t>(k)];
      if (row < 0 || row >= size || (k > from && row <= rows[static_cast<size_t>(k) - 1])) refuse();
    }
  }
  return Eigen::Map<const SparseMatrix>(size, size, static_cast<Eigen::Index>(rows.size()), starts.data(), rows.data(),
                                        values.data());
}

void write_integrals(Hdf5Writer& file, const std::string& name, const InertiaIntegrals& I) {
  file.write(name + "/mass", std::vector<double>{I.mass});
  file.write(name + "/s0", MatrixX(I.s0));
  file.write(name + "/Ct", I.Ct);
  file.write(name + "/J0", MatrixX(I.J0));
  file.write(name + "/J1", I.J1);
  file.write(name + "/J2", I.J2);
  file.write(name + "/C0", I.C0);
  file.write(name + "/C1", I.C1);
  file.write(name + "/Mff", I.Mff);
  file.write(name + "/antisymmetric", std::vector<int>{I.antisymmetric});
}

InertiaIntegrals read_integrals(const Hdf5Reader& file, const std::string& name) {
  InertiaIntegrals I;
  I.Ct = file.matrix(name + "/Ct", 3);
  const Eigen::Index nm = I.Ct.cols();
  I.mass = file.numbers(name + "/mass", 1)[0];
  I.s0 = file.matrix(name + "/s0", 3, 1);
  I.J0 = file.matrix(name + "/J0", 6, 1);
  I.J1 = file.matrix(name + "/J1", 6, nm);
  I.J2 = file.matrix(name + "/J2", 6 * nm, nm);
  I.C0 = file.matrix(name + "/C0", 3, nm);
  I.C1 = file.matrix(name + "/C1", 3 * nm, nm);
  I.Mff = file.matrix(name + "/Mff", nm, nm);
  I.antisymmetric = file.integers(name + "/antisymmetric", 1)[0] != 0;
  return I;
}

void write_deflection(Hdf5Writer& file, const std::string& name, const QuadraticDeflection& deflection) {
  file.write(name + "/fields", deflection.fields);
  file.write(name + "/curvature", deflection.curvature);
  write_integrals(file, name + "/integrals", deflection.integrals);
  file.write(name + "/quartic", deflection.quartic);
}

std::shared_ptr<const QuadraticDeflection> read_deflection(const Hdf5Reader& file, const std::string& name,
                                                           Eigen::Index dofs, Eigen::Index nm) {
  auto deflection = std::make_shared<QuadraticDeflection>();
  deflection->fields = file.matrix(name + "/fields", dofs);
  const Eigen::Index all = nm + deflection->fields.cols();
  const Eigen::Index pairs = nm * (nm + 1) / 2;
  deflection->curvature = file.matrix(name + "/curvature", all, pairs);
  deflection->integrals = read_integrals(file, name + "/integrals");
  if (deflection->integrals.mode_count() != all) file.refuse(name + "/integrals", "are not of all modes and fields");
  deflection->quartic = file.matrix(name + "/quartic");
  if (deflection->quartic.size() > 0 && (deflection->quartic.rows() != pairs || deflection->quartic.cols() != pairs))
    file.refuse(name + "/quartic", "is not pairs x pairs");
  return deflection;
}

/// Lists of lists as their lengths and all entries in a row.
void write_lists(Hdf5Writer& file, const std::string& name, const std::vector<std::vector<int>>& lists) {
  std::vector<int> lengths, entries;
  for (const auto& list : lists) {
    lengths.push_back(static_cast<int>(list.size()));
    entries.insert(entries.end(), list.begin(), list.end());
  }
  file.write(name + "_lengths", lengths);
  file.write(name, entries);
}

std::vector<std::vector<int>> read_lists(const Hdf5Reader& file, const std::string& name) {
  const std::vector<int> lengths = file.integers(name + "_lengths"), entries = file.integers(name);
  std::vector<std::vector<int>> lists;
  size_t from = 0;
  for (int length : lengths) {
    if (length < 0 || entries.size() - from < static_cast<size_t>(length)) file.refuse(name, "ends within a list");
    lists.emplace_back(entries.begin() + static_cast<long>(from), entries.begin() + static_cast<long>(from) + length);
    from += static_cast<size_t>(length);
  }
  if (from != entries.size()) file.refuse(name, "has entries that belong to no list");
  return lists;
}

void write_elements(Hdf5Writer& file, const std::vector<ElementBlock>& blocks) {
  std::vector<std::string> types;
  for (size_t k = 0; k < blocks.size(); ++k) {
    types.push_back(blocks[k].type);
    const Material& m = blocks[k].material;
    const std::string name = "/elements/" + std::to_string(k);
    file.write(name + "/material", std::vector<double>{m.young, m.poisson, m.density});
    write_lists(file, name + "/nodes", blocks[k].nodes);
  }
  file.write("/elements/types", types);
}

std::vector<ElementBlock> read_elements(const Hdf5Reader& file, int node_count) {
  std::vector<ElementBlock> blocks;
  for (const std::string& type : file.texts("/elements/types")) {
    const std::string name = "/elements/" + std::to_string(blocks.size());
    const std::vector<double> m = file.numbers(name + "/material", 3);
    blocks.push_back({type, read_lists(file, name + "/nodes"), {m[0], m[1], m[2]}});
    for (const auto& element : blocks.back().nodes)
      for (int node : element)
        if (node < 0 || node >= node_count) file.refuse(name + "/nodes", "uses a node that is not there");
  }
  return blocks;
}

void write_skin(Hdf5Writer& file, const DrawnSkin& skin) {
  const auto flat = [](const auto& rows) {
    std::vector<int> all;
    for (const auto& row : rows) all.insert(all.end(), row.begin(), row.end());
    return all;
  };
  file.write("/skin/points", skin.points);
  file.write("/skin/nodes", flat(skin.nodes));
  file.write("/skin/shares", skin.shares);
  file.write("/skin/triangles", flat(skin.triangles));
  file.write("/skin/edges", flat(skin.edges));
}

void require_indices(const Hdf5Reader& file, const std::string& name, const std::vector<int>& indices, int count) {
  if (std::any_of(indices.begin(), indices.end(), [count](int i) { return i < 0 || i >= count; }))
    file.refuse(name, "has an index beyond the " + std::to_string(count) + " there are");
}

/// Rows of so many indices, `rows` of them or as many as there are (-1).
template <std::size_t width>
std::vector<std::array<int, width>> read_rows(const Hdf5Reader& file, const std::string& name, std::int64_t rows,
                                              int count) {
  const std::vector<int> all = rows < 0 ? file.integers(name) : file.integers(name, rows * std::int64_t{width});
  if (all.size() % width != 0) file.refuse(name, "ends within a row of " + std::to_string(width));
  require_indices(file, name, all, count);
  std::vector<std::array<int, width>> out(all.size() / width);
  for (std::size_t i = 0; i < all.size(); ++i) out[i / width][i % width] = all[i];
  return out;
}

std::shared_ptr<const DrawnSkin> read_skin(const Hdf5Reader& file, int node_count) {
  auto skin = std::make_shared<DrawnSkin>();
  skin->points = file.matrix("/skin/points", 3);
  const auto count = static_cast<int>(skin->points.cols());
  skin->nodes = read_rows<2>(file, "/skin/nodes", count, node_count);
  skin->shares = file.numbers("/skin/shares", count);
  skin->triangles = read_rows<3>(file, "/skin/triangles", -1, count);
  skin->edges = read_rows<2>(file, "/skin/edges", -1, count);
  return skin;
}

}  // namespace

void write_modal_basis(const ModalBasis& basis, const std::string& path) try {
  Hdf5Writer file(path);
  file.attribute("/", "kind", kKind);
  file.attribute("/", "version", kVersion);
  file.write("/name", basis.name);
  file.write("/origin", MatrixX(basis.origin));
  file.write("/rotation", MatrixX(basis.rotation));
  file.write("/node_ids", basis.node_ids);
  std::vector<std::string> names;
  std::vector<std::vector<int>> sets;
  for (const auto& [name, ids] : basis.node_sets) {
    names.push_back(name);
    sets.push_back(ids);
  }
  file.write("/node_sets/names", names);
  write_lists(file, "/node_sets/ids", sets);
  write_elements(file, basis.elements);
  if (basis.skin) write_skin(file, *basis.skin);
  file.write("/nodes", basis.nodes);
  std::vector<int> turned_nodes, turned_axes;
  for (const RotationalDof& turn : basis.rotations) {
    turned_nodes.push_back(turn.node);
    turned_axes.push_back(turn.axis);
  }
  file.write("/rotations/nodes", turned_nodes);
  file.write("/rotations/axes", turned_axes);
  write_sparse(file, "/nodal_mass", basis.nodal_mass);
  file.write("/modes", basis.modes);
  file.write("/flags", std::vector<int>{basis.nodal, basis.diagonal, basis.free_swing_dropped});
  file.write("/free_dofs", basis.free_dofs);
  write_sparse(file, "/stiffness", basis.stiffness);
  write_sparse(file, "/modal_mass", basis.modal_mass);
  file.write("/damping", basis.damping);
  write_integrals(file, "/integrals", basis.integrals);
  file.write("/frequencies", MatrixX(basis.frequencies));
  if (basis.deflection) write_deflection(file, "/deflection", *basis.deflection);
  file.attribute("/nodes", "unit", "m");
  file.attribute("/frequencies", "unit", "Hz");
  file.commit();
} catch (...) {
  rethrow_as_error("writing the file", path, "see what it says; an older file of that name is unharmed");
}

std::shared_ptr<const ModalBasis> read_modal_basis(const std::string& path) try {
  const Hdf5Reader file(path);
  if (const std::string kind = file.text_attribute("/", "kind"); kind != kKind)
    file.refuse("/", "is a '" + kind + "' and no '" + kKind + "'");
  if (const std::int64_t version = file.number_attribute("/", "version"); version != kVersion)
    throw FileError("the basis has version " + std::to_string(version) + ", this program reads version " +
                        std::to_string(kVersion) + ".",
                    path, "write it again from the finite-element model, or use the program that wrote it.");
  auto basis = std::make_shared<ModalBasis>();
  basis->name = file.text("/name");
  basis->origin = file.matrix("/origin", 3, 1);
  basis->rotation = file.matrix("/rotation", 3, 3);
  basis->nodes = file.matrix("/nodes", 3);
  const auto n = static_cast<int>(basis->nodes.cols());
  basis->node_ids = file.integers("/node_ids", n);
  const std::vector<std::string> names = file.texts("/node_sets/names");
  const std::vector<std::vector<int>> sets = read_lists(file, "/node_sets/ids");
  if (names.size() != sets.size()) file.refuse("/node_sets", "has another number of names than of sets");
  for (size_t k = 0; k < names.size(); ++k) basis->node_sets[names[k]] = sets[k];
  basis->elements = read_elements(file, n);
  if (file.has("/skin/points")) basis->skin = read_skin(file, n);
  const std::vector<int> turned_nodes = file.integers("/rotations/nodes");
  const std::vector<int> turned_axes = file.integers("/rotations/axes", static_cast<std::int64_t>(turned_nodes.size()));
  require_indices(file, "/rotations/nodes", turned_nodes, n);
  require_indices(file, "/rotations/axes", turned_axes, 3);
  for (size_t k = 0; k < turned_nodes.size(); ++k) basis->rotations.push_back({turned_nodes[k], turned_axes[k]});
  const Eigen::Index dofs = 3 * n + static_cast<Eigen::Index>(turned_nodes.size());

  const std::vector<int> flags = file.integers("/flags", 3);
  basis->nodal = flags[0] != 0, basis->diagonal = flags[1] != 0, basis->free_swing_dropped = flags[2] != 0;
  basis->free_dofs = file.integers("/free_dofs");
  require_indices(file, "/free_dofs", basis->free_dofs, static_cast<int>(dofs));
  basis->modes = file.matrix("/modes");
  const Eigen::Index nm = basis->nodal ? static_cast<Eigen::Index>(basis->free_dofs.size()) : basis->modes.cols();
  if (!basis->nodal && basis->modes.rows() != dofs) file.refuse("/modes", "do not fit the nodes");
  basis->nodal_mass = read_sparse(file, "/nodal_mass", n);
  basis->stiffness = read_sparse(file, "/stiffness", nm);
  basis->modal_mass = read_sparse(file, "/modal_mass", nm);
  basis->damping = file.matrix("/damping");
  if (basis->damping.size() > 0 && (basis->damping.rows() != nm || basis->damping.cols() != nm))
    file.refuse("/damping", "does not fit the number of modes");
  basis->integrals = read_integrals(file, "/integrals");
  if (basis->integrals.mass > 0 && basis->integrals.mode_count() != nm)
    file.refuse("/integrals", "do not fit the number of modes");
  basis->frequencies = file.matrix("/frequencies", Hdf5Reader::kAny, 1);
  if (basis->frequencies.size() != (basis->nodal ? 0 : nm)) file.refuse("/frequencies", "do not fit the modes");
  if (file.has("/deflection")) basis->deflection = read_deflection(file, "/deflection", dofs, nm);
  return basis;
} catch (...) {
  rethrow_as_error("reading the file", path, "see what it says");
}

}  // namespace lithe
