#pragma once

#include <vector>

#include "engine/observe/event.h"
#include "joints/gears/bevel_gear_pair.h"
#include "joints/gears/toothed_gear_pair.h"
#include "joints/gears/toothed_rack.h"

namespace lithe {

/// Where teeth in mesh lose contact and find it again, on either side of its teeth, as four events for
/// Simulation::on(): "<mesh> front meets", "<mesh> front parts", and "back" likewise. The front is the side that
/// touches where A drives with a torque about +z. For integrators that events are located with (all but time stepping).
/// With Action::restart the step ends there: across such a kink no method keeps its order. Borrows the mesh.
///   for (const Event& event : tooth_contact_events(mesh)) simulation.on(event);
std::vector<Event> tooth_contact_events(const ToothedGearPair& mesh, Event::Action action = Event::Action::record);
std::vector<Event> tooth_contact_events(const ToothedRack& mesh, Event::Action action = Event::Action::record);
std::vector<Event> tooth_contact_events(const BevelGearPair& mesh, Event::Action action = Event::Action::record);

}  // namespace lithe
