// Long chains between two points: statics where a loop has a row too many, and rows that nearly repeat others.
#include <gtest/gtest.h>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/base/log.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"

namespace lithe::test::equilibrium_chain_test {
namespace {

constexpr double kLength = 10, kMass = 1, g = 9.81;
enum class Ties { balls, hinges };

/// Links of one length, up and down by turns, from the origin to `end`.
struct Zigzag {
  Zigzag(int links, Ties ties) {
    const Matrix3 axes = ties == Ties::hinges ? rotation_about({1, 0, 0}, -M_PI / 2) : Matrix3::Identity();
    const double L = kLength / links, m = kMass / links;
    Marker last = graph.ground().marker({}, axes);
    Vector3 at(0, 0, 0);
    for (int i = 0; i < links; ++i) {
      const std::string number = std::to_string(i);
      const Matrix3 R = rotation_about({0, 1, 0}, (i % 2 ? -1 : 1) * std::acos(0.7));
      const Vector3 along = R * Vector3(L, 0, 0);
      auto& link = graph.add<RigidBody>("link " + number,
                                        {.mass = m,
                                         .inertia = Vector3(m * Vector3(1e-4, 1e-4 + L * L / 12, 1e-4 + L * L / 12)),
                                         .position = at + along / 2,
                                         .orientation = R});
      at += along;
      if (ties == Ties::hinges)
        graph.add<RevoluteJoint>("joint " + number, {last, link.marker({-L / 2, 0, 0}, axes)});
      else
        graph.add<SphericalJoint>("joint " + number, {last, link.marker({-L / 2, 0, 0})});
      last = link.marker({L / 2, 0, 0}, axes);
      bodies.push_back(&link);
    }
    graph.add<SphericalJoint>("end", {graph.ground().marker(at), last});
  }
  SystemGraph graph;
  std::vector<RigidBody*> bodies;
};

/// Slopes of links under their weight change by w / H from one to the next, H the horizontal tension.
void expect_funicular(const Zigzag& zigzag, const System& system, const Equilibrium& found) {
  std::vector<double> slopes;
  for (const RigidBody* link : zigzag.bodies) {
    const int q = system.layout().slice(*link).q;
    const Eigen::Quaterniond turn(found.state.q[q + 3], found.state.q[q + 4], found.state.q[q + 5],
                                  found.state.q[q + 6]);
    const Vector3 along = turn * Vector3::UnitX();
    slopes.push_back(along.z() / along.x());
    EXPECT_NEAR(along.y(), 0, 1e-9);
  }
  const double rise = (slopes.back() - slopes.front()) / static_cast<double>(slopes.size() - 1);
  EXPECT_GT(rise, 0);
  for (std::size_t i = 1; i < slopes.size(); ++i) EXPECT_NEAR(slopes[i] - slopes[i - 1], rise, 1e-6 * rise) << i;
}

TEST(EquilibriumOfChains, the_row_too_many_of_a_loop_of_a_thousand_hinges_is_detected) {
  // Its pivot is 9e-9 of the row's compliance by round-off alone. Kept, it drove reactions to 1e20 N.
  Zigzag zigzag(1000, Ties::hinges);
  EXPECT_EQ(assemble(zigzag.graph).redundant_rows().size(), 1u);
}

TEST(EquilibriumOfChains, hinges_between_two_points_hang_as_a_funicular_polygon) {
  for (const int links : {10, 300}) {
    SCOPED_TRACE(links);
    Zigzag zigzag(links, Ties::hinges);
    const System system = assemble(zigzag.graph);
    EXPECT_EQ(system.redundant_rows().size(), 1u);  // across the plane
    const Equilibrium found = find_equilibrium(system, system.initial_state());
    EXPECT_LT(found.out_of_balance, 1e-6);
    EXPECT_EQ(found.stability, RestStability::stable);
    expect_funicular(zigzag, system, found);
  }
}

TEST(EquilibriumOfChains, balls_let_links_spin_and_hang_them_alike) {
  Zigzag zigzag(100, Ties::balls);
  const System system = assemble(zigzag.graph);
  const Equilibrium found = find_equilibrium(system, system.initial_state());
  expect_funicular(zigzag, system, found);
}

}  // namespace
}  // namespace lithe::test::equilibrium_chain_test
