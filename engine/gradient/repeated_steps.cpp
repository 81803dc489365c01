#include "engine/gradient/repeated_steps.h"

#include "engine/base/error.h"
#include "engine/gradient/differences.h"
#include "engine/motion/projection.h"

namespace lithe {

namespace {

constexpr std::array<Offset, 6> kSixOffsets{
    {{1, 45.0 / 60}, {-1, -45.0 / 60}, {2, -9.0 / 60}, {-2, 9.0 / 60}, {3, 1.0 / 60}, {-3, -1.0 / 60}}};
constexpr double kAside = 4e-3;  // m, rad, and of the largest velocity: 4e-15 f⁽⁷⁾/140 beside a round-off of 1e-13
constexpr double kOnJoints = 1e-15;
constexpr int kMostProjections = 12;
constexpr double kSameEnd = 1e-6;  // of a step taken again: Newton's tolerance is below

}  // namespace

RepeatedSteps::RepeatedSteps(const DifferentiableSteps& method, const Drawing& nominal, ParameterDerivative& parameters)
    : evaluator_(nominal.system()), nominal_{&evaluator_, method.repeated_step(evaluator_), 0} {
  moved_.resize(static_cast<std::size_t>(parameters.count()));
  for (int k = 0; k < parameters.count(); ++k)
    parameters.visit(k, [&](Evaluator& equations, double weight) {
      moved_[static_cast<std::size_t>(k)].push_back({&equations, method.repeated_step(equations), weight});
    });
}

/// Where the step ends, from where that of the run did.
void RepeatedSteps::take(Equations& equations, const State& from, const State& to, VectorX& turn, VectorX& velocity) {
  equations.evaluator->recall(from.quarter_turns);
  equations.evaluator->recall_rows(from.left_out);
  reached_.time = to.time;
  if (equations.evaluator->parts().forward_dynamics) {
    // It reads coordinates of joints, and refuses states off them. The start moved onto them is the same start: that
    // of the run moves along them with state and parameters.
    on_joints_ = from;
    Projector projector(*equations.evaluator);
    if (!projector.position(from.time, on_joints_.q, kOnJoints, kMostProjections).converged)
      throw SimulationError("the state at t = " + std::to_string(from.time) + " s does not reach its joints nearby",
                            "the derivative of a run", "look for a singular pose, or give parameters smaller steps");
    projector.velocity(from.time, on_joints_.q, on_joints_.v);
    equations.step->take(on_joints_, reached_);
  } else {
    equations.step->take(from, reached_);
  }
  turn.resize(to.v.size());
  evaluator_.layout().difference(to.q, reached_.q, turn);
  velocity = reached_.v - to.v;
}

void RepeatedSteps::tangent(const State& from, const State& to, Variation& x) {
  VectorX turn, velocity;
  take(nominal_, from, to, turn, velocity);
  if (!(largest_entry(turn) <= kSameEnd && largest_entry(velocity) <= kSameEnd * (1 + largest_entry(to.v))))
    throw SimulationError("the step to t = " + std::to_string(to.time) + " s ends elsewhere when it is taken again",
                          "the derivative of a run",
                          "look for a singular pose that the run was led across, or for what is not smooth there");
  near_ = from;
  for (Eigen::Index k = 0; k < x.turn.cols(); ++k) {
    VectorX of_turn = VectorX::Zero(to.v.size()), of_velocity = of_turn;
    const VectorX along = x.turn.col(k), speed = x.velocity.col(k);
    const double size = std::max(largest_entry(along), largest_entry(speed) / (1 + largest_entry(from.v)));
    for (const Offset& offset : kSixOffsets) {
      if (size == 0) break;
      const double h = kAside / size;
      evaluator_.layout().retract(from.q, offset.steps * h * along, near_.q);
      near_.v = from.v + offset.steps * h * speed;
      take(nominal_, near_, to, turn, velocity);
      of_turn += offset.weight / h * turn;
      of_velocity += offset.weight / h * velocity;
    }
    for (Equations& moved : moved_[static_cast<std::size_t>(k)]) {
      take(moved, from, to, turn, velocity);
      of_turn += moved.weight * turn;
      of_velocity += moved.weight * velocity;
    }
    x.turn.col(k) = of_turn;
    x.velocity.col(k) = of_velocity;
  }
}

}  // namespace lithe
