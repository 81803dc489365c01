// Compiled apart, with optimisation: runs spend their time in the bodies defined here.
#include "tests/integrators/restart_scenes.h"

#include <filesystem>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/rigid_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/plugin.h"
#include "engine/plugin/registry.h"
#include "engine/run/sleeping_integrator.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/generalized_alpha.h"
#include "integrators/lie_bdf.h"
#include "integrators/moreau_jean.h"
#include "integrators/nonsmooth_generalized_alpha.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tests/bodies/sprung_bars.h"
#include "tests/plugins/kinds/frame_chain.cpp"
#include "tests/plugins/kinds/rattle_box.cpp"

namespace lithe::test::restart {
namespace {

/// Lithe's own method behind a C table, as a plug-in has it.
class Guest final : public Integrator {
 public:
  struct Parameters {
    double step = 0;
  };
  static constexpr Field<Parameters> kParameters[] = {{"step", &Parameters::step}};
  explicit Guest(Parameters parameters) : method_({.step = parameters.step}) {}
  std::string name() const override { return method_.name(); }
  const IntegratorStatistics& statistics() const override { return method_.statistics(); }
  void prepare(EquationsOfMotion& equations, State& state) override { method_.start(equations, state); }
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override {
    return method_.step(equations, state, t_stop);
  }
  bool keep(Archive& archive, EquationsOfMotion& equations, const State& state) override {
    bool kept = false;
    archive.group("method", [&] { kept = method_.history(archive, equations, state); });
    return kept;
  }

 private:
  GeneralizedAlpha method_;
};
/// One that tells nothing of its past.
class Forgetful final : public Integrator {
 public:
  struct Parameters {
    double step = 0;
  };
  static constexpr Field<Parameters> kParameters[] = {{"step", &Parameters::step}};
  explicit Forgetful(Parameters parameters) : method_({.step = parameters.step}) {}
  std::string name() const override { return "forgetful"; }
  const IntegratorStatistics& statistics() const override { return method_.statistics(); }
  void prepare(EquationsOfMotion& equations, State& state) override { method_.start(equations, state); }
  StepResult advance(EquationsOfMotion& equations, State& state, double t_stop) override {
    return method_.step(equations, state, t_stop);
  }

