// Nothing is allocated in a step.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <set>

#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/readers/calculix.h"
#include "bodies/rigid_body.h"
#include "engine/cones/gauss_seidel.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/contact/contact.h"
#include "joints/control/control_force.h"
#include "joints/forces/first_order_states.h"
#include "joints/forces/joint_coulomb_friction.h"
#include "joints/forces/point_force.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/joints/contact_pairs.h"
#include "tests/support/methods.h"
#include "tests/support/sanitized.h"
#include "tests/support/scenes.h"

#if defined(LITHE_SANITIZED) || !defined(__GLIBC__)
#define LITHE_TEST_NO_COUNT
#endif

namespace {
std::atomic<long> allocations{0};
}

#ifndef LITHE_TEST_NO_COUNT
// Every allocation of this program, operator new and Eigen's included, ends here; glibc keeps its own under these
// names.
extern "C" {
void* __libc_malloc(std::size_t);               // NOLINT
void* __libc_calloc(std::size_t, std::size_t);  // NOLINT
void* __libc_realloc(void*, std::size_t);       // NOLINT
void* malloc(std::size_t size) noexcept {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* at, std::size_t size) noexcept {
  ++allocations;
  return __libc_realloc(at, size);
}
}
#endif

namespace lithe::test::allocation_test {
namespace {

void expect_no_allocation(Integrator& method, Scene& scene, double end) {
  const long before = allocations;
  bool ok = true;
  while (scene.state.time < end) ok &= method.step(scene.equations, scene.state, end).ok();
  const long counted = allocations - before;
  EXPECT_TRUE(ok);
  EXPECT_EQ(counted, 0) << method.name() << ", " << method.statistics().steps << " steps";
}

TEST(Step, AllocatesNothing) {
#ifdef LITHE_TEST_NO_COUNT
  GTEST_SKIP() << "a sanitizer owns malloc";
#endif
  const long before_any = allocations;
  VectorX probe(100);
  EXPECT_GT(allocations, before_any) << "the counter does not count";

  for (Method& method : std::array<Method, 15>{
           runge_kutta(1e-6), runge_kutta_fixed(1e-3), runge_kutta8(1e-6), adams(1e-6), radau(1e-6), radau_fixed(2e-3),
           bdf(1e-6), hht(1e-3), index3(1e-3), index2(1e-3),
           std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.tolerance = {1e-4, 1e-4}}), rattle(1e-3),
           energy_momentum(1e-3), linearly_implicit(1e-3, 1), linearly_implicit(1e-3, 2)}) {
    for (bool revolute : {false, true}) {
      Scene scene = box_chain(8, revolute);
      scene.run(*method, 0.01);
      expect_no_allocation(*method, scene, 0.2);
    }
  }
}

TEST(Step, AllocatesNothingForALoadedFlexibleBody) {
#ifdef LITHE_TEST_NO_COUNT
  GTEST_SKIP() << "a sanitizer owns malloc";
#endif
  const FiniteElementModel rod = read_calculix(std::string(LITHE_EXAMPLE_DATA) + "/pendulum/hex8i/calculix/matrices");
  for (Deflection deflection : {Deflection::linear, Deflection::stiffened, Deflection::quadratic}) {
    const auto basis = make_basis(rod, HingeFrame{rod.node_set("hinge")}, 9, {.deflection = deflection});
    for (Method& method : std::array<Method, 3>{index3(1e-4), runge_kutta(1e-5), radau(1e-5)}) {
      Scene scene({0, 0, -9.81}, [&](SystemGraph& graph) {
        auto& body = graph.add<FlexibleBody>("rod", {.basis = basis});
        const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
        graph.add<RevoluteJoint>(
            "pin", {graph.ground().marker({0, 0.005, 0}, along_y), body.average(rod.node_set("hinge"), along_y)});
        graph.add<PointForce>("push", {body.average(rod.node_set("root_face"))}, {.force = {0, 0, 1}});
      });
      scene.run(*method, 0.01);
      expect_no_allocation(*method, scene, 0.03);
    }
  }
}

/// The pin of a pendulum that swings with friction, and slides throughout.
TEST(Step, AllocatesNothingForFrictionInAJoint) {
#ifdef LITHE_TEST_NO_COUNT
  GTEST_SKIP() << "a sanitizer owns malloc";
#endif
  Scene scene({0, 0, -9.81}, [](SystemGraph& graph) {
    const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
    auto& rod = graph.add<RigidBody>("rod", {.mass = 1, .inertia = {0.01, 0.02, 0.02}, .position = {0.3, 0, 0}});
    auto& pin =
        graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, along_y), rod.marker({-0.3, 0, 0}, along_y)});
    add_joint_coulomb_friction(graph, "rub", {pin.angle()}, {.joint = &pin, .coefficient = 0.2, .radius = 0.02});
  });
  MoreauJean method{{.step = 1e-3}};
  scene.run(method, 0.02);
  expect_no_allocation(method, scene, 0.3);
}

