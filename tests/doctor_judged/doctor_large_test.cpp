#include <gtest/gtest.h>

#include "joints/revolute_joint.h"
#include "tests/doctor_judged/judged_scene.h"

namespace lithe::test::doctor_large_test {
namespace {

constexpr int kMechanisms = 60, kOdd = 37;  // of three bodies each: 1080 velocities

/// Parallelograms side by side, their cranks at 1 rad from the line of their feet; the odd one's at `odd`, the axis of
/// one of its pins tilted by `tilt`.
void draw_row(SystemGraph& graph, double odd, double tilt) {
  for (int i = 0; i < kMechanisms; ++i) {
    const std::string number = " " + std::to_string(i);
    const double angle = i == kOdd ? odd : 1;
    const Vector3 O{0, 0.1 * i, 0}, D = O + kAlong, crank = 0.3 * Vector3(std::cos(angle), 0, std::sin(angle));
    auto& left = add_rod(graph, "left crank" + number, O, O + crank);
    auto& right = add_rod(graph, "right crank" + number, D, D + crank);
    auto& bar = add_rod(graph, "bar" + number, O + crank, D + crank);
    tie<RevoluteJoint>(graph, "left foot" + number, graph.ground(), left, O);
    tie<RevoluteJoint>(graph, "right foot" + number, graph.ground(), right, D);
    tie<RevoluteJoint>(graph, "left pin" + number, left, bar, O + crank);
    tie<RevoluteJoint>(graph, "right pin" + number, right, bar, D + crank,
                       i == kOdd ? rotation_about(kAlong, tilt) * kAcross : kAcross);
  }
}

std::vector<Finding> look_over_row(double odd, double tilt) {
  SystemGraph graph;
  draw_row(graph, odd, tilt);
  const System system = assemble(graph);
  EXPECT_EQ(system.layout().v_count(), 1080);
  return look_over(system, system.initial_state());
}

TEST(DoctorOfLargeScenes, NamesTheOneMechanismThatIsDrawnFlat) {
  const std::vector<Finding> found = look_over_row(0, 0);
  ASSERT_FALSE(found.empty());
  const auto singular = std::ranges::find(found, Cause::singular_position, &Finding::cause);
  ASSERT_NE(singular, found.end());
  EXPECT_TRUE(singular->alarm);
  EXPECT_NE(singular->what.find(" 37'"), std::string::npos) << singular->what;
}

TEST(DoctorOfLargeScenes, NamesTheOneMechanismThatATiltedAxisLocks) {
  const std::vector<Finding> found = look_over_row(1, 0.2);
  const auto locked = std::ranges::find(found, Cause::locked, &Finding::cause);
  ASSERT_NE(locked, found.end());
  for (const char* name : {"'left crank 37'", "'right crank 37'", "'bar 37'", "'right pin 37' by 11.5 degrees"})
    EXPECT_NE(locked->what.find(name), std::string::npos) << locked->what;
  EXPECT_EQ(locked->what.find(" 36'"), std::string::npos) << locked->what;
}

TEST(DoctorOfLargeScenes, RaisesNoAlarmWhereAllMove) {
  for (const Finding& found : look_over_row(1, 0)) {
    EXPECT_FALSE(found.alarm) << found.what;
    EXPECT_NE(found.cause, Cause::locked) << found.what;
  }
}

}  // namespace
}  // namespace lithe::test::doctor_large_test
