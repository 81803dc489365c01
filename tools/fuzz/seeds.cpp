// Writes the first inputs of the targets whose files are binary or long, one sound file each, into
// tests/data/fuzz/TARGET/seed:   fuzz_seeds tests/data/fuzz
#include <filesystem>
#include <fstream>

#include "bodies/flexible/basis_file.h"
#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/output/binary.h"
#include "engine/output/csv.h"
#include "engine/output/hdf5_file.h"
#include "engine/output/hdf5_table.h"
#include "engine/page/run_record_internal.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "joints/contact/contact.h"
#include "joints/revolute_joint.h"
#include "tools/fuzz/targets.h"

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

/// A flexible rod on a hinge and a ball on the floor, with an event: each kind of array, few numbers.
void write_run_seeds(const std::string& run_file, const std::string& run_scene) {
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  const auto modes = make_basis(brick_mesh({.size = {1, 0.1, 0.1},
                                            .divisions = {1, 1, 1},
                                            .type = "C3D8I",
                                            .material = {2e8, 0.3, 1200},
                                            .name = "rod"}),
                                MeanAxisFrame{}, 2, {.deflection = Deflection::quadratic});
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = modes});
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, along_y), rod.average({1, 2}, along_y)});
  auto& ball = graph.add<RigidBody>("ball", {.mass = 1, .inertia = {1, 1, 1}, .position = {2, 0, 0.09}});
  graph.add<Contact>("touch", {{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(0.1)}},
                     {.law = Compliance{.stiffness = 1e4}});
  const System system = assemble(graph);
  GeneralizedAlpha integrator{{.step = 1e-3}};
  Simulation simulation{system, integrator};
  Run run{system, {position(ball.marker(), "ball")}, {.coordinates = false, .energies = false}};
  simulation.observe(run, every(0.01));
  State state = system.initial_state();
  simulation.run(state, 0.02);
  run.add({{0.01, "touched", -1}});
  const RunRecord& record = *run.record();
  const auto by_rows = [](const std::vector<double>& all, int width) {
    return MatrixX(Eigen::Map<const MatrixX>(all.data(), width, static_cast<Eigen::Index>(all.size()) / width));
  };
  const MatrixX rows = by_rows(record.rows, record.width),
                contacts = by_rows(record.contacts, RunRecord::kContactWidth);

  std::ofstream text(run_scene);
  std::string names;
  int number = 0;
  Hdf5Writer file(run_file);
  for (const auto& [name, values] : record.sets) {
    text << name << ' ' << values.rows() << ' ' << values.cols() << '\n';
    file.write("/set_" + std::to_string(number++), values);
    names += name + '\n';
  }
  for (const auto& [kind, all] : {std::pair("row", &rows), std::pair("contact", &contacts)})
    for (Eigen::Index i = 0; i < all->cols(); ++i) text << kind << ' ' << all->col(i).transpose() << '\n';
  text << '\n' << record.scene;
  const auto bytes = [](const std::string& all) { return std::vector<int>(all.begin(), all.end()); };
  file.write("/scene", bytes(record.scene));
  file.write("/set_names", bytes(names));
  file.write("/rows", rows);
  file.write("/contacts", contacts);
  file.write("/events", MatrixX::Ones(61, 1));
  file.attribute("/", "format", std::string("lithe run"));
  file.attribute("/", "version", std::string("1"));
  file.commit();
}

}  // namespace
}  // namespace lithe

int main(int count, char** arguments) {
  const std::filesystem::path folder = count > 1 ? arguments[1] : ".";
  for (const char* target : {"csv", "binary", "hdf5_table", "basis", "checkpoint_file", "run_file", "run_scene"})
    std::filesystem::create_directories(folder / target);
  lithe::write_csv(lithe::table(), (folder / "csv/seed").string());
  lithe::write_binary(lithe::table(), (folder / "binary/seed").string());
  lithe::write_hdf5(lithe::table(), (folder / "hdf5_table/seed").string());
  lithe::write_modal_basis(lithe::basis(), (folder / "basis/seed").string());
  lithe::fuzz::write_checkpoint_seed((folder / "checkpoint_file/seed").string());
  lithe::write_run_seeds((folder / "run_file/seed").string(), (folder / "run_scene/seed").string());
}
