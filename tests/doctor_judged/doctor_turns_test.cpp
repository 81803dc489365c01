#include <gtest/gtest.h>

#include "engine/observe/sensors.h"
#include "joints/revolute_joint.h"
#include "tests/doctor_judged/judged_scene.h"

namespace lithe::test::doctor_turns_test {
namespace {

/// A rotor that turns at 100 rad/s for 2 s, by steps; its angle or its speed is watched.
Diagnosis spin(double step, bool watches_angle) {
  return examine(
      {{.name = "rotor",
        .duration = 2,
        .gravity = {0, 0, 0},
        .draw = [&](SystemGraph& graph) -> std::vector<Sensor> {
          auto& rotor = graph.add<RigidBody>("rotor", {.inertia = {0.1, 0.1, 0.2}, .angular_velocity = {0, 0, 100}});
          auto& shaft = tie<RevoluteJoint>(graph, "shaft", graph.ground(), rotor, {0, 0, 0}, kUp);
          if (watches_angle) return {coordinate(shaft.angle(), "turned")};
          return {coordinate_rate(shaft.angle(), "speed")};
        }},
       "generalized-alpha index 3, fixed step",
       step});
}

// A step of 0.1 s turns by 10 rad, of which 10 - 4π are counted: two turns are lost, twenty times.
TEST(DoctorOfTurns, CountsThoseThatLongStepsLose) {
  const Diagnosis diagnosis = spin(0.1, true);
  ASSERT_FALSE(diagnosis.findings.empty());
  const Finding& first = diagnosis.findings.front();
  EXPECT_EQ(first.cause, Cause::lost_turns) << diagnosis.text();
  EXPECT_TRUE(first.alarm);
  for (const char* part : {"'shaft'", "40 turns are lost", "'turned'", "0.1 s"})
    EXPECT_NE(first.what.find(part), std::string::npos) << part << " in: " << first.what;
  EXPECT_NE(first.fix.find("0.0314 s"), std::string::npos) << first.fix;
}

TEST(DoctorOfTurns, IsCalmWhereStepsAreShortOrNothingReadsTheTurns) {
  EXPECT_TRUE(spin(0.01, true).findings.empty()) << spin(0.01, true).text();
  EXPECT_TRUE(spin(0.1, false).findings.empty()) << spin(0.1, false).text();
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
