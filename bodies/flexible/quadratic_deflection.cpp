#include "bodies/flexible/quadratic_deflection.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "bodies/flexible/elastic_problem.h"
#include "bodies/flexible/elements/solid_element.h"
#include "bodies/flexible/general_inertia.h"
#include "bodies/flexible/inertia_integrals.h"
#include "bodies/flexible/static_modes.h"
#include "engine/base/error.h"
#include "engine/base/log.h"

namespace lithe {
namespace {

constexpr double kSmallestField = 1e-7;  // of the largest: round-off below
constexpr double kElementsMatch = 1e-6;  // StiffnessDifference: files of six digits and more; materials differ by more

/// Symmetric tensors as (xx yy zz xy yz xz), shear as 2 E_xy.
Vector6 strain_of(const Matrix3& H) {
  return (Vector6() << H(0, 0), H(1, 1), H(2, 2), H(0, 1) + H(1, 0), H(1, 2) + H(2, 1), H(0, 2) + H(2, 0)).finished();
}
Matrix3 stress_tensor(const Vector6& s) {
  return (Matrix3() << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]).finished();
}

int pair_of(int k, int l) { return k <= l ? l * (l + 1) / 2 + k : k * (k + 1) / 2 + l; }

/// Vectors of the mesh's axes from the body's, node by node; R: body axes to mesh axes.
MatrixX turned(const MatrixX& columns, const Matrix3& R) {
  MatrixX result(columns.rows(), columns.cols());
  for (Eigen::Index i = 0; i < columns.rows(); i += 3) result.middleRows<3>(i) = R * columns.middleRows<3>(i);
  return result;
}

/// Derivatives of the strain energy at rest along the modes (mesh axes, a column a pair of modes); internal
/// coordinates of the elements condensed, and what they relax beside it.
struct EnergyDerivatives {
  MatrixX stress_forces;   // 3n x pairs: v ↦ 2 ∫ C E2(φ_k, φ_l) : ∇v
  MatrixX turning_forces;  // 3n x pairs: v ↦ ∫ (H_l C ε_k + H_k C ε_l) : ∇v
  MatrixX membrane;        // pairs x pairs: ∫ E2_kl C E2_mn
  MatrixX relaxed;         // pairs x pairs, internal coordinates alone: s_kl K_ii⁻¹ s_mn, s the stress forces
  MatrixX turned;          // pairs x pairs, the same: -t_kl K_ii⁻¹ s_mn, t the turning forces
};

/// Adds one element's share; `whole`: all that the energy of fourth order needs. H: displacement gradients at a point.
void add_element(const SolidElement& element, const MatrixX& modes, bool whole, EnergyDerivatives& out) {
  const auto nm = static_cast<int>(modes.cols()), pairs = nm * (nm + 1) / 2;
  const auto shapes = static_cast<Eigen::Index>(element.nodes.size()) + element.internal;
  const auto inner = 3 * element.internal;
  const Matrix6 C = elasticity(element.material);
  MatrixX coordinates(3 * shapes, nm);
  MatrixX stress_forces = MatrixX::Zero(3 * shapes, pairs),
          turning_forces = MatrixX::Zero(3 * shapes, whole ? pairs : 0);
  for (int k = 0; k < nm; ++k) coordinates.col(k) = element.coordinates_of(modes.col(k));
  MatrixX strains(6, pairs);
  std::vector<Matrix3> H(static_cast<size_t>(nm)), S(static_cast<size_t>(nm));
  for (const SolidPoint& point : element.points) {
    const auto add = [&](MatrixX& forces, int column, const Matrix3& stress) {
      Eigen::Map<Matrix3X>(forces.col(column).data(), 3, shapes) +=
          point.volume * (stress * point.gradients.transpose());
    };
    for (int k = 0; k < nm; ++k) {
      const auto at = static_cast<size_t>(k);
      H[at] = Eigen::Map<const Matrix3X>(coordinates.col(k).data(), 3, shapes) * point.gradients;
      if (whole) S[at] = stress_tensor(C * strain_of(H[at]));
    }
    for (int l = 0; l < nm; ++l)
      for (int k = 0; k <= l; ++k) {
        const auto a = static_cast<size_t>(k), b = static_cast<size_t>(l);
        const int p = pair_of(k, l);
        strains.col(p) = strain_of(Matrix3(0.5 * H[a].transpose() * H[b]));  // E2: strain_of() takes the symmetric part
        add(stress_forces, p, 2 * stress_tensor(C * strains.col(p)));
        if (whole) add(turning_forces, p, H[b] * S[a] + H[a] * S[b]);
      }
    if (whole) out.membrane.noalias() += strains.transpose() * (point.volume * C * strains);
  }
  // Internal (incompatible) modes relax inside the element: they are condensed, and what they relieve of the energy of
  // fourth order is kept beside it.
  if (inner > 0 && whole) {
    const MatrixX relaxation = element.internal_compliance * stress_forces.bottomRows(inner);
    out.relaxed.noalias() += stress_forces.bottomRows(inner).transpose() * relaxation;
    out.turned.noalias() -= turning_forces.bottomRows(inner).transpose() * relaxation;
  }
  const auto scatter = [&](MatrixX& forces, MatrixX& nodal) {
    const auto count = static_cast<Eigen::Index>(element.nodes.size());
    if (inner > 0)
      forces.topRows(3 * count).noalias() += element.internal_from_nodal.transpose() * forces.bottomRows(inner).eval();
    for (Eigen::Index a = 0; a < count; ++a)
      nodal.middleRows<3>(3 * element.nodes[static_cast<size_t>(a)]) += forces.middleRows<3>(3 * a);
  };
  scatter(stress_forces, out.stress_forces);
  if (whole) scatter(turning_forces, out.turning_forces);
}

/// Of entries, not of modes: bending of a slender body is what is left where entries cancel, round-off included.
void require_stiffness_of_elements(const FiniteElementModel& model, const std::string& where) {
  const auto [largest, node] = stiffness_difference(model);
  if (largest < kElementsMatch) return;
  char figure[32];
  std::snprintf(figure, sizeof figure, "%.2g", largest);
  throw SceneError("the elements and their material do not give the stiffness matrix: entries differ by up to " +
                       std::string(figure) + " of the diagonal, most at node " +
                       std::to_string(model.node_ids[static_cast<size_t>(node)]) + ".",
                   where,
                   "give each block its type (C3D8 or C3D8I, C3D20 or C3D20R) and the material of K, or the "
                   "stress stiffness of unit loads instead.");
}

EnergyDerivatives differentiate(const FiniteElementModel& model, const ModalBasis& basis, bool whole) {
  const int nm = basis.mode_count(), pairs = nm * (nm + 1) / 2;
  const int quartic = whole ? pairs : 0;
  EnergyDerivatives found{MatrixX::Zero(basis.modes.rows(), pairs), MatrixX::Zero(basis.modes.rows(), quartic),
                          MatrixX::Zero(quartic, quartic), MatrixX::Zero(quartic, quartic),
                          MatrixX::Zero(quartic, quartic)};
  const MatrixX modes = turned(basis.modes, basis.rotation);
  for (const SolidElement& element : make_solid_elements(model)) add_element(element, modes, whole, found);
  found.stress_forces = turned(found.stress_forces, basis.rotation.transpose());
  found.turning_forces = turned(found.turning_forces, basis.rotation.transpose());
  return found;
}

MatrixX deflections(const SupportedProblem& problem, const MatrixX& loads, const std::string& where) {
  ElasticProblem elastic(problem.K, problem.M, problem.rigid, where);
  if (problem.held.cols() > 0) elastic.hold(problem.held);
  return elastic.deflections(loads);
}

/// θ within the span of the deflections under the given loads, so that each meets its stress stiffness:
/// θ_kl = Σ u_a x_a,kl with F_bᵀ θ_kl = -B_kᵀ K_b B_l.
MatrixX fields_of_loads(const FiniteElementModel& model, const ModalBasis& basis, const SupportedProblem& problem,
                        const std::string& where) {
  const int nm = basis.mode_count(), pairs = nm * (nm + 1) / 2;
  const auto count = static_cast<Eigen::Index>(model.stress_stiffness.size());
  MatrixX loads(basis.modes.rows(), count), stiffness(count, pairs);
  const MatrixX modes = turned(basis.modes, basis.rotation);
  for (Eigen::Index a = 0; a < count; ++a) {
    const StressStiffness& given = model.stress_stiffness[static_cast<size_t>(a)];
    if (given.load.size() != model.dof_count() || given.matrix.rows() != model.dof_count() || !given.load.allFinite())
      throw SceneError("stress stiffness " + std::to_string(a + 1) + " has " + std::to_string(given.matrix.rows()) +
                           " rows and a load of " + std::to_string(given.load.size()) + " for " +
                           std::to_string(model.dof_count()) + " degrees of freedom.",
                       where, "give both for all nodes, without supports.");
    loads.col(a) = turned(given.load, basis.rotation.transpose());
    const MatrixX modal = modes.transpose() * (given.matrix * modes);
    for (int l = 0; l < nm; ++l)
      for (int k = 0; k <= l; ++k) stiffness(a, pair_of(k, l)) = modal(k, l);
  }
  const MatrixX u = problem.T * deflections(problem, problem.T.transpose() * loads, where);
  const MatrixX gram = loads.transpose() * u;
  return -u * Eigen::CompleteOrthogonalDecomposition<MatrixX>(0.5 * (gram + gram.transpose())).solve(stiffness);
}

/// X(kl, mn) + X(km, ln) + X(kn, lm).
MatrixX symmetrised(const MatrixX& X, int nm) {
  MatrixX Q(X.rows(), X.cols());
  for (int l = 0; l < nm; ++l)
    for (int k = 0; k <= l; ++k)
      for (int n = 0; n < nm; ++n)
        for (int m = 0; m <= n; ++m)
          Q(pair_of(k, l), pair_of(m, n)) =
              X(pair_of(k, l), pair_of(m, n)) + X(pair_of(k, m), pair_of(l, n)) + X(pair_of(k, n), pair_of(l, m));
  return Q;
}

/// θ = B C_B + Ψ C_Ψ, Ψ mass-orthonormal: the fields that matter, by singular values.
void split_fields(const ModalBasis& basis, const SparseMatrix& mass, MatrixX theta, double tolerance,
                  QuadraticDeflection& out) {
  const int nm = basis.mode_count();
  const MatrixX along = basis.modes.transpose() * (mass * theta);
  // The part of a field along the modes is a change of the modal coordinates; Ψ is what no mode can do.
  theta -= basis.modes * along;
  // Each pair at the amplitudes of unit energy.
  VectorX scale(theta.cols());
  for (int l = 0; l < nm; ++l)
    for (int k = 0; k <= l; ++k)
      scale[pair_of(k, l)] = 1 / std::sqrt(basis.stiffness.coeff(k, k) * basis.stiffness.coeff(l, l));
  // Principal fields by the Gram matrix, then orthonormal to round-off; the matrix itself sees half the digits.
  const MatrixX scaled = theta * scale.asDiagonal();
  const MatrixX gram = scaled.transpose() * (mass * scaled);
  const Eigen::SelfAdjointEigenSolver<MatrixX> parts(MatrixX(0.5 * (gram + gram.transpose())));
  const double largest = std::max(parts.eigenvalues().tail<1>()[0], 0.0);
  const double bound = std::max(tolerance, kSmallestField);
  const auto kept = (parts.eigenvalues().array() > bound * bound * largest).count();
  out.fields = scaled * parts.eigenvectors().rightCols(kept) *
               parts.eigenvalues().tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  orthonormalise(mass, out.fields);
  out.curvature.resize(nm + kept, theta.cols());
  out.curvature << along, out.fields.transpose() * (mass * theta);
}

}  // namespace

