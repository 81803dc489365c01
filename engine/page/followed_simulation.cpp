#include "engine/page/followed_simulation.h"

#include <algorithm>
#include <limits>

#include "engine/page/run.h"

namespace lithe {
namespace {

/// The first state, and then the first of each interval.
class Glances final : public Observer {
 public:
  Glances(const System& system, double interval) : run_(system), interval_(interval) {}

  void observe(Snapshot& now) override {
    if (now.time() < next_) return;
    next_ = now.time() + interval_;
    run_.observe(now);
  }

 private:
  Run run_;
  const double interval_;                                   // s
  double next_ = -std::numeric_limits<double>::infinity();  // s
};

}  // namespace

void FollowedSimulation::observe(Observer& observer, Schedule schedule) {
  recorded_ = recorded_ || dynamic_cast<const Run*>(&observer);
  Simulation::observe(observer, schedule);
}

void FollowedSimulation::run(State& state, double end, Multipliers multipliers) {
  if (!recorded_ && end > state.time) {
    recorded_ = true;
    const double interval = std::min(1. / 60, (end - state.time) / 100);
    const bool has_steps = islands().size() == 1 && !simplification();
    glances_ = std::make_unique<Glances>(observed(), has_steps ? interval : interval / 2);
    Simulation::observe(*glances_, has_steps ? every_step() : every(interval));
  }
  Simulation::run(state, end, multipliers);
}

}  // namespace lithe
