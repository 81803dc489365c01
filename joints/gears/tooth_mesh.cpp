#include "joints/gears/tooth_mesh.h"

#include <array>
#include <numbers>

#include "engine/base/checks.h"
#include "joints/gears/limited_damping.h"

namespace lithe {
namespace {

using Coordinate = ToothMesh::Coordinate;

/// x through a function with this value and slope there.
Coordinate through(const Coordinate& x, const CubicSpline::Value& f) {
  return chain(x, f.value, [&] { return f.slope; });
}

Wrench on_A(const Coordinate& x) { return {{x.d[0], x.d[1], x.d[2]}, {x.d[3], x.d[4], x.d[5]}}; }
Wrench on_B(const Coordinate& x) { return {{x.d[6], x.d[7], x.d[8]}, {x.d[9], x.d[10], x.d[11]}}; }
double rate(const Coordinate& x, const MarkerView& A, const MarkerView& B) {
  const Wrench a = on_A(x), b = on_B(x);
  return a.force.dot(A.v) + a.torque.dot(A.w) + b.force.dot(B.v) + b.torque.dot(B.w);
}

/// Flanks apart by round-off already count in the stiffness: without it a balance would have nothing to start from.
constexpr double kTouch = 1e-12;  // m

/// U = (1/b) ∫ ½ max(0, δ - γ y)² dy, with its derivatives by δ and γ.
struct Spread {
  double value = 0, by_1 = 0, by_2 = 0, by_11 = 0, by_12 = 0, by_22 = 0;

  Spread(double approach, double tilt, double half_face) {
    const double h = std::abs(tilt) * half_face, w = approach + h, side = std::copysign(half_face, tilt);
    if (w <= 0) {
      if (w > -kTouch) by_11 = 1;
      return;
    }
    if (approach >= h) {
      value = 0.5 * (approach * approach + h * h / 3);
      by_1 = approach, by_11 = 1;
      by_2 = h / 3 * side, by_22 = half_face * half_face / 3;
      return;
    }
    const double r = w / h;  // of the face in contact, doubled
    value = w * w * r / 12;
    by_1 = 0.25 * w * r, by_11 = 0.5 * r;
    by_2 = (0.25 * r - r * r / 12) * w * side;
    by_12 = (0.5 * r - 0.25 * r * r) * side;
    by_22 = (0.5 - 0.5 * r + r * r / 6) * r * half_face * half_face;
  }
};

MeshCycle stiffness_of(const GearGeometry& geometry, const ToothContact& contact) {
  const bool table = contact.model == ToothStiffness::table;
  if (table == contact.stiffness.empty())
    throw SceneError(table ? "the table of stiffness has no values" : "stiffness has values, but model is no table", "",
                     "give both .model = ToothStiffness::table and .stiffness, or neither");
  for (double k : contact.stiffness) require::positive(k, "stiffness");
  return {table ? contact.stiffness : mesh_stiffness(geometry, contact.model, contact.material), "stiffness"};
}

}  // namespace

ToothMesh::ToothMesh(const GearGeometry& geometry, const ToothContact& contact)
    : stiffness_(stiffness_of(geometry, contact)),
      error_(contact.error.empty() ? std::vector<double>{0} : contact.error, "error"),
      friction_({contact.friction, 0, 1, contact.creep_speed}),
      damping_(contact.damping),
      half_face_(0.5 * geometry.design().face_width),
      rubs_(contact.friction > 0),
      base_pitch_(geometry.base_pitch),
      approach_(geometry.approach),
      recess_(geometry.recess),
      base_helix_(geometry.base_helix_angle),
      thickness_(geometry.A.tooth_thickness * geometry.A.teeth / (2 * std::numbers::pi * geometry.A.working_radius)) {
  require::not_negative(contact.damping, "damping");
  require::finite(contact.phase, "phase");
}

ToothMesh::Coordinate ToothMesh::back_phase(const Coordinate& phase) const { return thickness_ - phase; }

double ToothMesh::depth(const Flank& flank) const {
  return flank.approach.value - error_(flank.phase.value).value + std::abs(flank.tilt.value) * half_face_;
}

void ToothMesh::add(Flank flank, const MarkerView& A, const MarkerView& B, ForceRows& rows) const {
  const CubicSpline::Value k = stiffness_(flank.phase.value);
  flank.approach -= through(flank.phase, error_(flank.phase.value));
  const Spread u(flank.approach.value, flank.tilt.value, half_face_);

  const double elastic = k.value * u.by_1;
  const LimitedDamping damped(damping_, rate(flank.approach, A, B), elastic);
  // V = k(ψ) U(δ, γ): its three forces, and its second derivatives as stiffness. A row without tension along the sum of
  // two coordinates carries what couples them, taken off their own rows.
  const std::array<const Coordinate*, 3> x = {&flank.approach, &flank.tilt, &flank.phase};
  const double force[] = {elastic + damped.force, k.value * u.by_2, k.slope * u.value};
  const double coupled[] = {k.value * u.by_12, k.slope * u.by_1, k.slope * u.by_2};  // 0 with 1, 0 with 2, 1 with 2
  const double own[] = {k.value * u.by_11 * damped.by_elastic - coupled[0] - coupled[1],
                        k.value * u.by_22 - coupled[0] - coupled[2], k.curvature * u.value - coupled[1] - coupled[2]};
  for (std::size_t i = 0; i < 3; ++i)
    rows.add({on_A(*x[i]), on_B(*x[i])}, force[i], own[i], i == 0 ? damped.damping : 0, i == 0 ? k.value * u.value : 0);
  constexpr std::pair<std::size_t, std::size_t> kPairs[] = {{0, 1}, {0, 2}, {1, 2}};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& [one, other] = kPairs[i];
    rows.add({on_A(*x[one]) + on_A(*x[other]), on_B(*x[one]) + on_B(*x[other])}, 0, coupled[i], 0, 0);
  }
  if (rubs_ && force[0] > 0) add_friction(flank, force[0], A, B, rows);
}

