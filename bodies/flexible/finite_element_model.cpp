#include "bodies/flexible/finite_element_model.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>

#include "bodies/flexible/general_inertia.h"
#include "bodies/flexible/sparse_cholesky.h"
#include "engine/base/error.h"
#include "engine/base/number_text.h"

namespace lithe {
namespace {

// Bounds of require_sound(). CalculiX prints 14 digits, so its matrices are symmetric and rigid to some 1e-13.
constexpr double kAsymmetryBound = 1e-10;
constexpr double kRigidBound = 1e-8;
// K + shift M, shift = this times tr K / tr M: above the noise of printed matrices, far below the first eigenvalue.
constexpr double kDefiniteShift = 1e-10;
constexpr double kMassShift = 1e-10;  // of the mean diagonal: above the round-off of a singular mass matrix

std::string where(const FiniteElementModel& model) { return "model '" + model.name + "'"; }

/// Of a matrix that need not be compressed: a user fills it as he likes.
double max_entry(const SparseMatrix& A) {
  double largest = 0;
  for (int column = 0; column < A.outerSize(); ++column)
    for (SparseMatrix::InnerIterator entry(A, column); entry; ++entry)
      largest = std::max(largest, std::abs(entry.value()));
  return largest;
}

double asymmetry(const SparseMatrix& A) {
  const SparseMatrix difference = A - SparseMatrix(A.transpose());
  const double scale = max_entry(A);
  return scale > 0 ? max_entry(difference) / scale : 0.0;
}

void require_square(const FiniteElementModel& model, const SparseMatrix& A, const char* what) {
  const int dofs = model.dof_count();
  if (A.rows() == dofs && A.cols() == dofs) return;
  const std::string turns =
      model.rotations.empty() ? "" : " with " + std::to_string(model.rotations.size()) + " rotations";
  throw SceneError("the " + std::string(what) + " matrix is " + std::to_string(A.rows()) + " x " +
                       std::to_string(A.cols()) + ", but " + std::to_string(model.node_count()) + " nodes" + turns +
                       " have " + std::to_string(dofs) + " degrees of freedom.",
                   where(model), "give the matrix of all nodes, three translations each, without supports.");
}

void require_finite(const FiniteElementModel& model, const SparseMatrix& A, const char* what) {
  for (int column = 0; column < A.outerSize(); ++column)
    for (SparseMatrix::InnerIterator entry(A, column); entry; ++entry)
      if (!std::isfinite(entry.value()))
        throw SceneError("the " + std::string(what) + " matrix has a NaN or infinite entry at row " +
                             std::to_string(entry.row() + 1) + ", column " + std::to_string(column + 1) + ".",
                         where(model), "export the matrices again; the finite-element run has failed.");
}

void require_labels(const FiniteElementModel& model) {
  if (model.node_count() == 0) throw SceneError("the model has no nodes.", where(model), "give at least four nodes.");
  if (static_cast<int>(model.node_ids.size()) != model.node_count())
    throw SceneError(
        std::to_string(model.node_ids.size()) + " node labels for " + std::to_string(model.node_count()) + " nodes.",
        where(model), "give one label a node.");
  std::vector<int> labels = model.node_ids;
  std::sort(labels.begin(), labels.end());
  const auto twice = std::adjacent_find(labels.begin(), labels.end());
  if (twice != labels.end())
    throw SceneError("two nodes have the label " + std::to_string(*twice) + ".", where(model), "number nodes once.");
  if (!model.nodes.allFinite())
    throw SceneError("a node coordinate is NaN or infinite.", where(model), "export the nodes again.");
  for (const auto& [set, members] : model.node_sets)
    for (int id : members)
      if (!std::binary_search(labels.begin(), labels.end(), id))
        throw SceneError("node set '" + set + "' names node " + std::to_string(id) + ", which the model does not have.",
                         where(model), "remove it from the set or add the node.");
  for (const ElementBlock& block : model.elements)
    for (const auto& element : block.nodes)
      for (int node : element)
        if (node < 0 || node >= model.node_count())
          throw SceneError("an element of type " + block.type + " uses node index " + std::to_string(node) + " of " +
                               std::to_string(model.node_count()) + " nodes.",
                           where(model), "element connectivity is by node index, counted from 0.");
}

void require_rotations(const FiniteElementModel& model) {
  std::set<std::pair<int, int>> seen;
  for (const RotationalDof& turn : model.rotations) {
    if (turn.node < 0 || turn.node >= model.node_count() || turn.axis < 0 || turn.axis > 2)
      throw SceneError("a nodal rotation is about axis " + std::to_string(turn.axis) + " of node index " +
                           std::to_string(turn.node) + " of " + std::to_string(model.node_count()) + " nodes.",
                       where(model), "node indices count from 0, axes are 0, 1, 2.");
    if (!seen.insert({turn.node, turn.axis}).second)
      throw SceneError("node " + std::to_string(model.node_ids[turn.node]) + " has two rotations about one axis.",
                       where(model), "list a degree of freedom once.");
  }
}

/// m_ij E, three equal diagonals a block.
SparseMatrix isotropic(const SparseMatrix& scalar) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(3 * static_cast<size_t>(scalar.nonZeros()));
  for (int j = 0; j < scalar.outerSize(); ++j)
    for (SparseMatrix::InnerIterator m(scalar, j); m; ++m)
      for (int axis = 0; axis < 3; ++axis)
        entries.emplace_back(3 * static_cast<int>(m.row()) + axis, 3 * j + axis, m.value());
  SparseMatrix S(3 * scalar.rows(), 3 * scalar.cols());
  S.setFromTriplets(entries.begin(), entries.end());
  return S;
}

/// max over nodes of |sum_j S_ij - k_i E|, relative to max|k_i| (eqs. 19-20).
double row_sum_deviation(const SparseMatrix& mass) {
  const Matrix3X unit = Matrix3::Identity().replicate(1, mass.cols() / 3);
  const MatrixX sums = mass * unit.transpose();  // 3n x 3, block i = sum_j S_ij
  double worst = 0, scale = 0;
  for (Eigen::Index i = 0; i < sums.rows() / 3; ++i) {
    const Matrix3 block = sums.middleRows<3>(3 * i);
    const double k = block.trace() / 3;
    worst = std::max(worst, (block - k * Matrix3::Identity()).cwiseAbs().maxCoeff());
    scale = std::max(scale, std::abs(k));
  }
  return scale > 0 ? worst / scale : 0.0;
}

/// Every node has mass, and no motion has a negative one. That some motion has none is borne: CalculiX integrates the
/// mass of tetrahedra at too few points for a regular matrix.
bool positive_mass(const SparseMatrix& M) {
  const VectorX diagonal = M.diagonal();
  if (!(diagonal.minCoeff() > 0)) return false;
  SparseMatrix shifted = M;
  shifted.diagonal() += VectorX::Constant(M.rows(), kMassShift * diagonal.mean());
  return SparseCholesky(shifted).positive_definite();
}

}  // namespace