/// A pin that sticks under a torque, a slide on a slope that does, and a rod on two pins of which each would hold it:
/// steps that hold what sticks; and a slide that begins to slide.
TEST(Step, AllocatesNothingForJointsThatStick) {
#ifdef LITHE_TEST_NO_COUNT
  GTEST_SKIP() << "a sanitizer owns malloc";
#endif
  const auto draw = [](SystemGraph& graph) {
    const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2), slope = rotation_about({0, 1, 0}, 1.2);
    auto& rod = graph.add<RigidBody>("rod", {.mass = 1, .inertia = {0.01, 0.02, 0.02}, .position = {0.1, 0, 0}});
    auto& pin =
        graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, along_y), rod.marker({-0.1, 0, 0}, along_y)});
    for (const char* name : {"rub", "rub too"})
      add_joint_coulomb_friction(graph, name, {pin.angle()}, {.joint = &pin, .coefficient = 0.9, .radius = 0.2});
    for (const auto& [name, coefficient] : {std::pair("sticks", 0.9), std::pair("slides", 0.1)}) {
      auto& block = graph.add<RigidBody>(name, {.mass = 2, .inertia = {0.01, 0.02, 0.02}});
      auto& slide = graph.add<PrismaticJoint>(
          std::string(name) + " on a slope", {graph.ground().marker({0, 0, 0}, slope), block.marker({0, 0, 0}, slope)});
      add_joint_coulomb_friction(graph, std::string(name) + " rub", {slide.displacement()},
                                 {.joint = &slide, .coefficient = coefficient});
    }
  };
  MoreauJean moreau{{.step = 1e-3}};
  NonsmoothGeneralizedAlpha alpha{{.step = 1e-3}};
  for (Integrator* method : std::initializer_list<Integrator*>{&moreau, &alpha}) {
    Scene scene({0, 0, -9.81}, draw);
    const VectorX start = scene.state.q;
    scene.run(*method, 0.02);
    expect_no_allocation(*method, scene, 0.3);
    EXPECT_LT((scene.state.q - start).head(14).lpNorm<Eigen::Infinity>(), 1e-9) << "it does not stick";
    EXPECT_GT((scene.state.q - start).lpNorm<Eigen::Infinity>(), 0.1);
  }
}

/// Colliders where they are put; the nodes of the last, a surface, at their points on it.
class PosesWithNodes final : public ContactPoses {
 public:
  GivenPoses poses;
  std::vector<Vector3> nodes;
  Vector3 at;  // of the surface
  explicit PosesWithNodes(int count) : poses(count) {}
  const MarkerKinematics& collider(int collider) const override { return poses.collider(collider); }
  void node(int, int marker, MarkerKinematics& out) const override { out.p = at + nodes[marker]; }
  std::span<const double> deformation(int) const override { return {}; }
};

TEST(Step, AllocatesNothingForALargeControlDiagram) {
#ifdef LITHE_TEST_NO_COUNT
  GTEST_SKIP() << "a sanitizer owns malloc";
#endif
  for (Method& method : std::array<Method, 5>{runge_kutta(1e-6), radau(1e-6), bdf(1e-6), index3(1e-3), index2(1e-3)}) {
    ControlDiagram control;
    Scene scene({0, 0, 0}, [&](SystemGraph& graph) {
      std::vector<JointCoordinate> x;
      for (int i = 0; i < 7; ++i) {
        const std::string number = std::to_string(i);
        const Vector3 at(0, i, 0);
        auto& mass = graph.add<RigidBody>("mass " + number, {.mass = 1.0 + i, .position = at});
        x.push_back(graph.add<RevoluteJoint>("hinge " + number, {graph.ground().marker(at), mass.marker()}).angle());
      }
      for (std::size_t i = 0; i < x.size(); ++i)
        control.push(x[i], control.pid(control.law(harmonic(0.3, 9)) - control.value(x[(i + 1) % x.size()]),
                                       {.proportional = 3, .integral = 1, .derivative = 0.1, .filter = 100}));
      auto& states = graph.add<FirstOrderStates>("states", {.start = control.start()});
      EXPECT_GT(add_control(graph, "control", control, states).part_count(), 1);
    });
    scene.run(*method, 0.05);
    expect_no_allocation(*method, scene, 0.3);
  }
}

