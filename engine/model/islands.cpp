#include "engine/model/islands.h"

#include <algorithm>
#include <map>

#include "engine/factor/graph_topology.h"

namespace lithe {

std::vector<std::unique_ptr<SystemGraph>> split(SystemGraph& graph) {
  // 1. Who is tied to whom.
  std::map<const Body*, int> number;
  for (const auto& b : graph.bodies()) number.emplace(b.body, static_cast<int>(number.size()) - 1);  // ground: -1
  Topology topology{static_cast<int>(number.size()) - 1, {}};
  const auto bodies_of = [&](const std::vector<Marker>& markers) {
    std::vector<int> bodies;
    for (const Marker& m : markers) bodies.push_back(number.at(m.body));
    return bodies;
  };
  for (const auto& c : graph.constraints()) topology.ties.push_back(bodies_of(c.markers));
  const auto tie_bodies = [&](const auto& entry) { topology.ties.push_back(bodies_of(entry.markers)); };
  graph.for_each_load(tie_bodies, tie_bodies);
  for (const auto& f : graph.forces()) {
    if (!f.force->reaction_of()) continue;
    const auto joint = std::find_if(graph.constraints().begin(), graph.constraints().end(),
                                    [&](const auto& c) { return c.constraint == f.force->reaction_of(); });
    if (joint == graph.constraints().end()) continue;
    const auto pressed = bodies_of(joint->markers);
    auto& tied = topology.ties[graph.constraints().size() + static_cast<std::size_t>(f.place)];
    tied.insert(tied.end(), pressed.begin(), pressed.end());
  }
  const std::vector<int> island = islands(topology);

  // 2. A graph for each, by its first body.
  std::vector<std::unique_ptr<SystemGraph>> parts(island.empty() ? 0
                                                                 : *std::max_element(island.begin(), island.end()) + 1);
  for (auto& part : parts) part = SystemGraph::part_of(graph);
  for (const auto& b : graph.bodies())
    if (const int i = number.at(b.body); i >= 0) parts[island[i]]->share(b);
  std::size_t tie = 0;
  const auto part_of_tie = [&]() -> SystemGraph* {
    const auto& bodies = topology.ties[tie++];
    const auto moved = std::find_if(bodies.begin(), bodies.end(), [](int body) { return body >= 0; });
    return moved == bodies.end() ? nullptr : parts[island[*moved]].get();
  };
  for (const auto& c : graph.constraints())
    if (SystemGraph* part = part_of_tie()) part->share(c, c.markers);
  const auto share = [&](const auto& entry) {
    if (SystemGraph* part = part_of_tie()) part->share(entry, entry.markers);
  };
  graph.for_each_load(share, share);
  return parts;
}

bool depends_on_time(const SystemGraph& graph) {
  const auto& constraints = graph.constraints();
  const auto& forces = graph.forces();
  return std::any_of(constraints.begin(), constraints.end(),
                     [](const auto& c) { return c.constraint->depends_on_time(); }) ||
         std::any_of(forces.begin(), forces.end(), [](const auto& f) { return f.force->depends_on_time(); });
}

}  // namespace lithe
