// Closed loops in Simbody: mobilizers along a tree, constraints where it closes; its solver of the loops is dense.
#include <algorithm>

#include "tools/bench/peers/mechanisms.h"
#include "tools/bench/peers/simbody.h"

namespace lithe::bench::peers {

using namespace SimTK;

namespace {

using Pin = MobilizedBody::Pin;

/// A planar closure, two equations: a point of B stays on the axis through a point of A.
void close(MobilizedBody& a, const Vec3& on_a, MobilizedBody& b, const Vec3& on_b,
           const std::array<CoordinateAxis, 2>& plane) {
  for (const CoordinateAxis& axis : plane)
    Constraint::PointInPlane(a, UnitVec3(axis), dot(Vec3(UnitVec3(axis)), on_a), b, on_b);
}

/// A run in which a point of a body is compared with its path after every step.
Outcome follow_station(const Request& request, Path path, SimbodyModel& model, State& start, bool project,
                       const MobilizedBody& body, const Vec3& station) {
  model.system.realize(start, Stage::Velocity);
  const double energy = model.system.calcEnergy(start);
  Outcome outcome;
  double largest_change = 0;
  simbody_integrate(request, model, start, project, outcome, [&](const State& state) {
    model.system.realize(state, Stage::Velocity);
    path.compare(state.getTime(), point(body.findStationLocationInGround(state, station)));
    largest_change = std::max(largest_change, std::abs(model.system.calcEnergy(state) - energy));
  });
  outcome.error = path.worst();
  outcome.energy_error = largest_change;
  return outcome;
}

}  // namespace

Outcome run_simbody_andrews(const Request& request) {
  using namespace andrews;
  SimbodyModel model;
  // Parent, the pin's place on it, and the centre of mass of body k from the pin.
  const auto pin = [&](MobilizedBody& parent, const Vec3& at, int k, const Vec3& com) {
    return Pin(parent, Transform(at), simbody_body(kMass[k], com, Vec3(kInertia[k])), Transform());
  };
  MobilizedBody& ground = model.matter.updGround();
  const Vec3 A(kA[0], kA[1], 0), B(kB[0], kB[1], 0), C(kC[0], kC[1], 0);
  Pin K1 = pin(ground, Vec3(0), 0, Vec3(ra, 0, 0));
  Pin K2 = pin(K1, Vec3(rr, 0, 0), 1, Vec3(-da, 0, 0));
  Pin K3 = pin(ground, B, 2, Vec3(sa, sb, 0));
  Pin K5 = pin(ground, A, 4, Vec3(ta, tb, 0));
  Pin K4 = pin(K5, Vec3(zt, 0, 0), 3, Vec3(0, -(e - ea), 0));
  Pin K7 = pin(ground, A, 6, Vec3(ua, ub, 0));
  Pin K6 = pin(K7, Vec3(0, -u, 0), 5, Vec3(zf - fa, 0, 0));
  const Vec3 E(-d, 0, 0);  // on K2
  close(K2, E, K3, Vec3(0, -ss, 0), {XAxis, YAxis});
  close(K2, E, K4, Vec3(0, -e, 0), {XAxis, YAxis});
  close(K2, E, K6, Vec3(zf, 0, 0), {XAxis, YAxis});
  const Force::TwoPointLinearSpring spring(model.forces, K3, Vec3(sd, -sc, 0), ground, C, kStiffness, kRestLength);
  Force::MobilityConstantForce(model.forces, K1, 0, kTorque);

  model.system.realizeTopology();
  State start = model.system.getDefaultState();
  const std::array<Pin*, 7> angles{&K1, &K2, &K3, &K4, &K5, &K6, &K7};
  for (int i = 0; i < 7; ++i) angles[i]->setAngle(start, kStart[i]);
  model.system.realize(start, Stage::Velocity);
  const double energy = spring.calcPotentialEnergyContribution(start);

  Outcome outcome;
  const State end = simbody_integrate(request, model, start, false, outcome);
  std::array<double, 7> reached{};
  for (int i = 0; i < 7; ++i) reached[i] = angles[i]->getAngle(end);
  outcome.error = worst_angle(reached);
  const double work = kTorque * (reached[0] - kStart[0]);
  outcome.energy_error =
      std::abs(model.matter.calcKineticEnergy(end) + spring.calcPotentialEnergyContribution(end) - energy - work);
  return outcome;
}

Outcome run_simbody_four_bar(const Request& request) {
  SimbodyModel model;
  Force::Gravity(model.forces, model.matter, -ZAxis, kGravity);
  const Rotation tilt(-Pi / 2, XAxis);  // pins along y
  const Vec3 up(0, 0, kRodLength), along(kRodLength, 0, 0);
  const auto rod = [&](MobilizedBody& parent, const Vec3& at, const Vec3& end) {
    return Pin(parent, Transform(tilt, at), simbody_body(kRodMass, end / 2, Vec3(kAcross)), Transform(tilt));
  };
  std::vector<Pin> uprights, couplers;
  for (int i = 0; i <= request.count; ++i) uprights.push_back(rod(model.matter.updGround(), i * along, up));
  for (int i = 0; i < request.count; ++i) {
    couplers.push_back(rod(uprights[i], up, along));
    close(uprights[i + 1], up, couplers[i], along, {XAxis, ZAxis});
  }
  model.system.realizeTopology();
  State start = model.system.getDefaultState();
  for (Pin& upright : uprights) upright.setRate(start, four_bar::kSpeed / kRodLength);
  for (Pin& coupler : couplers) coupler.setRate(start, -four_bar::kSpeed / kRodLength);  // they stay level
  // At the flat positions, which are singular, the loops must be closed every step: else the solution is lost.
  Outcome outcome =
      follow_station(request, four_bar::first_top(request.count, request.end), model, start, true, uprights[0], up);
  outcome.note = "projected every step";
  return outcome;
}

Outcome run_simbody_bricard(const Request& request) {
  SimbodyModel model;
  Force::Gravity(model.forces, model.matter, -YAxis, kGravity);
  const auto at = [](int i) { return Vec3(bricard::kPoints[i][0], bricard::kPoints[i][1], bricard::kPoints[i][2]); };
  const CoordinateAxis axes[6] = {YAxis, ZAxis, XAxis, YAxis, ZAxis, XAxis};
  std::vector<MobilizedBody> rods;
  for (int i = 0; i < 5; ++i) {  // drawn in world axes, from its first point
    const Vec3 rod = at(i + 1) - at(i);
    Vec3 moments(bricard::kAcross);
    for (int k = 0; k < 3; ++k)
      if (rod[k] != 0) moments[k] = bricard::kAlong;
    MobilizedBody before = i > 0 ? rods.back() : MobilizedBody(model.matter.Ground());
    const Rotation turn(UnitVec3(axes[i]), ZAxis);
    const Vec3 place = i > 0 ? at(i) - at(i - 1) : at(0);
    rods.push_back(Pin(before, Transform(turn, place), simbody_body(kRodMass, rod / 2, moments), Transform(turn)));
  }
  // The last revolute without its redundant row: with it Simbody needs more time and, left to project where it will,
  // loses the solution at tolerances above 1e-6.
  MobilizedBody& ground = model.matter.updGround();
  Constraint::Ball(ground, at(5), rods[4], at(5) - at(4));
  Constraint::ConstantAngle(ground, UnitVec3(YAxis), rods[4], UnitVec3(XAxis), Pi / 2);
  model.system.realizeTopology();
  State start = model.system.getDefaultState();
  Outcome outcome = follow_station(request, Path(request.reference()), model, start, false, rods[1], at(2) - at(1));
  outcome.note = "without the redundant row of the last joint";
  return outcome;
}

}  // namespace lithe::bench::peers
