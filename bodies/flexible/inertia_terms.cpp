#include "bodies/flexible/inertia_terms.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "bodies/flexible/inertia_integrals.h"
#include "engine/archive/archive.h"
#include "engine/base/checks.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

constexpr std::array kGroups{InertiaGroup::Ct, InertiaGroup::C0, InertiaGroup::C1, InertiaGroup::J1, InertiaGroup::J2};

Matrix3 full(const Vector6& s) { return Matrix3{{s[0], s[3], s[4]}, {s[3], s[1], s[5]}, {s[4], s[5], s[2]}}; }

/// What |a x b| is at most, component by component, for bounds a, b.
Vector3 cross_bound(const Vector3& a, const Vector3& b) {
  return {a.y() * b.z() + a.z() * b.y(), a.z() * b.x() + a.x() * b.z(), a.x() * b.y() + a.y() * b.x()};
}

/// Bounds of the left-hand sides of the equations of motion (docs/equations.md 3.2), body axes.
struct Load {
  Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
  VectorX modal;
};

/// Of the groups that are not zero in `I`; all signs taken alike.
class Majorant {
 public:
  Majorant(const InertiaIntegrals& I, const MotionBounds& bounds) : I_(I), b_(bounds) {}

  Load load(InertiaGroup group) const {
    Load load{.modal = VectorX::Zero(I_.mode_count())};
    switch (group) {
      case InertiaGroup::Ct:
        return of_first_moment(load);
      case InertiaGroup::C0:
        return of_coupling(I_.C0.cwiseAbs(), Matrix3X::Zero(3, I_.mode_count()), load);
      case InertiaGroup::C1:
        return of_second_coupling(load);
      case InertiaGroup::J1:
        for (int k = 0; k < I_.mode_count(); ++k) add_inertia(k, full(I_.J1.col(k).cwiseAbs()), Matrix3::Zero(), load);
        return load;
      case InertiaGroup::J2:
        for (int k = 0; k < I_.mode_count(); ++k) {
          Vector6 by_eta = Vector6::Zero(), by_rate = Vector6::Zero();
          for (int l = 0; l < I_.mode_count(); ++l) {
            const Vector6 J = I_.J2.block<6, 1>(6 * k, l).cwiseAbs();
            by_eta += b_.eta[l] * J, by_rate += b_.eta_rate[l] * J;
          }
          add_inertia(k, full(by_eta), full(by_rate), load);
        }
        return load;
    }
    return load;
  }
  /// Of the rigid body.
  Load rigid() const {
    const Vector3 s = I_.s0.cwiseAbs();
    const Matrix3 J = full(I_.J0.cwiseAbs());
    return {.force = I_.mass * b_.acceleration + cross_bound(b_.angular_acceleration, s) +
                     cross_bound(b_.spin, cross_bound(b_.spin, s)),
            .moment = cross_bound(s, b_.acceleration) + J * b_.angular_acceleration + cross_bound(b_.spin, J * b_.spin),
            .modal = VectorX::Zero(I_.mode_count())};
  }

 private:
  Load of_first_moment(Load load) const {
    const Matrix3X Ct = I_.Ct.cwiseAbs();
    const Vector3 s = Ct * b_.eta, rate = Ct * b_.eta_rate;
    load.force = cross_bound(b_.angular_acceleration, s) + Ct * b_.eta_acceleration +
                 cross_bound(b_.spin, cross_bound(b_.spin, s)) + 2 * cross_bound(b_.spin, rate);
    load.moment = cross_bound(s, b_.acceleration);
    load.modal = Ct.transpose() * b_.acceleration;
    return load;
  }
  /// Cr, and what its rate adds to the modal forces.
  Load of_coupling(const Matrix3X& Cr, const Matrix3X& rate, Load load) const {
    load.moment = Cr * b_.eta_acceleration + cross_bound(b_.spin, Cr * b_.eta_rate);
    load.modal = Cr.transpose() * b_.angular_acceleration + rate.transpose() * b_.spin;
    return load;
  }
  Load of_second_coupling(Load load) const {
    const int nm = I_.mode_count();
    Matrix3X Cr = Matrix3X::Zero(3, nm), rate = Matrix3X::Zero(3, nm), u = Matrix3X::Zero(3, nm);
    for (int k = 0; k < nm; ++k)
      for (int l = 0; l < nm; ++l) {
        const Vector3 c = I_.C1.block<3, 1>(3 * k, l).cwiseAbs();
        Cr.col(l) += b_.eta[k] * c;
        rate.col(l) += b_.eta_rate[k] * c;
        u.col(k) += b_.eta_rate[l] * c;
      }
    load = of_coupling(Cr, rate + u, std::move(load));
    if (!I_.antisymmetric) load.moment += rate * b_.eta_rate;
    return load;
  }
  /// η_k times the inertia `J` (J1_k, or η_l J2_kl with its rate).
  void add_inertia(int k, const Matrix3& J, const Matrix3& J_rate, Load& load) const {
    const bool second = !J_rate.isZero(0);
    load.moment += b_.eta[k] * (J * b_.angular_acceleration + cross_bound(b_.spin, J * b_.spin)) +
                   (b_.eta_rate[k] * J + b_.eta[k] * J_rate) * b_.spin;
    load.modal[k] += (second ? 1 : 0.5) * b_.spin.dot(J * b_.spin);
  }

