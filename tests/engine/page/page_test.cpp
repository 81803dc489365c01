#include <gtest/gtest.h>

#include "bodies/flexible/body_stress.h"
#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/surface_mesh.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/observe/contact_sensors.h"
#include "engine/observe/recorder.h"
#include "engine/page/page.h"
#include "engine/run/simulation.h"
#include "engine/simplify/simplification.h"
#include "integrators/generalized_alpha.h"
#include "integrators/radau.h"
#include "joints/contact/contact.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "joints/three_node_fixation.h"
#include "plugins/inertial_body/inertial_body.h"
#include "tests/engine/page/page_reader.h"

/// Pages, read back as a viewer reads them.
namespace lithe::test::page_test {
namespace {

using namespace page;

/// Largest distance between the page's points and the body's own nodes, over its size.
double largest_miss(const Page& page, FlexibleBody& body, const System& system, const std::vector<State>& states) {
  const DrawnMesh mesh = body.drawn_mesh(false);
  const double size = (mesh.points.rowwise().maxCoeff() - mesh.points.rowwise().minCoeff()).norm();
  double most = 0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    Snapshot now(system, states[i]);
    const VectorX rest = VectorX::Zero(body.coordinates().v_count());
    const Matrix3X exact = body.nodal_motion(now.body_state(body), rest.data()).position;
    const Matrix3X drawn = page.mesh_points(page.body(body.name()), static_cast<Eigen::Index>(i));
    most = std::max(most, (drawn - exact(Eigen::all, mesh.nodes)).colwise().norm().maxCoeff());
  }
  return most / size;
}

TEST(Page, PutsTheNodesOfAModalBodyWhereTheBodyHasThem) {
  const ScratchFolder folder;
  for (const Deflection deflection : {Deflection::linear, Deflection::stiffened, Deflection::quadratic}) {
    RodScene scene(deflection);
    const System system = assemble(scene.graph);
    State state = system.initial_state();
    GeneralizedAlpha integrator{{.step = 1e-3, .spectral_radius = 0.8}};
    Simulation simulation(system, integrator);
    lithe::Run run{system, {position(scene.tip, "tip")}};
    States states;
    simulation.observe(run, every(0.05));
    simulation.observe(states, every(0.05));
    simulation.run(state, 1.0);
    write_page(run, folder.path("rod.html"));
    const Page page(folder.path("rod.html"));

    const Json& mesh = page.body("rod").at("mesh");
    EXPECT_EQ(mesh.at("modes").size(), 6u);
    EXPECT_TRUE(mesh.at("natural"));
    EXPECT_NEAR(mesh.at("modes")[2].at("frequency").get<double>(), scene.rod->basis().frequencies[2], 1e-9);
    EXPECT_EQ(mesh.at("pairs").is_object(), deflection != Deflection::linear);
    ASSERT_EQ(states.all.size(), 21u);
    EXPECT_LT(largest_miss(page, *scene.rod, system, states.all), 1e-6);

    // It does bend: without the pairs the points would be elsewhere.
    double bent = 0;
    for (const State& s : states.all) bent = std::max(bent, s.q.tail(6).cwiseAbs()[0]);
    EXPECT_GT(bent * page.array(mesh.at("shapes"), 1).cwiseAbs().maxCoeff(), 0.02);

    // The trace is the recorded position, and the marker follows a point of the mesh.
    const MatrixX trace = page.array(page.scene["runs"][0]["traces"][0]["points"], 3);
    const auto marker =
        page.scene["runs"][0]["markers"][page.scene["runs"][0]["traces"][0]["marker"].get<std::size_t>()];
    const Matrix3X points = page.mesh_points(page.body("rod"), 20);
    EXPECT_LT((trace.col(20) - points.col(marker["node"].get<Eigen::Index>())).norm(), 1e-6);
    EXPECT_LT((trace.col(20) - Snapshot(system, states.all[20]).marker(scene.tip).p).norm(), 1e-7);
  }
}

TEST(Page, ColoursAModalBodyByItsStress) {
  const ScratchFolder folder;
  RodScene scene(Deflection::linear);
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  GeneralizedAlpha integrator{{.step = 1e-3, .spectral_radius = 0.8}};
  Simulation simulation(system, integrator);
  lithe::Run run{system};
  simulation.observe(run, every(0.1));
  simulation.run(state, 0.5);
  write_page(run, folder.path("rod.html"));
  const Page page(folder.path("rod.html"));

  const Json& mesh = page.body("rod").at("mesh");
  const VectorX eta = page.array(mesh.at("coordinates"), 6).col(5);
  const Json& stress = mesh.at("stress");
  EXPECT_EQ(stress.at("unit"), "Pa");
  const MatrixX shapes = page.array(stress.at("shapes"), page.array(mesh.at("points"), 3).cols() * 6);
  const MatrixX drawn = (shapes * eta).reshaped(6, shapes.rows() / 6);  // xx yy zz xy yz zx
  Snapshot now(system, state);
  const DrawnMesh own = scene.rod->drawn_mesh(false);
  const VectorX exact = von_mises(BodyStress(*scene.rod).stress(now)(Eigen::all, own.nodes));
  Matrix6X ours = drawn;
  ours.row(4) = drawn.row(5), ours.row(5) = drawn.row(4);
  EXPECT_LT((von_mises(ours) - exact).cwiseAbs().maxCoeff(), 1e-3 * exact.maxCoeff());
  EXPECT_GT(exact.maxCoeff(), 1e4);
}

/// A rod of all its nodes, and the same in the inertial frame.
TEST(Page, FitsShapesToTheNodesOfABodyWithoutModes) {
  const ScratchFolder folder;
  SystemGraph graph;
  const BrickMesh bricks = brick_block({0.4, 0.02, 0.02}, {5, 1, 1}, {2e7, 0.3, 1000});
  auto& free = graph.add<InertialBody>(
      "inertial",
      {.mesh = std::make_shared<BrickMesh>(bricks), .position = {0, 1, 0}, .angular_velocity = {0.5, 3, 1}});
  const Marker held = free.average(bricks.node_set("x0"));
  graph.add<SphericalJoint>("pin", {graph.ground().marker(Vector3(0, 1.01, 0.01)), held});
  const FiniteElementModel model =
      brick_mesh({.size = {0.4, 0.02, 0.02}, .divisions = {5, 1, 1}, .type = "C3D8I", .material = {2e8, 0.3, 1000}});
  const std::vector<int>& root = model.node_set("x_min");
  auto& nodal = graph.add<FlexibleBody>(
      "nodal", {.basis = make_basis(model, ThreeNodeFrame{root[0], root[1], root[2]}, kAllNodal)});
  graph.add<ThreeNodeFixation>(
      "clamp", {graph.ground().marker(), nodal.node(root[0]), nodal.node(root[1]), nodal.node(root[2])});
  const System system = assemble(graph);
  State state = system.initial_state();
  GeneralizedAlpha integrator{{.step = 1e-3, .spectral_radius = 0.7}};
  Simulation simulation(system, integrator);
  lithe::Run run{system};
  States states;
  simulation.observe(run, every(0.02));
  simulation.observe(states, every(0.02));
  simulation.run(state, 0.5);
  write_page(run, folder.path("nodal.html"));
  const Page page(folder.path("nodal.html"));

  EXPECT_FALSE(page.body("inertial").at("mesh").at("natural"));
  EXPECT_LT(largest_miss(page, nodal, system, states.all), 1.8e-4);  // √3 of 1e-4
  const DrawnMesh mesh = free.drawn_mesh(false);
  double miss = 0, turn = 0;
  for (std::size_t i = 0; i < states.all.size(); ++i) {
    Snapshot now(system, states.all[i]);
    const Matrix3X exact = free.positions(now.body_state(free))(Eigen::all, mesh.nodes);
    const Matrix3X drawn = page.mesh_points(page.body("inertial"), static_cast<Eigen::Index>(i));
    miss = std::max(miss, (drawn - exact).colwise().norm().maxCoeff());
    turn = std::max(turn, (exact - mesh.points).colwise().norm().maxCoeff());
  }
  EXPECT_LT(miss, 1.8e-4 * 0.401);
  EXPECT_GT(turn, 0.1);
  const auto shapes = page.body("inertial").at("mesh").at("modes").size();
  EXPECT_GT(shapes, 0u);
  EXPECT_LT(shapes, 16u) << "few shapes of " << states.all.size() << " frames";
  EXPECT_EQ(page.scene["runs"][0]["notes"].size(), 2u) << "that the stress of neither is drawn";
}

/// A double pendulum with a spring, a drive and a joint of four markers.
TEST(Page, ShowsWhatJointsAndForcesDoToTheirBodies) {
  const ScratchFolder folder;
  SystemGraph graph;
  auto& arm = graph.add<RigidBody>("arm <1> \"é\"", {.mass = 2, .inertia = {0.1, 0.2, 0.3}, .position = {0.5, 0, 0}});
  auto& bob = graph.add<RigidBody>("bob", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {1.5, 0, 0}});
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, along_y), arm.marker({-0.5, 0, 0}, along_y)});
  graph.add<CoordinateDrive>("drive", {pin.angle()}, {.motion = ramp(0, 1.5)});
  const auto& clamp = graph.add<ThreeNodeFixation>(
      "clamp", {arm.marker(), bob.marker({-0.5, 0, 0}), bob.marker({-0.4, 0.1, 0}), bob.marker({-0.4, 0, 0.1})});
  auto& spring = graph.add<SpringDamper>("spring", {graph.ground().marker({0, 0, -1}), bob.marker()},
                                         {.stiffness = 50, .natural_length = 0.5});
  const System system = assemble(graph);
  State state = system.initial_state();
  Radau integrator{{.tolerance = {1e-6, 1e-8}}};
  Simulation simulation(system, integrator);
  lithe::Run run{system, {reaction(pin, 1, kWorldAxes, "in_world"), coordinate(pin.angle(), "angle")}, {.name = "arm"}};
  Recorder record{{joint_reaction(pin), reaction(clamp, 1, kWorldAxes, "c1"), reaction(clamp, 2, kWorldAxes, "c2"),
                   reaction(clamp, 3, kWorldAxes, "c3"), applied_force(spring, 1), total_energy(arm, "arm_energy"),
                   constraint_residual("largest")}};
  run.draw(bob, visual::box({0.2, 0.1, 0.1}).at({0.1, 0, 0}));
  simulation.observe(run, every(0.04));
  simulation.observe(record, every(0.04));
  simulation.on({.name = "half </script>", .function = watch(coordinate(pin.angle(), "a")), .level = 0.3});
  simulation.run(state, 0.4);
  run.add(simulation.events());
  write_page(run, folder.path("arm.html"),
             {.title = "Träger <&>", .findings = {{"open joint", "'pin' gapes", "close it"}, {.alarm = false}}});
  const Page page(folder.path("arm.html"));
  const Table& table = record.table();

  const auto column = [&](const std::string& name) {
    const std::vector<double> values = table.column(name);
    return VectorX(Eigen::Map<const VectorX>(values.data(), static_cast<Eigen::Index>(values.size())));
  };
  const Json& shown = page.connector("pin");
  EXPECT_EQ(shown["kind"], "RevoluteJoint");
  EXPECT_EQ(shown["role"], "joint");
  EXPECT_EQ(page.connector("drive")["role"], "drive");
  EXPECT_EQ(page.connector("spring")["role"], "force");
  EXPECT_EQ(shown["bodies"], (Json{0, 1}));
  EXPECT_NE(shown["where"].get<std::string>().find("page_test.cpp:"), std::string::npos);
  const MatrixX force = page.array(shown["reaction"]["force"], 3), moment = page.array(shown["reaction"]["moment"], 3);
  ASSERT_EQ(force.cols(), 11);
  const char* kAxes[] = {"_x", "_y", "_z"};
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT((force.row(i).transpose() - page.channel(std::string("in_world_force") + kAxes[i])).norm(), 1e-4);
    EXPECT_LT((moment.row(i).transpose() - page.channel(std::string("in_world_moment") + kAxes[i])).norm(), 1e-4);
    EXPECT_LT((page.channel(std::string("pin_force") + kAxes[i]) - column(std::string("pin_force") + kAxes[i])).norm(),
              1e-4);
    const VectorX spring_force = column(std::string("spring_m1_force") + kAxes[i]);
    EXPECT_LT((page.array(page.connector("spring")["reaction"]["force"], 3).row(i).transpose() - spring_force).norm(),
              1e-4);
    // All three of the clamp's points are on the bob: the page shows their sum.
    VectorX sum = VectorX::Zero(11);
    for (const char* c : {"c1_force", "c2_force", "c3_force"}) sum += column(std::string(c) + kAxes[i]);
    EXPECT_LT((page.array(page.connector("clamp")["reaction"]["force"], 3).row(i).transpose() - sum).norm(), 1e-4);
  }
  EXPECT_GT(force.norm(), 10);
  EXPECT_LT(page.array(shown["reaction"]["point"], 3).norm(), 1e-8) << "the pin is at the origin";
  const std::string arm_name = arm.name();
  EXPECT_LT(
      (page.channel(arm_name + "_kinetic_energy") + page.channel(arm_name + "_gravity_energy") - column("arm_energy"))
          .norm(),
      1e-4);
  EXPECT_NEAR((page.channel("angle").tail<1>())[0], 0.6, 1e-6);
  EXPECT_LT((page.channel("constraint_residual") - column("largest")).norm(), 1e-12);

  // Names as they are, a title with a tag in it, an event, a shape that was drawn and sticks that were not.
  EXPECT_EQ(page.scene["title"], "Träger <&>");
  ASSERT_EQ(page.scene["findings"].size(), 2u);
  EXPECT_EQ(page.scene["findings"][0],
            (Json{{"kind", "open joint"}, {"text", "'pin' gapes"}, {"fix", "close it"}, {"alarm", true}}));
  EXPECT_EQ(page.scene["findings"][1]["alarm"], false);
  EXPECT_EQ(page.scene["runs"][0]["bodies"][1]["name"], arm.name());
  ASSERT_EQ(page.scene["runs"][0]["events"].size(), 1u);
  EXPECT_EQ(page.scene["runs"][0]["events"][0]["name"], "half </script>");
  EXPECT_NEAR(page.scene["runs"][0]["events"][0]["time"], 0.2, 1e-6);
  ASSERT_EQ(page.body("bob")["shapes"].size(), 1u);
  EXPECT_EQ(page.body("bob")["shapes"][0]["role"], "visual");
  EXPECT_NEAR(page.body("bob")["shapes"][0]["position"][0], 0.1, 1e-15);
  EXPECT_EQ(page.body(arm.name())["shapes"][0]["role"], "inferred");
  EXPECT_NEAR(page.body(arm.name())["shapes"][0]["size"][1], 0.5, 1e-12);
}

