// Simbody: chains and loops, the only engine here that controls its error: Runge-Kutta-Merson 4(3) by default,
// Feldberg 5(4), or CPODES, the variable-order BDF of CVODE with projection; --tol is its "accuracy".
//   chain        mobilizers: joint coordinates, O(N)
//   stiff_chain  free bodies; the bushings are one custom force, which costs less than its general linear bushing
//   andrews, four_bar, bricard: simbody_loops.cpp
#include "tools/bench/peers/simbody.h"

namespace lithe::bench::peers {

using namespace SimTK;

SimTK::Body::Rigid simbody_body(double mass, const Vec3& com, const Vec3& central_moments) {
  return Body::Rigid(MassProperties(mass, com, Inertia(central_moments).shiftFromMassCenter(com, mass)));
}

SimTK::State simbody_integrate(const Request& request, SimbodyModel& model, const State& start, bool project,
                               Outcome& outcome, const std::function<void(const State&)>& watch) {
  std::unique_ptr<Integrator> integrator;
  if (request.method == "merson")
    integrator = std::make_unique<RungeKuttaMersonIntegrator>(model.system);
  else if (request.method == "feldberg")
    integrator = std::make_unique<RungeKuttaFeldbergIntegrator>(model.system);
  else
    integrator = std::make_unique<CPodesIntegrator>(model.system);
  if (request.fixed)
    integrator->setFixedStepSize(request.step);
  else
    integrator->setAccuracy(request.tolerance);
  integrator->setFinalTime(request.end);
  integrator->setAllowInterpolation(false);
  integrator->setProjectEveryStep(project);
  integrator->setReturnEveryInternalStep(static_cast<bool>(watch));
  const double started = cpu_seconds();
  integrator->initialize(start);
  while (integrator->getTime() < request.end) {
    if (integrator->stepTo(request.end, request.end) == Integrator::EndOfSimulation) break;
    if (watch) watch(integrator->getState());
  }
  outcome.seconds = cpu_seconds() - started;
  outcome.steps = integrator->getNumStepsTaken();
  State end = integrator->getState();
  model.system.realize(end, Stage::Velocity);
  return end;
}

namespace {

const Vec3 kCenter(kRodLength / 2, 0, 0), kTip(kRodLength, 0, 0);

std::vector<Rod> read_rods(const std::vector<MobilizedBody>& bodies, const State& state) {
  std::vector<Rod> rods;
  for (const MobilizedBody& body : bodies)
    rods.push_back(
        {point(body.findStationLocationInGround(state, kCenter)), point(Vec3(body.getBodyRotation(state).x())),
         point(body.findStationVelocityInGround(state, kCenter)), point(body.getBodyAngularVelocity(state))});
  return rods;
}

/// All bushings of the stiff chain.
class Bushings : public Force::Custom::Implementation {
 public:
  explicit Bushings(const std::vector<MobilizedBody>& rods) : rods_(rods) {}

  void calcForce(const State& state, Vector_<SpatialVec>& forces, Vector_<Vec3>&, Vector&) const override {
    Vec3 before_tip(0);
    for (std::size_t i = 0; i < rods_.size(); ++i) {
      const MobilizedBody& rod = rods_[i];
      const Vec3 at = rod.getBodyOriginLocation(state), tip = at + kRodLength * rod.getBodyRotation(state).x();
      Vec3 speed = rod.getBodyOriginVelocity(state);
      if (i > 0) {
        const MobilizedBody& before = rods_[i - 1];
        speed -= before.getBodyOriginVelocity(state) +
                 before.getBodyAngularVelocity(state) % (at - before.getBodyOriginLocation(state));
      }
      const Vec3 force = -kBushingStiffness * (at - before_tip) - kBushingDamping * speed;
      forces[rod.getMobilizedBodyIndex()][1] += force;  // at its origin: no moment
      if (i > 0) {
        SpatialVec& other = forces[rods_[i - 1].getMobilizedBodyIndex()];
        other[0] -= (at - rods_[i - 1].getBodyOriginLocation(state)) % force;
        other[1] -= force;
      }
      before_tip = tip;
    }
  }
  Real calcPotentialEnergy(const State&) const override { return 0; }

 private:
  const std::vector<MobilizedBody>& rods_;
};

Outcome run_chain(const Request& request) {
  SimbodyModel model;
  Force::Gravity(model.forces, model.matter, -ZAxis, kGravity);
  const Body::Rigid rod = simbody_body(kRodMass, kCenter, Vec3(kAlong, kAcross, kAcross));
  const Rotation tilt(-Pi / 2, XAxis);  // a Pin turns about z: this makes it y
  std::vector<MobilizedBody> rods;
  for (int i = 0; i < request.count; ++i) {
    MobilizedBody before = model.matter.Ground();
    if (i > 0 && request.problem == "chain") before = rods.back();
    const Vec3 at = i > 0 ? kTip : Vec3(0);
    if (request.problem == "stiff_chain") {
      MobilizedBody::Free body(before, Transform(), rod, Transform());
      body.setDefaultTransform(Transform(Vec3(i * kRodLength, 0, 0)));
      rods.push_back(body);
    } else if (request.spherical()) {
      rods.push_back(MobilizedBody::Ball(before, Transform(at), rod, Transform()));
    } else {
      rods.push_back(MobilizedBody::Pin(before, Transform(tilt, at), rod, Transform(tilt)));
    }
  }
  if (request.problem == "stiff_chain") Force::Custom(model.forces, new Bushings(rods));  // theirs to delete
  model.system.realizeTopology();
  State start = model.system.getDefaultState();
  model.system.realize(start, Stage::Velocity);

  Outcome outcome;
  const State end = simbody_integrate(request, model, start, false, outcome);
  request.judge(read_rods(rods, end), outcome);
  return outcome;
}

Outcome run(const Request& request) {
  if (request.problem == "andrews") return run_simbody_andrews(request);
  if (request.problem == "four_bar") return run_simbody_four_bar(request);
  if (request.problem == "bricard") return run_simbody_bricard(request);
  return run_chain(request);
}

}  // namespace
}  // namespace lithe::bench::peers

int main(int argument_count, char** words) {
  using namespace lithe::bench;
  return run_program(argument_count, words, [](Arguments& arguments) {
    const peers::Request request(arguments, {"simbody",
                                             PEER_VERSION,
                                             {"chain", "stiff_chain", "andrews", "four_bar", "bricard"},
                                             {"merson", "feldberg", "cpodes"},
                                             {"spherical", "revolute"},
                                             /*controls_error=*/true});
    arguments.finish();
    request.print_json(peers::cheapest_of(request.repeats, [&] { return peers::run(request); }));
  });
}
