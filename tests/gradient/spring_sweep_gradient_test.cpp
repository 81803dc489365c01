// Masses on springs by Radau, with numbers drawn at random: tangent against adjoint, and both against runs.
#include <random>

#include "bodies/point_mass.h"
#include "bodies/rigid_body.h"
#include "integrators/radau.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/spring_damper.h"
#include "joints/prismatic_joint.h"
#include "tests/gradient/gradient_support.h"

namespace lithe::test {
namespace {

using Mode = GradientOptions::Mode;

struct SprungMass {
  ParametricScene scene;
  std::vector<Quantity> quantities;
  std::vector<DesignParameter> parameters;
};

/// On a rail, on a spring that hangs, on one that swings, and on one beside its centre of mass; stiff and soft, damped
/// and not; Radau by error control at tolerances from 1e-10 to 1e-2, or with fixed steps from 1 to 100 ms, many of them
/// far too long for the springs.
SprungMass sprung_mass(unsigned seed, double newton_tolerance = 0) {
  std::mt19937 random(seed);
  const auto from_to = [&](double a, double b) {
    const double low = static_cast<double>(random()), high = static_cast<double>(random());
    return a + (b - a) * ((low + high * 4294967296.0) / 18446744073709551616.0);
  };
  const auto of_size = [&](double a, double b) { return std::exp(from_to(std::log(a), std::log(b))); };
  const unsigned kind = seed % 4, style = seed % 7;
  const double duration = of_size(0.05, 1), k = of_size(1, 1e5), m = of_size(0.01, 100), v = from_to(-3, 3);
  const double c = seed % 3 ? 0 : of_size(0.01, 1000), x0 = from_to(0.3, 1.5), g = seed % 5 == 0 ? 0 : -9.81;
  const double step = style == 1 ? of_size(1e-3, 0.1) : 0, tolerance = style > 1 ? of_size(1e-10, 1e-2) : 0;
  const auto draw = [=](SystemGraph& graph, const SweepPoint& p) {
    const Matrix3 along_x = rotation_about({0, 1, 0}, M_PI / 2);
    const auto sensors = [](auto& body) {
      return std::vector<Sensor>{position(body.marker(), "p"), velocity(body.marker(), "v")};
    };
    if (kind == 1) {
      auto& body =
          graph.add<PointMass>("mass", {.mass = p["mass"], .position = {0, 0, -x0}, .velocity = {0, 0, p["speed"]}});
      graph.add<SpringDamper>("spring", {graph.ground().marker(), body.marker()},
                              {.stiffness = p["stiffness"], .damping = c, .natural_length = 1});
      return sensors(body);
    }
    auto& body = graph.add<RigidBody>("mass", {.mass = p["mass"],
                                               .inertia = {0.01, 0.01, 0.01},
                                               .position = {kind == 0 ? 0 : x0, 0, 0},
                                               .velocity = {p["speed"], kind == 3 ? 0.3 : 0, 0}});
    if (kind == 0) {
      auto& rail = graph.add<PrismaticJoint>("rail", {graph.ground().marker({}, along_x), body.marker({}, along_x)});
      graph.add<CoordinateSpring>("spring", {rail.displacement()},
                                  {.stiffness = p["stiffness"], .damping = c, .free_value = x0 - 0.5});
    } else {
      const Vector3 aside = kind == 3 ? Vector3(-0.1, 0.05, 0) : Vector3(0, 0, 0);
      graph.add<SpringDamper>("spring", {graph.ground().marker(), body.marker(aside)},
                              {.stiffness = p["stiffness"], .damping = c, .natural_length = kind == 3 ? 0.8 : 1});
    }
    return sensors(body);
  };
  const auto integrator = [=] {
    Radau::Parameters parameters{.step = step, .newton_tolerance = newton_tolerance};
    if (tolerance > 0) parameters.tolerance = {.relative = tolerance, .absolute = tolerance};
    return std::make_unique<Radau>(parameters);
  };
  const std::string x = kind == 1 ? "p_z" : "p_x", speed = kind == 1 ? "v_z" : "v_x";
  return {.scene = {.name = "mass on a spring, " + std::to_string(seed),
                    .duration = duration,
                    .gravity = {0, 0, g},
                    .draw = draw,
                    .integrator = integrator},
          .quantities = {value_at(x, duration), value_at(speed, from_to(0, duration)), integral(x)},
          .parameters = {{"stiffness", k}, {"mass", m}, {"speed", v}}};
}

void expect_tangent_is_adjoint(unsigned seed) {
  const SprungMass sprung = sprung_mass(seed);
  MatrixX forwards = gradient(sprung.scene, sprung.quantities, sprung.parameters, {.mode = Mode::tangent}).derivatives;
  MatrixX backwards = gradient(sprung.scene, sprung.quantities, sprung.parameters, {.mode = Mode::adjoint}).derivatives;
  // What a damper has made of a derivative is round-off of what it was: of metres, metres a second, and their integral.
  const Vector3 of_quantities(1, 3, sprung.scene.duration);
  for (Eigen::Index k = 0; k < 3; ++k)
    for (MatrixX* found : {&forwards, &backwards})
      found->col(k) *= sprung.parameters[static_cast<std::size_t>(k)].value;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double size = forwards.row(i).lpNorm<Eigen::Infinity>() + 1e-2 * of_quantities[i];
    EXPECT_LE((forwards.row(i) - backwards.row(i)).lpNorm<Eigen::Infinity>(), 1e-8 * size)
        << sprung.scene.name << ", quantity " << i << ": " << forwards.row(i) << " against " << backwards.row(i);
  }
}

/// Newton leaves its share of the tolerance in the stages of each step.
TEST(SpringSweepGradients, ForwardsAndBackwardsAgree) {
  for (const unsigned seed :
       {2u,  4u,  7u,  8u,  10u, 13u, 16u, 17u,  18u,  19u,  20u,  21u,  23u,  24u,  26u,  28u,  30u,  31u, 32u,
        33u, 34u, 36u, 37u, 40u, 41u, 78u, 158u, 231u, 298u, 354u, 383u, 439u, 535u, 554u, 566u, 578u, 687u})
    expect_tangent_is_adjoint(seed);
}

/// Tolerances of a thousandth leave more of a step than round-off; long steps converge slowly.
TEST(SpringSweepGradients, StepsThatNewtonSolvesRoughlyOrSlowlyAreTakenAgain) {
  for (const unsigned seed : {15u,  22u,  51u,  59u,  66u,  75u,  122u, 146u, 155u, 167u, 183u, 211u, 219u, 234u, 235u,
                              302u, 314u, 315u, 323u, 342u, 387u, 402u, 415u, 454u, 519u, 559u, 635u, 655u, 678u, 683u})
    expect_tangent_is_adjoint(seed);
}

/// Fixed steps that the run too solves to round-off, against differences of runs.
TEST(SpringSweepGradients, OfFixedStepsAreThoseOfRuns) {
  for (const unsigned seed : {8u, 36u, 50u, 64u, 78u, 106u}) {
    const SprungMass sprung = sprung_mass(seed, 1e-13);
    expect_gradient(sprung.scene, sprung.quantities, sprung.parameters);
  }
}

}  // namespace
}  // namespace lithe::test