int find_node_index(const std::string& name, const std::vector<int>& node_ids, int id) {
  // Labels mostly count 1, 2, 3 ... or at least upwards; anything else is searched through.
  const int n = static_cast<int>(node_ids.size());
  if (id >= 1 && id <= n && node_ids[static_cast<size_t>(id - 1)] == id) return id - 1;
  auto found = std::lower_bound(node_ids.begin(), node_ids.end(), id);
  if (found == node_ids.end() || *found != id) found = std::find(node_ids.begin(), node_ids.end(), id);
  if (found != node_ids.end()) return static_cast<int>(found - node_ids.begin());

  std::vector<int> nearest = node_ids;
  const auto distance = [id](int a) { return std::abs(static_cast<long>(a) - id); };
  std::sort(nearest.begin(), nearest.end(),
            [&](int a, int b) { return distance(a) != distance(b) ? distance(a) < distance(b) : a < b; });
  std::string labels;
  for (size_t k = 0; k < std::min<size_t>(3, nearest.size()); ++k)
    labels += (k == 0 ? "" : ", ") + std::to_string(nearest[k]);
  throw SceneError("no node " + std::to_string(id) + ".", "model '" + name + "'", "nearest labels are " + labels + ".");
}

const std::vector<int>& find_node_set(const std::string& name, const std::map<std::string, std::vector<int>>& node_sets,
                                      const std::string& set) {
  // Readers store names in lower case: decks do not distinguish.
  std::string key = set;
  for (char& c : key) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const std::string& spelt : {set, key})
    if (const auto found = node_sets.find(spelt); found != node_sets.end()) return found->second;
  std::string known;
  for (const auto& [other, members] : node_sets) known += (known.empty() ? "" : ", ") + other;
  throw SceneError("no node set '" + set + "'.", "model '" + name + "'",
                   known.empty() ? "the model has no node sets; name the nodes by label." : "known are " + known + ".");
}

