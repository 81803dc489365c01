#include "bodies/flexible/flexible_body.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"
#include "engine/base/lanes.h"

namespace lithe {
namespace {

using ConstVector3 = Eigen::Map<const Vector3>;
using ConstVector = Eigen::Map<const VectorX>;

/// Full matrix from entries along a lower-triangle pattern, times x, added to out.
void add_symmetric_product(const LinearPattern& pattern, const VectorX& entries, double weight, const double* x,
                           double* out) {
  for (int k = 0; k < pattern.rows.size(); ++k) {
    const int i = pattern.rows[k], j = pattern.columns[k];
    out[i] += weight * entries[k] * x[j];
    if (i != j) out[j] += weight * entries[k] * x[i];
  }
}

}  // namespace

FlexibleBody::FlexibleBody(Parameters parameters) : drawn_(parameters), parameters_(std::move(parameters)) {
  build();
  for (int k = 0; k < modes_; ++k) fidelity_.modes.push_back(k);
  if (modes_ > 0) fidelity_.deflection = finest_deflection();
}

void FlexibleBody::build() {
  if (!parameters_.basis) throw SceneError("has no basis", "", "give .basis = make_basis(model, frame, mode_count)");
  const ModalBasis& basis = *parameters_.basis;
  const int available = basis.mode_count();
  if (parameters_.mode_count != kAll && (parameters_.mode_count < 0 || parameters_.mode_count > available))
    throw SceneError("mode_count is " + std::to_string(parameters_.mode_count) + " and its basis has " +
                         std::to_string(available) + " modes",
                     "", "ask for 0 to " + std::to_string(available) + " modes, or make a larger basis");
  modes_ = std::min(parameters_.mode_count, available);
  if (basis.nodal && modes_ > 0 && modes_ < available)
    throw SceneError("a nodal basis cannot be truncated to " + std::to_string(modes_) + " coordinates", "",
                     "use all its coordinates, 0 for a rigid body, or make_basis() with a mode count");
  if (basis.nodal && modes_ > 0) {
    inertia_ = std::make_unique<NodalInertia>(parameters_.basis);
  } else if (basis.nodal) {
    ModalBasis rigid = basis;
    rigid.nodal = false;
    rigid.modes = MatrixX(3 * basis.nodes.cols(), 0);
    rigid.stiffness = rigid.modal_mass = SparseMatrix(0, 0);
    inertia_ = std::make_unique<ModalInertia>(inertia_integrals(rigid));
  } else if (basis.deflection && modes_ > 0) {
    if (!basis.diagonal)
      throw SceneError("a quadratic deflection needs an eigenmode basis", "", "use make_basis() with a mode count");
    deflection_ = std::make_unique<DeflectionMap>(*basis.deflection, modes_);
    inertia_ = std::make_unique<ModalInertia>(basis.deflection->integrals);
  } else {
    const bool known = basis.integrals.mass > 0 && basis.integrals.mode_count() == available;
    inertia_ = std::make_unique<ModalInertia>(leading(known ? basis.integrals : inertia_integrals(basis), modes_));
  }
  set_up();
}

FlexibleBody::FlexibleBody(Parameters parameters, InertiaIntegrals integrals)
    : drawn_(parameters), parameters_(std::move(parameters)), with_integrals_(true) {
  modes_ = integrals.mode_count();
  inertia_ = std::make_unique<ModalInertia>(std::move(integrals));
  set_up();
}

void FlexibleBody::set_up() {
  const ModalBasis& basis = *parameters_.basis;
  const auto& p = parameters_;
  require::finite(p.position, "position");
  require::rotation(p.orientation, "orientation");
  require::finite(p.velocity, "velocity");
  require::finite(p.angular_velocity, "angular_velocity");
  require::not_negative(p.damping.mass_proportional, "damping.mass_proportional");
  require::not_negative(p.damping.stiffness_proportional, "damping.stiffness_proportional");
  for (const auto& [value, what] :
       {std::pair(&p.modal_coordinates, "modal_coordinates"), std::pair(&p.modal_velocities, "modal_velocities")}) {
    require::finite(*value, what);
    if (value->size() != 0 && value->size() != modes_)
      throw SceneError(std::string(what) + " has " + std::to_string(value->size()) + " entries for " +
                           std::to_string(modes_) + " modes",
                       "", "give one entry a mode, or none");
  }

  const bool damped = basis.damping.size() > 0;
  diagonal_ = basis.diagonal && !damped && !deflection_;
  if (diagonal_) {
    stiffness_ = basis.stiffness.diagonal().head(modes_);
    modal_mass_ = VectorX::Ones(modes_);
  } else {
    // The lower triangle of Mff, K^ and D together; all of it where deflection fills it.
    SparseMatrix pattern = (basis.stiffness + basis.modal_mass).topLeftCorner(modes_, modes_);
    if (damped || deflection_) pattern = MatrixX::Ones(modes_, modes_).sparseView();
    const SparseMatrix lower = pattern.triangularView<Eigen::Lower>();
    const int entries = static_cast<int>(lower.nonZeros());
    pattern_.rows.resize(entries), pattern_.columns.resize(entries);
    stiffness_.resize(entries), modal_mass_.resize(entries);
    int k = 0;
    for (int j = 0; j < lower.outerSize(); ++j)
      for (SparseMatrix::InnerIterator it(lower, j); it; ++it, ++k) {
        pattern_.rows[k] = static_cast<int>(it.row()), pattern_.columns[k] = static_cast<int>(it.col());
        stiffness_[k] = basis.stiffness.coeff(it.row(), it.col());
        modal_mass_[k] = basis.modal_mass.coeff(it.row(), it.col());
      }
  }
  damping_ = p.damping.mass_proportional * modal_mass_ + p.damping.stiffness_proportional * stiffness_;
  if (damped)
    for (int k = 0; k < damping_.size(); ++k) damping_[k] += basis.damping(pattern_.rows[k], pattern_.columns[k]);
  const auto& ratios = p.damping.modal_ratios;
  if (ratios.empty()) return;
  if (!basis.diagonal)
    throw SceneError("modal damping needs an eigenmode basis", "",
                     "use Rayleigh damping with nodal or given coordinates");
  if (ratios.size() != 1 && static_cast<int>(ratios.size()) != modes_)
    throw SceneError("damping.modal_ratios has " + std::to_string(ratios.size()) + " entries for " +
                         std::to_string(modes_) + " modes",
                     "", "give one ratio for all modes, or one a mode");
  for (int k = 0; k < modes_; ++k) {
    const double zeta = ratios[ratios.size() == 1 ? 0 : k];
    require::not_negative(zeta, "damping.modal_ratios[" + std::to_string(k) + "]");
    // In a full lower triangle, columns one after another, mode k's diagonal entry comes after k longer columns.
    damping_[diagonal_ ? k : k * modes_ - k * (k - 1) / 2] += 2 * zeta * std::sqrt(basis.stiffness.coeff(k, k));
  }
}

void FlexibleBody::add_modal(double mass, double damping, double stiffness, const double* x, double* out) const {
  if (diagonal_) {
    for (int k = 0; k < modes_; ++k) out[k] += (mass + damping * damping_[k] + stiffness * stiffness_[k]) * x[k];
    return;
  }
  if (mass != 0) add_symmetric_product(pattern_, modal_mass_, mass, x, out);
  if (damping != 0) add_symmetric_product(pattern_, damping_, damping, x, out);
  if (stiffness != 0) add_symmetric_product(pattern_, stiffness_, stiffness, x, out);
}

void FlexibleBody::initial_state(VectorRef q, VectorRef v) const {
  const auto& p = parameters_;
  const Vector3 arm = p.orientation * basis().origin;
  q.head<3>() = p.position + arm;
  q.segment<4>(3) = quaternion_of(p.orientation * basis().rotation);
  v.head<3>() = p.velocity + (p.orientation * p.angular_velocity).cross(arm);
  v.segment<3>(3) = basis().rotation.transpose() * p.angular_velocity;
  q.tail(modes_).setZero();
  v.tail(modes_).setZero();
  if (p.modal_coordinates.size() > 0) q.tail(modes_) = p.modal_coordinates;
  if (p.modal_velocities.size() > 0) v.tail(modes_) = p.modal_velocities;
}

void FlexibleBody::evaluate(const BodyState& state, Level level) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  cache.A = rotation_matrix(Eigen::Map<const Vector4>(state.q + 3));
  if (!deflection_) return inertia_->evaluate(state.q + 7, state.v + 6, ConstVector3(state.v + 3), level, cache.terms);
  DeflectionTerms& d = cache.deflection;
  deflection_->evaluate(state.q + 7, state.v + 6, level, d);
  inertia_->evaluate(d.xi.data(), d.xi_rate.data(), ConstVector3(state.v + 3), level, cache.terms);
  d.Ct.noalias() = inertia_->Ct * d.P;
  d.Cr.noalias() = cache.terms.Cr * d.P;
  if (level == Level::position) return;
  d.G_omega.noalias() = cache.terms.G_omega * d.P;
  d.u.noalias() = cache.terms.u * d.P;
  d.Cr_rate.noalias() = cache.terms.Cr_rate * d.P;
}