  const InertiaIntegrals& I_;
  const MotionBounds& b_;
};

void require_linear(const ModalBasis& basis) {
  const std::string where = "basis '" + basis.name + "'";
  if (basis.nodal || !basis.diagonal)
    throw SceneError("inertia terms are measured and left out by modes.", where,
                     "use make_basis() with a mode count: eigenmodes.");
  if (basis.deflection)
    throw SceneError("inertia terms of a quadratic deflection carry its stiffening.", where,
                     "measure and leave out terms of the linear basis.");
}

InertiaIntegrals integrals_of(const ModalBasis& basis) {
  const bool known = basis.integrals.mass > 0 && basis.integrals.mode_count() == basis.mode_count();
  return known ? basis.integrals : inertia_integrals(basis);
}

void leave_out(InertiaIntegrals& integrals, const std::vector<InertiaGroup>& groups) {
  for (const InertiaGroup group : groups) {
    if (group == InertiaGroup::Ct) integrals.Ct.setZero();
    if (group == InertiaGroup::C0) integrals.C0.setZero();
    if (group == InertiaGroup::C1) integrals.C1.setZero();
    if (group == InertiaGroup::J1) integrals.J1.setZero();
    if (group == InertiaGroup::J2) integrals.J2.setZero();
  }
}

/// Of the mass matrix of the undeformed body.
bool is_positive_definite(const InertiaIntegrals& I) {
  const int nm = I.mode_count();
  MatrixX M = MatrixX::Zero(6 + nm, 6 + nm);  // lower triangle
  M.topLeftCorner<3, 3>() = I.mass * Matrix3::Identity();
  M.block<3, 3>(3, 0) = skew(I.s0);
  M.block<3, 3>(3, 3) = full(I.J0);
  M.bottomLeftCorner(nm, 3) = I.Ct.transpose();
  M.block(6, 3, nm, 3) = I.C0.transpose();
  M.bottomRightCorner(nm, nm) = I.Mff;
  return Eigen::LLT<MatrixX>(M).info() == Eigen::Success;
}

double part(double share, double whole) { return share == 0 ? 0 : share / whole; }

}  // namespace

std::string to_string(InertiaGroup group) {
  switch (group) {
    case InertiaGroup::Ct:
      return "Ct";
    case InertiaGroup::C0:
      return "C0";
    case InertiaGroup::C1:
      return "C1";
    case InertiaGroup::J1:
      return "J1";
    case InertiaGroup::J2:
      return "J2";
  }
  return "";
}

void MotionBounds::include(Snapshot& now, const Body& body) {
  using ConstVector = Eigen::Map<const VectorX>;
  const Layout::BodySlice& slice = now.system().layout().slice(body);
  const double *q = now.state().q.data() + slice.q, *v = now.state().v.data() + slice.v,
               *v_dot = now.accelerations().data() + slice.v;
  const int modes = slice.linear;
  if (eta.size() != modes)
    for (VectorX* bound : {&eta, &eta_rate, &eta_acceleration}) bound->setZero(modes);
  const auto widen = [](auto& bound, const auto& value) { bound = bound.cwiseMax(value.cwiseAbs()).eval(); };
  widen(eta, ConstVector(q + 7, modes));
  widen(eta_rate, ConstVector(v + 6, modes));
  widen(eta_acceleration, ConstVector(v_dot + 6, modes));
  const Matrix3 A = rotation_matrix(Eigen::Map<const Vector4>(q + 3));
  widen(acceleration, Vector3(A.transpose() * (Eigen::Map<const Vector3>(v_dot) - now.system().gravity())));
  widen(spin, Eigen::Map<const Vector3>(v + 3));
  widen(angular_acceleration, Eigen::Map<const Vector3>(v_dot + 3));
}

void MotionWatch::history(Archive& archive) {
  archive("eta", bounds_.eta);
  archive("eta_rate", bounds_.eta_rate);
  archive("eta_acceleration", bounds_.eta_acceleration);
  archive("acceleration", bounds_.acceleration);
  archive("spin", bounds_.spin);
  archive("angular_acceleration", bounds_.angular_acceleration);
}

