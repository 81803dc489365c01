#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bodies/beam/beam.h"
#include "engine/analysis/equilibrium.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"
#include "tests/support/json_file.h"
#include "tests/support/methods.h"

/// Beams at rest under large displacements, against closed forms and tests/data/beams, which README.md there explains.
namespace lithe::test::beam_statics_test {
namespace {

nlohmann::json data(const std::string& name) { return read_json(std::string(LITHE_TEST_DATA) + "/beams/" + name); }

/// A clamped beam with a dead wrench at its end that grows with time from 0 to 1.
struct Cantilever {
  SystemGraph graph{{.gravity = Vector3::Zero()}};
  Beam& beam;
  System system;
  State state;
  int iterations = 0, load_steps = 0;

  Cantilever(const BeamAxis& axis, const BeamSection& section, int elements, const Wrench& load)
      : beam(graph.add<Beam>("beam", {.axis = axis, .sections = {{0, section}}, .elements = elements})),
        system(assembled(axis, load)),
        state(system.initial_state()) {}

  System assembled(const BeamAxis& axis, const Wrench& load) {
    const FramePose root = axis.pose(0);
    graph.add<FixedJoint>("clamp", {graph.ground().marker(root.position, root.axes), beam.marker(0)});
    graph.add<UserForce>("load", {beam.marker(axis.length)},
                         {[load](double share, const MarkerView&) { return share * load; }});
    return assemble(graph);
  }
  void solve(int steps = 1) {
    for (int i = 1; i <= steps; ++i) {
      state.time = static_cast<double>(i) / steps;
      const Equilibrium found = find_equilibrium(system, state);
      state = found.state;
      iterations += found.iterations, load_steps += found.load_steps;
    }
  }
  MarkerKinematics tip() {
    Snapshot now(system, state);
    return now.marker(beam.marker(beam.arc(beam.node_count() - 1)));
  }
  void report(const std::string& what) const {
    if (std::getenv("LITHE_PRINT"))
      std::printf("  %s: %d Newton iterations, %d load steps\n", what.c_str(), iterations, load_steps);
  }
};

BeamAxis along_x(double length) { return BeamAxis::straight({0, 0, 0}, {length, 0, 0}, {0, 1, 0}); }

/// A rod without stretch or shear, but for what the element needs: EA L²/EI = `slender`.
BeamSection rod(double slender) {
  return BeamSection::diagonal({slender, slender, slender, 1, 1, 1}, 1, {2 / slender, 1 / slender, 1 / slender});
}

TEST(BeamStatics, AMomentRollsItUpExactlyWithEightElements) {
  for (const double turns : {0.25, 0.5, 1.0, 1.5}) {
    const double a = 2 * M_PI * turns;
    Cantilever c(along_x(1), rod(1e4), 8, torque({0, 0, a}));
    c.solve(std::max(1, static_cast<int>(4 * turns)));
    c.report("roll-up by " + std::to_string(turns) + " turns");
    expect_below("roll-up, place of the tip", (c.tip().p - Vector3(std::sin(a) / a, (1 - std::cos(a)) / a, 0)).norm(),
                 1e-9);
    expect_below("roll-up, turn of the tip", (c.tip().R - rotation_about({0, 0, 1}, a)).norm(), 1e-9);
  }
}

TEST(BeamStatics, ElasticaConvergesWithOrderTwo) {
  const auto file = data("S02_elastica.json");
  for (const auto& row : file["table"]) {
    const double alpha = row["alpha"];
    const auto& shearable = row["shearable"];
    const Vector3 exact(shearable["tip_x"], shearable["tip_y"], shearable["tip_angle"]);
    Vector3 tips[3];
    for (int i = 0; i < 3; ++i) {
      const int elements = 20 << i;
      // EA L²/EI = 2500, GA L²/EI = 1000
      Cantilever c(along_x(1), BeamSection::diagonal({2500, 1000, 1000, 1, 1, 1}, 1, {2e-3, 1e-3, 1e-3}), elements,
                   force({0, alpha, 0}));
      c.solve();
      c.report("elastica, P L²/EI = " + std::to_string(alpha) + ", " + std::to_string(elements) + " elements");
      tips[i] << c.tip().p.head<2>(), std::atan2(c.tip().R(1, 0), c.tip().R(0, 0));
    }
    const double order = std::log2((tips[0] - exact).norm() / (tips[1] - exact).norm());
    expect_below("elastica, order below 2 by", std::abs(order - 2), 0.1);
    expect_below("elastica, error with 20 elements", (tips[0] - exact).norm(), 2e-3);
    const Vector3 first = (4 * tips[1] - tips[0]) / 3, second = (4 * tips[2] - tips[1]) / 3;
    expect_below("elastica, extrapolated twice", ((16 * second - first) / 15 - exact).norm(), 1e-9);
  }
}

TEST(BeamStatics, BendOf45DegreesAgrees) {
  const auto reference = data("S05_bend45.json")["reference"];
  const BeamSection section = BeamSection::diagonal(
      {1e7, 5e6, 5e6, 8.333333333333334e5, 8.333333333333334e5, 8.333333333333334e5}, 1, {1.0 / 6, 1.0 / 12, 1.0 / 12});
  // The clamp's tangent is +y, its axis 2 is -x: the arc bends about axis 3, towards +x.
  Matrix3 axes;
  axes << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const BeamAxis arc = BeamAxis::curved({Vector3::Zero(), axes}, {0, 0, -0.01}, 100 * M_PI / 4);
  for (const int load : {300, 450, 600}) {
    const auto& u = reference["shear factor 1, P=" + std::to_string(load)]["u_tip"];
    const Vector3 exact(u[0], u[1], u[2]), drawn = arc.pose(arc.length).position;
    Vector3 tips[2];
    for (int i = 0; i < 2; ++i) {
      Cantilever c(arc, section, 16 << i, force({0, 0, 1.0 * load}));
      c.solve();
      c.report("45 degree bend, " + std::to_string(load));
      tips[i] = c.tip().p - drawn;
    }
    expect_below("45 degree bend, 16 elements, of the tip's way", (tips[0] - exact).norm() / exact.norm(), 2e-3);
    expect_below("45 degree bend, extrapolated", ((4 * tips[1] - tips[0]) / 3 - exact).norm() / exact.norm(), 1e-6);
  }
}

TEST(BeamStatics, PrincetonBeamAgrees) {
  const auto file = data("S07_princeton_extended.json");
  for (const auto& [name, set] : file["sets"].items()) {
    const double h = set["height"], b = set["thickness"], k = set["shear_factor"], L = set["L"];
    BeamSection section = BeamSection::rectangle(h, b, {set["E"], set["nu"], 2700});
    expect_below("Princeton beam, torsion constant",
                 std::abs(section.stiffness(3, 3) * 2 * (1 + set["nu"].get<double>()) /
                              (set["E"].get<double>() * set["torsion_constant"].get<double>()) -
                          1),
                 1e-9);
    for (int i = 1; i <= 2; ++i)
      section.stiffness(i, i) *= k / (10 * (1 + set["nu"].get<double>()) / (12 + 11 * set["nu"].get<double>()));
    for (const auto& row : set["rows"]) {
      const double F = row[0], beta = row[1].get<double>() * M_PI / 180;
      if (row[1] != 0 && row[1] != 45 && row[1] != 75) continue;
      Vector3 tips[2];
      for (int i = 0; i < 2; ++i) {
        Cantilever c(along_x(L), section, 10 << i, force({0, -F * std::cos(beta), F * std::sin(beta)}));
        c.solve();
        if (i == 0) c.report("Princeton beam");
        tips[i] = c.tip().p - Vector3(L, 0, 0);
      }
      const Vector3 exact(row[2], row[3], row[4]);
      expect_below("Princeton beam, 10 elements", (tips[0] - exact).norm() / exact.norm(), 5e-3);
      expect_below("Princeton beam, extrapolated", ((4 * tips[1] - tips[0]) / 3 - exact).norm() / exact.norm(), 1e-6);
    }
  }
}

/// Four elements err alike whatever the thickness: nothing locks.
TEST(BeamStatics, DoesNotLock) {
  std::vector<double> share;
  for (const double ratio : {10.0, 100.0, 1000.0, 10000.0}) {
    const BeamSection section = BeamSection::rectangle(1 / ratio, 1 / ratio, {1e9, 0.3, 1000});
    const double EI = section.stiffness(5, 5), GA = section.stiffness(1, 1), P = 1e-3 * EI;
    Cantilever c(along_x(1), section, 4, force({0, P, 0}));
    c.solve();
    c.report("length over thickness " + std::to_string(ratio));
    share.push_back(c.tip().p[1] / (P / (3 * EI) + P / GA));
    expect_below("four elements, linear deflection", std::abs(share.back() - (1 - 1.0 / 64)), 2e-4);
  }
  for (const double s : share) expect_below("four elements, against the thickest", std::abs(s / share[0] - 1), 0.01);
}

}  // namespace
}  // namespace lithe::test::beam_statics_test