void FlexibleBody::add_residual(const BodyState& state, const double* v_dot, const Vector3& gravity, double* r) const {
  auto& cache = static_cast<Cache&>(*state.cache);
  const InertiaTerms& t = cache.terms;
  const ConstVector3 w(state.v + 3), acceleration(v_dot), w_dot(v_dot + 3);
  const int fields = field_count();
  const double* xi_acc = v_dot + 6;
  if (deflection_) {
    cache.deflection.acceleration = cache.deflection.xi_bias;
    cache.deflection.acceleration.noalias() += cache.deflection.P * ConstVector(v_dot + 6, modes_);
    xi_acc = cache.deflection.acceleration.data();
  }
  const ConstVector field_acc(xi_acc, fields);
  const Matrix3X& Ct = inertia_->Ct;
  // docs/equations.md 3.2. Gravity enters as an acceleration of the frame, so that its torque and its modal forces
  // follow the deformed centre of mass.
  const Vector3 lift = acceleration - gravity, lift_body = cache.A.transpose() * lift;
  // Acceleration of the first moment of mass s in the turning frame: tangential, elastic, centripetal, Coriolis.
  const Vector3 pull = w_dot.cross(t.s) + Ct.lazyProduct(field_acc) + w.cross(w.cross(t.s)) + 2 * w.cross(t.s_rate);
  Eigen::Map<Vector3>(r) += inertia_->mass * lift + cache.A * pull;
  Eigen::Map<Vector3>(r + 3) += t.s.cross(lift_body) + t.J * w_dot + t.Cr.lazyProduct(field_acc) + t.J_rate * w +
                                w.cross(Vector3(t.J * w + t.h)) + t.Cr_rate_h;
  double* modal = r + 6;
  if (deflection_) {
    DeflectionTerms& d = cache.deflection;
    for (int k = 0; k < fields; ++k)
      d.acceleration[k] += Ct.col(k).dot(lift_body) + t.Cr.col(k).dot(w_dot) - t.quadratic[k];
    Eigen::Map<VectorX> rows(modal, modes_);
    rows.noalias() += d.P.transpose() * d.acceleration;
    rows += d.force;
    add_modal(0, 1, 0, state.v + 6, modal);
    add_modal(0, 0, 1, state.q + 7, modal);
    return;
  }
  for (int k = 0; k < modes_; ++k) modal[k] += Ct.col(k).dot(lift_body) + t.Cr.col(k).dot(w_dot) - t.quadratic[k];
  if (diagonal_) {
    const double *eta = state.q + 7, *rate = state.v + 6;
    for (int k = 0; k < modes_; ++k) modal[k] += xi_acc[k] + damping_[k] * rate[k] + stiffness_[k] * eta[k];
  } else {
    add_modal(1, 0, 0, v_dot + 6, modal);
    add_modal(0, 1, 0, state.v + 6, modal);
    add_modal(0, 0, 1, state.q + 7, modal);
  }
}

