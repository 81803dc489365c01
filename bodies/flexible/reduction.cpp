#include "bodies/flexible/reduction.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "bodies/flexible/drawn_skin.h"
#include "bodies/flexible/eigen_modes.h"
#include "bodies/flexible/frames.h"
#include "bodies/flexible/general_inertia.h"
#include "bodies/flexible/inertia_integrals.h"
#include "bodies/flexible/node_sets.h"
#include "bodies/flexible/quadratic_deflection.h"
#include "bodies/flexible/static_modes.h"
#include "engine/base/error.h"
#include "engine/base/log.h"

namespace lithe {
namespace {

double hertz(double eigenvalue) { return std::sqrt(std::max(eigenvalue, 0.0)) / (2 * std::numbers::pi); }

/// The model in body axes.
struct BodyMatrices {
  SparseMatrix K, M, C;  // C may be empty
};

/// A^nT X A^n (18) of K, C and a mass that is no scalar interpolation (blocks of scalar mass do not change).
BodyMatrices in_body_axes(const FiniteElementModel& model, const Matrix3& rotation, bool scalar) {
  if (rotation.isIdentity(0)) return {model.stiffness, model.mass, model.damping};
  const SparseMatrix A = axes_turn(model, rotation), transposed = A.transpose();
  const auto turned = [&](const SparseMatrix& X) -> SparseMatrix {
    if (X.size() == 0) return X;
    const SparseMatrix body = transposed * X * A;
    return 0.5 * (body + SparseMatrix(body.transpose()));
  };
  return {turned(model.stiffness), scalar ? model.mass : turned(model.mass), turned(model.damping)};
}

SupportedProblem supported(const SparseMatrix& K, const SparseMatrix& M, SparseMatrix T, const MatrixX& rigid,
                           const MatrixX& means) {
  if (T.cols() == T.rows() && T.nonZeros() == T.cols()) return {std::move(T), K, M, rigid, means};  // all is free
  const SparseMatrix transposed = T.transpose();
  SparseMatrix Kz = transposed * K * T, Mz = transposed * M * T;
  MatrixX Rz = transposed * rigid, held = means.cols() > 0 ? MatrixX(transposed * means) : MatrixX();
  return {std::move(T), std::move(Kz), std::move(Mz), std::move(Rz), std::move(held)};
}

void require_held(const EigenModes& modes, const ElasticProblem& problem) {
  if (modes.eigenvalues.size() == 0 || modes.eigenvalues[0] > eigenvalue_noise(problem.stiffness(), problem.mass()))
    return;
  throw SceneError("the supported body still moves without stiffness: a mechanism.", problem.where(),
                   "hold every loose part: look for unconnected pieces, duplicate nodes, or nodes without elements.");
}

/// Nodal coordinates of a hinged body still contain its swing. One more condition for each free rigid motion takes it
/// out: the row where that motion is largest (the node farthest from the hinge axis, its component along the swing),
/// by QR with column pivoting.
std::vector<int> with_swing_held(const FramePlacement& placed) {
  std::vector<int> fixed = placed.fixed_dofs;
  const MatrixX motion = placed.rigid.transpose();
  const Eigen::ColPivHouseholderQR<MatrixX> qr(motion);
  for (Eigen::Index k = 0; k < placed.rigid.cols(); ++k)
    fixed.push_back(static_cast<int>(qr.colsPermutation().indices()[k]));
  std::sort(fixed.begin(), fixed.end());
  return fixed;
}

void fill_nodal(const BodyFrame& frame, FramePlacement placed, const BodyMatrices& body, bool scalar,
                const Reduction& reduction, ModalBasis& basis) {
  if (std::holds_alternative<MeanAxisFrame>(frame) || placed.means.cols() > 0)
    throw SceneError("mean axes, or the mean of some nodes, are no selection of nodal coordinates.", placed.where,
                     "use a ThreeNodeFrame (or a tangent or hinge frame) with kAllNodal.");
  if (!reduction.rigid.empty())
    throw SceneError("a body with all its nodal coordinates keeps no set of nodes rigid.", placed.where,
                     "ask for as many modes as there are coordinates instead of kAllNodal: it is the same body.");
  if (!scalar)
    throw SceneError("nodal coordinates need a mass that is a scalar interpolation, of solid elements.", placed.where,
                     "ask for a number of modes instead of kAllNodal: as many as there are coordinates, if need be.");
  placed.fixed_dofs = with_swing_held(placed);
  const SupportedProblem problem =
      supported(body.K, body.M, free_motions(placed, {}, {}).T, MatrixX(body.K.rows(), 0), {});
  const ElasticProblem elastic(problem.K, problem.M, problem.rigid, placed.where);
  require_held(lowest_modes(elastic, 1), elastic);
  basis.nodal = true;
  for (Eigen::Index k = 0; k < problem.T.cols(); ++k)
    basis.free_dofs.push_back(static_cast<int>(SparseMatrix::InnerIterator(problem.T, k).row()));
  basis.stiffness = problem.K;
  basis.modal_mass = problem.M;
  if (body.C.size() > 0) basis.damping = MatrixX(SparseMatrix(problem.T.transpose()) * body.C * problem.T);
}

std::vector<std::vector<int>> indices_of(const FiniteElementModel& model, const std::vector<std::vector<int>>& sets) {
  std::vector<std::vector<int>> indices(sets.size());
  for (size_t s = 0; s < sets.size(); ++s)
    for (int id : sets[s]) indices[s].push_back(model.node_index(id));
  return indices;
}

/// Nodal forces of unit loads on the interfaces, body axes, dofs x 6 an interface.
MatrixX unit_loads(const FiniteElementModel& model, const FramePlacement& placed,
                   const std::vector<WeightedNodes>& interfaces) {
  MatrixX F(model.dof_count(), 6 * static_cast<Eigen::Index>(interfaces.size()));
  for (size_t s = 0; s < interfaces.size(); ++s)
    F.middleCols<6>(6 * static_cast<Eigen::Index>(s)) =
        NodeAverage(placed.nodes, indices_of(model, {interfaces[s].ids})[0], interfaces[s].weights, placed.where)
            .unit_loads(model.dof_count());
  return F;
}

/// Rows of A.
MatrixX rows_of(const MatrixX& A, const std::vector<int>& rows) { return A(rows, Eigen::all); }

/// B - R (L R)⁺ L B: the rigid motion that the held rows L see of each shape taken out (docs/equations.md 5.2).
MatrixX without_rigid_motion_of(const std::vector<int>& held, const MatrixX& R, const MatrixX& B) {
  if (held.empty()) return B;
  const Eigen::CompleteOrthogonalDecomposition<MatrixX> LR(rows_of(R, held));
  const MatrixX seen = LR.solve(MatrixX(rows_of(B, held)));
  MatrixX moved = B - R * seen;
  return moved;
}

/// Shapes from elsewhere in the free coordinates: turned into body axes, without the rigid motion of what the frame
/// holds, and zero there.
MatrixX given_shapes(const FiniteElementModel& model, const FramePlacement& placed, const SparseMatrix& T,
                     const MatrixX& given) {
  if (given.rows() != model.dof_count() || !given.allFinite())
    throw SceneError("the given modes have " + std::to_string(given.rows()) + " rows for " +
                         std::to_string(model.dof_count()) + " degrees of freedom, or an entry that is not finite.",
                     placed.where, "give dofs x k, three rows a node, then those of the nodal rotations.");
  const SparseMatrix turn = axes_turn(model, placed.rotation).transpose();
  const MatrixX R = rigid_motions_left(placed.nodes, model.rotations, {});
  return T.transpose() * without_rigid_motion_of(placed.fixed_dofs, R, turn * given);
}

void require_available(int mode_count, int available, const std::string& where) {
  if (mode_count <= available) return;
  throw SceneError(std::to_string(mode_count) + " modes are asked for, but the frame leaves " +
                       std::to_string(available) + " elastic coordinates.",
                   where, "ask for at most " + std::to_string(available) + ", or for kAllNodal.");
}

/// Columns that span those of F, as many as are independent: nodes on a line have no mean turn about it.
MatrixX independent(MatrixX F) {
  for (Eigen::Index k = 0; k < F.cols(); ++k) F.col(k) /= std::max(F.col(k).norm(), 1e-300);
  const Eigen::SelfAdjointEigenSolver<MatrixX> parts(MatrixX(F.transpose() * F));
  const auto kept = (parts.eigenvalues().array() > 1e-9).count();
  return F * parts.eigenvectors().rightCols(kept);
}

/// Reduced to modes: all in the free coordinates z of frame and rigid sets, u = T z.
class ModeReduction {
 public:
  ModeReduction(const FiniteElementModel& model, const BodyFrame& frame, const FramePlacement& placed,
                const BodyMatrices& body, const Reduction& reduction)
      : model_(model), placed_(placed), reduction_(reduction), support_(placed) {
    // Fixed interfaces, not the frame, hold a body while Craig-Bampton modes are made: three frame nodes, or the mean
    // of some, come after.
    frame_afterwards_ = reduction.interface_modes == InterfaceModes::craig_bampton &&
                        (std::holds_alternative<ThreeNodeFrame>(frame) || placed.means.cols() > 0);
    if (frame_afterwards_) {
      support_.fixed_dofs.clear();
      support_.rigid = rigid_motions_left(placed.nodes, model.rotations, {});
    }
    FreeMotions free = free_motions(support_, model.rotations, indices_of(model, reduction.rigid));
    loose_ = free.loose;
    problem_ = supported(body.K, body.M, std::move(free.T), support_.rigid, support_.means);
  }