 private:
  GeneralizedAlpha method_;
};

}  // namespace

void draw_loop(SystemGraph& graph, const Drawing& d) {
  auto& crank = graph.add<RigidBody>("crank", {.mass = 0.5, .inertia = {1e-3, 5e-3, 5e-3}, .position = {0, 0, 0.1}});
  auto& coupler =
      graph.add<RigidBody>("coupler", {.mass = d.mass, .inertia = {2e-3, 2e-2, 2e-2}, .position = {0.2, 0, 0.25}});
  auto& rocker = graph.add<RigidBody>(d.name, {.mass = 0.8, .inertia = {1e-3, 9e-3, 9e-3}, .position = {0.4, 0, 0.15}});
  graph.add<RevoluteJoint>("a", {graph.ground().marker({0, 0, 0}, kAxisY), crank.marker({0, 0, -0.1}, kAxisY)});
  graph.add<RevoluteJoint>("b", {crank.marker({0, 0, 0.1}, kAxisY), coupler.marker({-0.2, 0, -0.05}, kAxisY)});
  graph.add<RevoluteJoint>("c", {coupler.marker({0.2, 0, 0.05}, kAxisY), rocker.marker({0, 0, 0.15}, kAxisY)});
  graph.add<RevoluteJoint>("d", {graph.ground().marker({0.4, 0, 0}, kAxisY), rocker.marker({0, 0, -0.15}, kAxisY)});
  graph.add<SpringDamper>("spring", {graph.ground().marker({0.5, 0, 0.6}), coupler.marker({0.1, 0, 0})},
                          {.stiffness = d.stiffness, .damping = 0.1, .natural_length = 0.2});
  if (d.spare) graph.add<RigidBody>("spare", {.mass = 1, .inertia = {1, 1, 1}});
}

void draw_rubbing(SystemGraph& graph) {
  draw_loop(graph, {});
  auto& pin = *dynamic_cast<const RevoluteJoint*>(graph.find("a"));
  graph.add<JointFriction>("rub", {pin.angle()},
                           {.joint = &pin, .coefficient = 0.2, .creep_speed = 3e-2, .radius = 0.02});
}

std::shared_ptr<const ModalBasis> rod_modes() {
  static const auto modes = make_basis(brick_mesh({.size = {0.4, 0.02, 0.02},
                                                   .divisions = {4, 1, 1},
                                                   .type = "C3D8I",
                                                   .material = {2e8, 0.3, 1200},
                                                   .name = "rod"}),
                                       MeanAxisFrame{}, 3);
  return modes;
}

void draw_flexible(SystemGraph& graph) {
  auto& rod = graph.add<FlexibleBody>("rod", {.basis = rod_modes()});
  graph.add<RevoluteJoint>("pin", {graph.ground().marker({0, 0, 0}, kAxisY), rod.average({1, 2}, kAxisY)});
}

void draw_contact(SystemGraph& graph, Contact::Parameters parameters) {
  auto& block = graph.add<RigidBody>("block", {.mass = 1,
                                               .inertia = {0.02, 0.03, 0.04},
                                               .position = {0, 0, 0.0505},
                                               .orientation = rotation_about({0, 1, 0}, 1e-3),
                                               .velocity = {0.4, 0.1, -0.1},
                                               .angular_velocity = {0, 0, 0.5}});
  auto& ball = graph.add<RigidBody>(
      "ball", {.mass = 0.3, .inertia = {4e-4, 4e-4, 4e-4}, .position = {0.05, 0, 0.16}, .velocity = {0, 0, -0.5}});
  graph.add<Contact>("touch",
                     {{graph.ground().marker(), shape::half_space()},
                      {block.marker(), shape::box({0.4, 0.3, 0.1})},
                      {ball.marker(), shape::sphere(0.05)}},
                     std::move(parameters));
}
void draw_compliant(SystemGraph& graph) {
  draw_contact(graph, {.law = Compliance{.stiffness = 2e4, .exponent = 1, .restitution = 0.5},
                       .friction = {.coefficient = 0.4, .bristle_stiffness = 3e3}});
}
void draw_rigid_contact(SystemGraph& graph) {
  draw_contact(graph, {.law = RigidSurfaces{.restitution = 0.5}, .friction = {.coefficient = 0.4}});
}

void draw_plug_ins(SystemGraph& graph) {
  Registry registry;
  registry.load_plugin(std::filesystem::path(LITHE_BINARY_DIR) / "plugins" / "massless_rod.so");
  registry.add<RattleBox>("rattle_box");
  auto& box =
      graph.add(registry.body("rattle_box"), "box", {{"position", {0.3, 0, 0}}, {"angular_velocity", {1, 2, 3}}});
  auto& bob = graph.add<RigidBody>("bob", {.mass = 1, .inertia = {0.01, 0.02, 0.03}, .position = {0.6, 0.1, 0}});
  const Marker at = box.marker({0, 0, 0});
  graph.add(registry.joint("massless_rod"), "string", {graph.ground().marker(), at}, {{"length", 0.3}});
  graph.add(registry.joint("massless_rod"), "rope", {at, bob.marker()}, {{"length", std::hypot(0.3, 0.1)}});
}

void draw_several_frames(SystemGraph& graph) {
  auto& chain = graph.add<FrameChain>("chain", {.position = {0.1, 0, 0}, .velocity = {0, 0.3, 0}});
  graph.add<SphericalJoint>("pin", {graph.ground().marker(), chain.marker_in(0, {-0.1, 0, 0})});
}

void draw_frames_and_modes(SystemGraph& graph) {
  auto& bars = graph.add<SprungBars>("bars", {});
  graph.add<SphericalJoint>("pin", {graph.ground().marker({0, -0.01, -0.015}), bars.node(1)});
}

void draw_driven(SystemGraph& graph) {
  draw_loop(graph, {});
  auto& pin = *dynamic_cast<const RevoluteJoint*>(graph.find("a"));
  graph.add<CoordinateDrive>("motor", {pin.angle()}, {.motion = ramp(0, 3)});
}

MakeMethod behind_a_table(const std::string& name) {
  return [=](const System&) {
    Registry registry;
    registry.add<Guest>("guest");
    registry.add<Forgetful>("forgetful");
    return registry.integrator(name, {{"step", 2e-3}});
  };
}

const std::vector<Case>& smooth_methods() {
  static const std::vector<Case> all = {
      {"runge_kutta5", of<ExplicitRungeKutta>({.tolerance = kTolerance})},
      {"runge_kutta8",
       of<ExplicitRungeKutta>({.method = ExplicitRungeKutta::Method::dormand_prince8, .tolerance = kTolerance})},
      {"runge_kutta_fixed", of<ExplicitRungeKutta>({.step = 1e-3})},
      {"automatic", [](const System&) { return automatic(1e-6); }},
      {"adams", [](const System&) { return adams(1e-6); }},
      {"ida", [](const System&) { return ida(1e-6); }},
      {"radau", [](const System&) { return radau(1e-6); }},
      {"radau_fixed", [](const System&) { return radau_fixed(4e-3); }},
      {"bdf", [](const System&) { return bdf(1e-6); }},
      {"bdf_fixed", of<LieBdf>({.step = 2e-3, .tolerance = {1e-4, 1e-5}, .max_order = 3})},
      {"index3", [](const System&) { return index3(2e-3); }},
      {"index2", [](const System&) { return index2(2e-3); }},
      {"alpha_automatic", of<GeneralizedAlpha>({.tolerance = {1e-4, 1e-6}})},
      {"hht", [](const System&) { return hht(2e-3); }},
      {"rattle", [](const System&) { return rattle(1e-3); }},
      {"energy_momentum", [](const System&) { return energy_momentum(1e-3); }},
      {"linearly_implicit", [](const System&) { return linearly_implicit(1e-3); }},
      {"extrapolated", [](const System&) { return linearly_implicit(2e-3, 2); }},
      {"moreau_jean", of<MoreauJean>({.step = 1e-3})},
      {"nonsmooth_alpha", of<NonsmoothGeneralizedAlpha>({.step = 1e-3})},
      {"sleeping", [](const System&) { return std::make_unique<SleepingIntegrator>(automatic(1e-6)); }},
      {"sleeping_adams", [](const System&) { return std::make_unique<SleepingIntegrator>(adams(1e-6)); }},
      {"guest", behind_a_table("guest")},
      {"forgetful", behind_a_table("forgetful")},
  };
  return all;
}

}  // namespace lithe::test::restart
