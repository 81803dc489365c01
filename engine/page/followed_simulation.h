#pragma once

#include <memory>

#include "engine/observe/observer.h"
#include "engine/run/simulation.h"

namespace lithe {

/// What `lithe view --follow` makes of the Simulation of a scene that records no Run: it has one, which is followed
/// (Run::follow). It sees the steps that first reach each 1/60 s, or hundredth of a short run, so that the steps stay
/// as they are; of islands, which have none in common, those times themselves.
class FollowedSimulation : public Simulation {
 public:
  using Simulation::Simulation;

  void observe(Observer& observer, Schedule schedule);
  void run(State& state, double end, Multipliers multipliers = Multipliers::found);

 private:
  std::unique_ptr<Observer> glances_;  // null: the scene has a Run, or nothing has run
  bool recorded_ = false;
};

}  // namespace lithe
