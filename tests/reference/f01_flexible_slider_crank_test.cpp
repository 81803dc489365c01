// F01: planar slider-crank with an elastic rod (IVP Test Set "crank", Simeon 1996); threshold 4 digits at 0.1 s,
// good 6.
#include <gtest/gtest.h>

#include <numbers>

#include "bodies/flexible/flexible_body.h"
#include "engine/assembly/batch_of.h"
#include "engine/observe/sensors.h"
#include "engine/observe/snapshot.h"
#include "integrators/explicit_runge_kutta.h"
#include "joints/coordinate_drive.h"
#include "joints/point_on_line_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/reference/benchmark.h"
#include "tests/reference/mechanism.h"

namespace lithe::test::f01_flexible_slider_crank_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kCrank = 0.15, kRod = 0.30, kSpeed = 150;
constexpr double kYoung = 2e11, kSide = 0.008, kDensity = 7870, kArea = kSide * kSide, kRodMass = 0.151104;

/// The rod's axial mass: as the Test Set has it, or that of a quadratic element, 15 times less.
enum class AxialMass { published, consistent };

/// w = q1 sin(pi x/L) + q2 sin(2 pi x/L) across, u quadratic along with q3 in the middle and q4 at the end; chord
/// frame.
std::shared_ptr<const ModalBasis> rod_basis(AxialMass axial) {
  const double slender = kSide * kSide / (kRod * kRod);
  MatrixX M = MatrixX::Zero(4, 4), K = MatrixX::Zero(4, 4);
  M(0, 0) = M(1, 1) = 0.5;
  M.bottomRightCorner<2, 2>() << 8, 1, 1, 2;
  if (axial == AxialMass::consistent) M.bottomRightCorner<2, 2>() /= 15;
  K(0, 0) = std::pow(kPi, 4) / 24 * slender;
  K(1, 1) = 2 * std::pow(kPi, 4) / 3 * slender;
  K.bottomRightCorner<2, 2>() << 16.0 / 3, -8.0 / 3, -8.0 / 3, 7.0 / 3;
  auto basis = std::make_shared<ModalBasis>();
  basis->name = "two sines and a parabola";
  basis->modal_mass = (kDensity * kArea * kRod * M).sparseView();
  basis->stiffness = (kYoung * kArea / kRod * K).sparseView();
  return basis;
}

/// ∫ over the rod; what leaves the plane is zero.
InertiaIntegrals rod_integrals(const ModalBasis& basis) {
  const double m = kDensity * kArea * kRod;
  InertiaIntegrals I;
  I.mass = kRodMass;
  I.s0 = {kRodMass * kRod / 2, 0, 0};
  I.Ct = Matrix3X::Zero(3, 4);
  I.Ct.row(0) << 0, 0, m * 2 / 3, m / 6;  // ∫u
  I.Ct.row(1) << m * 2 / kPi, 0, 0, 0;    // ∫w
  I.J0 << 1e-5, 0.0045339259, 0.0045339259, 0, 0, 0;
  I.J1 = Matrix6X::Zero(6, 4);
  I.J1.row(2) << 0, 0, 2 * kRod * m / 3, 2 * kRod * m / 6;  // 2 ∫x u
  I.C0 = Matrix3X::Zero(3, 4);
  I.C0.row(2) << kRod * m / kPi, -kRod * m / (2 * kPi), 0, 0;  // ∫x w
  I.Mff = MatrixX(basis.modal_mass);
  I.J2 = MatrixX::Zero(24, 4);
  for (int k = 0; k < 4; ++k) I.J2.row(6 * k + 2) = I.Mff.row(k);
  Eigen::Matrix4d B = Eigen::Matrix4d::Zero();  // -∫w u, skew
  B(0, 2) = -16 / std::pow(kPi, 3);
  B(0, 3) = 8 / std::pow(kPi, 3) - 1 / kPi;
  B(1, 3) = 1 / (2 * kPi);
  I.C1 = MatrixX::Zero(12, 4);
  for (int k = 0; k < 4; ++k) I.C1.row(3 * k + 2) = m * (B - B.transpose()).row(k);
  return I;
}