TEST(Page, ShowsShapesAndForcesOfContacts) {
  const ScratchFolder folder;
  SystemGraph graph;
  auto& box = graph.add<RigidBody>("box", {.mass = 1, .inertia = {0.01, 0.01, 0.01}, .position = {0, 0, 0.1}});
  auto& ball = graph.add<RigidBody>("ball", {.mass = 1, .inertia = {0.01, 0.01, 0.01}, .position = {1, 0, 0.2}});
  const auto& floor = graph.add<Contact>(
      "floor",
      {{graph.ground().marker({0, 0, 0.01}), shape::half_space()},
       {box.marker({0, 0, 0.02}), shape::box({0.1, 0.2, 0.22})},
       {ball.marker(),
        shape::compound({{{Vector3(0, 0, 0.1)}, shape::sphere(0.05)}, {{}, shape::cylinder(0.03, 0.3)}})}},
      {.law = Compliance{.stiffness = 1e5, .restitution = 0.5}, .friction = {.coefficient = 0.3}});
  const System system = assemble(graph);
  State state = system.initial_state();
  Radau integrator{{.tolerance = {1e-5, 1e-7}}};
  Simulation simulation(system, integrator);
  lithe::Run run{system};
  States states;
  simulation.observe(run, every(0.02));
  simulation.observe(states, every(0.02));
  simulation.run(state, 0.2);
  write_page(run, folder.path("contact.html"));
  const Page page(folder.path("contact.html"));

  EXPECT_EQ(page.body("ground")["shapes"][0]["kind"], "half_space");
  EXPECT_NEAR(page.body("ground")["shapes"][0]["position"][2], 0.01, 1e-15);
  EXPECT_NEAR(page.body("box")["shapes"][0]["size"][2], 0.22, 1e-15);
  EXPECT_NEAR(page.body("box")["shapes"][0]["position"][2], 0.02, 1e-15);
  EXPECT_EQ(page.body("ball")["shapes"][0]["kind"], "sphere");
  EXPECT_NEAR(page.body("ball")["shapes"][0]["position"][2], 0.1, 1e-15);
  EXPECT_NEAR(page.body("ball")["shapes"][1]["size"][1], 0.3, 1e-15);
  EXPECT_EQ(page.connector("floor")["role"], "contact");

  const Json& contacts_shown = page.scene["runs"][0]["contacts"];
  const MatrixX first = page.array(contacts_shown["first"], 1), points = page.array(contacts_shown["points"], 3),
                forces = page.array(contacts_shown["forces"], 3), pair = page.array(contacts_shown["pair"], 1);
  ASSERT_EQ(first.size(), 12);
  Eigen::Index all = 0;
  for (std::size_t i = 0; i < states.all.size(); ++i) {
    Snapshot now(system, states.all[i]);
    const ContactMemory exact = contacts(now, floor);
    EXPECT_EQ(first(0, static_cast<Eigen::Index>(i)), static_cast<double>(all));
    for (const ContactTrace& trace : exact) {
      EXPECT_LT((points.col(all) - trace.point.position).norm(), 1e-7);
      EXPECT_LT((forces.col(all) - trace.force).norm(), 1e-5 * (1 + trace.force.norm()));
      EXPECT_EQ(pair(0, all), 0);
      ++all;
    }
  }
  EXPECT_EQ(points.cols(), all);
  EXPECT_GT(all, 8);
  EXPECT_GT(forces.row(2).maxCoeff(), 1) << "the floor pushes up";
  EXPECT_EQ(page.channel("floor_points").tail<1>()[0], first(0, 11) - first(0, 10));
}

