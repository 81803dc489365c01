#include "engine/gradient/repeated_steps.h"

#include <algorithm>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/contact/contact_forces.h"
#include "engine/gradient/contact_numbers.h"
#include "engine/gradient/differences.h"
#include "engine/motion/projection.h"

namespace lithe {

namespace {

/// In pairs; weights of sixth order, of fourth from the inner two pairs, and of the value in the middle.
struct RepeatedOffset {
  double steps, weight, fourth;
  double middle;  // of the value between them, as a smooth function has it
};
constexpr std::array<RepeatedOffset, 6> kSixOffsets{{{1, 45.0 / 60, 8.0 / 12, 0.75},
                                                     {-1, -45.0 / 60, -8.0 / 12, 0.75},
                                                     {2, -9.0 / 60, -1.0 / 12, -0.3},
                                                     {-2, 9.0 / 60, 1.0 / 12, -0.3},
                                                     {3, 1.0 / 60, 0, 0.05},
                                                     {-3, -1.0 / 60, 0, 0.05}}};
constexpr double kAside = 4e-3;  // m, rad, and of the largest velocity: 4e-15 f⁽⁷⁾/140 beside a round-off of 1e-13
constexpr char kNoDerivative[] = "has no derivative: contacts change with the smallest change of its start";
constexpr double kOnJoints = 1e-15, kNoise = 1e-15, kUnsure = 1e2;
constexpr int kMostProjections = 12;
constexpr double kSameEnd = 1e-6;  // of a step taken again, beside what iterations left in the run
// Where steps bend more quickly, and at kinks, states are moved by less, down to the least, until the orders agree.
constexpr double kNearer = 0.2, kLeastAside = 5e-8, kOrdersAgree = 1e-7, kSmoothStep = 1e-4;

}  // namespace

MatrixX stacked(const Variation& x) {
  const Eigen::Index n = x.turn.rows(), vectors = 2 + static_cast<Eigen::Index>(x.history.size());
  MatrixX all(vectors * n + x.memory.rows(), x.turn.cols());
  all.topRows(n) = x.turn;
  all.middleRows(n, n) = x.velocity;
  for (Eigen::Index i = 2; i < vectors; ++i) all.middleRows(i * n, n) = x.history[static_cast<std::size_t>(i - 2)];
  all.bottomRows(x.memory.rows()) = x.memory;
  return all;
}

void unstack(const MatrixX& all, Eigen::Index count, std::size_t history, Variation& x) {
  x.turn = all.topRows(count);
  x.velocity = all.middleRows(count, count);
  x.history.resize(history);
  for (std::size_t i = 0; i < history; ++i)
    x.history[i] = all.middleRows(static_cast<Eigen::Index>(i + 2) * count, count);
  x.memory = all.bottomRows(all.rows() - static_cast<Eigen::Index>(2 + history) * count);
}

RepeatedSteps::RepeatedSteps(const DifferentiableSteps& method, const Drawing& nominal, ParameterDerivative& parameters)
    : evaluator_(nominal.system()),
      forward_(!method.step_derivative()),
      nominal_{.evaluator = &evaluator_, .step = method.repeated_step(evaluator_), .weight = 0} {
  moved_.resize(static_cast<std::size_t>(parameters.count()));
  for (int k = 0; k < parameters.count(); ++k)
    parameters.visit(k, [&](Evaluator& equations, double weight) {
      moved_[static_cast<std::size_t>(k)].push_back(
          {.evaluator = &equations, .step = method.repeated_step(equations), .weight = weight});
    });
}

void RepeatedSteps::refuse(const char* why) const {
  throw SimulationError(
      "the step to t = " + std::to_string(end_.time) + " s " + why, "the derivative of a run",
      "look for what is not smooth there: a singular pose, contacts that just begin to touch, to part "
      "or to slide; give another step or other parameters, or smaller steps of these");
}

/// Where the step ends, from end_. False: other points touch there, or stick.
bool RepeatedSteps::take(Equations& equations, const State& from, MatrixX history, VectorX& change) {
  equations.evaluator->recall(from.quarter_turns);
  equations.evaluator->recall_rows(from.left_out);
  equations.evaluator->recall(from.contacts);
  start_ = from;
  if (forward_ && equations.evaluator->parts().forward_dynamics) {
    // It reads coordinates of joints, and refuses states off them. The start moved onto them is the same start: that
    // of the run moves along them with state and parameters.
    Projector projector(*equations.evaluator);
    if (!projector.position(from.time, start_.q, kOnJoints, kMostProjections).converged)
      throw SimulationError("the state at t = " + std::to_string(from.time) + " s does not reach its joints nearby",
                            "the derivative of a run", "look for a singular pose, or give parameters smaller steps");
    projector.velocity(from.time, start_.q, start_.v);
  }
  if (step_->kinks)
    for (const PassedKink& kink : *step_->kinks)
      kink.number >= 0 ? land(equations, kink, history) : pass(equations, kink.time, kink.record.get(), history);
  pass(equations, step_->to.time, step_->record, history);
  const Eigen::Index n = end_.v.size();
  if (!same_contact_set(start_.contacts, step_->to.contacts)) return false;
  const VectorX memory = contact_numbers(start_.contacts);
  change.resize(n * (2 + history.cols()) + memory.size());
  evaluator_.layout().difference(end_.q, start_.q, change.head(n));
  change.segment(n, n) = start_.v - end_.v;
  change.segment(2 * n, history.size()) = history.reshaped() - end_history_.reshaped();
  change.tail(memory.size()) = memory - contact_numbers(end_contacts_);
  return true;
}

/// From start_ to another time: start_ is then the state there.
void RepeatedSteps::pass(Equations& equations, double time, const StepRecord* record, MatrixX& history) {
  reached_.time = time;
  equations.evaluator->recall(start_.contacts);
  equations.step->take(start_, record, history, reached_);
  start_.time = time;
  start_.q = reached_.q, start_.v = reached_.v, start_.contacts = reached_.contacts;
}

/// From start_ to where the law bends with these equations, and on from there: start_ and the history are then those
/// of the method started anew. By Newton's method for the time, with rates along the motion. Where the kink comes
/// before the step, or behind it, one of its parts leads back in time.
void RepeatedSteps::land(Equations& equations, const PassedKink& kink, MatrixX& history) {
  constexpr int kMostTries = 12;
  constexpr double kRate = 1e-6, kSameTime = 1e-16, kFarthest = 0.1;  // s; of the time; s
  if (!equations.now) {
    equations.now = std::make_unique<Snapshot>(equations.evaluator->system());
    equations.kinks = find_kinks(equations.evaluator->system());
  }
  const Kink& at = equations.kinks[static_cast<std::size_t>(kink.number)];
  const auto off = [&](double later) {
    State near = at_kink_;
    near.time += later;
    evaluator_.layout().retract(at_kink_.q, later * at_kink_.v, near.q);
    equations.now->evaluate(near, Accelerations::solved);
    return at.function(*equations.now) - at.level;
  };
  at_kink_ = start_;
  at_kink_.time = kink.time;
  MatrixX carried;
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMostTries; ++i) {
    carried = history;
    const double time = at_kink_.time;
    const State before = start_;
    pass(equations, time, kink.record.get(), carried);
    at_kink_ = std::exchange(start_, before);
    const double change = -off(0) / ((off(kRate) - off(-kRate)) / (2 * kRate));
    if (std::abs(change) <= kSameTime * std::abs(time) || std::abs(change) >= last) break;
    last = std::abs(change);
    at_kink_.time = time + change;
    if (!(std::abs(at_kink_.time - kink.time) <= kFarthest))
      throw SimulationError("the kink of '" + at.name + "' at t = " + std::to_string(kink.time) +
                                " s is far from there when its step is taken again nearby",
                            "the derivative of a run", "look for a law that is touched without being passed");
  }
  history = carried;
  start_ = at_kink_;
  equations.evaluator->recall(start_.contacts);
  equations.step->restart(start_, history);
}

