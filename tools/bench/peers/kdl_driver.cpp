// Orocos KDL on the falling chain: revolute joints alone (it has no spherical ones), classical Runge-Kutta 4 around
// ChainFdSolver_RNE, which forms and factors the dense mass matrix. Neither loops nor free bodies.
#include <kdl/chain.hpp>
#include <kdl/chainfdsolver_recursive_newton_euler.hpp>
#include <kdl/chainfksolvervel_recursive.hpp>

#include "tools/bench/peers/peer.h"

namespace {

using namespace lithe::bench;
using namespace lithe::bench::peers;

Point point(const KDL::Vector& v) { return {v.x(), v.y(), v.z()}; }

/// A segment's frame is at its outboard end.
KDL::Chain make_chain(int count) {
  const KDL::RigidBodyInertia rod(kRodMass, KDL::Vector(-kRodLength / 2, 0, 0),
                                  KDL::RotationalInertia(kAlong, kAcross, kAcross));
  KDL::Chain chain;
  for (int i = 0; i < count; ++i)
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotY), KDL::Frame(KDL::Vector(kRodLength, 0, 0)), rod));
  return chain;
}

std::vector<Rod> read_rods(const KDL::Chain& chain, const KDL::JntArrayVel& state) {
  KDL::ChainFkSolverVel_recursive kinematics(chain);
  std::vector<Rod> rods;
  for (unsigned i = 1; i <= chain.getNrOfSegments(); ++i) {
    KDL::FrameVel end;
    kinematics.JntToCart(state, end, static_cast<int>(i));
    const KDL::Vector axis = end.M.R.UnitX(), back = -0.5 * kRodLength * axis;
    rods.push_back({point(end.p.p + back), point(axis), point(end.p.v + end.M.w * back), point(end.M.w)});
  }
  return rods;
}

Outcome run_chain(const Request& request) {
  const KDL::Chain chain = make_chain(request.count);
  KDL::ChainFdSolver_RNE dynamics(chain, KDL::Vector(0, 0, -kGravity));
  const auto n = static_cast<unsigned>(request.count);
  KDL::JntArray q(n), v(n), no_torque(n), stage_q(n), stage_v(n), acceleration(n);
  const KDL::Wrenches no_force(n, KDL::Wrench::Zero());
  const double h = request.step, node[4] = {0, h / 2, h / 2, h}, weight[4] = {h / 6, h / 3, h / 3, h / 6};
  Eigen::VectorXd next_q, next_v, rate;

  Outcome outcome;
  outcome.steps = request.steps;
  const double started = cpu_seconds();
  for (long step = 0; step < request.steps; ++step) {
    next_q = q.data;
    next_v = v.data;
    for (int s = 0; s < 4; ++s) {
      stage_q.data = q.data;
      stage_v.data = v.data;
      if (s > 0) {
        stage_q.data += node[s] * rate;
        stage_v.data += node[s] * acceleration.data;
      }
      rate = stage_v.data;
      if (dynamics.CartToJnt(stage_q, stage_v, no_torque, no_force, acceleration) < 0)
        throw std::runtime_error("KDL: " + std::string(dynamics.strError(dynamics.getError())));
      next_q += weight[s] * rate;
      next_v += weight[s] * acceleration.data;
    }
    q.data = next_q;
    v.data = next_v;
  }
  outcome.seconds = cpu_seconds() - started;
  request.judge(read_rods(chain, KDL::JntArrayVel(q, v)), outcome);
  return outcome;
}

}  // namespace

int main(int argument_count, char** words) {
  return run_program(argument_count, words, [](Arguments& arguments) {
    const Request request(arguments, {"kdl", PEER_VERSION, {"chain"}, {"rk4"}, {"revolute"}});
    arguments.finish();
    request.print_json(cheapest_of(request.repeats, [&] { return run_chain(request); }));
  });
}
