#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engine/observe/sensors.h"
#include "engine/run/simulation.h"
#include "integrators/generalized_alpha.h"
#include "joints/revolute_joint.h"
#include "tests/doctor_judged/judged_scene.h"

namespace lithe::test::doctor_turns_test {
namespace {

constexpr double kSpeed = 100, kDuration = 2;  // rad/s, s

/// A rotor at constant speed; its angle or its speed is watched.
StudyScene rotor(bool watches_angle) {
  return {
      .name = "rotor",
      .duration = kDuration,
      .gravity = {0, 0, 0},
      .draw = [watches_angle](SystemGraph& graph) -> std::vector<Sensor> {
        auto& body = graph.add<RigidBody>("rotor", {.inertia = {0.1, 0.1, 0.2}, .angular_velocity = {0, 0, kSpeed}});
        auto& shaft = tie<RevoluteJoint>(graph, "shaft", graph.ground(), body, {0, 0, 0}, kUp);
        if (watches_angle) return {coordinate(shaft.angle(), "turned")};
        return {coordinate_rate(shaft.angle(), "speed")};
      }};
}

Diagnosis spin(double step, bool watches_angle) {
  return examine({rotor(watches_angle), "generalized-alpha index 3, fixed step", step});
}

// What the same run counts, beside speed times duration.
TEST(DoctorOfTurns, CountsThoseThatLongStepsLose) {
  SystemGraph graph{{.gravity = {0, 0, 0}}};
  const std::vector<Sensor> sensors = rotor(true).draw(graph);
  const System system = assemble(graph);
  State state = system.initial_state();
  GeneralizedAlpha integrator{{.step = 0.05}};
  Simulation simulation{system, integrator};
  simulation.run(state, kDuration);
  Snapshot end(system, state);
  const double lost = (kSpeed * kDuration - sensors.front().value(end)) / (2 * std::numbers::pi);
  EXPECT_NEAR(lost, std::round(lost), 1e-6);
  ASSERT_GT(std::round(lost), 1);

  const Diagnosis diagnosis = spin(0.05, true);
  ASSERT_FALSE(diagnosis.findings.empty());
  const Finding& first = diagnosis.findings.front();
  EXPECT_EQ(first.cause, Cause::lost_turns) << diagnosis.text();
  EXPECT_TRUE(first.alarm);
  const std::string turns = " " + std::to_string(std::lround(lost)) + " turns are lost";
  for (const std::string& part : {std::string("'shaft'"), turns, std::string("'turned'"), std::string("0.05 s")})
    EXPECT_NE(first.what.find(part), std::string::npos) << part << " in: " << first.what;
  EXPECT_NE(first.fix.find("0.0314 s"), std::string::npos) << first.fix;
}

TEST(DoctorOfTurns, IsCalmWhereStepsAreShortOrNothingReadsTheTurns) {
  EXPECT_TRUE(spin(0.01, true).findings.empty()) << spin(0.01, true).text();
  EXPECT_TRUE(spin(0.05, false).findings.empty()) << spin(0.05, false).text();
}

TEST(DoctorOnPages, GivesItsFindingsWithTheirCauses) {
  Diagnosis diagnosis;
  diagnosis.findings = {{Cause::open_joint, true, 0.9, "'pin' gapes", "close it"},
                        {Cause::redundant_rows, false, 0.5, "rows repeat", "drop them"}};
  const std::vector<PageFinding> listed = page_findings(diagnosis);
  ASSERT_EQ(listed.size(), 2u);
  EXPECT_EQ(listed[0].kind, "open joint");
  EXPECT_EQ(listed[0].text, "'pin' gapes");
  EXPECT_EQ(listed[0].fix, "close it");
  EXPECT_TRUE(listed[0].alarm);
  EXPECT_FALSE(listed[1].alarm);
}

}  // namespace
}  // namespace lithe::test::doctor_turns_test
