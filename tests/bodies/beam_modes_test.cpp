#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bodies/beam/beam.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/user_force.h"
#include "joints/revolute_joint.h"
#include "tests/support/json_file.h"
#include "tests/support/methods.h"

/// Frequencies of beams, at rest and turning, against closed forms and tests/data/beams, which README.md there
/// explains.
namespace lithe::test::beam_modes_test {
namespace {

/// Frequencies (rad/s) in rising order: all, and those of modes that move along an axis of the world most.
struct Frequencies {
  std::vector<double> all, along[3];
  double nearest(double exact) const {
    return *std::min_element(all.begin(), all.end(),
                             [&](double a, double b) { return std::abs(a - exact) < std::abs(b - exact); });
  }
};

Frequencies frequencies(const System& system, const State& state, int mode_count) {
  Frequencies found;
  for (const Mode& mode : linearize(system, state, {.mode_count = mode_count}).modes) {
    if (mode.frequency() < 1e-3) continue;
    const double omega = 2 * M_PI * mode.frequency();
    Vector3 size = Vector3::Zero();
    for (const auto& body : system.layout().bodies())
      if (body.frame) size += mode.shape.segment<3>(body.v).cwiseAbs2();
    int axis = 0;
    size.maxCoeff(&axis);
    found.all.push_back(omega), found.along[axis].push_back(omega);
  }
  std::sort(found.all.begin(), found.all.end());
  for (auto& some : found.along) std::sort(some.begin(), some.end());
  return found;
}

/// From three meshes, each twice as fine as the one before: without the errors of second and fourth order.
double extrapolated(const double (&w)[3]) {
  const double first = (4 * w[1] - w[0]) / 3, second = (4 * w[2] - w[1]) / 3;
  return (16 * second - first) / 15;
}

/// On a drive that turns it at a steady rate about z.
struct Rotor {
  double hub, length, mass;  // m, m, kg/m
  BeamSection section;