  const SupportedProblem& problem() const { return problem_; }

  EigenModes modes(int count) const {
    ElasticProblem elastic(problem_.K, problem_.M, problem_.rigid, placed_.where);
    const bool fixed_interfaces = reduction_.interface_modes == InterfaceModes::craig_bampton &&
                                  !(reduction_.rigid.empty() && reduction_.loaded.empty());
    if (problem_.held.cols() > 0 && !fixed_interfaces) elastic.hold(problem_.held);
    EigenModes found{VectorX(0), MatrixX(problem_.K.rows(), 0)};
    MatrixX shapes(problem_.K.rows(), 0);
    if (fixed_interfaces) {
      elastic.hold(interface_conditions());
      require_available(count, elastic.elastic_count(), placed_.where);
      shapes = craig_bampton_shapes(elastic, count);
    } else {
      require_available(count, elastic.elastic_count(), placed_.where);
      found = lowest_modes(elastic, count);
      require_held(found, elastic);
      if (!reduction_.loaded.empty()) {
        if (count == 0) require_held(lowest_modes(elastic, 1), elastic);
        const MatrixX loads = problem_.T.transpose() * unit_loads(model_, placed_, reduction_.loaded);
        shapes = reduction_.interface_modes == InterfaceModes::krylov
                     ? krylov_shapes(elastic, loads, reduction_.krylov_blocks)
                     : elastic.deflections(loads);
      }
    }
    if (reduction_.given_modes.cols() > 0)
      shapes = beside(shapes, given_shapes(model_, support_, problem_.T, reduction_.given_modes));
    if (shapes.cols() == 0) return found;
    shapes = in_frame(elastic, straining(elastic, std::move(shapes)));
    const Eigen::Index offered = found.vectors.cols() + shapes.cols();
    found = joined(elastic, found, shapes);
    if (const Eigen::Index dropped = offered - found.vectors.cols(); dropped > 0)
      log::info(placed_.where + ": " + std::to_string(dropped) + " shapes add nothing to the others, left out");
    return found;
  }