MotionBounds motion_of_displacement(const ModalBasis& basis, double displacement) {
  require_linear(basis);
  require::positive(displacement, "displacement");
  MotionBounds bounds;
  const VectorX omega = MatrixX(basis.stiffness).diagonal().cwiseSqrt();
  if (omega.size() == 0) return bounds;
  const Eigen::Map<const Matrix3X> first(basis.modes.col(0).data(), 3, basis.nodes.cols());
  const double rate = omega[0] * displacement / first.colwise().norm().maxCoeff();
  bounds.eta = rate * omega.cwiseInverse();
  bounds.eta_rate = VectorX::Constant(omega.size(), rate);
  bounds.eta_acceleration = rate * omega;
  return bounds;
}

double InertiaEffect::largest() const { return std::max({force, moment, deflection}); }

std::string InertiaEffects::report() const {
  std::string table = "largest effect of    force    moment    deflection\n";
  for (const InertiaEffect& e : groups) {
    char line[96];
    std::snprintf(line, sizeof line, "  %-14s  %8.2g  %8.2g      %8.2g\n", to_string(e.group).c_str(), e.force,
                  e.moment, e.deflection);
    table += line;
  }
  return table;
}

InertiaEffects inertia_effects(const ModalBasis& basis, const MotionBounds& bounds) {
  require_linear(basis);
  const auto nm = static_cast<Eigen::Index>(basis.mode_count());
  if (bounds.eta.size() != nm || bounds.eta_rate.size() != nm || bounds.eta_acceleration.size() != nm)
    throw SceneError(
        "the bounds are of " + std::to_string(bounds.eta.size()) + " modes, the basis has " + std::to_string(nm) + ".",
        "basis '" + basis.name + "'", "give eta, eta_rate and eta_acceleration one entry a mode.");
  const InertiaIntegrals integrals = integrals_of(basis);
  const Majorant majorant(integrals, bounds);
  std::vector<Load> loads;
  Load whole = majorant.rigid();
  for (const InertiaGroup group : kGroups) {
    loads.push_back(majorant.load(group));
    whole.force += loads.back().force, whole.moment += loads.back().moment;
  }
  const VectorX stiffness = MatrixX(basis.stiffness).diagonal();
  const double deflection = std::sqrt(stiffness.dot(bounds.eta.cwiseAbs2()));
  InertiaEffects effects;
  for (std::size_t g = 0; g < kGroups.size(); ++g)
    effects.groups.push_back(
        {.group = kGroups[g],
         .force = part(loads[g].force.norm(), whole.force.norm()),
         .moment = part(loads[g].moment.norm(), whole.moment.norm()),
         .deflection = part(std::sqrt(loads[g].modal.cwiseAbs2().dot(stiffness.cwiseInverse())), deflection)});
  return effects;
}

InertiaIntegrals without(InertiaIntegrals integrals, const std::vector<InertiaGroup>& groups) {
  leave_out(integrals, groups);
  if (!is_positive_definite(integrals))
    throw SceneError("the mass matrix is no longer positive definite without these inertia terms.",
                     "a body of " + std::to_string(integrals.mode_count()) + " modes",
                     "keep Ct and C0, or leave out both.");
  return integrals;
}

ReducedInertia reduced_to(double bound, const ModalBasis& basis, const MotionBounds& bounds) {
  require::not_negative(bound, "bound");
  std::vector<InertiaEffect> effects = inertia_effects(basis, bounds).groups;
  std::ranges::sort(effects, {}, &InertiaEffect::largest);
  ReducedInertia reduced;
  for (const InertiaEffect& effect : effects) {
    if (!(reduced.error + effect.largest() <= bound)) break;
    reduced.error += effect.largest();
    reduced.left_out.push_back(effect.group);
  }
  InertiaIntegrals integrals = integrals_of(basis);
  leave_out(integrals, reduced.left_out);
  if (!is_positive_definite(integrals)) {  // one of Ct, C0 left out alone
    integrals = integrals_of(basis);
    for (const InertiaEffect& effect : effects)
      if (effect.group == InertiaGroup::Ct || effect.group == InertiaGroup::C0)
        if (std::erase(reduced.left_out, effect.group) > 0) reduced.error -= effect.largest();
    leave_out(integrals, reduced.left_out);
  }
  reduced.basis = with_inertia(basis, std::move(integrals));
  return reduced;
}

std::shared_ptr<const ModalBasis> with_inertia(const ModalBasis& basis, InertiaIntegrals integrals) {
  require_linear(basis);
  if (integrals.mode_count() != basis.mode_count())
    throw SceneError("the integrals are of " + std::to_string(integrals.mode_count()) + " modes, the basis has " +
                         std::to_string(basis.mode_count()) + ".",
                     "basis '" + basis.name + "'", "give integrals of all its modes.");
  auto copy = std::make_shared<ModalBasis>(basis);
  copy->integrals = std::move(integrals);
  return copy;
}

}  // namespace lithe
