#include <gtest/gtest.h>

#include "engine/model/force_element.h"
#include "joints/constant_velocity_joint.h"
#include "joints/coordinate_coupling.h"
#include "joints/coordinate_drive.h"
#include "joints/cylindrical_joint.h"
#include "joints/distance_joint.h"
#include "joints/fixed_joint.h"
#include "joints/forces/bushing.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/forces/spring_damper.h"
#include "joints/gear_pair.h"
#include "joints/orientation_joint.h"
#include "joints/parallel_axes_joint.h"
#include "joints/perpendicular_axes_joint.h"
#include "joints/planar_joint.h"
#include "joints/planar_pin_joint.h"
#include "joints/point_on_line_joint.h"
#include "joints/point_on_plane_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/rack_and_pinion.h"
#include "joints/revolute_joint.h"
#include "joints/revolute_spherical_joint.h"
#include "joints/rolling_disc.h"
#include "joints/screw_joint.h"
#include "joints/spherical_joint.h"
#include "joints/three_node_fixation.h"
#include "joints/universal_joint.h"

/// The rows and reactions that the pages of docs/site/catalogue tell, against the code, at random poses.
namespace lithe::test::catalogue_equations_test {
namespace {

/// Two (or four) markers that stand and move anywhere.
class CatalogueEquations : public testing::Test {
 protected:
  CatalogueEquations() {
    std::srand(3);
    for (MarkerKinematics* k : {&a_, &b_, &c_, &d_}) {
      k->p = Vector3::Random(), k->R = rotation_exp(Vector3::Random());
      k->v = Vector3::Random(), k->w = Vector3::Random();
    }
  }
  const Vector3 d() const { return B.p - A.p; }

  template <class T>
  void evaluate(const T& joint, int markers = 2) {
    rows_.emplace(markers);
    joint.evaluate(0, {all_.data(), static_cast<std::size_t>(markers)}, *rows_);
    l = VectorX::Random(rows_->count());
  }
  double g(int row) const { return rows_->residual(row); }
  double bias(int row) const { return rows_->bias(row); }
  Vector3 g3(int row) const { return {g(row), g(row + 1), g(row + 2)}; }
  Vector3 l3(int row) const { return l.segment<3>(row); }
  double rate(int row) const {  // ġ without ∂g/∂t
    double sum = 0;
    for (const MarkerView& m : {A, B})
      sum += rows_->wrench(row, m.index).force.dot(m.v) + rows_->wrench(row, m.index).torque.dot(m.w);
    return sum;
  }
  /// -Σ W λ
  void expect_reaction(int marker, const Vector3& force, const Vector3& moment) const {
    Vector3 F = Vector3::Zero(), T = Vector3::Zero();
    for (int i = 0; i < rows_->count(); ++i)
      F -= l[i] * rows_->wrench(i, marker).force, T -= l[i] * rows_->wrench(i, marker).torque;
    EXPECT_LT((F - force).norm(), 1e-13) << "force on marker " << marker;
    EXPECT_LT((T - moment).norm(), 1e-13) << "moment on marker " << marker;
  }
  void expect_near(const Vector3& x, const Vector3& y) const { EXPECT_LT((x - y).norm(), 1e-13); }
  /// All z axes alike, the other markers around A.
  void draw(double angle) {
    a_.p = Vector3(angle, 1, 2);
    a_.R = rotation_exp(Vector3(0.3, angle, 1));
    const double length = angle < 0 ? 0.5 : 0.501;  // gears of 0.2 and 0.3 m mesh
    for (MarkerKinematics* k : {&b_, &c_, &d_}) {
      angle += 0.2;
      k->R = a_.R * rotation_about({0, 0, 1}, angle);
      k->p = a_.p + length * a_.R * Vector3(std::cos(angle), std::sin(angle), 0);
    }
  }
  /// What measures the drawing measures that of the last assembly, whatever was drawn before: a graph may be assembled
  /// as often as one likes, a joint of a simplified graph is that of the whole one. To the bit: nothing is left over.
  template <class Make>
  void expect_measured_anew(const Make& make, int markers = 2) {
    auto fresh = make(), used = make();
    using T = decltype(fresh);
    const std::span<const MarkerView> drawn(all_.data(), static_cast<std::size_t>(markers));
    draw(0.3);
    used.initialize(drawn);
    draw(-0.7);
    used.initialize(drawn);
    used.initialize(drawn);
    fresh.initialize(drawn);
    draw(0.9);
    std::vector<double> values[2];
    for (const T* element : {&fresh, &used}) {
      std::vector<double>& of = values[element == &used];
      if constexpr (std::is_base_of_v<Constraint, T>) {
        ConstraintRows rows(markers);
        element->evaluate(0, drawn, rows);
        for (int i = 0; i < rows.count(); ++i) of.insert(of.end(), {rows.residual(i), rows.bias(i)});
      } else {
        ForceRows rows(markers);
        element->evaluate(0, drawn, rows);
        of.push_back(rows.tension(0));
      }
    }
    EXPECT_EQ(values[0], values[1]) << typeid(T).name();
    EXPECT_GT(Eigen::Map<VectorX>(values[0].data(), static_cast<int>(values[0].size())).norm(), 1e-3);
  }
  void turn_B_about_common_z(double angle) { b_.R = a_.R * rotation_about({0, 0, 1}, angle); }

