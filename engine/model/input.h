#pragma once

#include <functional>
#include <limits>
#include <source_location>
#include <string>
#include <vector>

#include "engine/model/element.h"
#include "engine/model/motion_law.h"

namespace lithe {

/// A named quantity that is given from outside while a run goes on: a torque, a target, a length, a stiffness. Used
/// wherever a function of time is (drives, targets, lengths of rods, amplitudes of loads: it converts to a MotionLaw),
/// as a number of springs, dampers and loads (Adjustable), and in laws of a scene by value(t):
///   auto& torque = graph.add<Input>("torque", {.unit = "N m", .lower = -5, .upper = 5});
///   graph.add<CoordinateMotor>("motor", {hinge.angle()}, {.effort = torque});
///   simulation.run(state, 1);  torque.set(1, 2.5);  simulation.run(state, 2);
/// It is a table of samples (time, value), one at t = 0 at first; before the first and behind the last it is constant.
/// Samples may be given before a run, between runs, and by observers and events within one; a run is then as if all had
/// been known. Steps of a Simulation end where a held value jumps or a line bends, and the integrator starts anew there
/// (positions and velocities on the constraints); without such samples a run is, bit for bit, that with the function.
/// At a jump, what ends there sees the old value, and what begins there the new one.
/// Belongs to its graph: what else reads this graph meanwhile, in other threads too, sees the same values.
class Input final : public Element {
 public:
  enum class Between {
    held,    // the sample before, with a jump at the next: of forces, never of a drive
    linear,  // a straight line; drives knock at its bends, as an impact would
    smooth,  // from rest to rest, smooth_step(): 10 s³ - 15 s⁴ + 6 s⁵, its acceleration is continuous
  };
  struct Parameters {
    std::string unit{};  // "N m"; for tables, pages and other tools: nothing is converted
    double value = 0;    // before anything is set
    double lower = -std::numeric_limits<double>::infinity();
    double upper = std::numeric_limits<double>::infinity();
    Between between = Between::held;
    bool parameter = false;  // set by hand rather than by a signal: a stiffness. FMUs list it among their parameters
    std::string description{};
  };
  /// Throws SceneError for bounds or a value that are not numbers, bounds that cross, and a value outside them.
  explicit Input(Parameters parameters);

  const Parameters& parameters() const { return parameters_; }
  const std::string& unit() const { return parameters_.unit; }
  Between between() const { return parameters_.between; }

  /// Adds a sample behind all others, or replaces the last one if it has the same time (s). Throws SceneError for a
  /// value outside the bounds, what is not finite, and a time before the last sample's.
  void set(double time, double value, std::source_location where = std::source_location::current());
  /// Forgets all samples: this is the value at all times, and the next ones follow `time`. Throws SceneError likewise.
  void reset(double time, double value, std::source_location where = std::source_location::current());
  /// As it was drawn.
  void reset() { samples_.assign(1, {0, parameters_.value}); }

  /// Value, rate and acceleration at a time; at a jump those behind it.
  Motion at(double time) const {
    if (samples_.size() == 1 && !forced_) return {samples_.front().value, 0, 0};
    return among_samples(time);
  }
  double value(double time) const { return at(time).value; }

  // As functions of time, for the parameters of elements; an input outlives them, being of the same graph.
  operator MotionLaw() const;                                      // NOLINT: implicit on purpose
  operator std::function<double(double, double, double)>() const;  // NOLINT: the effort of a motor
  /// The input that a law is made of; null: another law.
  static const Input* of(const MotionLaw& law);

  // ---- the engine's side ----
  /// Time of the next jump or bend behind `time`; infinite: none.
  double next_kink(double time) const;
  /// Until the next call, times from `time` on see what is before a kink at `time`.
  void end_at(double time) const { end_ = time; }
  /// Until release(), it is that at all times: for linearizations and probes.
  void force(const Motion& motion) const { forced_ = true, forced_as_ = motion; }
  void release() const { forced_ = false; }
  struct Sample {
    double time, value;  // s, unit
  };
  const std::vector<Sample>& samples() const { return samples_; }
  /// Throws what set() would throw for this value; `where` asks.
  void require(double time, double value, const std::string& where) const;

 private:
  Motion among_samples(double time) const;

  const Parameters parameters_;
  std::vector<Sample> samples_;  // never empty, times grow
  mutable double end_ = std::numeric_limits<double>::infinity();
  mutable bool forced_ = false;
  mutable Motion forced_as_;
};

}  // namespace lithe