/// The step itself, once more. Steps nearby are compared with this one, not with that of the run: axes that iterations
/// left turned would be in the differences.
void RepeatedSteps::begin(const TakenStep& step) {
  step_ = &step;
  end_ = step.to;
  history_ = nominal_.step->history(
      step.from, step.kinks && !step.kinks->empty() ? step.kinks->front().record.get() : step.record);
  end_history_.setZero(history_.rows(), history_.cols());
  end_contacts_ = step.to.contacts;
  memory_ = contact_numbers(step.from.contacts);
  VectorX change;
  const Eigen::Index n = step.to.v.size();
  const RepeatedStep::Rest left = nominal_.step->left_by_iterations(step.from, step.to);
  if (!take(nominal_, step.from, history_, change) || !(largest_entry(change.head(n)) <= kSameEnd + left.turn) ||
      !(largest_entry(change.segment(n, n)) <= kSameEnd * (1 + largest_entry(step.to.v)) + left.velocity))
    refuse("ends elsewhere when it is taken again");
  end_.q = start_.q, end_.v = start_.v;
  end_history_ = change.segment(2 * n, history_.size()).reshaped(n, history_.cols());
}

/// False, where there is no derivative along the direction.
bool RepeatedSteps::along(const VectorX& direction, VectorX& best) {
  const State& from = step_->from;
  const Eigen::Index n = from.v.size(), m = memory_.size();
  const auto turn = direction.head(n), speed = direction.segment(n, n);
  double size = std::max(largest_entry(turn), largest_entry(speed) / (1 + largest_entry(from.v)));
  for (Eigen::Index i = 0; i < history_.cols(); ++i)
    size = std::max(size, largest_entry(direction.segment((2 + i) * n, n)) / (1 + largest_entry(history_.col(i))));
  size = std::max(size, largest_entry(direction.tail(m)) / (1 + largest_entry(memory_)));
  const Eigen::Index length = n * (2 + history_.cols()) + contact_numbers(end_contacts_).size();
  VectorX change;
  best.setZero(length);
  if (size == 0) return true;
  near_ = from;
  const bool jumps = evaluator_.contacts() && evaluator_.contacts()->any_rigid();
  double best_off = std::numeric_limits<double>::infinity();
  for (double aside = kAside; aside >= kLeastAside; aside *= kNearer) {
    const double h = aside / size;
    VectorX sum = VectorX::Zero(length), fourth = sum, middle = VectorX::Zero(2 * n);
    bool same = true;
    for (const RepeatedOffset& offset : kSixOffsets) {
      const double t = offset.steps * h;
      evaluator_.layout().retract(from.q, t * turn, near_.q);
      near_.v = from.v + t * speed;
      MatrixX history = history_;
      history.reshaped() += t * direction.segment(2 * n, history.size());
      set_contact_numbers(memory_ + t * direction.tail(m), near_.contacts);
      try {
        same = take(nominal_, near_, std::move(history), change);
      } catch (const SimulationError&) {  // too far away to be taken
        same = false;
      }
      if (!same) break;
      sum += offset.weight / h * change;
      fourth += offset.fourth / h * change;
      middle += offset.middle * change.head(2 * n);
    }
    if (!same) continue;
    // A step with impulses may be another one nearby, on both sides: its differences are as good as those of a smooth
    // one, about a middle apart.
    const double off = std::max(largest_entry((sum - fourth).head(2 * n)), jumps ? largest_entry(middle) / h : 0);
    if (off < best_off) best_off = off, best = sum;
    if (off <= kOrdersAgree * (size + largest_entry(sum.head(2 * n)))) break;
  }
  return best_off <= kSmoothStep * (size + largest_entry(best.head(2 * n)));
}