  MarkerKinematics a_, b_, c_, d_;
  const MarkerView A{a_, 0}, B{b_, 1};
  const std::vector<MarkerView> all_{A, B, {c_, 2}, {d_, 3}};
  const Vector3 none = Vector3::Zero();
  VectorX l;  // multipliers

 private:
  std::optional<ConstraintRows> rows_;
};

TEST_F(CatalogueEquations, OfJointsThatHoldAPoint) {
  evaluate(SphericalJoint());
  expect_reaction(0, l3(0), none);
  expect_reaction(1, -l3(0), none);
  evaluate(RevoluteJoint());
  expect_near(g3(2), {d().z(), A.x().dot(B.z()), A.y().dot(B.z())});
  expect_reaction(1, -l3(0), l[3] * A.x().cross(B.z()) + l[4] * A.y().cross(B.z()));
  evaluate(UniversalJoint());
  EXPECT_NEAR(g(3), A.x().dot(B.y()), 1e-15);
  expect_reaction(1, -l3(0), l[3] * A.x().cross(B.y()));
  evaluate(ConstantVelocityJoint());
  EXPECT_NEAR(g(3), A.y().dot(B.x()) - A.x().dot(B.y()), 1e-15);
  expect_reaction(1, -l3(0), l[3] * (A.y().cross(B.x()) - A.x().cross(B.y())));
  evaluate(FixedJoint());
  expect_reaction(1, -l3(0), l[3] * A.x().cross(B.y()) + l[4] * A.y().cross(B.z()) + l[5] * A.z().cross(B.x()));
}

TEST_F(CatalogueEquations, OfJointsThatGuide) {
  evaluate(CylindricalJoint());
  const Vector3 turning = l[0] * A.x().cross(B.z()) + l[1] * A.y().cross(B.z());
  expect_reaction(1, -l[2] * A.x() - l[3] * A.y(), turning);
  expect_reaction(0, l[2] * A.x() + l[3] * A.y(), -turning - l[2] * A.x().cross(d()) - l[3] * A.y().cross(d()));
  evaluate(PrismaticJoint());
  expect_near(g3(0), {A.x().dot(B.y()), A.y().dot(B.z()), A.z().dot(B.x())});
  expect_reaction(1, -l[3] * A.x() - l[4] * A.y(),
                  l[0] * A.x().cross(B.y()) + l[1] * A.y().cross(B.z()) + l[2] * A.z().cross(B.x()));
  evaluate(PlanarJoint());
  expect_reaction(1, -l[2] * A.z(), l[0] * A.x().cross(B.z()) + l[1] * A.y().cross(B.z()));
  evaluate(PointOnLineJoint());
  expect_reaction(1, -l[0] * A.x() - l[1] * A.y(), none);
  expect_reaction(0, l[0] * A.x() + l[1] * A.y(), -l[0] * A.x().cross(d()) - l[1] * A.y().cross(d()));
  evaluate(PointOnPlaneJoint());
  expect_reaction(1, -l[0] * A.z(), none);
  expect_reaction(0, l[0] * A.z(), -l[0] * A.z().cross(d()));
}

TEST_F(CatalogueEquations, OfJointsOfAFewRows) {
  evaluate(PlanarPinJoint());
  EXPECT_NEAR(g(0), A.x().dot(d()), 1e-15);
  EXPECT_NEAR(g(1), A.y().dot(d()), 1e-15);
  expect_reaction(1, -l[0] * A.x() - l[1] * A.y(), none);
  expect_reaction(0, l[0] * A.x() + l[1] * A.y(), -l[0] * A.x().cross(d()) - l[1] * A.y().cross(d()));
  evaluate(ParallelAxesJoint());
  EXPECT_NEAR(g(0), A.x().dot(B.z()), 1e-15);
  EXPECT_NEAR(g(1), A.y().dot(B.z()), 1e-15);
  const Vector3 tilting = l[0] * A.x().cross(B.z()) + l[1] * A.y().cross(B.z());
  expect_reaction(1, none, tilting);
  expect_reaction(0, none, -tilting);
  evaluate(PerpendicularAxesJoint());
  EXPECT_NEAR(g(0), A.z().dot(B.z()), 1e-15);
  expect_reaction(1, none, l[0] * A.z().cross(B.z()));
  expect_reaction(0, none, -l[0] * A.z().cross(B.z()));
  evaluate(OrientationJoint());
  expect_near(g3(0), {A.x().dot(B.y()), A.y().dot(B.z()), A.z().dot(B.x())});
  const Vector3 turning = l[0] * A.x().cross(B.y()) + l[1] * A.y().cross(B.z()) + l[2] * A.z().cross(B.x());
  expect_reaction(1, none, turning);
  expect_reaction(0, none, -turning);
  evaluate(RevoluteSphericalJoint({.length = 0.4}));
  EXPECT_NEAR(g(0), 0.5 * (d().squaredNorm() - 0.16), 1e-15);
  EXPECT_NEAR(g(1), A.z().dot(d()), 1e-15);
  EXPECT_NEAR(bias(0), (B.v - A.v).squaredNorm(), 1e-14);
  expect_reaction(1, -l[0] * d() - l[1] * A.z(), none);
  expect_reaction(0, l[0] * d() + l[1] * A.z(), -l[1] * A.z().cross(d()));
}

TEST_F(CatalogueEquations, OfClosedJointsInTheAxesOfA) {
  turn_B_about_common_z(0);
  evaluate(RevoluteJoint());
  expect_reaction(1, -l3(0), l[4] * A.x() - l[3] * A.y());
  evaluate(FixedJoint());
  expect_reaction(1, -l3(0), l[4] * A.x() + l[5] * A.y() + l[3] * A.z());
  evaluate(OrientationJoint());
  expect_reaction(1, none, l[1] * A.x() + l[2] * A.y() + l[0] * A.z());
  turn_B_about_common_z(0.8);
  evaluate(ScrewJoint({.lead = 0.7}));
  EXPECT_NEAR(g(4), A.z().dot(d()) - 0.7 / (2 * M_PI) * 0.8, 1e-14);
  expect_reaction(1, -l[2] * A.x() - l[3] * A.y() - l[4] * A.z(),
                  l[0] * A.x().cross(B.z()) + l[1] * A.y().cross(B.z()) + l[4] * 0.7 / (2 * M_PI) * A.z());
}

TEST_F(CatalogueEquations, OfDistancesAndHeldNodes) {
  evaluate(DistanceJoint({.length = 0.4}));
  EXPECT_NEAR(g(0), 0.5 * (d().squaredNorm() - 0.16), 1e-15);
  EXPECT_NEAR(bias(0), (B.v - A.v).squaredNorm(), 1e-14);
  expect_reaction(1, -l[0] * d(), none);
  evaluate(DistanceJoint({.length_law = ramp(0.4, 2)}));
  EXPECT_NEAR(bias(0), (B.v - A.v).squaredNorm() - 4, 1e-14);
  ThreeNodeFixation clamp;
  clamp.initialize(all_);
  const Vector3 c = A.R.transpose() * d();
  a_.R = rotation_exp(Vector3::Random());
  evaluate(clamp, 4);
  expect_near(g3(0), A.R.transpose() * d() - c);
  // (d/dt)² of x_A · d with constant v and ω: 2 ω × x_A · ḋ + ω × (ω × x_A) · d.
  EXPECT_NEAR(bias(0), 2 * A.w.cross(A.x()).dot(B.v - A.v) + A.w.cross(A.w.cross(A.x())).dot(d()), 1e-14);
}

TEST_F(CatalogueEquations, OfTransmissionsWhoseForceActsInThePitchPoint) {
  turn_B_about_common_z(-0.4);
  evaluate(RackAndPinion({.radius = 0.3}));
  EXPECT_NEAR(g(0), B.x().dot(A.p - B.p) + 0.3 * 0.4, 1e-14);
  expect_reaction(0, -l[0] * B.x(), -l[0] * 0.3 * B.z());
  expect_reaction(1, l[0] * B.x(), (A.p - 0.3 * B.y() - B.p).cross(l[0] * B.x()));
  b_.p = a_.p + 0.5 * A.R * Vector3(0.6, 0.8, 0);
  evaluate(GearPair({.radius_A = 0.2, .radius_B = 0.3}));
  const Vector3 back = B.R.transpose() * -d(), t = A.z().cross(d()).normalized();
  EXPECT_NEAR(g(0), 0.2 * std::atan2(0.8, 0.6) + 0.3 * std::atan2(back.y(), back.x()), 1e-14);
  expect_reaction(0, l[0] * t, l[0] * 0.2 * A.z());
  expect_reaction(1, -l[0] * t, l[0] * 0.3 * A.z());
}

TEST_F(CatalogueEquations, OfTheRollingDiscAtItsPointOfContact) {
  evaluate(RollingDisc({.radius = 0.3}));
  const Vector3 n = A.z(), a = B.z(), u = (n - n.dot(a) * a).normalized(), c = B.p - 0.3 * u;
  EXPECT_NEAR(g(0), n.dot(d()) - 0.3 * std::sqrt(1 - n.dot(a) * n.dot(a)), 1e-14);
  const Vector3 F = -(l[0] * n + l[1] * A.x() + l[2] * A.y());
  expect_reaction(1, F, (c - B.p).cross(F));
  const Vector3 slip = B.v - B.w.cross(0.3 * u) - A.v - A.w.cross(c - A.p);
  EXPECT_NEAR(rate(1), A.x().dot(slip), 1e-14);
  EXPECT_NEAR(rate(2), A.y().dot(slip), 1e-14);
}

TEST_F(CatalogueEquations, OfADriveAlongAndAboutZ) {
  evaluate(CoordinateDrive(CoordinateSet({displacement_between({}, {})}), {.motion = ramp(0.2, 3)}));
  EXPECT_NEAR(g(0), A.z().dot(d()) - 0.2, 1e-15);
  expect_reaction(1, -l[0] * A.z(), none);
  expect_reaction(0, l[0] * A.z(), -l[0] * A.z().cross(d()));
  turn_B_about_common_z(0.7);
  evaluate(CoordinateDrive(CoordinateSet({angle_between({}, {})}), {.motion = constant(0.5)}));
  EXPECT_NEAR(g(0), 0.2, 1e-15);
  expect_reaction(1, none, -l[0] * A.z());
}

TEST_F(CatalogueEquations, OfSpringsAndBushings) {
  ForceRows spring(2);
  SpringDamper({.stiffness = 7, .damping = 2, .natural_length = 0.3, .preload = 0.5})
      .evaluate(0, {&all_[0], 2}, spring);
  const Vector3 n = d().normalized();
  EXPECT_NEAR(spring.tension(0), 7 * (d().norm() - 0.3) + 2 * n.dot(B.v - A.v) + 0.5, 1e-14);
  expect_near(spring.wrench(0, 1).force, n);

  const Matrix6 half = Matrix6::Random(), K = half * half.transpose(), D = 0.3 * Matrix6::Identity();
  ForceRows bushing(2);
  Bushing({.stiffness = K, .damping = D, .relaxed_as_drawn = false}).evaluate(0, {&all_[0], 2}, bushing);
  const Vector3 turn = rotation_log(A.R.transpose() * B.R);
  Vector6 e, e_dot;
  e << A.R.transpose() * d(), turn;
  e_dot << A.R.transpose() * (B.v - A.v - A.w.cross(d())),
      left_jacobian(turn).inverse() * (A.R.transpose() * (B.w - A.w));
  double power = 0;
  for (int row = 0; row < 6; ++row)
    for (const MarkerView& m : {A, B}) {
      const Wrench& W = bushing.wrench(row, m.index);
      power += bushing.tension(row) * (W.force.dot(m.v) + W.torque.dot(m.w));
    }
  EXPECT_NEAR(power, (K * e + D * e_dot).dot(e_dot), 1e-12);
  EXPECT_NEAR(bushing.energy(), 0.5 * e.dot(K * e), 1e-12);
}

TEST_F(CatalogueEquations, OfWhatMeasuresItsDrawingForgetTheDrawingBefore) {
  expect_measured_anew([] { return DistanceJoint({}); });
  expect_measured_anew([] { return RevoluteSphericalJoint({}); });
  expect_measured_anew([] { return ScrewJoint({.lead = 0.7}); });
  expect_measured_anew([] { return RackAndPinion({.radius = 0.3}); });
  expect_measured_anew([] { return GearPair({.radius_A = 0.2, .radius_B = 0.3}); });
  expect_measured_anew([] { return ThreeNodeFixation(); }, 4);
  const CoordinateSet turn({angle_between({}, {})}), both({angle_between({}, {}), displacement_between({}, {}, 0)});
  expect_measured_anew([&] { return CoordinateCoupling(both, {.factors = {1, 2.5}}); }, 4);
  expect_measured_anew([&] { return CoordinateSpring(turn, {.stiffness = 2}); });
  expect_measured_anew([] { return SpringDamper({.stiffness = 7}); });
  expect_measured_anew([] { return Bushing({.stiffness = Matrix6::Identity()}); });
}

}  // namespace
}  // namespace lithe::test::catalogue_equations_test
