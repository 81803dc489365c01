// A contact is an element of a kind of its own: neither a constraint nor a force element.
#include <gmock/gmock.h>

#include "bodies/rigid_body.h"
#include "engine/assembly/system.h"
#include "engine/model/islands.h"
#include "engine/simplify/simplification.h"
#include "joints/contact/contact.h"
#include "joints/forces/spring_damper.h"

namespace lithe::test::contact_kind_test {
namespace {

using testing::ElementsAre;

static_assert(std::derived_from<Contact, Connector> && !std::derived_from<Contact, ForceElement> &&
              !std::derived_from<Contact, Constraint>);

/// Two balls, tied to ground by contacts and a spring between them in the order of their adding.
struct Balls {
  Balls() {
    auto& low = graph.add<RigidBody>("low", {.position = {0, 0, 0.2}});
    auto& high = graph.add<RigidBody>("high", {.position = {0, 0, 0.6}});
    const Collider ground{graph.ground().marker(), shape::half_space()};
    floor = &graph.add<Contact>("floor", {ground, {low.marker(), shape::sphere(0.1)}});
    graph.add<SpringDamper>("spring", {low.marker(), high.marker()}, {.stiffness = 10});
    graph.add<Contact>("upper floor", {ground, {high.marker(), shape::sphere(0.1)}},
                       {.law = Compliance{.stiffness = 1e4}});
  }
  SystemGraph graph;
  Contact* floor;
};

std::vector<std::string> loads_of(const SystemGraph& graph) {
  std::vector<std::string> names;
  graph.for_each_load([&](const SystemGraph::ForceEntry& f) { names.push_back("force " + f.force->name()); },
                      [&](const SystemGraph::ContactEntry& c) { names.push_back("contact " + c.contact->name()); });
  return names;
}

TEST(ContactKind, is_found_by_the_graph_as_its_own) {
  Balls scene;
  ASSERT_EQ(scene.graph.contacts().size(), 2u);
  EXPECT_EQ(scene.graph.contacts()[0].contact, scene.floor);
  EXPECT_EQ(scene.graph.contacts()[0].markers, scene.floor->markers());
  ASSERT_EQ(scene.graph.forces().size(), 1u);
  EXPECT_EQ(scene.graph.forces()[0].force->name(), "spring");
  EXPECT_EQ(scene.graph.find<Contact>("floor"), scene.floor);
  EXPECT_EQ(scene.graph.find<ContactElement>("floor"), scene.floor);
  EXPECT_EQ(scene.graph.find<Connector>("floor"), scene.floor);
  EXPECT_THROW(scene.graph.find<ForceElement>("floor"), SceneError);
  EXPECT_THROW(scene.graph.find<ContactElement>("spring"), SceneError);
}

TEST(ContactKind, keeps_its_place_among_force_elements) {
  Balls scene;
  const auto added = ElementsAre("contact floor", "force spring", "contact upper floor");
  EXPECT_THAT(loads_of(scene.graph), added);
  const auto parts = split(scene.graph);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_THAT(loads_of(*parts[0]), added);
  Simplification simple(scene.graph);
  EXPECT_THAT(loads_of(simple.graph()), added);
}

TEST(ContactKind, ties_bodies_to_one_island) {
  SystemGraph graph;
  auto& one = graph.add<RigidBody>("one", {});
  auto& other = graph.add<RigidBody>("other", {.position = {0, 0, 1}});
  EXPECT_EQ(split(graph).size(), 2u);
  graph.add<Contact>("touch", {{one.marker(), shape::sphere(0.1)}, {other.marker(), shape::sphere(0.1)}});
  EXPECT_EQ(split(graph).size(), 1u);
}

TEST(ContactKind, is_numbered_among_contacts) {
  Balls scene;
  const System system = assemble(scene.graph);
  ASSERT_EQ(system.contacts().size(), 2u);
  EXPECT_EQ(system.contacts()[1].number, 1);
  EXPECT_EQ(system.contacts()[1].element->name(), "upper floor");
  EXPECT_EQ(system.contacts()[1].energy, 2);  // behind the floor's and the spring's
}

}  // namespace
}  // namespace lithe::test::contact_kind_test
