#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "bodies/rigid_body.h"
#include "engine/observe/recorder.h"
#include "engine/page/page.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/revolute_joint.h"
#include "tests/engine/page/page_reader.h"
#include "tests/support/http_client.h"

/// Runs followed in a browser: its side is played by sockets.
namespace lithe::test::live_test {
namespace {

using namespace page;
using std::chrono::milliseconds;

/// A pendulum whose hinge has a motor: its torque is the sum of two inputs.
struct Pendulum {
  SystemGraph graph{{.gravity = {0, 0, -9.81}}};
  Input* torque = nullptr;
  Input* ramped = nullptr;
  Marker tip;
  System system;
  State state;
  GeneralizedAlpha integrator{{.step = 2e-3, .spectral_radius = 0.9}};
  Simulation simulation;
  lithe::Run run;
  std::atomic<int> seen = 0;  // states that were observed

  Pendulum()
      : system(assemble(drawn(*this))),
        state(system.initial_state()),
        simulation(system, integrator),
        run{system, {position(tip, "tip"), input_value(*torque)}, {.name = "pendulum"}} {}
  static SystemGraph& drawn(Pendulum& p) {
    auto& rod = p.graph.add<RigidBody>("rod", {.inertia = {1e-4, 1.0 / 12, 1.0 / 12}, .position = {0.5, 0, 0}});
    const Matrix3 along_y = rotation_about({1, 0, 0}, -M_PI / 2);
    auto& pin = p.graph.add<RevoluteJoint>(
        "pin", {p.graph.ground().marker({0, 0, 0}, along_y), rod.marker({-0.5, 0, 0}, along_y)});
    p.torque = &p.graph.add<Input>("torque", {.unit = "N m", .lower = -5, .upper = 5});
    p.ramped = &p.graph.add<Input>("ramped", {.between = Input::Between::linear});
    p.graph.add<CoordinateMotor>("motor", {pin.angle()}, {.effort = [&p](double time, double, double) {
                                   return p.torque->value(time) + p.ramped->value(time);
                                 }});
    p.tip = rod.marker({0.5, 0, 0});
    return p.graph;
  }
  void go(double end) {
    simulation.observe(run, every(kInterval));
    counter_.seen = &seen;
    simulation.observe(counter_, every(kInterval));
    simulation.run(state, end);
  }
  /// Waits for a state.
  bool reaches(int states, milliseconds patience = std::chrono::seconds(20)) const {
    const auto until = std::chrono::steady_clock::now() + patience;
    while (seen < states && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(milliseconds(1));
    return seen >= states;
  }
  static constexpr double kInterval = 0.01;

 private:
  struct Counter final : Observer {
    std::atomic<int>* seen = nullptr;
    void observe(Snapshot& /*now*/) override { ++*seen; }
  } counter_;
};

void expect_same_bits(const State& a, const State& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_TRUE(a.q == b.q) << (a.q - b.q).norm();
  EXPECT_TRUE(a.v == b.v) << (a.v - b.v).norm();
}

/// Sets an input at a time as a scene does.
struct SetsAt final : Observer {
  double when, value;
  Input& input;
  SetsAt(double t, double x, Input& u) : when(t), value(x), input(u) {}
  void observe(Snapshot& now) override {
    if (std::abs(now.time() - when) < 1e-9) input.set(now.time(), value);
  }
};

TEST(Live, IsServedToItsOwnPageAlone) {
  Pendulum p;
  const LiveAddress address(p.run.follow());
  EXPECT_EQ(address.path.size(), 34u) << "a token of 128 bits between slashes";
  const auto status = [&](const std::string& request) {
    HttpClient client(address.port);
    client.send(request);
    return client.receive().substr(0, 12);
  };
  const std::string own = "Host: " + address.host() + "\r\n", page = "GET " + address.path + " HTTP/1.1\r\n";
  EXPECT_EQ(status(page + own + "\r\n"), "HTTP/1.1 503") << "before the first state";
  Snapshot now(p.system, p.state);
  p.run.observe(now);
  EXPECT_EQ(status(page + own + "\r\n"), "HTTP/1.1 200");
  EXPECT_EQ(status(page + "hOsT:localhost:" + std::to_string(address.port) + "\r\n\r\n"), "HTTP/1.1 200");
  EXPECT_EQ(status(page + own + "Origin: http://" + address.host() + "\r\n\r\n"), "HTTP/1.1 200");

  std::string wrong = address.path;
  wrong[7] = wrong[7] == '0' ? '1' : '0';
  for (const std::string& path : {wrong, std::string("/"), address.path.substr(0, 32) + "/", "/" + address.path})
    EXPECT_EQ(status("GET " + path + " HTTP/1.1\r\n" + own + "\r\n"), "HTTP/1.1 403") << path;
  EXPECT_EQ(status(page + "\r\n"), "HTTP/1.1 403") << "no host";
  EXPECT_EQ(status(page + "Host: example.org\r\n\r\n"), "HTTP/1.1 403") << "a name that resolves to 127.0.0.1";
  EXPECT_EQ(status(page + own + "Host: example.org\r\n\r\n"), "HTTP/1.1 403") << "two hosts";
  EXPECT_EQ(status(page + "Host: 127.0.0.1\r\n\r\n"), "HTTP/1.1 403") << "another port";
  EXPECT_EQ(status(page + own + "Origin: http://example.org\r\n\r\n"), "HTTP/1.1 403");
  EXPECT_EQ(status(page + own + "Origin: null\r\n\r\n"), "HTTP/1.1 403");
  EXPECT_EQ(status("PUT " + address.path + " HTTP/1.1\r\n" + own + "\r\n"), "HTTP/1.1 405");
  EXPECT_EQ(status("nonsense\r\n" + own + "\r\n"), "HTTP/1.1 400");
  EXPECT_EQ(status(page + own + "Long: " + std::string(20000, 'x') + "\r\n\r\n"), "HTTP/1.1 431");
  EXPECT_EQ(status(page + own + "Content-Length: 99999999999999999999\r\n\r\n").substr(0, 9), "HTTP/1.1 ");
  EXPECT_EQ(address.get("elsewhere").substr(0, 12), "HTTP/1.1 404");
  for (const char* command : {"", "[]", "{", "{\"do\": \"dance\"}", "{\"do\": 1}", "{\"speed\": -1}",
                              "{\"speed\": \"x\"}", "{\"input\": \"torque\"}", "{\"input\": \"tork\", \"value\": 1}"})
    EXPECT_EQ(address.post(command).substr(0, 12), "HTTP/1.1 400") << command;
  EXPECT_EQ(address.post("{\"speed\": 0}").substr(0, 12), "HTTP/1.1 204");
}

TEST(Live, ShowsTheStatesOfTheRunInTheirOrderToAllWhoLook) {
  Pendulum p;
  const LiveAddress address(p.run.follow({.wait = 20}));
  std::jthread running([&] { p.go(2); });
  std::string html;
  while ((html = address.get("")).starts_with("HTTP/1.1 503")) std::this_thread::sleep_for(milliseconds(1));
  LiveFrames first(address), second(address);
  first.read(200), second.read(200);
  running.join();

  ASSERT_EQ(p.run.frame_count(), 201);
  const std::vector<double> t = p.run.channel("t"), z = p.run.channel("tip_z");
  // The page has the first state, and tells where the others have theirs.
  const ScratchFolder folder;
  write_text(folder.path("page.html"), html);
  const Page page(folder.path("page.html"));
  EXPECT_EQ(page.scene.at("live").at("width"), first.frames.at(0).size());
  EXPECT_EQ(page.channel("tip_z").size(), 1);
  EXPECT_EQ(page.channel("tip_z")[0], z[0]);
  std::size_t column = 0;
  for (const Json& channel : page.scene.at("runs").at(0).at("channels"))
    if (channel.at("name") == "tip_z") column = channel.at("values").at("row").get<std::size_t>();
  for (const LiveFrames* frames : {&first, &second}) {
    ASSERT_EQ(frames->frames.size(), 200u);
    for (std::size_t i = 0; i < 200; ++i) {
      EXPECT_EQ(frames->frames[i].at(0), t[i + 1]);
      EXPECT_EQ(frames->frames[i].at(column), z[i + 1]);
    }
  }
}

TEST(Live, APauseHoldsTheTimeAndAStepGoesToTheNextState) {
  Pendulum p;
  const LiveAddress address(p.run.follow({.wait = 20}));
  ASSERT_EQ(address.post(R"({"do": "pause"})").substr(0, 12), "HTTP/1.1 204");
  std::jthread running([&] { p.go(0.5); });
  LiveFrames frames(address);
  frames.read(1, milliseconds(100));
  EXPECT_EQ(frames.frames.size(), 0u);
  EXPECT_EQ(parse_json(frames.status).at("state"), "paused");
  for (std::size_t step = 1; step <= 3; ++step) {
    address.post(R"({"do": "step"})");
    frames.read(step);
    frames.read(step + 1, milliseconds(100));
    ASSERT_EQ(frames.frames.size(), step);
    EXPECT_NEAR(frames.frames.back()[0], static_cast<double>(step) * Pendulum::kInterval, 1e-12);
    EXPECT_EQ(p.seen, static_cast<int>(step)) << "others were told of all before the state that is held";
  }
  // In real time the rest takes as long as it is, slower in proportion.
  address.post(R"({"speed": 2})");
  const auto begun = std::chrono::steady_clock::now();
  address.post(R"({"do": "run"})");
  frames.read(50);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begun;
  EXPECT_GT(taken.count(), 0.9 * 0.47 / 2);
  running.join();
  EXPECT_EQ(frames.frames.size(), 50u);
}

TEST(Live, AnInputMovedInThePageActsAsOneSetByTheScene) {
  const auto natively = [](double when, double value) {
    Pendulum p;
    SetsAt sets(when, value, *p.torque);
    p.simulation.observe(sets, every(Pendulum::kInterval));
    p.go(1);
    return p.state;
  };
  Pendulum p;
  const LiveAddress address(p.run.follow({.wait = 20}));
  address.post(R"({"do": "pause"})");
  std::jthread running([&] { p.go(1); });
  LiveFrames frames(address);
  for (int step = 0; step < 20; ++step) address.post(R"({"do": "step"})");
  frames.read(20);
  address.post(R"({"input": "torque", "value": 3.25})");
  const auto status_says = [&](const std::string& words) {
    for (int i = 0; i < 200 && frames.status.find(words) == std::string::npos; ++i)
      frames.read(frames.frames.size() + 1, milliseconds(20));
    return frames.status.find(words) != std::string::npos;
  };
  EXPECT_TRUE(status_says("3.25")) << frames.status;
  // What is out of bounds is told in the page, and changes nothing.
  address.post(R"({"input": "torque", "value": 5.5})");
  EXPECT_TRUE(status_says("input 'torque' is given 5.5 N m, outside its bounds -5 to 5")) << frames.status;
  address.post(R"({"do": "run"})");
  running.join();
  expect_same_bits(p.state, natively(0.2, 3.25));
  Pendulum still;
  still.go(1);
  EXPECT_GT((p.state.q - still.state.q).norm(), 0.1);
}

TEST(Live, AnInputBetweenLinearSamplesGoesThereInARamp) {
  Pendulum p;
  const LiveAddress address(p.run.follow({.wait = 20, .ramp = 0.1}));
  address.post(R"({"do": "pause"})");
  std::jthread running([&] { p.go(0.6); });
  LiveFrames frames(address);
  address.post(R"({"input": "ramped", "value": 2})");
  for (int step = 0; step < 5; ++step) address.post(R"({"do": "step"})");
  frames.read(5);
  address.post(R"({"input": "ramped", "value": -1})");  // behind the ramp that is under way
  address.post(R"({"do": "run"})");
  running.join();
  for (const auto& [time, value] :
       {std::pair(0.0, 0.0), {0.05, 1.0}, {0.1, 2.0}, {0.15, 0.5}, {0.2, -1.0}, {0.5, -1.0}})
    EXPECT_NEAR(p.ramped->value(time), value, 1e-9) << time;
}

TEST(Live, ARunIsTheSameToTheBitWhoeverLooksOrLeavesOrReadsNothing) {
  Pendulum alone, followed;
  alone.go(3);
  const LiveAddress address(followed.run.follow({.wait = 20}));
  HttpClient reads_nothing(address.port), asks_half(address.port);
  reads_nothing.send("GET " + address.path + "frames HTTP/1.1\r\nHost: " + address.host() + "\r\n\r\n");
  asks_half.send("GET " + address.path + "fra");
  std::jthread running([&] { followed.go(3); });
  {
    LiveFrames leaves(address);
    leaves.read(10);
    HttpClient mid_frame(address.port);
    mid_frame.send("GET " + address.path + "frames HTTP/1.1\r\nHost: " + address.host() + "\r\n\r\n");
    mid_frame.receive(600);  // some of the head, and of a message
  }
  running.join();
  expect_same_bits(alone.state, followed.state);
  EXPECT_EQ(alone.run.channel("tip_x"), followed.run.channel("tip_x"));
}

TEST(Live, ARunThatIsPausedGoesOnWhenAllHaveLeft) {
  Pendulum p;
  const LiveAddress address(p.run.follow({.wait = 20}));
  address.post(R"({"do": "pause"})");
  std::jthread running([&] { p.go(0.1); });
  {
    LiveFrames looks(address);
    address.post(R"({"do": "step"})");
    looks.read(1);
  }
  EXPECT_FALSE(p.reaches(2, milliseconds(1000)));
  running.join();
  EXPECT_EQ(p.run.frame_count(), 11);
}

TEST(Live, ThePageEndsARunWithItsResults) {
  Pendulum p;
  const LiveAddress address(p.run.follow({.wait = 20}));
  address.post(R"({"do": "pause"})");
  Recorder tip{{position(p.tip, "tip")}};
  p.simulation.observe(tip, every(0.02));
  std::jthread running([&] { p.go(100); });
  LiveFrames frames(address);
  for (int step = 0; step < 10; ++step) address.post(R"({"do": "step"})");
  frames.read(10);
  address.post(R"({"do": "stop"})");
  running.join();
  EXPECT_NEAR(p.state.time, 0.1, 1e-12);
  EXPECT_EQ(p.simulation.stopped_by(), "the page of run 'pendulum'");
  EXPECT_EQ(p.run.frame_count(), 11);
  EXPECT_EQ(p.seen, 11) << "who is told behind it, too";
  EXPECT_EQ(tip.table().row_count(), 6);
  const ScratchFolder folder;
  write_page(p.run, folder.path("ended.html"));
  EXPECT_EQ(Page(folder.path("ended.html")).channel("tip_z").size(), 11);
  // What was to follow ends at its next state.
  p.simulation.run(p.state, 100);
  EXPECT_NEAR(p.state.time, 0.11, 1e-12);
}

TEST(Live, ThePageEndsARunOfIslands) {
  SystemGraph graph;
  for (const char* name : {"one", "two"}) graph.add<RigidBody>(name, {.velocity = {1, 0, 0}});
  Simulation simulation(graph,
                        [] { return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = 0.01}); });
  ASSERT_EQ(simulation.islands().size(), 2u);
  lithe::Run run{simulation.system()};
  simulation.observe(run, every(0.1));
  const LiveAddress address(run.follow());
  address.post(R"({"do": "stop"})");
  State state = simulation.start();
  simulation.run(state, 1);
  EXPECT_EQ(state.time, 0);
  EXPECT_EQ(simulation.stopped_by(), "the page of run 'run'");
  EXPECT_EQ(run.frame_count(), 1);
}

TEST(Live, OfALongRunThePageHasEverySecondState) {
  Pendulum p;
  const LiveAddress address(p.run.follow({.wait = 20, .kept = 20000}));
  address.post(R"({"do": "pause"})");
  std::jthread running([&] { p.go(2); });
  LiveFrames early(address);
  for (int step = 0; step < 5; ++step) address.post(R"({"do": "step"})");
  early.read(5);
  address.post(R"({"do": "run"})");
  running.join();
  early.read(201, milliseconds(500));
  const std::vector<double> t = p.run.channel("t");
  ASSERT_EQ(t.size(), 201u) << "the run itself has all";
  const std::size_t every = std::size_t{1} << early.thinned;
  EXPECT_GE(every, 2u);
  ASSERT_EQ(early.frames.size(), 200 / every);
  for (std::size_t i = 0; i < early.frames.size(); ++i) EXPECT_EQ(early.frames[i][0], t[every * (i + 1)]);
}

TEST(Live, MeshesOfModesAndOfNodesAreShownAsTheyAreWhateverIsToCome) {
  RodScene scene(Deflection::stiffened, 3);
  const FiniteElementModel model =
      brick_mesh({.size = {0.2, 0.05, 0.05}, .divisions = {2, 1, 1}, .type = "C3D8I", .material = {2e8, 0.3, 1000}});
  const std::vector<int>& root = model.node_set("x_min");
  auto& nodal = scene.graph.add<FlexibleBody>(
      "nodal", {.basis = make_basis(model, ThreeNodeFrame{root[0], root[1], root[2]}, kAllNodal)});
  const System system = assemble(scene.graph);
  State state = system.initial_state();
  lithe::Run run{system};
  const LiveAddress address(run.follow());
  Snapshot now(system, state);
  run.observe(now);
  const ScratchFolder folder;
  write_text(folder.path("page.html"), address.get(""));
  const Page page(folder.path("page.html"));
  const Json& modes = page.body("rod").at("mesh");
  EXPECT_EQ(modes.at("shapes").at("type"), "f32") << "16-bit integers hold what has been";
  EXPECT_EQ(modes.at("coordinates").at("width"), 3);
  const Json& nodes = page.body(nodal.name()).at("mesh");
  EXPECT_EQ(nodes.at("nodal").at("n"), nodes.at("points").at("n"));
  EXPECT_LT((page.array(nodes.at("nodal"), 3) - page.array(nodes.at("points"), 3)).norm(), 1e-6);

  // A row is as long as its last part, and a state is a row.
  LiveFrames frames(address);
  state.time = 0.1;
  now.evaluate(state);
  run.observe(now);
  frames.read(1);
  ASSERT_EQ(frames.frames.size(), 1u);
  const std::size_t first = nodes.at("nodal").at("row"), width = nodes.at("nodal").at("width");
  ASSERT_LE(first + width, frames.frames[0].size());
  const VectorX points = page.array(nodes.at("points"), 1).transpose();
  for (std::size_t i = 0; i < width; ++i)
    EXPECT_NEAR(frames.frames[0][first + i], points[static_cast<Eigen::Index>(i)], 1e-6);
}

TEST(Live, WhatCannotBeIsRefused) {
  Pendulum p, q;
  const LiveAddress address(p.run.follow());
  expect_says(message_of<FileError>([&] { q.run.follow({.port = address.port}); }),
              {"port " + std::to_string(address.port) + " of 127.0.0.1 cannot be had: Address already in use",
               "live_test.cpp", "give another port"});
  expect_says(message_of<SceneError>([&] { q.run.follow({.port = 70000}); }), {"70000 is no port"});
  expect_says(message_of<SceneError>([&] { q.run.follow({.speed = NAN}); }), {"speed of nan", "live_test.cpp"});
  EXPECT_THROW(q.run.follow({.wait = -1}), SceneError);
  EXPECT_THROW(q.run.follow({.ramp = 0}), SceneError);
  Snapshot now(q.system, q.state);
  q.run.observe(now);
  expect_says(message_of<SceneError>([&] { q.run.follow(); }), {"the run 'pendulum' has begun", "Run::follow"});
}

}  // namespace
}  // namespace lithe::test::live_test
