#pragma once

#include <vector>

#include "engine/motion/integrator.h"
#include "engine/observe/event.h"

namespace lithe {

class Archive;

/// Finds where functions pass their levels within the steps of an integrator: by a change of sign between the ends or
/// the middle of a step, or where the parabola through these has an extremum near the level (two passages in one step);
/// then on the integrator's dense output, by bracketing (Alefeld, Potra & Shi 1995), to round-off of time. What passes
/// its level more than twice within a step may be missed. Functions of accelerations and reactions are given those of
/// the equations at each state looked at, at one factorisation each (Integrator::follows_equations()). Has an evaluator
/// of its own.
class EventFinder {
 public:
  explicit EventFinder(const System& system);

  void add(std::string name, EventFunction function, double level, Event::Direction direction);
  bool empty() const { return watched_.empty(); }
  int count() const { return static_cast<int>(watched_.size()); }

  /// A new state to go on from. Where a function lies at its level, or has just been dealt with, its sign is that of
  /// its trend in the next step: so an event is not found again where it happened.
  void start(const Integrator& integrator, const State& state);
  /// Whether a function lay below its level as the step began.
  bool below(int watched) const { return watched_[watched].start < 0; }
  void dealt_with(int watched) { watched_[watched].by_trend = true; }
  /// After find() in a step of h seconds: how long a function that has not passed its level takes to get there, by its
  /// change over the second half of the step; 0 where it does not come nearer.
  double time_left(int watched, double h) const;

  struct Crossing {
    int watched;  // in the order of add()
    double time;  // the function has passed its level here
    bool rising;
  };
  /// Passages in the last step, which led from `from` to `to`, by time. Throws SimulationError for a function that
  /// gives no finite value.
  const std::vector<Crossing>& find(const Integrator& integrator, const State& from, const State& to);
  /// Ends the step: its end is where the next begins.
  void accept();
  /// Throws SceneError when loading what other functions left.
  void history(Archive& archive);
  /// After loading: where a value has another sign than the function at this state, the function's counts.
  void resume(const Integrator& integrator, const State& state);

 private:
  struct Watched {
    std::string name;
    EventFunction function;
    double level;
    Event::Direction direction;
    double start = 0, soon = 0, middle = 0, end = 0;  // of the function, less its level; soon: a moment after the start
    bool by_trend = false;
  };
  struct Step {
    const Integrator& integrator;
    const State &from, &to;
  };
  double value(Watched& w);
  void evaluate(const Integrator& integrator, const State& state);
  bool by_trend(const Watched& w) const;
  void look(const Step& step, double s);
  double value_at(const Step& step, Watched& w, double s);
  double extremum(const Step& step, Watched& w, double sign);
  void find(const Step& step, int watched);
  void find_between(const Step& step, int watched, double s_a, double a, double s_b, double b);

  Snapshot snapshot_;
  State state_;  // on the dense output
  std::vector<Watched> watched_;
  std::vector<Crossing> crossings_;
};

}  // namespace lithe
