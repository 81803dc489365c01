#include "bodies/flexible/quadratic_deflection.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "bodies/flexible/eigen_modes.h"
#include "bodies/flexible/elements/solid_element.h"
#include "bodies/flexible/inertia_integrals.h"
#include "engine/error.h"
#include "engine/log.h"

namespace lithe {
namespace {

constexpr double kElementsMatch = 1e-6;   // of the largest modal stiffness
constexpr double kFieldTolerance = 1e-3;  // of the largest field, pairs weighted by the inverse of their frequencies

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

/// Derivatives of the strain energy at rest along the modes (mesh axes, a column a mode).
struct EnergyDerivatives {
  MatrixX second;    // nm x nm: must be K^
  MatrixX forces;    // 3n x pairs: f_kl
  MatrixX cubic;     // nm x pairs
  MatrixX membrane;  // pairs x pairs: ∫ E2_kl C E2_mn
  MatrixX internal;  // pairs x pairs: what the elements' internal coordinates relax, f_kl K_ii⁻¹ f_mn
};

/// Adds one element's share. With H the displacement gradients, at each point:
///   f_kl: v ↦ ∫ (2 C E2(φ_k, φ_l) + H_l C ε_k + H_k C ε_l) : ∇v, the last two for `whole` derivatives only.
void add_element(const SolidElement& element, const MatrixX& modes, bool whole, EnergyDerivatives& out) {
  const auto nm = static_cast<int>(modes.cols()), pairs = nm * (nm + 1) / 2;
  const auto shapes = static_cast<Eigen::Index>(element.nodes.size()) + element.internal;
  const auto nodal = 3 * static_cast<Eigen::Index>(element.nodes.size());
  const Matrix6 C = elasticity(element.material);
  MatrixX coordinates(3 * shapes, nm), forces = MatrixX::Zero(3 * shapes, pairs),
                                       linear = MatrixX::Zero(3 * shapes, nm);
  for (int k = 0; k < nm; ++k) coordinates.col(k) = element.coordinates_of(modes.col(k));
  MatrixX strains(6, pairs);
  std::vector<Matrix3> H(static_cast<size_t>(nm)), S(static_cast<size_t>(nm));
  for (const SolidPoint& point : element.points) {
    for (int k = 0; k < nm; ++k) {
      const auto at = static_cast<size_t>(k);
      H[at] = Eigen::Map<const Matrix3X>(coordinates.col(k).data(), 3, shapes) * point.gradients;
      S[at] = stress_tensor(C * strain_of(H[at]));
      Eigen::Map<Matrix3X>(linear.col(k).data(), 3, shapes) += point.volume * (S[at] * point.gradients.transpose());
    }
    for (int l = 0; l < nm; ++l)
      for (int k = 0; k <= l; ++k) {
        const auto a = static_cast<size_t>(k), b = static_cast<size_t>(l);
        const int p = pair_of(k, l);
        strains.col(p) = strain_of(Matrix3(0.5 * H[a].transpose() * H[b]));  // symmetrised by strain_of: 2 shear halves
        Matrix3 stress = 2 * stress_tensor(C * strains.col(p));
        if (whole) stress += H[b] * S[a] + H[a] * S[b];
        Eigen::Map<Matrix3X>(forces.col(p).data(), 3, shapes) += point.volume * (stress * point.gradients.transpose());
      }
    if (whole) out.membrane.noalias() += strains.transpose() * (point.volume * C * strains);
  }
  out.second.noalias() += coordinates.transpose() * linear;
  if (whole) out.cubic.noalias() += coordinates.transpose() * forces;
  if (element.internal > 0) {
    const MatrixX inner = forces.bottomRows(3 * element.internal);
    forces.topRows(nodal).noalias() += element.internal_from_nodal.transpose() * inner;
    if (whole) out.internal.noalias() += inner.transpose() * (element.internal_compliance * inner);
  }
  for (size_t a = 0; a < element.nodes.size(); ++a)
    out.forces.middleRows<3>(3 * element.nodes[a]) += forces.middleRows<3>(3 * static_cast<Eigen::Index>(a));
}

EnergyDerivatives differentiate(const FiniteElementModel& model, const ModalBasis& basis, bool whole,
                                const std::string& where) {
  const int nm = basis.mode_count(), pairs = nm * (nm + 1) / 2;
  EnergyDerivatives found{MatrixX::Zero(nm, nm), MatrixX::Zero(basis.modes.rows(), pairs), MatrixX::Zero(nm, pairs),
                          MatrixX::Zero(pairs, pairs), MatrixX::Zero(pairs, pairs)};
  const MatrixX modes = turned(basis.modes, basis.rotation);
  for (const SolidElement& element : make_solid_elements(model)) add_element(element, modes, whole, found);
  const double error =
      (found.second - MatrixX(basis.stiffness)).cwiseAbs().maxCoeff() / basis.stiffness.coeffs().cwiseAbs().maxCoeff();
  if (!(error < kElementsMatch)) {
    char figure[32];
    std::snprintf(figure, sizeof figure, "%.2g", error);
    throw SceneError("the elements and their material do not give the stiffness matrix: modal stiffnesses differ by " +
                         std::string(figure) + " of the largest.",
                     where,
                     "give each block its type (C3D8 or C3D8I, C3D20 or C3D20R) and the material of K, or the "
                     "stress stiffness of unit loads instead.");
  }
  found.forces = turned(found.forces, basis.rotation.transpose());
  return found;
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
  const MatrixX u =
      problem.T * static_deflections(problem.K, problem.M, problem.rigid, problem.T.transpose() * loads, where);
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
void split_fields(const ModalBasis& basis, const SparseMatrix& mass, MatrixX theta, QuadraticDeflection& out) {
  const int nm = basis.mode_count();
  const MatrixX along = basis.modes.transpose() * (mass * theta);
  theta -= basis.modes * along;
  // Each pair at the amplitudes of unit energy.
  VectorX scale(theta.cols());
  for (int l = 0; l < nm; ++l)
    for (int k = 0; k <= l; ++k)
      scale[pair_of(k, l)] = 1 / std::sqrt(basis.stiffness.coeff(k, k) * basis.stiffness.coeff(l, l));
  const MatrixX scaled = theta * scale.asDiagonal();
  const MatrixX gram = scaled.transpose() * (mass * scaled);
  const Eigen::SelfAdjointEigenSolver<MatrixX> parts(0.5 * (gram + gram.transpose()));
  const double largest = std::max(parts.eigenvalues().tail<1>()[0], 0.0);
  const auto kept = (parts.eigenvalues().array() > kFieldTolerance * kFieldTolerance * largest).count();
  out.fields = scaled * parts.eigenvectors().rightCols(kept) *
               parts.eigenvalues().tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  out.curvature.resize(nm + kept, theta.cols());
  out.curvature << along, out.fields.transpose() * (mass * theta);
}

}  // namespace

std::shared_ptr<const QuadraticDeflection> make_quadratic_deflection(const FiniteElementModel& model,
                                                                     const ModalBasis& basis,
                                                                     const SupportedProblem& problem,
                                                                     Deflection deflection, const std::string& where) {
  const bool whole = deflection == Deflection::quadratic;
  const bool by_loads = !whole && !model.stress_stiffness.empty();
  if (!model.rotations.empty() || (model.elements.empty() && !by_loads))
    throw SceneError("stiffening needs the solid elements and their material, or the stress stiffness of unit loads.",
                     where, "read the model with its deck, or fill FiniteElementModel::stress_stiffness.");
  auto out = std::make_shared<QuadraticDeflection>();
  const int nm = basis.mode_count();
  MatrixX theta;
  if (by_loads) {
    theta = fields_of_loads(model, basis, problem, where);
  } else {
    const EnergyDerivatives energy = differentiate(model, basis, whole, where);
    const MatrixX loads = problem.T.transpose() * energy.forces;
    theta = -(problem.T * static_deflections(problem.K, problem.M, problem.rigid, loads, where));
    if (whole) {
      theta -= basis.modes * (basis.modes.transpose() * (model.mass * theta));
      const MatrixX z = problem.T.transpose() * theta;
      const MatrixX relaxed = z.transpose() * (problem.K * z) + energy.internal;
      out->cubic = energy.cubic;
      out->quartic = symmetrised(4 * energy.membrane - relaxed, nm);
    }
  }
  split_fields(basis, model.mass, std::move(theta), *out);

  ModalBasis all;
  all.nodes = basis.nodes;
  all.nodal_mass = basis.nodal_mass;
  all.modes.resize(basis.modes.rows(), nm + out->field_count());
  all.modes << basis.modes, out->fields;
  all.modal_mass.resize(all.modes.cols(), all.modes.cols());
  all.modal_mass.setIdentity();
  all.stiffness = all.modal_mass;
  out->integrals = inertia_integrals(all);
  log::info(where + ": " + std::to_string(out->field_count()) + " fields of second order for " +
            std::to_string(nm * (nm + 1) / 2) + " pairs of modes" + (whole ? ", energy to fourth order" : ""));
  return out;
}

}  // namespace lithe
