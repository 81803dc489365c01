// Bullet on the chains, in double precision.
//   chain        btMultiBody, joint coordinates, O(N): euler (semi-implicit, order 1) or rk4
//   stiff_chain  btRigidBody without joints, semi-implicit Euler; its bushings are forces given anew before every step.
//                No rk4 here: Bullet's holds the forces through a step, and so is of order 1 with them too.
//   four_bar     btRigidBody and hinges, 50 sweeps of sequential impulses a step; its btMultiBody takes loops as
//   impulses
//                after the step too. Andrews' and Bricard's mechanisms are left out: order 1 would cost more still
//                there.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <memory>

#include "tools/bench/peers/mechanisms.h"

namespace {

using namespace lithe::bench;
using namespace lithe::bench::peers;
static_assert(sizeof(btScalar) == sizeof(double), "link bullet-float64");

Point point(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
btVector3 vector(const Point& p) { return {p[0], p[1], p[2]}; }

/// What a world needs and does not own.
struct Stage {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
};

std::unique_ptr<btMultiBody> make_chain(const Request& request) {
  auto chain = std::make_unique<btMultiBody>(request.count, 1, btVector3(1, 1, 1), /*fixedBase=*/true,
                                             /*canSleep=*/false);
  const btVector3 inertia(kAlong, kAcross, kAcross), half(kRodLength / 2, 0, 0), none(0, 0, 0);
  const btQuaternion straight = btQuaternion::getIdentity();
  for (int i = 0; i < request.count; ++i) {
    const btVector3 pivot = i > 0 ? half : none;  // from the centre of the link before
    if (request.spherical())
      chain->setupSpherical(i, kRodMass, inertia, i - 1, straight, pivot, half, true);
    else
      chain->setupRevolute(i, kRodMass, inertia, i - 1, straight, btVector3(0, 1, 0), pivot, half, true);
  }
  chain->finalizeMultiDof();
  chain->setLinearDamping(0);  // both are 0.04 otherwise
  chain->setAngularDamping(0);
  chain->setMaxCoordinateVelocity(1e6);
  chain->setUseGyroTerm(true);
  chain->useRK4Integration(request.method == "rk4");
  return chain;
}

std::vector<Rod> read_rods(btMultiBody& chain) {
  const int n = chain.getNumLinks();
  btAlignedObjectArray<btQuaternion> rotations;
  btAlignedObjectArray<btVector3> origins, spins, speeds;
  rotations.resize(n + 1, btQuaternion::getIdentity());
  for (auto* array : {&origins, &spins, &speeds}) array->resize(n + 1, btVector3(0, 0, 0));
  chain.forwardKinematics(rotations, origins);
  chain.compTreeLinkVelocities(&spins[0], &speeds[0]);  // link axes, at the centre of mass; the base comes first
  std::vector<Rod> rods;
  for (int i = 0; i < n; ++i) {
    const btTransform& pose = chain.getLink(i).m_cachedWorldTransform;
    const btMatrix3x3& R = pose.getBasis();
    rods.push_back({point(pose.getOrigin()), point(R.getColumn(0)), point(R * speeds[i + 1]), point(R * spins[i + 1])});
  }
  return rods;
}

Outcome run_chain(const Request& request) {
  Stage stage;
  btMultiBodyConstraintSolver solver;
  btMultiBodyDynamicsWorld world(&stage.dispatcher, &stage.broadphase, &solver, &stage.configuration);
  world.setGravity(btVector3(0, 0, -kGravity));
  const std::unique_ptr<btMultiBody> chain = make_chain(request);
  world.addMultiBody(chain.get());

  Outcome outcome;
  outcome.steps = request.steps;
  const double started = cpu_seconds();
  for (long i = 0; i < request.steps; ++i) world.stepSimulation(request.step, 0);
  outcome.seconds = cpu_seconds() - started;
  request.judge(read_rods(*chain), outcome);
  world.removeMultiBody(chain.get());
  return outcome;
}

std::vector<Rod> read_rods(const std::vector<std::unique_ptr<btRigidBody>>& bodies) {
  std::vector<Rod> rods;
  for (const auto& body : bodies)
    rods.push_back({point(body->getCenterOfMassPosition()), point(body->getWorldTransform().getBasis().getColumn(0)),
                    point(body->getLinearVelocity()), point(body->getAngularVelocity())});
  return rods;
}

using Bodies = std::vector<std::unique_ptr<btRigidBody>>;

btRigidBody& add_body(btDiscreteDynamicsWorld& world, Bodies& bodies, const Point& center, const btVector3& moments) {
  static btEmptyShape nothing;
  btRigidBody::btRigidBodyConstructionInfo rod(kRodMass, nullptr, &nothing, moments);
  rod.m_startWorldTransform.setIdentity();
  rod.m_startWorldTransform.setOrigin(vector(center));
  bodies.push_back(std::make_unique<btRigidBody>(rod));
  bodies.back()->setActivationState(DISABLE_DEACTIVATION);
  bodies.back()->setFlags(BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY);
  world.addRigidBody(bodies.back().get());
  return *bodies.back();
}

Outcome run_stiff_chain(const Request& request) {
  Stage stage;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&stage.dispatcher, &stage.broadphase, &solver, &stage.configuration);
  world.setGravity(btVector3(0, 0, -kGravity));
  Bodies bodies;
  for (int i = 0; i < request.count; ++i)
    add_body(world, bodies, {(i + 0.5) * kRodLength, 0, 0}, btVector3(kAlong, kAcross, kAcross));

  Outcome outcome;
  outcome.steps = request.steps;
  const double started = cpu_seconds();
  for (long step = 0; step < request.steps; ++step) {
    const std::vector<Rod> now = read_rods(bodies);
    for (std::size_t i = 0; i < now.size(); ++i) {
      const Point force = bushing_force(i ? &now[i - 1] : nullptr, now[i]), at = now[i].inboard();
      bodies[i]->applyForce(vector(force), vector(at - now[i].center));
      if (i > 0) bodies[i - 1]->applyForce(vector(-1 * force), vector(at - now[i - 1].center));
    }
    world.stepSimulation(request.step, 0);
  }
  outcome.seconds = cpu_seconds() - started;
  request.judge(read_rods(bodies), outcome);
  for (const auto& body : bodies) world.removeRigidBody(body.get());
  return outcome;
}

Outcome run_four_bar(const Request& request) {
  Stage stage;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&stage.dispatcher, &stage.broadphase, &solver, &stage.configuration);
  world.setGravity(btVector3(0, 0, -kGravity));
  world.getSolverInfo().m_numIterations = 50;
  const btVector3 moments(kAcross, kAcross, kAcross), y(0, 1, 0);
  Bodies bodies;  // the uprights, then the couplers
  std::vector<std::unique_ptr<btHingeConstraint>> hinges;
  for (int i = 0; i <= request.count; ++i) {
    btRigidBody& upright = add_body(world, bodies, {i * kRodLength, 0, kRodLength / 2}, moments);
    upright.setLinearVelocity(btVector3(four_bar::kSpeed / 2, 0, 0));
    upright.setAngularVelocity(btVector3(0, four_bar::kSpeed / kRodLength, 0));
    hinges.push_back(std::make_unique<btHingeConstraint>(upright, btVector3(0, 0, -kRodLength / 2), y));
  }
  for (int i = 0; i < request.count; ++i) {
    btRigidBody& coupler = add_body(world, bodies, {(i + 0.5) * kRodLength, 0, kRodLength}, moments);
    coupler.setLinearVelocity(btVector3(four_bar::kSpeed, 0, 0));
    for (int side : {0, 1})
      hinges.push_back(std::make_unique<btHingeConstraint>(*bodies[i + side], coupler, btVector3(0, 0, kRodLength / 2),
                                                           btVector3((side - 0.5) * kRodLength, 0, 0), y, y));
  }
  for (const auto& hinge : hinges) world.addConstraint(hinge.get(), true);
  const auto energy = [&] {
    double sum = 0;
    for (const Rod& rod : read_rods(bodies)) sum += four_bar::energy(rod);
    return sum;
  };
  const auto top = [&] { return point(bodies[0]->getWorldTransform() * btVector3(0, 0, kRodLength / 2)); };
  const auto advance = [&](long count) {
    for (long i = 0; i < count; ++i) world.stepSimulation(request.step, 0);
  };
  const Outcome outcome = follow(request, four_bar::first_top(request.count, request.end), advance, top, energy);
  for (const auto& hinge : hinges) world.removeConstraint(hinge.get());
  for (const auto& body : bodies) world.removeRigidBody(body.get());
  return outcome;
}

Outcome run(const Request& request) {
  if (request.problem == "four_bar") return run_four_bar(request);
  return request.problem == "stiff_chain" ? run_stiff_chain(request) : run_chain(request);
}

}  // namespace

int main(int argument_count, char** words) {
  return run_program(argument_count, words, [](Arguments& arguments) {
    const Request request(arguments, {"bullet", PEER_VERSION, {"chain", "stiff_chain", "four_bar"}, {"euler", "rk4"}});
    arguments.finish();
    if (request.problem != "chain" && request.method == "rk4")
      throw std::invalid_argument("Bullet's rk4 sees neither forces nor loops within a step");
    request.print_json(cheapest_of(request.repeats, [&] { return run(request); }));
  });
}
