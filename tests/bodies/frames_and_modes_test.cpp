// A body with several frames and linear coordinates against the same bars and spring as bodies and a force of their
// own, by the same methods.
#include <gtest/gtest.h>

#include "bodies/rigid_body.h"
#include "engine/analysis/describe.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "engine/assembly/batch_of.h"
#include "engine/gradient/gradient.h"
#include "engine/observe/sensors.h"
#include "engine/plugin/registry.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "integrators/moreau_jean.h"
#include "joints/contact/contact.h"
#include "joints/distance_joint.h"
#include "joints/forces/point_force.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/bodies/sprung_bars.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/body_checks.h"
#include "tests/support/joint_checks.h"
#include "tests/support/methods.h"
#include "tests/support/scenes.h"

namespace lithe::test::frames_and_modes_test {
namespace {

constexpr int kModes = SprungBars::kModes;

/// The spring of SprungBars between two markers.
class Spring final : public Force<2, 0> {
 public:
  struct Parameters {
    double stiffness;
  };
  explicit Spring(Parameters parameters) : stiffness_(parameters.stiffness) {}
  bool depends_on_time() const override { return false; }
  void evaluate(double, std::span<const MarkerView> m, ForceRows& rows) const override {
    const Vector3 pull = stiffness_ * (m[1].p - m[0].p);
    rows.add_load(m[0], force(pull));
    rows.add_load(m[1], force(-pull));
    rows.add_energy(0.5 * stiffness_ * (m[1].p - m[0].p).squaredNorm());
  }