TEST(Page, DrawsTheStandInsOfASimplifiedScene) {
  const ScratchFolder folder;
  SystemGraph graph;
  auto& arm = graph.add<RigidBody>("arm", {.mass = 2, .inertia = {0.1, 0.2, 0.3}, .position = {0.5, 0, 0}});
  auto& bob = graph.add<RigidBody>("bob", {.mass = 1, .inertia = {0.1, 0.1, 0.1}, .position = {1.5, 0, 0}});
  const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, along_y), arm.marker({-0.5, 0, 0}, along_y)});
  graph.add<RevoluteJoint>("elbow", {arm.marker({0.5, 0, 0}, along_y), bob.marker({-0.5, 0, 0}, along_y)});
  Simplification simple{graph};
  ASSERT_TRUE(simple.smaller());
  const System system = assemble(simple.graph());
  State state = simple.start();
  Radau integrator{{.tolerance = {1e-6, 1e-8}}};
  Simulation simulation(system, integrator);
  lithe::Run run{system};
  States states;
  simulation.observe(run, every(0.1));
  simulation.observe(states, every(0.1));
  simulation.run(state, 0.5);
  write_page(run, folder.path("simple.html"));
  const Page page(folder.path("simple.html"));

  State whole;
  simple.expand(states.all.back(), whole);
  Snapshot now(simple.whole(), whole);
  const Json& elbow = page.connector("elbow");
  EXPECT_EQ(elbow["kind"], "RevoluteJoint") << "not the class of what is left of it";
  const Json& marker = page.scene["runs"][0]["markers"][elbow["markers"][1].get<std::size_t>()];
  const Json& body = page.scene["runs"][0]["bodies"][marker["body"].get<std::size_t>()];
  EXPECT_FALSE(body["shapes"].empty());
  const Vector3 in_body(marker["position"][0], marker["position"][1], marker["position"][2]);
  const Vector3 at = page.array(body["position"], 3).col(5);
  const Vector4 turned = page.array(body["rotation"], 4).col(5);
  EXPECT_LT((at + rotation_matrix(turned) * in_body - now.marker(bob.marker({-0.5, 0, 0})).p).norm(), 1e-6);
}

