#include "joints/forces/joint_friction.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/checks.h"

namespace lithe {

namespace {

/// A part of the pressing force and its derivative.
struct Press {
  double force = 0;
  Wrench by{Vector3::Zero(), Vector3::Zero()};

  void add(const Vector3& f, double arm, Vector3 Wrench::*of) {
    const double length = f.norm();
    if (length == 0) return;
    force += length / arm;
    by.*of += f / (length * arm);
  }
};

}  // namespace

JointFriction::JointFriction(CoordinateSet coordinate, Parameters parameters)
    : coordinate_(std::move(coordinate)),
      parameters_(parameters),
      law_({parameters.coefficient, parameters.static_coefficient, parameters.stribeck_speed, parameters.creep_speed}) {
  const Parameters& p = parameters_;
  coordinate_.require_one("friction");
  if (!p.joint) throw SceneError("names no joint", "", "give .joint = &pin: whose reaction presses");
  for (const auto& [value, name] : {std::pair(p.viscous, "viscous"), std::pair(p.radius, "radius"),
                                    std::pair(p.bending_arm, "bending_arm"), std::pair(p.preload, "preload")})
    require::not_negative(value, name);
  if (coordinate_.is_angle(0)) require::positive(p.radius, "radius");
}

void JointFriction::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  const auto& p = parameters_;
  const MeasuredCoordinate x = coordinate_.measure(0, markers, rows);
  const bool turns = coordinate_.is_angle(0);
  const Vector3 axis = coordinate_.axis(0, markers);
  const auto& [F, T] = rows.reaction();

  Press press;
  const Vector3 F_axial = axis.dot(F) * axis, T_axial = axis.dot(T) * axis;
  press.add(F - F_axial, 1, &Wrench::force);
  if (turns) press.add(F_axial, 1, &Wrench::force);
  if (p.bending_arm > 0) press.add(T - T_axial, p.bending_arm, &Wrench::torque);
  if (!turns && p.radius > 0) press.add(T_axial, p.radius, &Wrench::torque);
  const double N = press.force + p.preload;

  const double arm = turns ? p.radius : 1, s = arm * x.rate;
  const auto [mu, mu_slope] = law_.at(s);
  rows.add({x.on_A, x.on_B}, arm * mu * N + p.viscous * x.rate, 0, arm * arm * mu_slope * N + p.viscous, 0);
  rows.depends_on_reaction((arm * mu) * press.by);
}

template std::unique_ptr<ForceBatch> make_force_batch<JointFriction>();

}  // namespace lithe
