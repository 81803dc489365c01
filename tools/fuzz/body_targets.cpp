// Readers of finite-element files: what they accept is finite and fits together.
#include <algorithm>
#include <fstream>
#include <set>

#include "bodies/flexible/modal_basis.h"
#include "bodies/flexible/readers/abaqus.h"
#include "bodies/flexible/readers/ansys.h"
#include "bodies/flexible/readers/calculix.h"
#include "bodies/flexible/readers/calculix_modes.h"
#include "bodies/flexible/readers/gmsh.h"
#include "bodies/flexible/readers/harwell_boeing.h"
#include "bodies/flexible/readers/matrix_market.h"
#include "bodies/flexible/readers/nastran.h"
#include "bodies/flexible/readers/sid.h"
#include "tools/fuzz/targets.h"

namespace lithe::fuzz {
namespace {

bool finite(const SparseMatrix& A) { return A.nonZeros() == 0 || A.coeffs().allFinite(); }

void check_matrix(const SparseMatrix& A, Eigen::Index size) {
  demand(A.rows() == size && A.cols() == size, "a matrix does not fit the degrees of freedom");
  demand(finite(A), "a matrix has an entry that is not finite");
}

void check_elements(const std::vector<ElementBlock>& elements, int nodes) {
  for (const ElementBlock& block : elements) {
    demand(std::isfinite(block.material.young + block.material.poisson + block.material.density),
           "a material is not finite");
    for (const auto& element : block.nodes)
      for (const int node : element) demand(node >= 0 && node < nodes, "an element has a node that is not there");
  }
}

enum class Matrices { given, left_out };  // by a mesh

void check_model(const FiniteElementModel& model, Matrices matrices = Matrices::given) {
  demand(static_cast<Eigen::Index>(model.node_ids.size()) == model.nodes.cols(), "labels do not fit the nodes");
  const std::set<int> ids(model.node_ids.begin(), model.node_ids.end());
  demand(ids.size() == model.node_ids.size(), "two nodes have one label");
  demand(model.nodes.allFinite(), "a node's position is not finite");
  for (const RotationalDof& turn : model.rotations)
    demand(turn.node >= 0 && turn.node < model.node_count() && turn.axis >= 0 && turn.axis < 3,
           "a rotation is of a node or axis that is not there");
  const int size = matrices == Matrices::given ? model.dof_count() : 0;
  check_matrix(model.stiffness, size);
  check_matrix(model.mass, size);
  if (model.damping.size() > 0) check_matrix(model.damping, model.dof_count());
  for (const StressStiffness& stress : model.stress_stiffness) {
    demand(stress.load.size() == model.dof_count() && stress.load.allFinite(), "a load does not fit");
    check_matrix(stress.matrix, model.dof_count());
  }
  for (const auto& [name, set] : model.node_sets)
    for (const int id : set) demand(ids.contains(id), "a set has a node that is not there");
  check_elements(model.elements, model.node_count());
}

void check_basis(const ModalBasis& basis) {
  const Eigen::Index modes = basis.mode_count(), dofs = basis.nodes.size() + Eigen::Index(basis.rotations.size());
  demand(static_cast<Eigen::Index>(basis.node_ids.size()) == basis.nodes.cols(), "labels do not fit the nodes");
  demand(basis.nodes.allFinite() && basis.modes.allFinite(), "nodes or modes are not finite");
  demand(basis.modes.rows() == dofs && basis.modes.cols() == modes, "modes do not fit the nodes");
  check_matrix(basis.stiffness, modes);
  check_matrix(basis.modal_mass, modes);
  demand(basis.damping.allFinite() && (basis.damping.size() == 0 || basis.damping.rows() == modes),
         "the damping does not fit");
  demand(basis.integrals.mode_count() == modes, "the integrals do not fit the modes");
  demand(std::isfinite(basis.integrals.mass) && basis.integrals.J0.allFinite() && basis.integrals.C1.allFinite() &&
             basis.integrals.J2.allFinite(),
         "the integrals are not finite");
  demand(basis.frequencies.allFinite() && basis.frequencies.size() == modes, "frequencies do not fit the modes");
}

/// A model for mode shapes to belong to.
FiniteElementModel four_nodes() {
  FiniteElementModel model;
  model.node_ids = {1, 2, 3, 4};
  model.nodes = Matrix3X::Zero(3, 4);
  return model;
}

/// The files of a body in one input: what follows a line "=== name" becomes the file job.name. Returns ".../job".
std::string job_of(std::string_view input, const std::filesystem::path& folder) {
  const std::string job = (folder / "job").string();
  while (!input.empty()) {
    const size_t line_end = std::min(input.find('\n'), input.size());
    std::string_view name = input.substr(0, line_end);
    input.remove_prefix(std::min(line_end + 1, input.size()));
    const size_t next = input.find("\n=== ");
    const std::string_view text = input.substr(0, next == std::string_view::npos ? next : next + 1);
    if (name.starts_with("=== ")) name.remove_prefix(4);
    // No other names than those below: an input must not reach for files elsewhere.
    for (const char* known : {"sid", "msh", "frd", "inp", "sti", "mas", "dof", "K", "M", "nodes", "sets", "elements",
                              "mapping", "bdf", "op4"})
      if (name == known) std::ofstream(job + "." + known, std::ios::binary) << text;
    input.remove_prefix(text.size());
  }
  return job;
}

template <void (*read)(const std::string& job)>
void run(std::string_view input, const std::filesystem::path& folder) {
  read(job_of(input, folder));
}

void sid(const std::string& job) { check_basis(*read_sid(job + ".sid").basis); }
void gmsh(const std::string& job) {
  check_model(read_gmsh(job + ".msh", Material{2.1e11, 0.3, 7850}), Matrices::left_out);
}
void frd(const std::string& job) {
  const ImportedModes modes = read_calculix_modes(job + ".frd", four_nodes());
  demand(modes.frequencies.allFinite() && modes.shapes.allFinite(), "a mode is not finite");
  demand(modes.shapes.cols() == modes.frequencies.size() && (modes.shapes.size() == 0 || modes.shapes.rows() == 12),
         "modes do not fit");
}
void calculix(const std::string& job) { check_model(read_calculix(job)); }
void matrix_market(const std::string& job) {
  check_model(read_matrix_market(job + ".K", job + ".M", job + ".nodes", job + ".sets", job + ".elements"));
}
void abaqus(const std::string& job) { check_model(read_abaqus({job + ".inp", job + ".K", job + ".M"})); }
void ansys(const std::string& job) {
  check_model(read_ansys({job + ".K", job + ".M", job + ".mapping", job + ".nodes"}));
}
void harwell_boeing(const std::string& job) {
  const SparseMatrix A = read_harwell_boeing(job + ".K");
  demand(finite(A), "a matrix has an entry that is not finite");
}
void nastran(const std::string& job) { check_model(read_nastran({.deck = job + ".bdf"})); }
void op4(const std::string& job) { check_model(read_nastran({.deck = job + ".bdf", .matrices = {job + ".op4"}})); }

}  // namespace

std::vector<Target> body_targets() {
  return {{"calculix", run<calculix>}, {"matrix_market", run<matrix_market>},
          {"sid", run<sid>},           {"gmsh", run<gmsh>},
          {"frd", run<frd>},           {"abaqus", run<abaqus>},
          {"ansys", run<ansys>},       {"harwell_boeing", run<harwell_boeing>},
          {"nastran", run<nastran>},   {"op4", run<op4>}};
}

}  // namespace lithe::fuzz