VectorX RepeatedSteps::by_parameter(std::size_t k) {
  VectorX sum, change;
  for (Equations& moved : moved_[k]) {
    if (!take(moved, step_->from, history_, change))
      refuse("meets other contacts with parameters moved by their steps");
    if (sum.size() == 0) sum.setZero(change.size());
    sum += moved.weight * change;
  }
  return sum;
}

/// What round-off makes of a parameter that changes nothing.
double RepeatedSteps::noise(std::size_t k) const {
  double largest = 0;
  for (const Equations& moved : moved_[k]) largest = std::max(largest, std::abs(moved.weight));
  return kNoise * largest;
}

void RepeatedSteps::tangent(const TakenStep& step, Variation& x) {
  const log::Quiet quiet;
  begin(step);
  const MatrixX before = stacked(x);
  MatrixX after;
  VectorX change;
  for (Eigen::Index k = 0; k < before.cols(); ++k) {
    const double size = largest_entry(before.col(k)) > noise(static_cast<std::size_t>(k)) ? 1 : 0;
    if (!along(size * before.col(k), change)) refuse(kNoDerivative);
    if (k == 0) after.resize(change.size(), before.cols());
    after.col(k) = change + by_parameter(static_cast<std::size_t>(k));
  }
  unstack(after, step.to.v.size(), static_cast<std::size_t>(history_.cols()), x);
}

