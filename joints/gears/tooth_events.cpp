#include "joints/gears/tooth_events.h"

#include "engine/model/marker_motions.h"

namespace lithe {
namespace {

template <class Teeth>
std::vector<Event> contact_events_of(const Teeth& mesh, Event::Action action) {
  std::vector<Event> events;
  for (const std::size_t side : {0, 1}) {
    const auto depth = [&mesh, side](Snapshot& now) {
      const MarkerMotions markers(mesh.markers(), [&](const Marker& m) { return now.marker(m); });
      AngleMemory memory;
      memory.recall(now.quarter_turns_of(mesh));
      return mesh.mesh().depth(mesh.flanks(markers, memory)[side]);
    };
    const std::string name = mesh.name() + (side == 0 ? " front " : " back ");
    events.push_back(
        {.name = name + "meets", .function = depth, .direction = Event::Direction::rising, .action = action});
    events.push_back(
        {.name = name + "parts", .function = depth, .direction = Event::Direction::falling, .action = action});
  }
  return events;
}

}  // namespace

std::vector<Event> tooth_contact_events(const ToothedGearPair& mesh, Event::Action action) {
  return contact_events_of(mesh, action);
}
std::vector<Event> tooth_contact_events(const ToothedRack& mesh, Event::Action action) {
  return contact_events_of(mesh, action);
}
std::vector<Event> tooth_contact_events(const BevelGearPair& mesh, Event::Action action) {
  return contact_events_of(mesh, action);
}

}  // namespace lithe