int FiniteElementModel::node_index(int id) const { return find_node_index(name, node_ids, id); }

const std::vector<int>& FiniteElementModel::node_set(const std::string& set) const {
  return find_node_set(name, node_sets, set);
}

SparseMatrix scalar_mass(const SparseMatrix& mass) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<size_t>(mass.nonZeros()));
  for (int column = 0; column < mass.outerSize(); ++column)
    for (SparseMatrix::InnerIterator entry(mass, column); entry; ++entry)
      if (entry.row() % 3 == column % 3)
        entries.emplace_back(static_cast<int>(entry.row()) / 3, column / 3, entry.value() / 3);
  SparseMatrix m(mass.rows() / 3, mass.cols() / 3);
  m.setFromTriplets(entries.begin(), entries.end());
  return m;
}

MatrixX rigid_motions(const Matrix3X& nodes, const Vector3& center) {
  MatrixX R(3 * nodes.cols(), 6);
  for (Eigen::Index i = 0; i < nodes.cols(); ++i) {
    R.block<3, 3>(3 * i, 0).setIdentity();
    R.block<3, 3>(3 * i, 3) = -skew(nodes.col(i) - center);
  }
  return R;
}

ModelCheck check(const FiniteElementModel& model, Definiteness definiteness) {
  require_labels(model);
  require_square(model, model.stiffness, "stiffness");
  require_square(model, model.mass, "mass");
  require_finite(model, model.stiffness, "stiffness");
  require_finite(model, model.mass, "mass");
  require_rotations(model);
  if (model.damping.size() > 0) {
    require_square(model, model.damping, "damping");
    require_finite(model, model.damping, "damping");
  }

  const SparseMatrix &K = model.stiffness, &M = model.mass;
  ModelCheck found;
  found.name = model.name;
  found.nodes = model.node_count();
  found.rotations = static_cast<int>(model.rotations.size());
  found.stiffness_asymmetry = asymmetry(K);
  found.mass_asymmetry = asymmetry(M);

  const RigidMass rigid_part = rigid_mass(model);
  found.mass = rigid_part.mass;
  found.center = rigid_part.center;
  found.inertia = rigid_part.inertia;

  // Six rigid motions about the centre must meet no force. Rotations count by the length that makes their stiffnesses
  // comparable to those of translations, so that the figure does not depend on the unit of length.
  VectorX unit = VectorX::Ones(model.dof_count());
  if (found.rotations > 0) {
    const double length2 = K.diagonal().tail(found.rotations).mean() / K.diagonal().head(3 * found.nodes).mean();
    if (length2 > 0) unit.tail(found.rotations).setConstant(1 / std::sqrt(length2));
  }
  const double norm = unit.cwiseProduct(K.cwiseAbs() * unit).maxCoeff();
  const MatrixX rigid = rigid_motions(model.nodes, model.rotations, found.center);
  const MatrixX force = unit.asDiagonal() * (K * rigid);
  for (int k = 0; k < 6; ++k) {
    const double scale = norm * rigid.col(k).cwiseQuotient(unit).cwiseAbs().maxCoeff();
    found.rigid_residual[k] = scale > 0 ? force.col(k).cwiseAbs().maxCoeff() / scale : 0.0;
  }

  // S_ij = m_ij E? If so, M is positive exactly if m is, at a ninth of the entries.
  {
    const SparseMatrix S = translations(M, found.nodes), m = scalar_mass(S), anisotropic = S - isotropic(m);
    const double mass_scale = max_entry(S);
    found.mass_isotropy = mass_scale > 0 ? max_entry(anisotropic) / mass_scale : 0.0;
    found.row_sum_deviation = row_sum_deviation(S);
    found.mass_positive = positive_mass(is_scalar_interpolation(model, found) ? m : M);
  }

  if (definiteness == Definiteness::not_looked_at) return found;
  // K is only semidefinite; a shift above its rounding noise makes Cholesky decide, and Sylvester count if it fails.
  const double shift = found.mass > 0 ? kDefiniteShift * K.diagonal().sum() / M.diagonal().sum() : 0.0;
  const SparseMatrix shifted = K + shift * M;
  if (!SparseCholesky(shifted).positive_definite()) found.stiffness_negative = count_negative_eigenvalues(shifted);
  return found;
}