/// 4,000 elements, 12 modes with stress, 10 s in 500 frames.
TEST(Page, OfALargeFlexibleBodyStaysBelowThreeMegabytes) {
  const ScratchFolder folder;
  const FiniteElementModel model =
      brick_mesh({.size = {1, 1, 0.5}, .divisions = {20, 20, 10}, .type = "C3D8", .material = {2e11, 0.3, 7800}});
  SystemGraph graph;
  auto& block = graph.add<FlexibleBody>("block", {.basis = make_basis(model, MeanAxisFrame{}, 12)});
  const System system = assemble(graph);
  lithe::Run run{system, {position(block.node(1), "corner")}};
  State state = system.initial_state();
  Snapshot now(system);
  for (int frame = 0; frame <= 500; ++frame) {  // it tumbles, and all of its modes ring
    state.time = 0.02 * frame;
    state.q.head<3>() = Vector3(std::sin(state.time), std::cos(2 * state.time), state.time);
    state.q.segment<4>(3) = quaternion_of(rotation_about({1, 2, 3}, 0.7 * state.time));
    for (int k = 0; k < 12; ++k) state.q[7 + k] = 0.1 / (1 + k) * std::sin((3.1 + k) * state.time + k);
    now.evaluate(state);
    run.observe(now);
  }
  write_page(run, folder.path("block.html"));
  const double size = static_cast<double>(std::filesystem::file_size(folder.path("block.html")));
  RecordProperty("megabytes", std::to_string(1e-6 * size));
  EXPECT_LT(size, 3e6);
  const Page page(folder.path("block.html"));
  EXPECT_EQ(page.body("block")["mesh"]["modes"].size(), 12u);
  EXPECT_TRUE(page.body("block")["mesh"]["stress"].is_object());
  EXPECT_EQ(page.array(page.body("block")["mesh"]["triangles"], 3).cols(), 2 * 2 * (400 + 200 + 200));
  const MatrixX corner = page.array(page.scene["runs"][0]["traces"][0]["points"], 3);
  const auto marker = page.scene["runs"][0]["markers"][0];
  const Matrix3X points = page.mesh_points(page.body("block"), 500);
  EXPECT_LT((points.col(marker["node"].get<Eigen::Index>()) - corner.col(500)).norm(), 1.5e-6);
}