void FlexibleBody::add_tangent(const BodyState& state, const double* v_dot, const Vector3& gravity,
                               const TangentWeights& weights, BodyTangent& S) const {
  using namespace lanes;
  auto& cache = static_cast<Cache&>(*state.cache);
  const InertiaTerms& t = cache.terms;
  const double a = weights.acceleration, d = weights.velocity, p = weights.position;
  const Columns A = load3x3(cache.A.data()), J = load3x3(t.J.data()), s = skewed(load3(t.s.data()));

  // The frame's blocks: force by turning is -A upper, torque by turning is turn. Mass matrix, symmetric:
  // [m E, -A s~, A Ct; ·, J, Cr; ·, ·, Mff].
  Columns upper = a * s, turn = a * J;
  const Columns lower = transposed(A * upper);
  Lanes lift = none();
  if (d != 0) {  // docs/equations.md 3.3, left-hand side; the small modal-modal gyroscopic part is left to Newton
    const Lanes w = load3(state.v + 3), spin = J * w + load3(t.h.data());
    const Columns W = skewed(w);
    upper = upper + d * (skewed(cross(w, load3(t.s.data()))) + W * s + skewed(2 * load3(t.s_rate.data())));
    turn = turn + d * (load3x3(t.J_rate.data()) + W * J - skewed(spin));
  }
  if (p != 0) {  // turning the body under gravity and acceleration
    const ConstVector3 w(state.v + 3), w_dot(v_dot + 3);
    const Vector3 acceleration = ConstVector3(v_dot) - gravity;
    Vector3 pull = w_dot.cross(t.s) + w.cross(w.cross(t.s)) + 2 * w.cross(t.s_rate);
    pull.noalias() += (deflection_ ? cache.deflection.Ct : inertia_->Ct).lazyProduct(ConstVector(v_dot + 6, modes_));
    if (deflection_) pull.noalias() += inertia_->Ct.lazyProduct(cache.deflection.xi_bias);
    lift = p * A.transposed_times(of(acceleration));
    upper = upper + skewed(p * of(pull));
    turn = turn + s * skewed(lift);
  }
  double* frame = S.frame.data();
  for (int i = 0; i < 3; ++i) frame[7 * i] += a * inertia_->mass;
  store3x3(load3x3(frame + 18, 6) - A * upper, frame + 18, 6);
  store3x3(load3x3(frame + 3, 6) - lower, frame + 3, 6);
  store3x3(load3x3(frame + 21, 6) + turn, frame + 21, 6);

  add_couplings(cache, state.v + 3, v_dot + 3, vector(lift), weights, S);
  if (diagonal_)
    for (int k = 0; k < modes_; ++k) S.linear[k] += a + d * damping_[k] + p * stiffness_[k];
  else if (deflection_)
    add_linear_tangent(cache, v_dot, gravity, weights, S.linear);
  else
    S.linear += a * modal_mass_ + d * damping_ + p * stiffness_;
}