/// The forces on q1 ... q4 of stretch by bending and of damping, at markers that show the coordinates: the frame, one
/// at (q1, q2, q3), one at (q4, 0, 0). What they do to the frame is taken off it again.
class StretchByBending final : public Force</*markers=*/3, /*rows=*/0> {
 public:
  void evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const override {
    const MarkerView &frame = markers[0], &three = markers[1], &one = markers[2];
    const Vector3 d = three.p - frame.p, e = one.p - frame.p;
    const Vector3 q123 = frame.R.transpose() * d, rate = frame.R.transpose() * (three.v - frame.v - frame.w.cross(d));
    const double q1 = q123[0], q2 = q123[1], q3 = q123[2], q4 = frame.x().dot(e);
    const double q4_dot = frame.x().dot(one.v - frame.v - frame.w.cross(e));
    const double a = kYoung * kArea * kPi * kPi / (2 * kRod * kRod), k = 80 / (9 * kPi * kPi), s = -4 * q3 + 2 * q4;
    Vector3 f = -a * Vector3(q1 * q4 - k * q2 * s, 4 * q2 * q4 - k * q1 * s, 4 * k * q1 * q2);
    double f4 = -a * (0.5 * q1 * q1 + 2 * q2 * q2 - 2 * k * q1 * q2);
    f -= Vector3(5 * rate[0], 25 * rate[1], 0.5 * (230.8375455264791 * rate[2] - 262.6884879920526 * q4_dot));
    f4 -= 0.5 * (-262.6884879920526 * rate[2] + 421.7421837156818 * q4_dot);
    const Vector3 F = frame.R * f, F4 = f4 * frame.x();
    rows.add_load(three, force(F));
    rows.add_load(one, force(F4));
    rows.add_load(frame, {-F - F4, -d.cross(F) - e.cross(F4)});
  }
};

struct SliderCrank {
  SliderCrank(AxialMass axial, bool stretch)
      : scene({0, 0, 0}, [&](SystemGraph& graph) { draw(graph, axial, stretch); }) {}

  void draw(SystemGraph& graph, AxialMass axial, bool stretch) {
    // The clean start: elastic coordinates as published, the others consistent with them.
    const double q4 = 0.169327969e-4, q4_dot = -0.268938672e-5, tip = kRod + q4;
    auto& ground = graph.ground();
    auto& crank = graph.add<RigidBody>(
        "crank", {.mass = 0.36, .inertia = {0.002727, 0.002727, 0.002727}, .angular_velocity = {0, 0, kSpeed}});
    FlexibleBody::Parameters p{.basis = rod_basis(axial)};
    p.position = {kCrank, 0, 0};
    p.velocity = {0, kCrank * kSpeed, 0};
    p.angular_velocity = {0, 0, -kCrank * kSpeed / tip};
    p.modal_coordinates.resize(4), p.modal_velocities.resize(4);
    p.modal_coordinates << 0, 0, 0.103339863e-4, q4;
    p.modal_velocities << 0.444896105, 0.463434311e-2, -0.178591076e-5, q4_dot;
    const InertiaIntegrals integrals = rod_integrals(*p.basis);
    auto& rod = graph.add<FlexibleBody>("rod", std::move(p), integrals);
    auto& slider = graph.add<RigidBody>(
        "slider",
        {.mass = 0.075552, .inertia = {1, 1, 1}, .position = {kCrank + tip, 0, 0}, .velocity = {q4_dot, 0, 0}});

    const Matrix3 E = Matrix3::Identity(), along_x = axes_with_z({1, 0, 0}, {0, 1, 0});
    const auto shows = [&](std::initializer_list<int> modes) {  // a marker at (q_a, q_b, ...) of the frame
      Matrix3X B = Matrix3X::Zero(3, 4);
      int axis = 0;
      for (int mode : modes) B(axis++, mode) = 1;
      return rod.modal_marker({0, 0, 0}, B, Matrix3X(3, 0), E);
    };
    Matrix3X end = Matrix3X::Zero(3, 4);
    end(0, 3) = 1;
    auto& bearing = graph.add<RevoluteJoint>("main bearing", {ground.marker(), crank.marker()});
    drive = &graph.add<CoordinateDrive>("drive", {bearing.angle()}, {.motion = ramp(0, kSpeed)});
    graph.add<RevoluteJoint>("crank pin", {crank.marker({kCrank, 0, 0}), rod.frame()});
    wrist = &graph.add<PointOnLineJoint>("wrist",
                                         {slider.marker(), rod.modal_marker({kRod, 0, 0}, end, Matrix3X(3, 0), E)});
    graph.add<PrismaticJoint>("guide", {ground.marker({0, 0, 0}, along_x), slider.marker({0, 0, 0}, along_x)});
    if (stretch) graph.add<StretchByBending>("stretch", {rod.frame(), shows({0, 1, 2}), shows({3})});
  }

