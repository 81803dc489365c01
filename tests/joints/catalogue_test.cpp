#include <gtest/gtest.h>

#include "joints/constant_velocity_joint.h"
#include "joints/coordinate_coupling.h"
#include "joints/coordinate_drive.h"
#include "joints/cylindrical_joint.h"
#include "joints/gear_pair.h"
#include "joints/planar_joint.h"
#include "joints/point_on_line_joint.h"
#include "joints/point_on_plane_joint.h"
#include "joints/rack_and_pinion.h"
#include "joints/screw_joint.h"
#include "tests/support/joint_checks.h"
#include "tests/support/pairs.h"

namespace lithe::test::catalogue_test {
namespace {

/// Angles bend more than the difference formulas of the checks resolve to their usual 1e-9.
constexpr double kCurved = 1e-6, kFine = 3e-5;

/// The checks that every joint owes, between every pairing of bodies. `gap`: from marker A to B as drawn.
template <class T, class... Parameters>
void check_between_all_pairs(JointExpectation expected, const Vector3& gap, const Parameters&... parameters) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph;
    const std::vector<Marker> markers = pair.draw(graph, gap);
    auto& joint = graph.add<T>("joint", markers, parameters...);
    check_joint(graph, joint, expected);
  }
}

TEST(PlanarJoint, LeavesTwoSlidingsAndATurnFree) { check_between_all_pairs<PlanarJoint>({.rank = 3}, {0.2, -0.3, 0}); }
TEST(PointOnLineJoint, LeavesFourFreedoms) { check_between_all_pairs<PointOnLineJoint>({.rank = 2}, {0, 0, 0.4}); }
TEST(PointOnPlaneJoint, LeavesFiveFreedoms) { check_between_all_pairs<PointOnPlaneJoint>({.rank = 1}, {0.1, 0.2, 0}); }
TEST(ConstantVelocityJoint, LeavesTwoRotationsFree) {
  check_between_all_pairs<ConstantVelocityJoint>({.rank = 4}, {0, 0, 0});
}
TEST(ScrewJoint, LeavesOneScrewMotionFree) {
  check_between_all_pairs<ScrewJoint>({.rank = 5, .tolerance = kCurved, .difference = kFine}, {0, 0, 0.3},
                                      ScrewJoint::Parameters{.lead = 0.2});
}
TEST(RackAndPinion, TakesOneFreedom) {
  check_between_all_pairs<RackAndPinion>({.rank = 1, .tolerance = kCurved, .difference = kFine}, {0.3, -0.1, 0},
                                         RackAndPinion::Parameters{.radius = 0.1});
}
TEST(GearPair, TakesOneFreedom) {
  check_between_all_pairs<GearPair>({.rank = 1, .tolerance = kCurved, .difference = kFine}, {0.3, 0.4, 0},
                                    GearPair::Parameters{.radius_A = 0.2, .radius_B = 0.3});
  check_between_all_pairs<GearPair>({.rank = 1, .tolerance = kCurved, .difference = kFine}, {0.3, 0.4, 0},
                                    GearPair::Parameters{.radius_A = 0.7, .radius_B = -0.2});
}

template <class T>
void check_on_coordinate(JointCoordinate::Kind kind, int axis, const typename T::Parameters& parameters) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph;
    const std::vector<Marker> m = pair.draw(graph, {0.3, -0.2, 0.4});
    auto& joint = graph.add<T>("joint", {JointCoordinate{kind, m[0], m[1], axis}}, parameters);
    check_joint(graph, joint, {.rank = 1, .tolerance = kCurved, .difference = kFine});
  }
}

TEST(CoordinateDrive, PrescribesAnyCoordinate) {
  for (auto kind : {JointCoordinate::Kind::angle, JointCoordinate::Kind::bearing, JointCoordinate::Kind::displacement,
                    JointCoordinate::Kind::distance})
    for (int axis = 0; axis < 3; ++axis)
      check_on_coordinate<CoordinateDrive>(kind, axis, {.motion = harmonic(0.2, 3, 0.4, 0.3)});
}

TEST(CoordinateCoupling, TiesAnAngleToADisplacement) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph;
    const std::vector<Marker> m = pair.draw(graph, {0, 0, 0.4});
    const JointCoordinate angle{JointCoordinate::Kind::angle, m[0], m[1]},
        slide{JointCoordinate::Kind::displacement, m[0], m[1]};
    auto& joint = graph.add<CoordinateCoupling>("joint", {angle, -slide}, {.factors = {0.3, 2}});
    check_joint(graph, joint, {.rank = 1, .tolerance = kCurved, .difference = kFine});
  }
}

}  // namespace
}  // namespace lithe::test::catalogue_test