/// The blocks that couple frame and deformation. The frame's rows by η hold gravity's moment and the inertia that
/// balances it: one without the other is worse for Newton than neither. Terms with η̇ and η̈ in them are left out, and
/// so is what η̇ gives to the frame's rows as the body turns (Coriolis): the modal rows know nothing of it, and where
/// the frame is held at nodes that lie close together a motion of the modes against the frame has next to no inertia,
/// so that half of it is much, and all of it little. lift: p Aᵀ (p̈ - g).
void FlexibleBody::add_couplings(Cache& cache, const double* omega, const double* omega_dot, const Vector3& lift,
                                 const TangentWeights& weights, BodyTangent& S) const {
  using namespace lanes;
  InertiaTerms& t = cache.terms;
  const DeflectionTerms& map = cache.deflection;
  const Matrix3X &Ct = deflection_ ? map.Ct : inertia_->Ct, &Cr = deflection_ ? map.Cr : t.Cr,
                 &G_omega = deflection_ ? map.G_omega : t.G_omega, &u = deflection_ ? map.u : t.u,
                 &Cr_rate = deflection_ ? map.Cr_rate : t.Cr_rate;
  const double a = weights.acceleration, d = weights.velocity, p = weights.position;
  // With a mass matrix alone the rates below may be of another state, and no numbers: they are not read.
  const bool moving = d != 0 || p != 0;
  const Columns A = load3x3(cache.A.data()), W = skewed(load3(omega)), L = skewed(of(lift)), aA = a * A;
  Columns pull = aA;
  if (moving) {
    pull = A * (scalar(a) + p * (skewed(load3(omega_dot)) + W * W));
    if (p != 0) inertia_->inertia_slopes(t, ConstVector3(omega_dot), t.G_omega_dot);
  }
  for (int k = 0; k < modes_; ++k) {
    const Lanes ct = load3(Ct.data() + 3 * k), cr = load3(Cr.data() + 3 * k);
    Lanes force = pull * ct, torque = a * cr, row = torque;
    if (moving) {
      const Lanes Gw = load3(G_omega.data() + 3 * k), uk = load3(u.data() + 3 * k), c = load3(Cr_rate.data() + 3 * k);
      const Lanes moment = L * ct;
      torque += p * (W * Gw) - moment;
      row -= d * (Gw + uk - c) + moment;
      if (p != 0) {
        Vector3 through;
        if (deflection_) through = t.G_omega_dot.lazyProduct(map.P.col(k));
        torque += p * load3(deflection_ ? through.data() : t.G_omega_dot.data() + 3 * k);
      }
    }
    double* column = S.frame_linear.data() + 6 * k;
    store3(load3(column) + force, column);
    store3(load3(column + 3) + torque, column + 3);
    const Lanes start = aA * ct;
    for (int i = 0; i < 3; ++i) S.linear_frame(k, i) += start[i], S.linear_frame(k, 3 + i) += row[i];
  }
}