  /// phi2, x3, q1 ... q4
  Vector6 coordinates() const {
    Vector6 out;
    const VectorX& q = scene.state.q;
    out << 2 * std::atan2(q[7 + 6], q[7 + 3]), q[18], q.segment<4>(14);
    return out;
  }
  /// Of g = (y of the wrist, x3 - x of the wrist, phi1 - angle), M a = f - Gᵀ lambda.
  Vector3 multipliers() const {
    Snapshot now(scene.system, scene.state);
    const Sensor on_slider = reaction(*wrist, 0), torque = lithe::multipliers(*drive);
    return {on_slider.value(now, 1), -on_slider.value(now, 0), torque.value(now)};
  }

  const PointOnLineJoint* wrist = nullptr;
  const CoordinateDrive* drive = nullptr;
  Scene scene;
};

void check(const std::string& name, const std::string& file, AxialMass axial, bool stretch, Integrator& integrator,
           double digits, double multiplier_bound) {
  const Table table = reference("F01_flexible_slider_crank/" + file + ".csv");
  SliderCrank mechanism(axial, stretch);
  EXPECT_EQ(mechanism.scene.system.degrees_of_freedom(), 4);
  double way = 0, largest = 0, force = 0, end = 0;
  follow(mechanism.scene, integrator, table, 0.1, [&](std::span<const double> row) {
    const Vector6 expected(row.data() + 1), actual = mechanism.coordinates();
    const Eigen::Array<double, 6, 1> scale = (Vector6() << 0.5, 0.45, 2e-4, 3e-5, 2e-5, 2e-5).finished();
    way = std::max(way, ((actual - expected).array() / scale).abs().maxCoeff());
    const Vector3 multipliers(row.data() + 13), found = mechanism.multipliers();
    largest = std::max(largest, multipliers.norm());
    force = std::max(force, (found - multipliers).norm());
    end = ((actual - expected).array() / expected.array()).abs().maxCoeff();
  });
  EXPECT_DOUBLE_EQ(mechanism.scene.state.time, 0.1);
  const double scd = -std::log10(end);
  expect_below("F01 " + name + ", " + integrator.name() + ", error at 0.1 s (scd " + std::to_string(scd) + ")", end,
               std::pow(10, -digits));
  expect_below("F01 " + name + ", all the way, of the largest", way, std::pow(10, -digits));
  expect_below("F01 " + name + ", multipliers, of the largest", force / largest, multiplier_bound);
}

Method precise() {
  return std::make_unique<ExplicitRungeKutta>(
      ExplicitRungeKutta::Parameters{.tolerance = {.relative = 1e-10, .absolute = 1e-13}});
}

TEST(F01FlexibleSliderCrank, WithThePublishedMassHasThePublishedMotion) {
  check("published mass", "reference", AxialMass::published, false, *precise(), 6, 1e-5);
}
TEST(F01FlexibleSliderCrank, WithConsistentMassHasTheMotionOfATrueRod) {
  check("consistent mass", "reference_consistent_mass", AxialMass::consistent, false, *precise(), 6, 1e-5);
}
TEST(F01FlexibleSliderCrank, StretchesByBendingAndIsDamped) {
  check("nonlinear and damped", "reference_nonlinear_damped", AxialMass::published, true, *precise(), 6, 1e-5);
}
TEST(F01FlexibleSliderCrank, StaysRightWithImplicitMethods) {
  check("published mass", "reference", AxialMass::published, false, *ida(1e-10), 4, 1e-4);
}

}  // namespace
}  // namespace lithe::test::f01_flexible_slider_crank_test
