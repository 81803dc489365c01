// solve() where surfaces meet: against closed forms, and against other methods in finer steps.
#include <gtest/gtest.h>

#include <cmath>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "bodies/flexible/surface_mesh.h"
#include "bodies/rigid_body.h"
#include "engine/observe/recorder.h"
#include "engine/run/simulation.h"
#include "integrators/moreau_jean.h"
#include "integrators/solve.h"
#include "joints/contact/contact.h"
#include "tests/bodies/fe_models.h"
#include "tests/support/methods.h"

namespace lithe::test::solve_contact_test {
namespace {

constexpr double g = 9.81, kDrop = 0.4, kRadius = 0.1;  // m

/// A ball let go above a plane; its height over the plane is watched.
struct BallOnFloor {
  explicit BallOnFloor(const Contact::Parameters& law) {
    auto& ball =
        graph.add<RigidBody>("ball", {.mass = 2, .inertia = {8e-3, 8e-3, 8e-3}, .position = {0, 0, kRadius + kDrop}});
    graph.add<Contact>(
        "floor",
        std::vector<Collider>{{graph.ground().marker(), shape::half_space()}, {ball.marker(), shape::sphere(kRadius)}},
        law);
    middle = ball.marker();
  }
  Sensor gap() const {
    return {
        "gap", {"gap"}, [this](Snapshot& now, std::span<double> out) { out[0] = now.marker(middle).p.z() - kRadius; }};
  }
  SystemGraph graph;
  Marker middle;
};

/// The largest difference of the samples from a height that is known; by how much that is more than stated, fails.
template <class Height>
double check(const Solution& solution, const Height& height) {
  double most = 0;
  for (int row = 0; row < solution.samples.row_count(); ++row)
    most = std::max(most, std::abs(solution.samples.at(row, 1) - height(solution.samples.at(row, 0))));
  const CertifiedQuantity& gap = solution.certificate.quantities.at(0);
  EXPECT_TRUE(solution.certificate.met()) << solution.certificate.text();
  EXPECT_LE(most, gap.error.total()) << solution.certificate.text();
  return most;
}

/// Of a ball that bounces with this restitution, m.
double bouncing(double t, double restitution) {
  double speed = std::sqrt(2 * g * kDrop), fallen = speed / g;
  if (t < fallen) return kDrop - g * t * t / 2;
  for (t -= fallen;; t -= fallen) {
    speed *= restitution, fallen = 2 * speed / g;
    if (t < fallen) return speed * t - g * t * t / 2;
    if (speed < 1e-6) return 0;
  }
}

TEST(SolveContact, a_ball_bounces_off_a_rigid_plane_as_the_closed_form_says) {
  for (const double restitution : {1.0, 0.7, 0.0}) {
    SCOPED_TRACE(restitution);
    BallOnFloor ball({.law = RigidSurfaces{.restitution = restitution}});
    const Solution solution = solve(ball.graph, 2, {want(ball.gap(), percent(0.1))});
    const double error = check(solution, [&](double t) { return bouncing(t, restitution); });
    EXPECT_LT(error, 1e-3 * kDrop);
    EXPECT_TRUE(solution.certificate.bodies.empty());
    EXPECT_NE(solution.certificate.text().find("surfaces are rigid"), std::string::npos);
  }
}

TEST(SolveContact, a_ball_dips_into_a_linear_spring_as_the_oscillator_says) {
  constexpr double k = 2e4, m = 2, rest = m * g / k;
  const double w = std::sqrt(k / m), speed = std::sqrt(2 * g * kDrop), fall = speed / g;
  // In touch: z = -rest + rest cos wt - speed/w sin wt, until it is zero again.
  const double touch = 2 * (M_PI - std::atan(speed / (w * rest))) / w;
  const auto height = [&](double t) {
    t = std::fmod(t, 2 * fall + touch);
    if (t < fall) return kDrop - g * t * t / 2;
    t -= fall;
    if (t < touch) return rest * (std::cos(w * t) - 1) - speed / w * std::sin(w * t);
    t -= touch;
    return speed * t - g * t * t / 2;
  };
  for (const double wanted : {5.0, 0.1}) {
    SCOPED_TRACE(wanted);
    BallOnFloor ball({.law = Compliance{.stiffness = k, .exponent = 1, .restitution = 1}});
    const Solution solution = solve(ball.graph, 1.5, {want(ball.gap(), percent(wanted))});
    EXPECT_LT(check(solution, height), wanted / 100 * kDrop);
  }
}

/// A bar that falls onto a plane, one end first.
struct FallingBar {
  FallingBar() {
    static const FiniteElementModel model =
        brick_mesh({.size = {0.4, 0.02, 0.02}, .divisions = {8, 1, 1}, .type = "C3D8I", .material = {2e9, 0.3, 1200}});
    static const auto basis = make_basis(model, MeanAxisFrame{}, 8);
    const double tilt = 0.1;
    bar = &graph.add<FlexibleBody>("bar", {.basis = basis,
                                           .damping = {.stiffness_proportional = 1e-4},
                                           .position = {0, 0, 0.4 * std::sin(tilt) + 1e-3},
                                           .orientation = rotation_about({0, 1, 0}, tilt),
                                           .velocity = {0, 0, -0.3}});
    const SurfaceMesh skin = surface(*bar);
    graph.add<Contact>(
        "table",
        std::vector<Collider>{{graph.ground().marker(), shape::half_space()},
                              {skin.frame, shape::surface(skin.nodes, skin.points, skin.triangles, skin.reach)}},
        Contact::Parameters{.law = RigidSurfaces{}});
    end = bar->average(model.node_set("x_min"));
  }
  SystemGraph graph;
  FlexibleBody* bar;
  Marker end;
};

TEST(SolveContact, a_flexible_bar_falls_onto_a_rigid_plane_as_another_method_says_in_fine_steps) {
  constexpr double kDuration = 0.05;
  constexpr int kSamples = 50;
  FallingBar fine;
  const System system = assemble(fine.graph);
  MoreauJean stepper({.step = 2e-5});
  Recorder recorder({position(fine.end, "end")});
  Simulation simulation(system, stepper);
  simulation.observe(recorder, every(kDuration / kSamples));
  State state = system.initial_state();
  simulation.run(state, kDuration);
  const Table& reference = recorder.table();
  for (const double wanted : {30.0, 5.0}) {
    SCOPED_TRACE(wanted);
    FallingBar scene;
    const Solution solution = solve(scene.graph, kDuration, {want(position(scene.end, "end"), percent(wanted))},
                                    {.samples = kSamples, .small_deflection = true});
    ASSERT_EQ(solution.samples.row_count(), reference.row_count());
    double most = 0;
    for (int row = 0; row < reference.row_count(); ++row)
      most = std::max(most, std::hypot(solution.samples.at(row, 1) - reference.at(row, 1),
                                       solution.samples.at(row, 2) - reference.at(row, 2),
                                       solution.samples.at(row, 3) - reference.at(row, 3)));
    const CertifiedQuantity& end = solution.certificate.quantities.at(0);
    EXPECT_TRUE(solution.certificate.met()) << solution.certificate.text();
    EXPECT_LE(most, end.error.total()) << solution.certificate.text();
    EXPECT_LT(most, wanted / 100 * end.change);
  }
}

TEST(SolveContact, rigid_surfaces_are_refused_where_no_method_takes_impulses) {
  BallOnFloor ball({.law = RigidSurfaces{}});
  expect_error<SceneError>(
      [&] {
        solve(ball.graph, 1, {want(ball.gap(), percent(1))},
              SolveMethods{.by_tolerance = [](const Tolerance& t) { return automatic(t.relative); },
                           .by_step = {},
                           .by_step_with_impacts = {}});
      },
      {"'floor'", "rigid surfaces", "by_step_with_impacts"});
}

}  // namespace
}  // namespace lithe::test::solve_contact_test