 private:
  double stiffness_;
};

int node_of(int bar, const char* face, int number) {
  return 1000 * bar + SprungBars::mesh().node_set(face)[static_cast<std::size_t>(number)];
}

enum class Form { one, parts, guest };  // one body, two with a spring, or one behind the table of plug-ins

/// Nodes of the bars by 1000 · bar + label.
using Nodes = std::function<Marker(int)>;

Nodes draw_bars(SystemGraph& graph, Form form, const SprungBars::Parameters& p) {
  if (form == Form::one) {
    auto& bars = graph.add<SprungBars>("bars", p);
    return [&bars](int node) { return bars.node(node); };
  }
  if (form == Form::guest) {
    static Registry registry;
    static const bool added = (registry.add<SprungBars>("sprung_bars"), true);
    EXPECT_TRUE(added);
    auto& bars =
        graph.add(registry.body("sprung_bars"), "bars",
                  {{"stiffness", p.stiffness},
                   {"velocity", {p.velocity[0], p.velocity[1], p.velocity[2]}},
                   {"angular_velocity", {p.angular_velocity[0], p.angular_velocity[1], p.angular_velocity[2]}}});
    return [&bars](int node) { return bars.node(node); };
  }
  FlexibleBody* bar[2];
  for (int i = 0; i < 2; ++i) bar[i] = &graph.add<FlexibleBody>("bar" + std::to_string(i), SprungBars::bar(i, p));
  graph.add<Spring>("spring", {bar[0]->node(SprungBars::sprung_node(0)), bar[1]->node(SprungBars::sprung_node(1))},
                    {p.stiffness});
  return [first = bar[0], second = bar[1]](int node) { return (node < 1000 ? first : second)->node(node % 1000); };
}

/// On a pin, with a rod hinged to the far end and a string between a node of each bar.
RigidBody& draw_machine(SystemGraph& graph, Form form, const SprungBars::Parameters& p = {}) {
  const Nodes node = draw_bars(graph, form, p);
  const Marker pinned = node(node_of(0, "start", 0)), end = node(node_of(1, "end", 0));
  graph.add<SphericalJoint>("pin", {graph.ground().marker({0, -0.01, -0.015}), pinned});
  auto& rod = graph.add<RigidBody>(
      "rod", {.mass = 0.2, .inertia = {1e-3, 2e-3, 2e-3}, .position = {2 * SprungBars::kLength + 0.1, -0.01, -0.015}});
  graph.add<SphericalJoint>("ball", {end, rod.marker({-0.1, 0, 0})});
  graph.add<DistanceJoint>("string", {node(node_of(0, "start", 2)), node(node_of(1, "end", 3))});
  return rod;
}

/// Frames and modes of both forms, in the order of the parts.
VectorX coordinates_of(const Scene& scene, Form form) {
  constexpr int n = 7 + kModes;
  const VectorX& q = scene.state.q;
  if (form == Form::parts) return q;
  VectorX out(q.size());
  out << q.head<7>(), q.segment<kModes>(14), q.segment<7>(7), q.segment<kModes>(14 + kModes), q.tail(q.size() - 2 * n);
  return out;
}

const Vector3 kGravity{0.5, 1, -9.81};

TEST(FramesAndModes, OweWhatEveryBodyOwes) {
  SystemGraph graph{{.gravity = kGravity}};
  auto& bars = graph.add<SprungBars>("bars", {});
  const std::vector<Marker> markers = {bars.node(node_of(0, "start", 1)), bars.node(node_of(0, "end", 2)),
                                       bars.node(node_of(1, "end", 0))};
  check_body(graph, bars, markers, {.mass = bars.mass()});
}

/// The same steps, so that what differs is round-off and what Newton's iteration leaves; of the last two methods, which
/// take tangents for part of the equations and balance the energy of bodies and of forces each in its own way, errors
/// of the method.
TEST(FramesAndModes, MoveAsBodiesOfTheirOwnByEveryMethod) {
  struct Case {
    const char* name;
    std::function<Method()> make;
    double bound = 2e-9;
  };
  const std::vector<Case> all = {{"Runge-Kutta 5", [] { return runge_kutta(1e-8); }},
                                 {"Runge-Kutta 8", [] { return runge_kutta8(1e-9); }},
                                 {"Adams", [] { return adams(1e-9); }},
                                 {"automatic", [] { return automatic(1e-9); }},
                                 {"Radau", [] { return radau(1e-9); }},
                                 {"BDF", [] { return bdf(1e-9); }},
                                 {"RATTLE", [] { return rattle(5e-5); }},
                                 {"HHT", [] { return hht(2e-4); }},
                                 {"generalized-alpha 3", [] { return index3(2e-4); }},
                                 {"generalized-alpha 2", [] { return index2(2e-4); }},
                                 {"linearly implicit", [] { return linearly_implicit(5e-5); }, 3e-6},
                                 {"energy-momentum", [] { return energy_momentum(5e-5); }, 3e-6}};
  for (const auto& [name, make, bound] : all) {
    SCOPED_TRACE(name);
    VectorX end[3];
    double energy[3];
    for (const Form form : {Form::one, Form::parts, Form::guest}) {
      Scene scene(kGravity, [&](SystemGraph& graph) { draw_machine(graph, form); });
      const int k = static_cast<int>(form);
      energy[k] = scene.energy();
      scene.run(*make(), 0.012);
      end[k] = coordinates_of(scene, form);
    }
    EXPECT_NEAR(energy[0], energy[1], 1e-12);
    EXPECT_GT(end[1].segment<3>(7 + kModes).norm(), 0.5);
    EXPECT_GT(end[1].segment<kModes>(7).norm(), 1e-5);  // bent
    expect_below(name, (end[0] - end[1]).lpNorm<Eigen::Infinity>(), bound);
    expect_below(std::string(name) + ", behind the table of plug-ins", (end[2] - end[1]).lpNorm<Eigen::Infinity>(),
                 bound);
  }
}

/// A rest of theirs is one of the parts, with the same frequencies. There are several, a saddle among them: which is
/// found from the drawing hangs on rounding, so it is handed over and not looked for again.
TEST(FramesAndModes, RestAndSwingAsBodiesOfTheirOwn) {
  Scene one({0, 0, -9.81}, [&](SystemGraph& graph) { draw_machine(graph, Form::one); });
  Scene parts({0, 0, -9.81}, [&](SystemGraph& graph) { draw_machine(graph, Form::parts); });
  one.state = find_equilibrium(one.system, one.system.initial_state()).state;
  parts.state.q = coordinates_of(one, Form::one);
  EXPECT_LT(parts.state.q[7 + kModes + 2], -0.5);  // m: far from where it was drawn

  std::vector<double> frequencies[2];
  for (const Scene* scene : {&one, &parts}) {
    const Linearization motion = linearize(scene->system, scene->state);
    expect_below("acceleration at rest", motion.state.v_dot.lpNorm<Eigen::Infinity>(), 1e-5);
    for (const Mode& mode : motion.modes)  // turns about the vertical and about the rod are free
      if (mode.frequency() > 0.05) frequencies[scene == &parts].push_back(mode.frequency());
  }
  ASSERT_EQ(frequencies[0].size(), frequencies[1].size());
  EXPECT_GT(frequencies[0].size(), 10u);
  for (std::size_t i = 0; i < frequencies[0].size(); ++i)
    EXPECT_NEAR(frequencies[0][i] / frequencies[1][i], 1, 1e-5) << i;
}

/// How far apart they are once balls on two nodes have met the ground.
double apart_on_the_ground(decltype(Contact::Parameters::law) law, const std::function<Method()>& make) {
  VectorX end[2];
  for (const Form form : {Form::one, Form::parts}) {
    Scene scene({0, 0, -9.81}, [&](SystemGraph& graph) {
      const Nodes node = draw_bars(graph, form, {.velocity = {0.3, 0, -1}});
      graph.add<Contact>("floor",
                         {{graph.ground().marker({0, 0, -0.05}), shape::half_space()},
                          {node(node_of(0, "start", 0)), shape::sphere(0.02)},
                          {node(node_of(1, "end", 0)), shape::sphere(0.02)}},
                         {.law = law, .friction = {.coefficient = 0.3}});
    });
    scene.run(*make(), 0.06);
    end[static_cast<int>(form)] = coordinates_of(scene, form);
  }
  EXPECT_GT(end[1][2], -0.07);  // the floor holds it: it would fall by 0.078 m
  return (end[0] - end[1]).lpNorm<Eigen::Infinity>();
}

TEST(FramesAndModes, TouchAsBodiesOfTheirOwn) {
  expect_below("compliant, apart, m",
               apart_on_the_ground(Compliance{.stiffness = 1e5, .exponent = 1}, [] { return radau(1e-8); }), 1e-6);
  // Rigid: time stepping solves a step with the tangents that bodies and forces have; what that leaves falls with the
  // step.
  const auto rigid = [](double step) {
    return apart_on_the_ground(RigidSurfaces{},
                               [&] { return std::make_unique<MoreauJean>(MoreauJean::Parameters{.step = step}); });
  };
  const double coarse = rigid(1e-4), fine = rigid(2.5e-5);
  expect_below("rigid, apart with a fine step, m", fine, 2e-4);
  expect_below("rigid, a fourth of the step: a fourth", fine / coarse, 0.35);
}

/// Names and sensors: frames one by one, then the modes of both.
TEST(FramesAndModes, AreNamedAndMeasured) {
  Scene scene(kGravity, [](SystemGraph& graph) { draw_machine(graph, Form::one); });
  const Body& bars = *scene.graph.bodies()[1].body;
  EXPECT_EQ(scene.system.layout().velocity_name(9), "bars frame 1: omega_x");
  EXPECT_EQ(scene.system.layout().velocity_name(13), "bars: eta_2");
  EXPECT_EQ(scene.system.layout().velocity_name(12 + 2 * kModes), "rod: p_x");
  EXPECT_EQ(scene.system.layout().body_names(), (std::vector<std::string>{"bars", "rod"}));
  EXPECT_EQ(coordinates(bars).columns().size(), 14u + 2 * kModes);
  EXPECT_EQ(modal_coordinates(bars).columns().size(), 2u * kModes);
  EXPECT_NE(describe(scene.system).find("'bars': 2 frames, 6 elastic coordinates"), std::string::npos);
  // The acceleration that a sensor tells is the rate of the velocity that it tells.
  const auto read = [](double time, auto&& sensor) {
    Scene run(kGravity, [](SystemGraph& graph) { draw_machine(graph, Form::one); });
    run.run(*runge_kutta8(1e-12), time);
    return read_vector(run, sensor(Marker{run.graph.bodies()[1].body, 1}));
  };
  const auto speed = [](const Marker& at) { return velocity(at); };
  const double h = 1e-5;
  const Vector3 a = read(0.01, [](const Marker& at) { return acceleration(at); });
  EXPECT_LT((a - (read(0.01 + h, speed) - read(0.01 - h, speed)) / (2 * h)).norm(), 1e-4 * a.norm());
}

/// Derivatives of a swing by the spring's stiffness and a load, forwards and backwards, are those of the parts.
TEST(FramesAndModes, HaveTheGradientsOfBodiesOfTheirOwn) {
  VectorX slopes[4];
  int k = 0;
  for (const Form form : {Form::one, Form::parts})
    for (const auto mode : {GradientOptions::Mode::tangent, GradientOptions::Mode::adjoint}) {
      ParametricScene scene{.name = "bars", .duration = 0.02};
      scene.draw = [form](SystemGraph& graph, const SweepPoint& p) {
        RigidBody& rod = draw_machine(graph, form, {.stiffness = p["stiffness"]});
        graph.add<PointForce>("load", {rod.marker()}, {.force = {0, p["load"], 0}});
        return std::vector<Sensor>{position(rod.marker(), "tip")};
      };
      scene.integrator = [] { return std::make_unique<GeneralizedAlpha>(GeneralizedAlpha::Parameters{.step = 2e-4}); };
      const Gradient found = gradient(scene, {value_at("tip_y", 0.02), value_at("tip_z", 0.02)},
                                      {{"stiffness", 3e4}, {"load", 2}}, {.mode = mode});
      slopes[k++] = found.derivatives.reshaped();
    }
  for (int i = 0; i < 4; ++i) EXPECT_GT(std::abs(slopes[1][i]), 0);
  for (const int other : {0, 2, 3})
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(slopes[other][i] / slopes[1][i], 1, 1e-5) << other << ' ' << i;
}

}  // namespace
}  // namespace lithe::test::frames_and_modes_test
