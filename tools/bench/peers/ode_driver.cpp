// ODE on the chains and the four-bars. It works on bodies and joints at the level of velocities, semi-implicit Euler,
// order 1:
//   world  a direct solver of all joints at once, O(N³) a step
//   quick  20 sweeps of successive over-relaxation: the joints do not close on long chains, however small the step
// The stiff chain has no joints: its bushings are forces, given anew before every step. The four-bars' hinges write
// more equations than are independent, which a trace of CFM makes solvable. Andrews' and Bricard's mechanisms are left
// out: already two four-bars cost it several times what MuJoCo needs for 1e-4.
#include <ode/ode.h>

#include "tools/bench/peers/mechanisms.h"

namespace {

using namespace lithe::bench;
using namespace lithe::bench::peers;

Point point(const dReal* v) { return {v[0], v[1], v[2]}; }

class World {
 public:
  World() {
    dWorldSetGravity(id, 0, 0, -kGravity);
    dWorldSetERP(id, 0.2);
    dWorldSetCFM(id, 0);
    dWorldSetQuickStepNumIterations(id, 20);
    dWorldSetAutoDisableFlag(id, 0);
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;
  ~World() { dWorldDestroy(id); }

  /// A rod at rest; its moments about the axes of the world, in which it is drawn.
  dBodyID add_rod(const Point& center, const Point& moments) const {
    const dBodyID rod = dBodyCreate(id);
    dBodySetPosition(rod, center[0], center[1], center[2]);
    dMass mass;
    dMassSetParameters(&mass, kRodMass, 0, 0, 0, moments[0], moments[1], moments[2], 0, 0, 0);
    dBodySetMass(rod, &mass);
    dBodySetGyroscopicMode(rod, 1);
    return rod;
  }
  void add_ball(dBodyID a, dBodyID b, const Point& at) const {
    const dJointID joint = dJointCreateBall(id, nullptr);
    dJointAttach(joint, a, b);
    dJointSetBallAnchor(joint, at[0], at[1], at[2]);
  }
  /// About y.
  void add_hinge(dBodyID a, dBodyID b, const Point& at) const {
    const dJointID joint = dJointCreateHinge(id, nullptr);
    dJointAttach(joint, a, b);
    dJointSetHingeAnchor(joint, at[0], at[1], at[2]);
    dJointSetHingeAxis(joint, 0, 1, 0);
  }

  const dWorldID id = dWorldCreate();
};

using Step = int (*)(dWorldID, dReal);
Step step_of(const Request& request) { return request.method == "quick" ? dWorldQuickStep : dWorldStep; }

std::vector<Rod> read_rods(const std::vector<dBodyID>& bodies) {
  std::vector<Rod> rods;
  for (const dBodyID body : bodies) {
    const dReal* R = dBodyGetRotation(body);  // 3 x 4, by rows
    rods.push_back({point(dBodyGetPosition(body)),
                    {R[0], R[4], R[8]},
                    point(dBodyGetLinearVel(body)),
                    point(dBodyGetAngularVel(body))});
  }
  return rods;
}

void add_bushing_forces(const std::vector<dBodyID>& bodies) {
  const std::vector<Rod> now = read_rods(bodies);
  for (std::size_t i = 0; i < now.size(); ++i) {
    const Point force = bushing_force(i ? &now[i - 1] : nullptr, now[i]), at = now[i].inboard();
    dBodyAddForceAtPos(bodies[i], force[0], force[1], force[2], at[0], at[1], at[2]);
    if (i > 0) dBodyAddForceAtPos(bodies[i - 1], -force[0], -force[1], -force[2], at[0], at[1], at[2]);
  }
}

Outcome run_chain(const Request& request) {
  const bool stiff = request.problem == "stiff_chain";
  const World world;
  std::vector<dBodyID> rods;
  for (int i = 0; i < request.count; ++i) {
    const dBodyID before = rods.empty() ? nullptr : rods.back();
    rods.push_back(world.add_rod({(i + 0.5) * kRodLength, 0, 0}, {kAlong, kAcross, kAcross}));
    const Point at{i * kRodLength, 0, 0};
    if (stiff) continue;
    if (request.spherical())
      world.add_ball(rods.back(), before, at);
    else
      world.add_hinge(rods.back(), before, at);
  }

  const Step step = step_of(request);
  Outcome outcome;
  outcome.steps = request.steps;
  const double started = cpu_seconds();
  for (long i = 0; i < request.steps; ++i) {
    if (stiff) add_bushing_forces(rods);
    step(world.id, request.step);
  }
  outcome.seconds = cpu_seconds() - started;
  request.judge(read_rods(rods), outcome);
  return outcome;
}

Outcome run_four_bar(const Request& request) {
  const World world;
  dWorldSetCFM(world.id, 1e-10);
  const Point up{0, 0, kRodLength}, along{kRodLength, 0, 0}, moments{kAcross, kAcross, kAcross};
  std::vector<dBodyID> rods;  // the uprights, then the couplers
  for (int i = 0; i <= request.count; ++i) {
    const Point foot = i * along;
    rods.push_back(world.add_rod(foot + 0.5 * up, moments));
    world.add_hinge(rods.back(), nullptr, foot);
    dBodySetLinearVel(rods.back(), 0.5 * four_bar::kSpeed, 0, 0);
    dBodySetAngularVel(rods.back(), 0, four_bar::kSpeed / kRodLength, 0);
  }
  for (int i = 0; i < request.count; ++i) {
    const Point top = i * along + up;
    rods.push_back(world.add_rod(top + 0.5 * along, moments));
    world.add_hinge(rods.back(), rods[i], top);
    world.add_hinge(rods.back(), rods[i + 1], top + along);
    dBodySetLinearVel(rods.back(), four_bar::kSpeed, 0, 0);
  }
  const auto energy = [&] {
    double sum = 0;
    for (const Rod& rod : read_rods(rods)) sum += four_bar::energy(rod);
    return sum;
  };
  const auto top = [&] {
    dVector3 at;
    dBodyGetRelPointPos(rods[0], 0, 0, 0.5 * kRodLength, at);
    return point(at);
  };
  const Step step = step_of(request);
  const auto advance = [&](long count) {
    for (long i = 0; i < count; ++i) step(world.id, request.step);
  };
  return follow(request, four_bar::first_top(request.count, request.end), advance, top, energy);
}

}  // namespace

int main(int argument_count, char** words) {
  return run_program(argument_count, words, [](Arguments& arguments) {
    const Request request(arguments, {"ode", PEER_VERSION, {"chain", "stiff_chain", "four_bar"}, {"world", "quick"}});
    arguments.finish();
    dInitODE2(0);
    const Outcome outcome =
        cheapest_of(request.repeats, [&] { return request.is_chain() ? run_chain(request) : run_four_bar(request); });
    dCloseODE();
    request.print_json(outcome);
  });
}
