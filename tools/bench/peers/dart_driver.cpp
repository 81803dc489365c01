// DART on the chains and the four-bars: joint coordinates, O(N) articulated bodies and its one scheme, semi-implicit
// Euler (order 1). The stiff chain is free bodies, its bushings forces given anew before every step; the four-bars
// close by its ball joint constraint, an impulse a step. Andrews' and Bricard's mechanisms are left out: on the
// four-bars already 1e-4 is out of reach of steps of 0.1 ms. A chain is built once for all repeats: dense N x N caches
// grow with every body, which takes minutes at N = 1000 with ball joints.
#include <dart/constraint/BallJointConstraint.hpp>
#include <dart/dart.hpp>

#include "tools/bench/peers/mechanisms.h"

namespace {

using namespace lithe::bench;
using namespace lithe::bench::peers;
using namespace dart::dynamics;

Point point(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Vector3d vector(const Point& p) { return {p[0], p[1], p[2]}; }

Rod read_rod(const BodyNode* rod) {
  return {point(rod->getCOM()), point(rod->getWorldTransform().linear().col(0)), point(rod->getCOMLinearVelocity()),
          point(rod->getAngularVelocity())};
}

class FallingChain {
 public:
  explicit FallingChain(const Request& request) : request_(request), stiff_(request.problem == "stiff_chain") {
    for (int i = 0; i < request.count; ++i) rods_.push_back(add_rod(i));
    world_->setGravity(Eigen::Vector3d(0, 0, -kGravity));
    world_->setTimeStep(request.step);
    world_->addSkeleton(chain_);
    start_ = chain_->getPositions();
  }

  Outcome run() {
    chain_->setPositions(start_);
    chain_->setVelocities(Eigen::VectorXd::Zero(start_.size()));
    Outcome outcome;
    outcome.steps = request_.steps;
    const double started = cpu_seconds();
    for (long i = 0; i < request_.steps; ++i) {
      if (stiff_) add_bushing_forces();
      world_->step();
    }
    outcome.seconds = cpu_seconds() - started;
    request_.judge(rods(), outcome);
    return outcome;
  }

 private:
  BodyNode* add_rod(int i) {
    BodyNode* const before = i > 0 ? rods_.back() : nullptr;
    BodyNode::Properties body;
    body.mName = "rod" + std::to_string(i);
    body.mInertia = Inertia(kRodMass, Eigen::Vector3d(kRodLength / 2, 0, 0),
                            Eigen::Vector3d(kAlong, kAcross, kAcross).asDiagonal());
    Joint::Properties at;
    at.mName = "joint" + std::to_string(i);
    if (stiff_)  // drawn where it starts: the coordinates of a free joint begin at zero
      at.mT_ParentBodyToJoint.translation().x() = i * kRodLength;
    else if (before != nullptr)
      at.mT_ParentBodyToJoint.translation().x() = kRodLength;
    if (stiff_) return add<FreeJoint>(nullptr, FreeJoint::Properties(at), body);
    if (request_.spherical()) return add<BallJoint>(before, BallJoint::Properties(at), body);
    RevoluteJoint::Properties hinge{GenericJoint<dart::math::R1Space>::Properties(at)};
    hinge.mAxis = Eigen::Vector3d::UnitY();
    return add<RevoluteJoint>(before, hinge, body);
  }
  template <class Joint>
  BodyNode* add(BodyNode* before, const typename Joint::Properties& joint, const BodyNode::Properties& body) {
    return chain_->createJointAndBodyNodePair<Joint>(before, joint, body).second;
  }

  std::vector<Rod> rods() const {
    std::vector<Rod> read;
    for (const BodyNode* rod : rods_) read.push_back(read_rod(rod));
    return read;
  }
  void add_bushing_forces() {
    const std::vector<Rod> now = rods();
    for (std::size_t i = 0; i < now.size(); ++i) {
      const Eigen::Vector3d force = vector(bushing_force(i ? &now[i - 1] : nullptr, now[i]));
      rods_[i]->addExtForce(force, Eigen::Vector3d::Zero(), false, true);
      if (i == 0) continue;
      const Eigen::Isometry3d to_before = rods_[i - 1]->getWorldTransform().inverse();
      rods_[i - 1]->addExtForce(-force, to_before * vector(now[i].inboard()), false, true);
    }
  }

  const Request& request_;
  const bool stiff_;
  const SkeletonPtr chain_ = Skeleton::create("chain");
  const dart::simulation::WorldPtr world_ = dart::simulation::World::create();
  std::vector<BodyNode*> rods_;
  Eigen::VectorXd start_;
};

/// Hinged about y, of the same inertia about all axes: a rod that moves in the plane.
BodyNode* add_planar_rod(const SkeletonPtr& skeleton, BodyNode* before, const Eigen::Vector3d& at,
                         const Eigen::Vector3d& center) {
  RevoluteJoint::Properties hinge;
  hinge.mName = before ? "top" : "foot";
  hinge.mAxis = Eigen::Vector3d::UnitY();
  hinge.mT_ParentBodyToJoint.translation() = at;
  BodyNode::Properties rod;
  rod.mName = before ? "coupler" : "upright";
  rod.mInertia = Inertia(kRodMass, center, kAcross * Eigen::Matrix3d::Identity());
  return skeleton->createJointAndBodyNodePair<RevoluteJoint>(before, hinge, rod).second;
}

Outcome run_four_bar(const Request& request) {
  const Eigen::Vector3d up(0, 0, kRodLength), along(kRodLength, 0, 0);
  const auto world = dart::simulation::World::create();
  world->setGravity(Eigen::Vector3d(0, 0, -kGravity));
  world->setTimeStep(request.step);
  std::vector<SkeletonPtr> windows;
  for (int i = 0; i <= request.count; ++i) {
    const SkeletonPtr window = Skeleton::create("window" + std::to_string(i));
    BodyNode* upright = add_planar_rod(window, nullptr, i * along, up / 2);
    window->setVelocity(0, four_bar::kSpeed / kRodLength);
    if (i < request.count) {
      add_planar_rod(window, upright, up, along / 2);
      window->setVelocity(1, -four_bar::kSpeed / kRodLength);
    }
    world->addSkeleton(window);
    if (i > 0)
      world->getConstraintSolver()->addConstraint(std::make_shared<dart::constraint::BallJointConstraint>(
          windows[i - 1]->getBodyNode(1), upright, i * along + up));
    windows.push_back(window);
  }
  const auto energy = [&] {
    double sum = 0;
    for (const SkeletonPtr& window : windows)
      for (const BodyNode* rod : window->getBodyNodes()) sum += four_bar::energy(read_rod(rod));
    return sum;
  };
  const auto top = [&] { return point(windows[0]->getBodyNode(0)->getWorldTransform() * up); };
  const auto advance = [&](long count) {
    for (long i = 0; i < count; ++i) world->step();
  };
  return follow(request, four_bar::first_top(request.count, request.end), advance, top, energy);
}

}  // namespace

int main(int argument_count, char** words) {
  return run_program(argument_count, words, [](Arguments& arguments) {
    const Request request(arguments, {"dart", PEER_VERSION, {"chain", "stiff_chain", "four_bar"}, {"euler"}});
    arguments.finish();
    if (request.problem == "four_bar") {
      request.print_json(cheapest_of(request.repeats, [&] { return run_four_bar(request); }));
      return;
    }
    FallingChain chain(request);
    request.print_json(cheapest_of(request.repeats, [&] { return chain.run(); }));
  });
}