/// Column by column of the step's matrix. Columns along which it has no derivative, such as those that contacts block,
/// count as zero: what leads there is followed backwards, and refused where a parameter does.
void RepeatedSteps::adjoint(const TakenStep& step, Variation& x, MatrixX& gradient) {
  const log::Quiet quiet;
  begin(step);
  const MatrixX wanted = stacked(x);
  for (std::size_t k = 0; k < moved_.size(); ++k) {
    const VectorX change = by_parameter(k);
    if (unreached_.lead(change, kUnsure * noise(k))) refuse(kNoDerivative);
    gradient.row(static_cast<Eigen::Index>(k)) += change.transpose() * wanted;
  }
  const Eigen::Index n = step.from.v.size(), length = n * (2 + history_.cols()) + memory_.size();
  UnreachedDirections unreached(length);
  MatrixX carried = MatrixX::Zero(memory_.size(), 2 * n);
  if (evaluator_.contacts() && evaluator_.contacts()->any_rigid()) {
    const TouchingPoints touching = touching_points(evaluator_, step.from);
    carried = touching.carried;
    VectorX row = VectorX::Zero(length);
    for (Eigen::Index i = 0; i < touching.blocked.rows(); ++i) {
      row.head(2 * n) = touching.blocked.row(i).transpose();
      unreached.add(row);
    }
  }
  // By velocities that contacts remember as those of points less what bodies make of these.
  MatrixX before = MatrixX::Zero(length, wanted.cols()), leading = MatrixX::Zero(unreached_.rows().rows(), length);
  std::vector<Eigen::Index> without;
  VectorX change;
  for (Eigen::Index i = 0; i < length; ++i) {
    VectorX direction = unreached.leave_out(VectorX::Unit(length, i));
    direction.tail(memory_.size()) += carried * direction.head(2 * n);
    if (!along(direction, change)) {
      without.push_back(i);
      continue;
    }
    before.row(i) = change.transpose() * wanted;
    if (!unreached_.empty()) leading.col(i) = unreached_.rows() * change;
  }
  const auto as_they_are = [&](auto&& rows) {
    rows.topRows(2 * n) -= carried.transpose() * rows.bottomRows(memory_.size());
  };
  as_they_are(before);
  leading.transposeInPlace();
  MatrixX none = MatrixX::Zero(length, static_cast<Eigen::Index>(without.size()));
  for (Eigen::Index i = 0; i < none.cols(); ++i) none(without[static_cast<std::size_t>(i)], i) = 1;
  for (MatrixX* rows : {&none, &leading}) {
    as_they_are(*rows);
    for (Eigen::Index i = 0; i < rows->cols(); ++i) unreached.add(rows->col(i));
  }
  unreached_ = std::move(unreached);
  unstack(before, n, static_cast<std::size_t>(history_.cols()), x);
}

void RepeatedSteps::begin_at(const Variation& start) const {
  if (unreached_.empty()) return;
  const MatrixX changes = stacked(start);
  for (Eigen::Index k = 0; k < changes.cols(); ++k)
    if (unreached_.lead(changes.col(k), kUnsure * noise(static_cast<std::size_t>(k)))) refuse(kNoDerivative);
}

void RepeatedSteps::leave() const {
  if (!unreached_.empty()) refuse(kNoDerivative);
}

}  // namespace lithe
