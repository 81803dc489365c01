#include "bodies/beam/beam.h"
#include "bodies/rigid_body.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/point_force.h"
#include "joints/forces/spring_damper.h"
#include "joints/revolute_joint.h"
#include "tests/gradient/gradient_support.h"

namespace lithe::test {
namespace {

const Matrix3 kRestAlongY = rotation_about({1, 0, 0}, -M_PI / 2);

/// A rod on a hinge with a spring about it, at rest at θ: k θ = m g a cos θ below the level.
ParametricScene sprung_rod() {
  return {.name = "sprung rod", .draw = [](SystemGraph& graph, const SweepPoint& p) {
            const double a = p["length"], m = p["mass"];
            auto& rod =
                graph.add<RigidBody>("rod", {.mass = m, .inertia = {0.03, m * a * a / 3, 0.1}, .position = {a, 0, 0}});
            auto& pin = graph.add<RevoluteJoint>(
                "pin", {graph.ground().marker({}, kRestAlongY), rod.marker({-a, 0, 0}, kRestAlongY)});
            graph.add<CoordinateSpring>("spring", {pin.angle()}, {.stiffness = p["stiffness"], .free_value = 0.0});
            return std::vector<Sensor>{coordinate(pin.angle(), "angle"), position(rod.marker({a, 0, 0}), "tip"),
                                       joint_reaction(pin, "pin")};
          }};
}

TEST(StaticGradient, OfARodOnASpringIsTheFormula) {
  const double m = 1.7, a = 0.4, k = 12, g = 9.81;
  const Gradient found = gradient(sprung_rod(), {at_rest("angle"), frequency(0), at_rest("pin_force_x")},
                                  {{"mass", m}, {"length", a}, {"stiffness", k}});
  const double theta = found.values[0];
  EXPECT_NEAR(k * theta, m * g * a * std::cos(theta), 1e-9);
  // F = k θ - m g a cos θ: dθ = -∂F/∂p / ∂F/∂θ
  const double stiff = k + m * g * a * std::sin(theta);
  const double by_m = g * a * std::cos(theta) / stiff, by_a = m * g * std::cos(theta) / stiff, by_k = -theta / stiff;
  EXPECT_NEAR(found("angle at rest", "mass"), by_m, 1e-10);
  EXPECT_NEAR(found("angle at rest", "length"), by_a, 1e-10);
  EXPECT_NEAR(found("angle at rest", "stiffness"), by_k, 1e-11);
  // ω² = (k + m g a sin θ)/(4/3 m a²)
  const double J = 4.0 / 3 * m * a * a, omega = std::sqrt(stiff / J);
  EXPECT_NEAR(found.values[1], omega / (2 * M_PI), 1e-9);
  const auto frequency_by = [&](double stiff_by, double inertia_by, double theta_by) {
    return (stiff_by + m * g * a * std::cos(theta) * theta_by - omega * omega * inertia_by) / (2 * omega * J) /
           (2 * M_PI);
  };
  EXPECT_NEAR(found("frequency 0", "mass"), frequency_by(g * a * std::sin(theta), J / m, by_m), 1e-8);
  EXPECT_NEAR(found("frequency 0", "length"), frequency_by(m * g * std::sin(theta), 2 * J / a, by_a), 2e-8);
  EXPECT_NEAR(found("frequency 0", "stiffness"), frequency_by(1, 0, by_k), 1e-9);
}

/// A strip bent far by a force at its end, with a spring beside it.
ParametricScene bent_strip() {
  return {.name = "bent strip", .draw = [](SystemGraph& graph, const SweepPoint& p) {
            const BeamSection strip = BeamSection::rectangle(0.02, p["thickness"], {p["E"], 0.3, 7850});
            auto& beam = graph.add<Beam>(
                "strip",
                {.axis = BeamAxis::straight({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), .sections = {{0, strip}}, .elements = 6});
            auto& clamp = graph.add<FixedJoint>("clamp", {graph.ground().marker({}, beam.axes(0)), beam.marker(0)});
            graph.add<PointForce>("push", {beam.marker(1)}, {.force = {0, 0, p["force"]}});
            graph.add<SpringDamper>("spring", {graph.ground().marker({0.5, 0, -0.4}), beam.marker(0.5)},
                                    {.stiffness = p["stiffness"], .natural_length = 0.4});
            return std::vector<Sensor>{position(beam.marker(1), "tip"), joint_reaction(clamp, "clamp")};
          }};
}

/// Central differences of equilibria and frequencies themselves, extrapolated.
TEST(StaticGradient, OfABeamBentFarAgreesWithDifferences) {
  const std::vector<Quantity> quantities{at_rest("tip_x"), at_rest("tip_z"), at_rest("clamp_moment_y"), frequency(0),
                                         frequency(2)};
  const std::vector<DesignParameter> parameters{{"thickness", 2e-3}, {"E", 2.1e11}, {"force", 5}, {"stiffness", 30}};
  const ParametricScene scene = bent_strip();
  const Gradient found = gradient(scene, quantities, parameters);
  const auto values = [&](const std::vector<DesignParameter>& at) {
    const Drawing drawing(scene, at);
    const State rest = find_equilibrium(drawing.system(), drawing.system().initial_state()).state;
    Snapshot now(drawing.system());
    now.evaluate(rest, Accelerations::solved);
    VectorX out(5);
    for (int i = 0; i < 3; ++i) {
      const Drawing::Place place = drawing.find(quantities[static_cast<std::size_t>(i)].column);
      out[i] = drawing.sensor(place.sensor).value(now, place.column);
    }
    // Rayleigh's quotient of the refined modes.
    ParametricScene fixed = scene;
    fixed.draw = [&](SystemGraph& graph, const SweepPoint&) {
      Table table;
      for (const DesignParameter& p : at) table.columns.push_back(p.name), table.values.push_back(p.value);
      return scene.draw(graph, SweepPoint(table, 0));
    };
    out.tail(2) = gradient(fixed, {frequency(0), frequency(2)}, {{"nothing", 1}}).values;
    return out;
  };
  const std::vector<DesignParameter> drawn = checked_parameters(parameters);
  for (int k = 0; k < 4; ++k) {
    // Of a thousandth of the parameter; extrapolated.
    const auto difference = [&](double steps) {
      return VectorX((values(moved_parameter(drawn, k, steps)) - values(moved_parameter(drawn, k, -steps))) /
                     (2e-3 * steps));
    };
    const VectorX d8 = difference(32), d4 = difference(16), d2 = difference(8);
    const VectorX e4 = d4 + (d4 - d8) / 3, e2 = d2 + (d2 - d4) / 3, expected = e2 + (e2 - e4) / 15;
    for (int i = 0; i < 5; ++i) {
      const double by = found.derivatives(i, k) * parameters[static_cast<std::size_t>(k)].value;
      if (std::getenv("LITHE_SHOW_ERRORS"))
        std::printf("%s by %s: %.6e, off %.1e\n", found.quantities[static_cast<std::size_t>(i)].c_str(),
                    found.parameters[static_cast<std::size_t>(k)].c_str(), by, by - expected[i]);
      // The strip is a million times stiffer along than across: of the clamp's moment (the strip's own resultant) and
      // of frequencies, round-off leaves some 1e-8.
      EXPECT_NEAR(by, expected[i], (i >= 2 ? 1e-7 : 1e-8) * std::abs(found.values[i]))
          << found.quantities[static_cast<std::size_t>(i)] << " by " << found.parameters[static_cast<std::size_t>(k)];
    }
  }
}

TEST(StaticGradient, RefusesWhatHasNoDerivative) {
  const std::vector<DesignParameter> parameters{{"mass", 1.7}, {"length", 0.4}, {"stiffness", 12}};
  EXPECT_THROW(gradient(sprung_rod(), {frequency(1)}, parameters), SceneError);
  EXPECT_THROW(gradient(sprung_rod(), {at_rest("angel")}, parameters), SceneError);
  EXPECT_THROW(gradient(sprung_rod(), {}, parameters), SceneError);
  EXPECT_THROW(gradient(sprung_rod(), {at_rest("angle")}, {}), SceneError);
  EXPECT_THROW(gradient(sprung_rod(), {at_rest("angle")}, {{"mass", 1.7}, {"mass", 1}}), SceneError);
  ParametricScene changing = sprung_rod();
  changing.draw = [draw = changing.draw](SystemGraph& graph, const SweepPoint& p) {
    auto sensors = draw(graph, p);
    if (p["mass"] > 1.7) graph.add<RigidBody>("more", {.mass = 1});
    return sensors;
  };
  EXPECT_THROW(gradient(changing, {at_rest("angle")}, parameters), SceneError);
}

}  // namespace
}  // namespace lithe::test