void ToothMesh::add_friction(const Flank& flank, double force, const MarkerView& A, const MarkerView& B,
                             ForceRows& rows) const {
  // A pair counts in full from half the entry behind its ends on: the number of pairs changes without jumps.
  const double entry = 0.05 * base_pitch_;
  const auto counted = [&](double along) {
    return std::clamp(0.5 + (along + approach_) / entry, 0.0, 1.0) *
           std::clamp(0.5 + (recess_ - along) / entry, 0.0, 1.0);
  };
  const double first = base_pitch_ * (flank.phase.value - std::floor(flank.phase.value));
  const int before = static_cast<int>((first + approach_) / base_pitch_) + 1,
            behind = static_cast<int>((recess_ - first) / base_pitch_) + 1;
  double pairs = 0;
  for (int i = -before; i <= behind; ++i) pairs += counted(first + i * base_pitch_);
  const double press = force / std::cos(base_helix_);
  for (int i = -before; i <= behind; ++i) {
    const double along = first + i * base_pitch_, share = counted(along) / pairs;
    if (share == 0) continue;
    const Vector3 at = flank.pitch_point + along * flank.normal, from_A = at - A.p, from_B = at - B.p;
    const double slides = flank.across.dot(B.v + B.w.cross(from_B) - A.v - A.w.cross(from_A));
    const Vector3 rub = -friction_.at(slides).mu * press * share * flank.across;
    rows.add_load(B, {rub, from_B.cross(rub)});
    rows.add_load(A, {-rub, -from_A.cross(rub)});
  }
}

double ToothMesh::critical_damping(double mobility) const {
  constexpr int kSamples = 256;
  double mean = 0;
  for (int i = 0; i < kSamples; ++i) mean += stiffness_(i / double{kSamples}).value / kSamples;
  return 2 * std::sqrt(mean / mobility);
}

}  // namespace lithe