TEST(Contact, AllocatesNothingOnceItHasBeenThere) {
#ifdef LITHE_TEST_NO_COUNT
  GTEST_SKIP() << "a sanitizer owns malloc";
#endif
  const std::vector<Vector3> square{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  const std::vector<std::array<int, 3>> triangles{{0, 1, 2}, {0, 2, 3}};
  std::vector<Vector3> octahedron;
  for (int axis = 0; axis < 3; ++axis)
    for (double side : {-0.2, 0.2}) octahedron.push_back(side * Vector3::Unit(axis));
  SystemGraph graph;
  auto& sheet = graph.add<RigidBody>("sheet");
  std::vector<Marker> nodes;
  for (int i = 0; i < 4; ++i) nodes.push_back({sheet.marker().body, i});
  std::vector<Shape> shapes{shape::half_space(), shape::mesh(square, triangles)};
  for (int i = 0; i < 3; ++i)  // more pairs than are looked at one by one
    for (const Shape& convex : {shape::sphere(0.2), shape::box({0.4, 0.3, 0.5}), shape::cylinder(0.2, 0.4),
                                shape::cone(0.2, 0.4), shape::capsule(0.1, 0.3), shape::convex_hull(octahedron)})
      shapes.push_back(convex);
  shapes.push_back(shape::surface(nodes, square, triangles));
  const int count = static_cast<int>(shapes.size());
  std::vector<Collider> colliders;
  for (int i = 0; i < count; ++i)
    colliders.push_back({graph.add<RigidBody>("body " + std::to_string(i)).marker(), shapes[i]});
  const Contact contact(colliders, {.law = Sensing{}});
  const auto detector = make_bullet_detector(contact);

  PosesWithNodes poses(count);
  poses.nodes = square;
  const std::vector<double> reach(count, 0.02);
  std::vector<ContactPoint> points;
  const auto find = [&](double moved) {
    Random random(8);
    for (int i = 0; i < count; ++i) {
      const ContactPose turn = i > 1 && i + 1 < count ? random_pose(random, 0) : ContactPose{};
      const Vector3 place(uniform(random, -0.4, 0.4), uniform(random, -0.4, 0.4), uniform(random, -0.2, 0.2));
      poses.poses.set(i, {place + moved * Vector3::Ones(), turn.R});
      poses.at = place + moved * Vector3::Ones();
    }
    points.clear();
    detector->find(poses, reach, points);
  };
  find(0);
  std::set<int> touched;
  for (const ContactPoint& p : points) touched.insert({p.A.collider, p.B.collider});
  EXPECT_EQ(touched.size(), shapes.size());
  const std::size_t found = points.size();
  points.reserve(2 * found);
  for (double moved : {0.0, 1e-6, -0.3, 0.0}) {
    if (moved < 0) {  // far enough for the tree to be changed
      find(moved);
      continue;
    }
    const long before = allocations;
    find(moved);
    EXPECT_EQ(allocations - before, 0) << moved;
  }
}

TEST(Step, AllocatesNothingForContactsThatStay) {
#ifdef LITHE_TEST_NO_COUNT
  GTEST_SKIP() << "a sanitizer owns malloc";
#endif
  const auto pile = [](std::variant<Compliance, RigidSurfaces, Sensing> law) {
    return Scene({0, 0, -9.81}, [&](SystemGraph& graph) {
      std::vector<Collider> colliders{{graph.ground().marker(), shape::half_space()}};
      for (int i = 0; i < 3; ++i) {
        auto& ball = graph.add<RigidBody>("ball " + std::to_string(i), {.position = {0.3 * i, 0, 0.1}});
        auto& box = graph.add<RigidBody>("box " + std::to_string(i), {.position = {0.5 * i, 1, 0.1}});
        colliders.push_back({ball.marker(), shape::sphere(0.1)});
        colliders.push_back({box.marker(), shape::box({0.2, 0.2, 0.2})});
      }
      auto& rod = graph.add<RigidBody>("rod", {.position = {0, -1.5, 0.1}});
      graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, -2, 0.1}), rod.marker({0, -0.5, 0})});
      colliders.push_back({rod.marker(), shape::capsule(0.1, 0.5)});
      graph.add<Contact>("contact", std::move(colliders), {.law = law, .friction = {.coefficient = 0.3}});
    });
  };
  const auto counted = [](Scene scene, Integrator& integrator) {
    scene.run(integrator, 0.02);
    const long before = allocations;
    bool ok = true;
    while (scene.state.time < 0.05) ok &= integrator.step(scene.equations, scene.state, 0.05).ok();
    EXPECT_TRUE(ok);
    return allocations - before;
  };
  MoreauJean moreau{{.step = 1e-3}, std::make_unique<GaussSeidel>()};
  EXPECT_EQ(counted(pile(RigidSurfaces{}), moreau), 0);
  ExplicitRungeKutta rk{{.tolerance = {1e-6, 1e-8}}};
  EXPECT_EQ(counted(pile(Compliance{.stiffness = 1e5, .exponent = 1}), rk), 0);
}

}  // namespace
}  // namespace lithe::test::allocation_test