/// The modal block of a quadratic deflection: Pᵀ P, damping, and the tangent of V and of P under the fields' loads.
void FlexibleBody::add_linear_tangent(Cache& cache, const double* v_dot, const Vector3& gravity,
                                      const TangentWeights& weights, Eigen::Map<VectorX>& linear) const {
  const InertiaTerms& t = cache.terms;
  DeflectionTerms& map = cache.deflection;
  if (weights.position != 0) {
    // The loads of inertia and gravity on the fields, as add_residual() sums them.
    const ConstVector3 acceleration(v_dot), w_dot(v_dot + 3);
    const Vector3 lift = cache.A.transpose() * (acceleration - gravity);
    map.acceleration = map.xi_bias;
    map.acceleration.noalias() += map.P * ConstVector(v_dot + 6, modes_);
    for (int k = 0; k < field_count(); ++k)
      map.acceleration[k] += inertia_->Ct.col(k).dot(lift) + t.Cr.col(k).dot(w_dot) - t.quadratic[k];
    deflection_->geometric_stiffness(map.acceleration, map.loaded);
  }
  const double a = weights.acceleration, d = weights.velocity, p = weights.position;
  int entry = 0;
  for (int l = 0; l < modes_; ++l)
    for (int k = l; k < modes_; ++k, ++entry) {
      linear[entry] += a * map.P.col(k).dot(map.P.col(l)) + d * damping_[entry] + p * stiffness_[entry];
      if (p != 0) linear[entry] += p * (map.stiffness(k, l) + map.loaded(k, l));
    }
}

BodyEnergy FlexibleBody::energy(const BodyState& state, const Vector3& gravity) const {
  const auto& cache = static_cast<const Cache&>(*state.cache);
  const InertiaTerms& t = cache.terms;
  const ConstVector3 x(state.q), v(state.v), w(state.v + 3);
  const ConstVector eta(state.q + 7, modes_), rate(state.v + 6, modes_);
  VectorX product = VectorX::Zero(modes_);
  add_modal(1, 0, 0, rate.data(), product.data());
  if (deflection_) product.noalias() = cache.deflection.P.transpose() * cache.deflection.xi_rate;
  BodyEnergy e;
  e.kinetic = 0.5 * inertia_->mass * v.squaredNorm() + (cache.A.transpose() * v).dot(w.cross(t.s) + t.s_rate) +
              0.5 * w.dot(t.J * w) + w.dot(t.h) + 0.5 * rate.dot(product);
  product.setZero();
  add_modal(0, 0, 1, eta.data(), product.data());
  e.elastic = 0.5 * eta.dot(product) + (deflection_ ? cache.deflection.energy : 0.0);
  e.gravity = -gravity.dot(inertia_->mass * x + cache.A * t.s);
  return e;
}

template std::unique_ptr<BodyBatch> make_body_batch<FlexibleBody>();

}  // namespace lithe