TEST(Page, StoresTheArraysOfAMeshOnce) {
  const ScratchFolder folder;
  const auto basis = make_basis(
      brick_mesh({.size = {1, 0.1, 0.1}, .divisions = {20, 4, 4}, .type = "C3D8", .material = {2e11, 0.3, 7800}}),
      MeanAxisFrame{}, 3);
  const auto page_of = [&](int bodies) {
    SystemGraph graph;
    for (int k = 0; k < bodies; ++k)
      graph.add<FlexibleBody>("bar " + std::to_string(k), {.basis = basis, .position = {0, 0.5 * k, 0}});
    const System system = assemble(graph);
    State state = system.initial_state();
    lithe::Run run{system, {}};
    Snapshot now(system, state);
    run.observe(now);
    if (bodies > 1) state.q[static_cast<int>(state.q.size()) - 3] = 1e-3;  // the last one bends
    state.time = 0.1;
    now.evaluate(state);
    run.observe(now);
    const std::string path = folder.path(std::to_string(bodies) + ".html");
    write_page(run, path);
    return path;
  };
  const Page page(page_of(4));
  for (const char* array : {"points", "triangles", "shapes"})
    EXPECT_EQ(page.body("bar 3")["mesh"][array]["at"], page.body("bar 0")["mesh"][array]["at"]) << array;
  EXPECT_GT((page.mesh_points(page.body("bar 3"), 1) - page.mesh_points(page.body("bar 3"), 0)).norm(), 1e-4);
  EXPECT_EQ((page.mesh_points(page.body("bar 0"), 1) - page.mesh_points(page.body("bar 0"), 0)).norm(), 0);
}

