#pragma once

#include <functional>
#include <string>

#include "engine/contact/contact_event.h"
#include "engine/model/state.h"
#include "engine/observe/sensors.h"
#include "engine/observe/snapshot.h"

namespace lithe {

/// The function of an event: a number that changes continuously with the state.
using EventFunction = std::function<double(Snapshot&)>;

/// A column of a sensor as such a function: watch(height(ball.marker())), watch(velocity(bob.marker()), 0).
EventFunction watch(Sensor sensor, int column = 0);

/// An event where a function of the state passes a level; registered by Simulation::on().
///   simulation.on({.name = "impact", .function = watch(height(ball.marker())),
///                  .direction = Event::Direction::falling, .action = Event::Action::restart,
///                  .change = [](State& state) { state.v[2] *= -0.8; }});
struct Event {
  enum class Direction { rising, falling, both };
  /// record: its time is kept, the integrator continues undisturbed; restart: the step ends there, `change` is applied
  /// and the integrator restarts; stop: the run ends there, likewise.
  enum class Action { record, stop, restart };

  std::string name;
  EventFunction function;
  double level = 0;
  Direction direction = Direction::both;
  Action action = Action::record;
  /// Applied to the state at the event (restart, stop): an impact law, a changed speed. Positions and velocities are
  /// moved onto the constraints afterwards, velocities as an impact of the joints would.
  std::function<void(State&)> change = {};
};

/// An event that occurred.
struct EventRecord {
  double time;  // s
  std::string name;
  int index;  // of the event, in the order of Simulation::on(); -1: of surfaces of a contact of that name
  ContactEvent contact = {};  // what these did
};

}  // namespace lithe