ModelCheck require_sound(const FiniteElementModel& model, Definiteness definiteness) {
  const ModelCheck found = check(model, definiteness);
  const auto refuse = [&](const std::string& problem, const std::string& fix) {
    throw SceneError(problem, where(model), fix);
  };
  const auto beyond = [](double value, double bound) {
    return three_digits(value) + ", the bound is " + three_digits(bound) + ".";
  };

  if (found.stiffness_asymmetry > kAsymmetryBound)
    refuse("K is not symmetric: max|K - K'| / max|K| is " + beyond(found.stiffness_asymmetry, kAsymmetryBound),
           "export a linear static stiffness, without contact, follower loads or damping.");
  if (found.mass_asymmetry > kAsymmetryBound)
    refuse("M is not symmetric: max|M - M'| / max|M| is " + beyond(found.mass_asymmetry, kAsymmetryBound),
           "export the mass matrix again.");
  if (!(found.mass > 0))
    refuse("the mass is " + three_digits(found.mass) + " kg, it must be positive.",
           "give the material a density and check the units.");
  if (!found.mass_positive)
    refuse("the mass matrix is not positive definite.",
           "every node needs mass: use a consistent mass, or give all elements a density.");
  if (model.damping.size() > 0 && asymmetry(model.damping) > kAsymmetryBound)
    refuse("the damping matrix is not symmetric: max|C - C'| / max|C| is " +
               beyond(asymmetry(model.damping), kAsymmetryBound),
           "export viscous damping alone, without gyroscopic terms.");
  for (int k = 0; k < 6; ++k)
    if (found.rigid_residual[k] > kRigidBound)
      refuse("a rigid " + std::string(k < 3 ? "translation along " : "rotation about ") + "xyz"[k % 3] +
                 " meets stiffness: |K r| / (|K| |r|) is " + beyond(found.rigid_residual[k], kRigidBound),
             "export the free body: no supports, no springs to ground, no preload, node positions in full precision.");
  if (found.stiffness_negative > 0)
    refuse("K is indefinite: it has " + std::to_string(found.stiffness_negative) +
               " negative eigenvalue(s), the bound is 0.",
           "export the unloaded, unbuckled body and check the material (0 <= nu < 0.5, E > 0).");
  return found;
}

std::string ModelCheck::report() const {
  char text[2000];
  const double rigid = *std::max_element(std::begin(rigid_residual), std::end(rigid_residual));
  const auto verdict = [](bool sound) { return sound ? "ok" : "REFUSED"; };
  const bool scalar = rotations == 0 && mass_isotropy <= kIsotropyBound;
  std::snprintf(
      text, sizeof text,
      "model '%s', %d nodes, %d nodal rotations\n"
      "  mass                      %.6g kg  %s\n"
      "  centre of mass            %.6g %.6g %.6g m\n"
      "  inertia about it          xx %.6g  yy %.6g  zz %.6g  xy %.6g  xz %.6g  yz %.6g kg m2\n"
      "  M positive definite       %s  %s\n"
      "  K negative eigenvalues    %d  %s\n"
      "  K asymmetry               %.1e  (bound %.0e)  %s\n"
      "  M asymmetry               %.1e  (bound %.0e)  %s\n"
      "  rigid motion meets force  %.1e  (bound %.0e)  %s\n"
      "  M off m_ij E              %.1e  (bound %.0e)  %s\n"
      "  M row sums off k_i E      %.1e\n"
      "%s",
      name.substr(0, 200).c_str(), nodes, rotations, mass, verdict(mass > 0), center[0], center[1], center[2],
      inertia(0, 0), inertia(1, 1), inertia(2, 2), inertia(0, 1), inertia(0, 2), inertia(1, 2),
      mass_positive ? "yes" : "no", verdict(mass_positive), stiffness_negative, verdict(stiffness_negative == 0),
      stiffness_asymmetry, kAsymmetryBound, verdict(stiffness_asymmetry <= kAsymmetryBound), mass_asymmetry,
      kAsymmetryBound, verdict(mass_asymmetry <= kAsymmetryBound), rigid, kRigidBound, verdict(rigid <= kRigidBound),
      mass_isotropy, kIsotropyBound, scalar ? "ok" : "note", row_sum_deviation,
      scalar ? ""
             : "  note: M is no scalar interpolation. Mass, centre, inertia and their coupling to deformation\n"
               "        are exact; how deformation changes them is that of masses lumped at the nodes.\n");
  return text;
}

}  // namespace lithe