 private:
  /// F with Fᵀ z = 0 where the interfaces are fixed: coordinates of rigid sets, mean motions of loaded ones.
  MatrixX interface_conditions() const {
    const Eigen::Index n = problem_.T.cols(), tied = n - loose_;
    MatrixX F = MatrixX::Zero(n, tied);
    F.bottomRows(tied).setIdentity();
    for (const WeightedNodes& interface : reduction_.loaded)
      F = beside(F, independent(problem_.T.transpose() * unit_loads(model_, placed_, {interface})));
    return F;
  }

  /// Rid of rigid content, as the frame demands.
  MatrixX in_frame(const ElasticProblem& elastic, MatrixX shapes) const {
    elastic.rigid().clean(shapes);
    if (!frame_afterwards_ && problem_.held.cols() == 0) return shapes;
    const SparseMatrix held = SparseMatrix(problem_.T.transpose());  // columns are degrees of freedom
    MatrixX L(static_cast<Eigen::Index>(placed_.fixed_dofs.size()), problem_.T.cols());
    for (size_t k = 0; k < placed_.fixed_dofs.size(); ++k)
      L.row(static_cast<Eigen::Index>(k)) = held.col(placed_.fixed_dofs[k]).transpose();
    if (problem_.held.cols() > 0) L = problem_.held.transpose();
    const MatrixX& D = elastic.rigid().D;
    for (int pass = 0; pass < 2; ++pass) shapes -= D * MatrixX(L * D).fullPivLu().solve(MatrixX(L * shapes));
    return shapes;
  }

