#include "engine/gradient/event_derivative.h"

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/gradient/differences.h"
#include "engine/gradient/parameter_derivative.h"
#include "engine/gradient/sensor_derivative.h"
#include "engine/motion/projection.h"
#include "engine/motion/step_derivative.h"

namespace lithe {

void apply_event(const ParametricEvent& event, const Drawing& drawing, Evaluator& equations, State& state) {
  constexpr double kTolerance = 1e-13;  // in the units of the rows
  constexpr int kMostProjections = 20;
  if (!event.change) return;
  const double time = state.time;
  event.change(state, drawing.point());
  state.time = time;
  const auto refuse = [&](const char* what) {
    throw SimulationError("the change of the event '" + event.name + "' leaves a state that " + what,
                          "t = " + std::to_string(time) + " s", "see what it does to the state");
  };
  if (!state.q.allFinite() || !state.v.allFinite()) refuse("is not finite");
  equations.recall(state.quarter_turns);
  equations.recall_rows(state.left_out);
  Projector projector(equations);
  if (!projector.position(time, state.q, kTolerance, kMostProjections).converged) refuse("is far off the joints");
  equations.track(state.quarter_turns);
  projector.velocity(time, state.q, state.v);
}

EventDerivative::EventDerivative(const ParametricScene& scene, const std::vector<DesignParameter>& parameters,
                                 const Drawing& drawing)
    : scene_(scene), parameters_(parameters), drawing_(drawing), equations_(drawing.system()) {}

EventDerivative::~EventDerivative() = default;

/// The drawings in which a parameter is moved, with their weights in its derivative.
template <class Look>
void EventDerivative::visit(int k, const Look& look) {
  const log::Quiet quiet;
  const bool few = static_cast<int>(parameters_.size()) <= kFewParameters;
  if (few) few_.resize(kOffsets.size() * parameters_.size());
  for (std::size_t i = 0; i < kOffsets.size(); ++i) {
    std::unique_ptr<MovedDrawing> drawn;
    std::unique_ptr<MovedDrawing>& kept = few ? few_[kOffsets.size() * static_cast<std::size_t>(k) + i] : drawn;
    if (!kept) kept = std::make_unique<MovedDrawing>(scene_, moved_parameter(parameters_, k, kOffsets[i].steps));
    look(*kept, kOffsets[i].weight / parameters_[static_cast<std::size_t>(k)].step);
  }
}

/// q̇ and v̇.
VectorX EventDerivative::rate(const State& state) {
  VectorX rate(2 * state.v.size()), lambda = state.lambda;
  lambda.conservativeResize(drawing_.system().layout().row_count());
  equations_.recall(state.quarter_turns);
  equations_.recall_rows(state.left_out);
  rate.head(state.v.size()) = state.v;
  Projector(equations_).accelerations(state.time, state.q, state.v, rate.tail(state.v.size()), lambda);
  return rate;
}

EventDerivative::Jump EventDerivative::at(int number, const State& before, const State& after) {
  constexpr double kGrazing = 1e-6;  // of what the function's terms come to
  const Layout& layout = drawing_.system().layout();
  const Eigen::Index n = layout.v_count(), count = static_cast<Eigen::Index>(parameters_.size());
  Jump jump{MatrixX::Identity(2 * n, 2 * n), MatrixX::Zero(2 * n, count), VectorX::Zero(2 * n), VectorX::Zero(count)};
  const ParametricEvent& event = scene_.events[static_cast<std::size_t>(number)];
  const Drawing::Place place = drawing_.find(event.column);
  const auto moved = [&](double time, const VectorX& turn, const VectorX& velocity) {
    State state = before;
    state.time += time;
    layout.retract(before.q, turn, state.q);
    state.v += velocity;
    return state;
  };
  // 1. The function, and its rate along the motion.
  SensorDerivative function(drawing_, place, {before, after});
  State behind_event = before;
  apply_event(event, drawing_, equations_, behind_event);
  VectorX of_state = VectorX::Zero(2 * n);
  function.add(before, 1, of_state.head(n), of_state.tail(n));
  const VectorX ahead = rate(before), behind = rate(behind_event);
  const double h = kDirectionStep / (1 + largest_entry(ahead));
  double slope = 0;
  for (const Offset& offset : kOffsets) {
    const double t = offset.steps * h;
    slope += offset.weight / h * function.value(moved(t, t * ahead.head(n), t * ahead.tail(n)));
  }
  if (!(std::abs(slope) > kGrazing * of_state.cwiseProduct(ahead).lpNorm<1>()))
    throw SimulationError("the event '" + event.name + "' touches its level without passing it",
                          "t = " + std::to_string(before.time) + " s",
                          "its time has no derivative there: move the level or the scene");
  // 2. The jump by the state, by its time and by the parameters.
  const auto reach = [&](const Drawing& drawing, Evaluator& equations, State state) {
    apply_event(event, drawing, equations, state);
    VectorX to(2 * n);
    layout.difference(behind_event.q, state.q, to.head(n));
    to.tail(n) = state.v - behind_event.v;
    return to;
  };
  VectorX by_time = VectorX::Zero(2 * n);
  if (event.change) {
    const double of_v = 1 + largest_entry(before.v);
    jump.by_state.setZero();
    for (const Offset& offset : kOffsets) {
      const double step = offset.steps * kDirectionStep, weight = offset.weight / kDirectionStep;
      const VectorX none = VectorX::Zero(n);
      for (Eigen::Index i = 0; i < n; ++i) {
        const VectorX unit = VectorX::Unit(n, i);
        jump.by_state.col(i) += weight * reach(drawing_, equations_, moved(0, step * unit, none));
        jump.by_state.col(n + i) += weight / of_v * reach(drawing_, equations_, moved(0, none, step * of_v * unit));
      }
      by_time += weight * reach(drawing_, equations_, moved(step, none, none));
    }
  }
  for (int k = 0; k < count; ++k)
    visit(k, [&](MovedDrawing& drawn, double weight) {
      jump.time_by_parameters[k] += weight * drawn.value(place, before);
      if (event.change) jump.by_parameters.col(k) += weight * reach(drawn.drawing, drawn.equations, before);
    });
  // 3. What the other time does.
  jump.time_by_parameters /= -slope;
  jump.time_by_state = -of_state / slope;
  const VectorX shift = jump.by_state * ahead + by_time - behind;
  jump.by_state += shift * jump.time_by_state.transpose();
  jump.by_parameters += shift * jump.time_by_parameters.transpose();
  add_start(behind_event, jump);
  return jump;
}

/// A method may move velocities as it starts (the shift of index 3), and carry what it finds there.
void EventDerivative::add_start(const State& behind, Jump& jump) {
  const Layout& layout = drawing_.system().layout();
  const Eigen::Index n = layout.v_count();
  const auto start = [&](Evaluator& equations, State state) -> VectorX {
    const auto method = scene_.integrator();
    method->start(equations, state);
    const auto derivative = dynamic_cast<const DifferentiableSteps&>(*method).step_derivative();
    const MatrixX history = derivative ? derivative->history(state) : MatrixX(n, 0);
    VectorX all((2 + history.cols()) * n);
    layout.difference(behind.q, state.q, all.head(n));
    all.segment(n, n) = state.v;
    all.tail(history.size()) = history.reshaped();
    return all;
  };
  const VectorX as_run = start(equations_, behind);
  if (as_run.size() == 2 * n) return;
  MatrixX by_state = MatrixX::Zero(as_run.size(), 2 * n),
          by_parameters = MatrixX::Zero(as_run.size(), jump.by_parameters.cols());
  const double of_v = 1 + largest_entry(behind.v);
  State near = behind;
  for (Eigen::Index i = 0; i < 2 * n; ++i)
    for (const Offset& offset : kOffsets) {
      const double step = kDirectionStep * (i < n ? 1 : of_v);
      const VectorX moved = offset.steps * step * VectorX::Unit(2 * n, i);
      layout.retract(behind.q, moved.head(n), near.q);
      near.v = behind.v + moved.tail(n);
      by_state.col(i) += offset.weight / step * (start(equations_, near) - as_run);
    }
  for (int k = 0; k < by_parameters.cols(); ++k)
    visit(k, [&](MovedDrawing& drawn, double weight) {
      by_parameters.col(k) += weight * (start(drawn.equations, behind) - as_run);
    });
  jump.by_parameters = (by_state * jump.by_parameters + by_parameters).eval();
  jump.by_state = (by_state * jump.by_state).eval();
}

}  // namespace lithe