  Frequencies at(double omega, int elements, int mode_count) const {
    const BeamAxis axis = BeamAxis::straight({hub, 0, 0}, {hub + length, 0, 0}, {0, 1, 0});
    const auto draw = [&](SystemGraph& graph, const Vector3& spin) {
      return &graph.add<Beam>("beam", {.axis = axis,
                                       .sections = {{0, section}},
                                       .elements = elements,
                                       .velocity = spin.cross(Vector3(hub, 0, 0)),
                                       .angular_velocity = spin});
    };
    // The stretch: at rest, under the centrifugal forces of the pieces at the nodes.
    SystemGraph still{{.gravity = Vector3::Zero()}}, turning{{.gravity = Vector3::Zero()}};
    Beam& loaded = *draw(still, Vector3::Zero());
    still.add<FixedJoint>("clamp", {still.ground().marker({hub, 0, 0}), loaded.marker(0)});
    for (int i = 0; i <= elements; ++i) {
      const double l = length / elements, inside = i == 0 ? l / 4 : i == elements ? -l / 4 : 0;
      const double m = mass * (inside == 0 ? l : l / 2);
      still.add<UserForce>("pull " + std::to_string(i), {loaded.marker(l * i, {inside, 0, 0})},
                           {[=](double, const MarkerView& at) {
                             return force({m * omega * omega * at.p[0], 0, 0});
                           }});
    }
    const System at_rest = assemble(still);
    const State stretched = find_equilibrium(at_rest, at_rest.initial_state()).state;

    Beam& beam = *draw(turning, {0, 0, omega});
    const Marker hub_marker = beam.marker(0, {-hub, 0, 0});
    auto& pin = turning.add<RevoluteJoint>("hub", {turning.ground().marker(), hub_marker});
    turning.add<CoordinateDrive>("drive", {pin.angle()}, {.motion = ramp(0, omega)});
    const System system = assemble(turning);
    State state = system.initial_state();
    state.q = stretched.q;
    for (const auto& body : system.layout().bodies())
      if (body.frame) state.v.segment<3>(body.v) = Vector3(0, 0, omega).cross(Vector3(state.q.segment<3>(body.q)));
    return frequencies(system, state, mode_count);
  }
};

/// All speeds of one hub, one set of modes.
void check_turning(const std::string& hub, const std::string& set) {
  const auto file = read_json(LITHE_TEST_DATA "/beams/D02b_rotating_timoshenko.json");
  const auto& c = file["cases"][hub];
  const double EA = c["EA"], GA = c["GA"], GJ = c["GJ"], EI = c["EI"], J = c["rhoI_bend"], other = c["rhoI_other"];
  // The lag set has the same bending, turned into the plane of rotation.
  const bool lag = set == "lag";
  const double beside = EI * other / J;
  const Rotor rotor{c["hub_radius"], c["L"], c["rhoA"],
                    BeamSection::diagonal({EA, GA, GA, GJ, lag ? beside : EI, lag ? EI : beside}, c["rhoA"],
                                          {J + other, lag ? other : J, lag ? J : other})};
  for (const auto& row : c["rows"]) {
    const double omega = row["Omega"];
    Frequencies meshes[3];
    for (int k = 0; k < 3; ++k) meshes[k] = rotor.at(omega, 8 << k, 60);
    for (const double exact : row[set]) {
      const std::string what = hub + ", " + set + " at " + std::to_string(omega) + " rad/s";
      double w[3];
      for (int k = 0; k < 3; ++k) w[k] = meshes[k].nearest(exact);
      expect_below(what + ", 8 elements", std::abs(w[0] / exact - 1), 0.06);
      if (omega == 0) {
        EXPECT_NEAR((w[0] - exact) / (w[1] - exact), 4, 0.05);
      }
      expect_below(what + ", extrapolated", std::abs(extrapolated(w) / exact - 1), omega < 800 ? 6e-6 : 2e-5);
    }
  }
}

TEST(BeamModes, FlapAndTorsionOfATurningBeam) { check_turning("timoshenko", "flap_torsion"); }
TEST(BeamModes, FlapAndTorsionOfATurningBeamOnAHub) { check_turning("timoshenko_hub", "flap_torsion"); }
TEST(BeamModes, LagOfATurningBeam) { check_turning("timoshenko", "lag"); }
TEST(BeamModes, LagOfATurningBeamOnAHub) { check_turning("timoshenko_hub", "lag"); }

/// Hardly any shear, stretch and rotary inertia, of length, mass and EI 1.
constexpr double kSlender = 1e7;
BeamSection slender(double EI2) {
  return BeamSection::diagonal({kSlender, kSlender, kSlender, 1, EI2, 1}, 1,
                               {2 / kSlender, 1 / kSlender, 1 / kSlender});
}

/// The reference is of flap; the frequencies of lag are those of flap less the speed, squared. The third, fourth and
/// fifth mode have waves of four to two elements on the coarsest mesh: there errors of higher order are left.
TEST(BeamModes, TurningSlenderBeam) {
  const double bounds[] = {2e-5, 1.5e-5, 2.5e-5, 8e-5, 3.2e-4};
  std::ifstream table(LITHE_TEST_DATA "/beams/D02a_rotating_euler_bernoulli.csv");
  std::string line;
  std::getline(table, line);
  int rows = 0;
  for (; std::getline(table, line); ++rows) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream numbers(line);
    double hub, eta, exact[5];
    numbers >> hub >> eta;
    for (double& mu : exact) numbers >> mu;
    Frequencies meshes[3];
    for (int k = 0; k < 3; ++k) meshes[k] = Rotor{hub, 1, 1, slender(1)}.at(eta, 8 << k, 12);
    for (int mode = 0; mode < 5; ++mode)
      for (const int axis : {1, 2}) {
        const double omega = axis == 2 ? exact[mode] : std::sqrt(exact[mode] * exact[mode] - eta * eta);
        double w[3];
        for (int k = 0; k < 3; ++k) w[k] = meshes[k].along[axis].at(mode);
        const std::string what = "slender, hub " + std::to_string(hub) + ", speed " + std::to_string(eta) + ", mode " +
                                 std::to_string(mode + 1) + (axis == 2 ? " of flap" : " of lag");
        expect_below(what, std::abs(extrapolated(w) / omega - 1), bounds[mode]);
      }
  }
  EXPECT_EQ(rows, 26);
}

/// What shear and rotary inertia leave is up to 2.2e-5.
TEST(BeamModes, FreeBeamHasSixRigidMotionsAndTheFrequenciesOfEulerAndBernoulli) {
  const double exact[] = {4.730040744862704, 7.853204624095838, 10.99560783800167};
  Frequencies meshes[3];
  for (int k = 0; k < 3; ++k) {
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    graph.add<Beam>("beam", {.axis = BeamAxis::straight({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                             .sections = {{0, slender(4)}},
                             .elements = 8 << k});
    const System system = assemble(graph);
    const State state = system.initial_state();
    const VectorX undamped = linearize(system, state).undamped;
    EXPECT_LT(std::abs(undamped[5]), 1e-4);
    EXPECT_NEAR(undamped[6] / std::pow(exact[0], 4), 1, 5e-4);
    meshes[k] = frequencies(system, state, 20);
  }
  for (const int axis : {1, 2})
    for (const double wave : exact) {
      const double omega = wave * wave * (axis == 1 ? 1 : 2);
      double w[3];
      for (int k = 0; k < 3; ++k) w[k] = meshes[k].nearest(omega);
      expect_below("free beam, " + std::to_string(omega) + " rad/s", std::abs(extrapolated(w) / omega - 1), 7e-5);
    }
}

}  // namespace
}  // namespace lithe::test::beam_modes_test