TEST(Page, RefusesWhatCannotBeShown) {
  const ScratchFolder folder;
  SystemGraph graph, other;
  auto& ball = graph.add<RigidBody>("ball", {});
  auto& stranger = other.add<RigidBody>("stranger", {});
  const System system = assemble(graph), others = assemble(other);
  Snapshot now(system, system.initial_state()), elsewhere(others, others.initial_state());
  const std::string path = folder.path("page.html");
  {
    lithe::Run run{system};
    EXPECT_EQ(told([&] { write_page(run, path); }), "the run 'run' has no states");
    EXPECT_NE(told([&] { run.observe(elsewhere); }).find("another system"), std::string::npos);
    run.observe(now);
    EXPECT_NE(told([&] { run.draw(ball, visual::sphere(0.1)); }).find("has begun"), std::string::npos);
    EXPECT_NE(told([&] { run.stream(folder.path("late.h5")); }).find("has begun"), std::string::npos);
    State earlier = system.initial_state();
    earlier.time = -1;
    Snapshot before(system, earlier);
    EXPECT_NE(told([&] { run.observe(before); }).find("t = -1 s"), std::string::npos);
    run.observe(now);  // told twice of one instant
    EXPECT_EQ(run.frame_count(), 1);
    EXPECT_THROW(write_page(run, "/proc/page.html"), FileError);
  }
  EXPECT_NE(
      told([&] { write_page(std::vector<std::reference_wrapper<const lithe::Run>>{}, path); }).find("without a run"),
      std::string::npos);
  {
    lithe::Run run{system};
    run.draw(stranger, visual::sphere(0.1));
    EXPECT_NE(told([&] { run.observe(now); }).find("'stranger', which is not in this system"), std::string::npos);
  }
  {
    double value = 1;
    lithe::Run run{system,
                   {Sensor{"root", {"root"}, [&](Snapshot&, std::span<double> out) { out[0] = std::sqrt(value); }}}};
    run.observe(now);
    value = -1;
    State next = system.initial_state();
    next.time = 1;
    Snapshot later(system, next);
    EXPECT_THROW(run.observe(later), SimulationError);
    EXPECT_EQ(run.frame_count(), 1) << "what was there is kept";
    write_page(run, path);
  }
  EXPECT_THROW((lithe::Run{system, {height(ball.marker(), "z"), height(ball.marker(), "z")}}), SceneError);
  EXPECT_THROW(visual::box({1, 0, 1}), SceneError);
  EXPECT_THROW(visual::cylinder(1, NAN), SceneError);
  EXPECT_THROW(visual::mesh({{0, 0, 0}}, {{0, 0, 1}}), SceneError);
  SystemGraph latin;
  latin.add<RigidBody>("B\xfclow", {});
  const System named = assemble(latin);
  Snapshot first(named, named.initial_state());
  lithe::Run run{named};
  EXPECT_NE(told([&] { run.observe(first); }).find("UTF-8"), std::string::npos);
}

}  // namespace
}  // namespace lithe::test::page_test
