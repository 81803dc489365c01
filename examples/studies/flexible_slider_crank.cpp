// Slider-crank with an elastic rod (F01: IVP Test Set "crank", Simeon 1996), published masses, crank at 150 rad/s.
// Axial vibrations of 1e5 rad/s beside a motion of 150 rad/s.  lithe chart flexible_slider_crank
#include <numbers>

#include "lithe/lithe.h"

using namespace lithe;

namespace {

constexpr double kPi = std::numbers::pi, kCrank = 0.15, kRod = 0.30, kSpeed = 150;
constexpr double kYoung = 2e11, kSide = 0.008, kArea = kSide * kSide, kRodMass = 0.151104, kMass = 7870 * kArea * kRod;

/// Two sines across, and a parabola along: q3 in the middle, q4 at the end.
std::shared_ptr<const ModalBasis> rod_basis() {
  const double slender = kSide * kSide / (kRod * kRod);
  MatrixX M = MatrixX::Zero(4, 4), K = MatrixX::Zero(4, 4);
  M.diagonal() << 0.5, 0.5, 8, 2;
  M(2, 3) = M(3, 2) = 1;
  K.diagonal() << std::pow(kPi, 4) / 24 * slender, 2 * std::pow(kPi, 4) / 3 * slender, 16.0 / 3, 7.0 / 3;
  K(2, 3) = K(3, 2) = -8.0 / 3;
  auto basis = std::make_shared<ModalBasis>();
  basis->name = "two sines and a parabola";
  basis->modal_mass = (kMass * M).sparseView();
  basis->stiffness = (kYoung * kArea / kRod * K).sparseView();
  return basis;
}

/// Of the rod as a line with a little inertia about itself; ∫ w and ∫ u of the four shapes.
InertiaIntegrals rod_integrals(const ModalBasis& basis) {
  const double m = kMass;
  InertiaIntegrals I;
  I.mass = kRodMass;
  I.s0 = {kRodMass * kRod / 2, 0, 0};
  I.Ct = Matrix3X::Zero(3, 4);
  I.Ct(0, 2) = m * 2 / 3, I.Ct(0, 3) = m / 6, I.Ct(1, 0) = m * 2 / kPi;
  I.J0 << 1e-5, 0.0045339259, 0.0045339259, 0, 0, 0;
  I.J1 = Matrix6X::Zero(6, 4);
  I.J1(2, 2) = 4 * kRod * m / 6, I.J1(2, 3) = 2 * kRod * m / 6;
  I.C0 = Matrix3X::Zero(3, 4);
  I.C0(2, 0) = kRod * m / kPi, I.C0(2, 1) = -kRod * m / (2 * kPi);
  I.Mff = MatrixX(basis.modal_mass);
  I.J2 = MatrixX::Zero(24, 4);
  I.C1 = MatrixX::Zero(12, 4);
  Eigen::Matrix4d B = Eigen::Matrix4d::Zero();  // -∫ w u, skew
  B(0, 2) = -16 / std::pow(kPi, 3), B(0, 3) = 8 / std::pow(kPi, 3) - 1 / kPi, B(1, 3) = 1 / (2 * kPi);
  for (int k = 0; k < 4; ++k) {
    I.J2.row(6 * k + 2) = I.Mff.row(k);
    I.C1.row(3 * k + 2) = m * (B - B.transpose()).row(k);
  }
  return I;
}

std::vector<Sensor> draw(SystemGraph& graph) {
  // Elastic coordinates as published, the others consistent with them.
  const double q4 = 0.169327969e-4, q4_dot = -0.268938672e-5, tip = kRod + q4;
  auto& crank = graph.add<RigidBody>(
      "crank", {.mass = 0.36, .inertia = {0.002727, 0.002727, 0.002727}, .angular_velocity = {0, 0, kSpeed}});
  FlexibleBody::Parameters of_rod{.basis = rod_basis()};
  of_rod.position = {kCrank, 0, 0};
  of_rod.velocity = {0, kCrank * kSpeed, 0};
  of_rod.angular_velocity = {0, 0, -kCrank * kSpeed / tip};
  of_rod.modal_coordinates = Vector4(0, 0, 0.103339863e-4, q4);
  of_rod.modal_velocities = Vector4(0.444896105, 0.463434311e-2, -0.178591076e-5, q4_dot);
  const InertiaIntegrals integrals = rod_integrals(*of_rod.basis);
  auto& rod = graph.add<FlexibleBody>("rod", std::move(of_rod), integrals);
  auto& slider = graph.add<RigidBody>(
      "slider", {.mass = 0.075552, .inertia = {1, 1, 1}, .position = {kCrank + tip, 0, 0}, .velocity = {q4_dot, 0, 0}});

  const Matrix3 along_x = rotation_about({0, 1, 0}, kPi / 2);  // a slider's way is the z axis of its markers
  Matrix3X end = Matrix3X::Zero(3, 4);
  end(0, 3) = 1;
  auto& bearing = graph.add<RevoluteJoint>("main bearing", {graph.ground().marker(), crank.marker()});
  graph.add<CoordinateDrive>("drive", {bearing.angle()}, {.motion = ramp(0, kSpeed)});
  graph.add<RevoluteJoint>("crank pin", {crank.marker({kCrank, 0, 0}), rod.frame()});
  const Marker wrist = rod.modal_marker({kRod, 0, 0}, end, Matrix3X(3, 0), Matrix3::Identity());
  graph.add<PointOnLineJoint>("wrist", {slider.marker(), wrist});
  graph.add<PrismaticJoint>("guide", {graph.ground().marker({0, 0, 0}, along_x), slider.marker({0, 0, 0}, along_x)});
  return {modal_coordinates(rod, "q")};
}

}  // namespace

StudyScene scene() {
  return {.name = "flexible slider-crank",
          .duration = 0.1,
          .gravity = {0, 0, 0},
          .characteristic_length = 2e-4,  // m: the largest deflection across
          .draw = draw};
}