  const FiniteElementModel& model_;
  const FramePlacement& placed_;
  const Reduction& reduction_;
  FramePlacement support_;
  bool frame_afterwards_ = false;
  int loose_ = 0;
  SupportedProblem problem_;
};

void fill_modes(const ModeReduction& reduced, int mode_count, const FramePlacement& placed, const BodyMatrices& body,
                ModalBasis& basis) {
  const EigenModes modes = reduced.modes(mode_count);
  basis.modes = reduced.problem().T * modes.vectors;
  for (int dof : placed.fixed_dofs) basis.modes.row(dof).setZero();
  basis.stiffness = diagonal_matrix(modes.eigenvalues);
  basis.modal_mass = diagonal_matrix(VectorX::Ones(modes.eigenvalues.size()));
  if (body.C.size() > 0) basis.damping = basis.modes.transpose() * (body.C * basis.modes);
  basis.diagonal = true;
  basis.frequencies = modes.eigenvalues.unaryExpr([](double lambda) { return hertz(lambda); });
}

void log_basis(const ModalBasis& basis, const std::string& where) {
  char text[96];
  if (basis.nodal)
    std::snprintf(text, sizeof text, ": %d nodal coordinates", basis.mode_count());
  else if (basis.mode_count() == 0)
    std::snprintf(text, sizeof text, ": rigid");
  else
    std::snprintf(text, sizeof text, ": %d modes, %.6g to %.6g Hz", basis.mode_count(), basis.frequencies[0],
                  basis.frequencies[basis.mode_count() - 1]);
  log::info(where + text + (basis.free_swing_dropped ? ", the free swing left out" : ""));
}

}  // namespace

std::shared_ptr<const ModalBasis> make_basis(const FiniteElementModel& model, const BodyFrame& frame, int mode_count,
                                             const Reduction& reduction) {
  const ModelCheck sheet = require_sound(model, Definiteness::not_looked_at);
  const bool scalar = is_scalar_interpolation(model, sheet);
  const FramePlacement placed = place_frame(model, frame);
  // A frame that takes the six rigid motions and no more leaves a stiffness with all the negative eigenvalues of K: the
  // factor that the modes need anyway will show them.
  const bool shows =
      placed.fixed_dofs.size() + static_cast<size_t>(placed.rigid.cols()) == 6 && reduction.rigid.empty();
  if (!shows) require_sound(model);
  if (mode_count < kAllNodal)
    throw SceneError("the mode count is " + std::to_string(mode_count) + ".", placed.where,
                     "give 0 (rigid), a number of modes, or kAllNodal.");
  auto basis = std::make_shared<ModalBasis>();
  basis->name = model.name;
  basis->origin = placed.origin;
  basis->rotation = placed.rotation;
  basis->node_ids = model.node_ids;
  basis->node_sets = model.node_sets;
  basis->elements = model.elements;
  if (model.skin) {
    auto skin = std::make_shared<DrawnSkin>(*model.skin);
    skin->points = placed.rotation.transpose() * (skin->points.colwise() - placed.origin);
    basis->skin = std::move(skin);
  }
  basis->nodes = placed.nodes;
  basis->rotations = model.rotations;
  basis->nodal_mass = scalar ? scalar_mass(model.mass) : lumped_mass(model.mass, model.node_count());
  basis->free_swing_dropped = std::holds_alternative<HingeFrame>(frame) && placed.rigid.cols() > 0;

  const BodyMatrices body = in_body_axes(model, placed.rotation, scalar);
  if (mode_count == kAllNodal) {
    fill_nodal(frame, placed, body, scalar, reduction, *basis);
  } else {
    const ModeReduction reduced(model, frame, placed, body, reduction);
    try {
      fill_modes(reduced, mode_count, placed, body, *basis);
    } catch (const SceneError&) {
      require_sound(model);  // which says it better if K is at fault
      throw;
    }
    basis->integrals = scalar ? inertia_integrals(*basis) : general_inertia_integrals(*basis, body.M);
    if (reduction.deflection != Deflection::linear && basis->mode_count() > 0)
      basis->deflection = make_quadratic_deflection(
          model, *basis,
          supported(body.K, body.M, free_motions(placed, model.rotations, indices_of(model, reduction.rigid)).T,
                    placed.rigid, placed.means),
          body.M, reduction, placed.where);
  }
  log_basis(*basis, placed.where);
  return basis;
}

VectorX frequencies(const FiniteElementModel& model, const std::vector<int>& fixed_dofs, int count) {
  require_sound(model);
  const int dofs = model.dof_count();
  const std::string where = "model '" + model.name + "', " + std::to_string(fixed_dofs.size()) + " fixed dofs";
  for (int dof : fixed_dofs)
    if (dof < 0 || dof >= dofs)
      throw SceneError("degree of freedom " + std::to_string(dof) + " of " + std::to_string(dofs) + " is fixed.", where,
                       "count 3 * node index + axis from 0, rotations after all nodes.");
  const MatrixX rigid = rigid_motions_left(model.nodes, model.rotations, fixed_dofs);
  const FramePlacement placed{.nodes = model.nodes, .fixed_dofs = fixed_dofs, .rigid = rigid, .where = where};
  const SupportedProblem problem =
      supported(model.stiffness, model.mass, free_motions(placed, model.rotations, {}).T, rigid, {});
  if (count < 0 || count > problem.T.cols())
    throw SceneError(
        std::to_string(count) + " frequencies of " + std::to_string(problem.T.cols()) + " free degrees of freedom.",
        where, "ask for fewer.");
  VectorX hz = VectorX::Zero(count);
  const int zero = static_cast<int>(rigid.cols());
  if (count <= zero) return hz;
  const EigenModes modes = lowest_modes(problem.K, problem.M, problem.rigid, count - zero, where);
  const double noise = eigenvalue_noise(problem.K, problem.M);
  for (int k = zero; k < count; ++k) {
    const double lambda = modes.eigenvalues[k - zero];
    hz[k] = lambda > noise ? hertz(lambda) : 0.0;
  }
  return hz;
}

}  // namespace lithe