std::shared_ptr<const QuadraticDeflection> make_quadratic_deflection(
    const FiniteElementModel& model, const ModalBasis& basis, const SupportedProblem& problem, const SparseMatrix& mass,
    const Reduction& reduction, const std::string& where) {
  const bool whole = reduction.deflection == Deflection::quadratic;
  const bool by_forces = static_cast<bool>(model.second_order_forces);
  const bool by_loads = !whole && !by_forces && !model.stress_stiffness.empty();
  if (whole && by_forces)
    throw SceneError("a strain energy of fourth order needs solid elements, and this model has beams.", where,
                     "give Deflection::stiffened, or keep the Beam as it is: it is exact.");
  if (!by_forces && (!model.rotations.empty() || (model.elements.empty() && !by_loads)))
    throw SceneError("stiffening needs the solid elements and their material, or the stress stiffness of unit loads.",
                     where, "read the model with its deck, or fill FiniteElementModel::stress_stiffness.");
  if (!(reduction.deflection_tolerance >= 0 && reduction.deflection_tolerance < 1))
    throw SceneError("the deflection tolerance is " + std::to_string(reduction.deflection_tolerance) + ".", where,
                     "give a part of the largest field, 0 to 1; 0.02 does for most.");
  auto out = std::make_shared<QuadraticDeflection>();
  const int nm = basis.mode_count();
  MatrixX theta;
  if (by_forces) {
    const MatrixX forces =
        turned(model.second_order_forces(turned(basis.modes, basis.rotation)), basis.rotation.transpose());
    theta = -(problem.T * deflections(problem, problem.T.transpose() * forces, where));
  } else if (by_loads) {
    theta = fields_of_loads(model, basis, problem, where);
  } else {
    require_stiffness_of_elements(model, where);
    const EnergyDerivatives energy = differentiate(model, basis, whole);
    const MatrixX loads = problem.T.transpose() * energy.stress_forces;
    const MatrixX z = deflections(problem, loads, where);
    theta = -(problem.T * z);
    if (whole) {
      // Fourth order: ½ ∫ E2 C E2, less what θ relieves of it, and the bending strain's work on E2(φ, θ).
      const MatrixX turning = energy.turning_forces.transpose() * theta + energy.turned;
      out->quartic =
          symmetrised(4 * energy.membrane - z.transpose() * loads - energy.relaxed + turning + turning.transpose(), nm);
    }
  }
  split_fields(basis, mass, std::move(theta), reduction.deflection_tolerance, *out);

  ModalBasis all;
  all.nodes = basis.nodes;
  all.rotations = basis.rotations;
  all.nodal_mass = basis.nodal_mass;
  all.modes.resize(basis.modes.rows(), nm + out->field_count());
  all.modes << basis.modes, out->fields;
  all.modal_mass.resize(all.modes.cols(), all.modes.cols());
  all.modal_mass.setIdentity();
  all.stiffness = all.modal_mass;
  out->integrals = basis.rotations.empty() ? inertia_integrals(all) : general_inertia_integrals(all, mass);
  log::info(where + ": " + std::to_string(out->field_count()) + " fields of second order for " +
            std::to_string(nm * (nm + 1) / 2) + " pairs of modes" + (whole ? ", energy to fourth order" : ""));
  return out;
}

}  // namespace lithe
