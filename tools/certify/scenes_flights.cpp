// Free bodies, and bars on springs.
#include <cmath>

#include "engine/assembly/batch_of.h"
#include "joints/forces/spring_damper.h"
#include "joints/forces/user_force.h"
#include "tools/certify/scenes.h"

namespace lithe::certify {
namespace {

std::vector<Sensor> tumbling(SystemGraph& graph, ElasticParts& parts) {
  const SolidModel solid = bar({0.6, 0.03, 0.015}, {12, 1, 1}, {1e9, 0.35, 1150});
  ElasticPart stick = parts.add(graph, "stick",
                                {.solid = solid,
                                 .eigenmodes = 10,
                                 .loaded = {solid->node_set("x1")},
                                 .velocity = {1, 0, 3},
                                 .angular_velocity = {4, 3, 1}});
  graph.add<UserForce>("blow", {stick.average("x1")},
                       {[](double t, const MarkerView&) { return force(Vector3(0, 10, 30) * pulse(t, 0.01, 0.03)); }});
  return {position(stick.node(1), "end"), position(stick.average("x1"), "struck")};
}

std::vector<Sensor> middle_axis(SystemGraph& graph, ElasticParts& parts) {
  const Vector3 size(0.2, 0.1, 0.04);
  const SolidModel solid = bar(size, {6, 3, 2}, {2e6, 0.3, 1150});
  const Vector3 spin(0.3, 20, 0.3);
  ElasticPart plate = parts.add(graph, "plate",
                                {.solid = solid,
                                 .eigenmodes = 16,
                                 .stiffness_damping = 1e-4,
                                 .position = -0.5 * size,
                                 .velocity = -spin.cross(0.5 * size),
                                 .angular_velocity = spin});
  return {position(plate.node(1), "corner")};
}

std::vector<Sensor> hung_bar(SystemGraph& graph, ElasticParts& parts, double frequency) {
  const SolidModel solid = bar({0.5, 0.02, 0.01}, {10, 1, 1}, {3e9, 0.35, 1150});
  const std::vector<int> ends[] = {solid->node_set("x0"), solid->node_set("x1")};
  const std::vector<int> middle = nodes_where(*solid, [](const Vector3& p) { return std::abs(p.x() - 0.25) < 1e-9; });
  ElasticPart beam =
      parts.add(graph, "bar",
                {.solid = solid, .eigenmodes = 10, .loaded = {ends[0], ends[1], middle}, .stiffness_damping = 1e-4});
  const double weight = 9.81 * beam.mass();
  for (const auto& end : ends) {
    const Vector3 place = beam.middle(end);
    const std::string name = place.x() < 0.25 ? "left" : "right";
    graph.add<SpringDamper>(name, {graph.ground().marker(place + Vector3(0, 0, 0.3)), beam.average(end)},
                            {.stiffness = 500, .damping = 0.5, .preload = weight / 2});
  }
  graph.add<UserForce>("shaker", {beam.average(middle)}, {[frequency](double t, const MarkerView&) {
                         return force(Vector3(0, 0, 3 * std::sin(frequency * t)));
                       }});
  return {position(beam.average(middle), "middle"), position(beam.average(ends[1]), "end")};
}

}  // namespace

void add_flights(std::vector<Scene>& scenes) {
  const Vector3 weightless(0, 0, 0);
  scenes.push_back({.name = "tumbling_stick",
                    .shows = "thrown, struck at its end, undamped: it flies on vibrating",
                    .duration = 0.8,
                    .samples = 100,
                    .draw = tumbling});
  scenes.push_back({.name = "middle_axis",
                    .shows = "a soft plate spun about its middle axis turns over; undeformed at the start",
                    .duration = 1.2,
                    .samples = 100,
                    .gravity = weightless,
                    .draw = middle_axis});
  scenes.push_back({.name = "hung_bar_below",
                    .shows = "on two springs, shaken at a third of its first bending frequency",
                    .duration = 0.6,
                    .samples = 100,
                    .draw = [](SystemGraph& graph, ElasticParts& parts) { return hung_bar(graph, parts, 140); }});
  scenes.push_back({.name = "hung_bar_resonant",
                    .shows = "the same near resonance",
                    .duration = 0.6,
                    .samples = 100,
                    .draw = [](SystemGraph& graph, ElasticParts& parts) { return hung_bar(graph, parts, 390); }});
}

}  // namespace lithe::certify
