// S12: the flexible slider-crank F01 (IVP Test Set "crank", Simeon 1996) from its published start of nine digits.
#include "bodies/flexible/flexible_body.h"
#include "engine/motion/projection.h"
#include "joints/coordinate_drive.h"
#include "joints/point_on_line_joint.h"
#include "tools/stability/lab.h"
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/scenes/mechanisms.h"
#include "tools/stability/scenes/ours.h"

namespace lithe::lab {
namespace {

constexpr double kPi = 3.1415927;  // as in the source of the Test Set
constexpr double kCrank = 0.15, kRod = 0.30, kSpeed = 150, kSide = 0.008, kRodMass = 0.151104;
constexpr double kLineMass = 7870 * kSide * kSide * kRod;  // kg
constexpr double kLimit = 1e-12;                           // m/s, of the velocity residual

/// w = q1 sin(πx/L) + q2 sin(2πx/L) across, u quadratic along with q3 in the middle and q4 at the end.
std::shared_ptr<const ModalBasis> rod_basis() {
  const double slender = kSide * kSide / (kRod * kRod);
  MatrixX M = MatrixX::Zero(4, 4), K = MatrixX::Zero(4, 4);
  M(0, 0) = M(1, 1) = 0.5;
  M.bottomRightCorner<2, 2>() << 8, 1, 1, 2;
  K(0, 0) = std::pow(kPi, 4) / 24 * slender;
  K(1, 1) = 2 * std::pow(kPi, 4) / 3 * slender;
  K.bottomRightCorner<2, 2>() << 16.0 / 3, -8.0 / 3, -8.0 / 3, 7.0 / 3;
  auto basis = std::make_shared<ModalBasis>();
  basis->name = "two sines and a parabola";
  basis->modal_mass = (kLineMass * M).sparseView();
  basis->stiffness = (2e11 * kSide * kSide / kRod * K).sparseView();
  return basis;
}

/// ∫ over the rod; what leaves the plane is zero.
InertiaIntegrals rod_integrals(const ModalBasis& basis) {
  const double m = kLineMass;
  InertiaIntegrals I;
  I.mass = kRodMass;
  I.s0 = {kRodMass * kRod / 2, 0, 0};
  I.Ct = Matrix3X::Zero(3, 4);
  I.Ct.row(0) << 0, 0, m * 2 / 3, m / 6;
  I.Ct.row(1) << m * 2 / kPi, 0, 0, 0;
  I.J0 << 1e-5, 0.0045339259, 0.0045339259, 0, 0, 0;
  I.J1 = Matrix6X::Zero(6, 4);
  I.J1.row(2) << 0, 0, 2 * kRod * m / 3, 2 * kRod * m / 6;
  I.C0 = Matrix3X::Zero(3, 4);
  I.C0.row(2) << kRod * m / kPi, -kRod * m / (2 * kPi), 0, 0;
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

class FlexibleSliderCrank : public Bench {
 public:
  /// With the published positions and velocities as they stand.
  FlexibleSliderCrank()
      : Bench({0, 0, 0}, [](SystemGraph& graph) {
          const double q4_dot = -0.268938672e-5;
          auto& ground = graph.ground();
          auto& crank = graph.add<RigidBody>(
              "crank", {.mass = 0.36, .inertia = {0.002727, 0.002727, 0.002727}, .angular_velocity = {0, 0, kSpeed}});
          FlexibleBody::Parameters p{.basis = rod_basis()};
          p.position = {kCrank, 0, 0};
          p.velocity = {0, kCrank * kSpeed, 0};
          p.angular_velocity = {0, 0, -0.749957670e2};
          p.modal_coordinates.resize(4), p.modal_velocities.resize(4);
          p.modal_coordinates << 0, 0, 0.103339863e-4, 0.169327969e-4;
          p.modal_velocities << 0.444896105, 0.463434311e-2, -0.178591076e-5, q4_dot;
          const InertiaIntegrals integrals = rod_integrals(*p.basis);
          auto& rod = graph.add<FlexibleBody>("rod", std::move(p), integrals);
          auto& slider = graph.add<RigidBody>(
              "slider",
              {.mass = 0.075552, .inertia = {1, 1, 1}, .position = {0.450016933, 0, 0}, .velocity = {q4_dot, 0, 0}});
          const Matrix3 along_x = axes_with_z({1, 0, 0}, {0, 1, 0});
          Matrix3X end = Matrix3X::Zero(3, 4);
          end(0, 3) = 1;
          auto& bearing = graph.add<RevoluteJoint>("main bearing", {ground.marker(), crank.marker()});
          graph.add<CoordinateDrive>("drive", {bearing.angle()}, {.motion = ramp(0, kSpeed)});
          graph.add<RevoluteJoint>("crank pin", {crank.marker({kCrank, 0, 0}), rod.frame()});
          const Marker tip = rod.modal_marker({kRod, 0, 0}, end, Matrix3X(3, 0), Matrix3::Identity());
          graph.add<PointOnLineJoint>("wrist", {slider.marker(), tip});
          graph.add<PrismaticJoint>("guide", {ground.marker({0, 0, 0}, along_x), slider.marker({0, 0, 0}, along_x)});
        }) {
    // assemble() has projected the state: what was drawn is put back.
    for (const Layout::BodySlice& b : system.layout().bodies()) {
      const Coordinates count = b.body->coordinates();
      b.body->initial_state(state.q.segment(b.q, count.q_count()), state.v.segment(b.v, count.v_count()));
    }
  }
  double q1() const { return state.q[14]; }
};

/// q1 at 0.1 s from the published start with its velocities made consistent in the metric of the mass; binary128
/// (flexible/F01_slider_crank/problem.md).
constexpr double kProjected = 1.8931928997009405e-4;

struct Result {
  double residual = 0, position = 0, q1 = NAN;
};

/// From the published start; its velocities as they stand or moved onto G v + ∂g/∂t = 0 in the metric of the mass.
Result from_published(bool project, Integrator& method) {
  FlexibleSliderCrank scene;
  if (project) Projector(scene.equations).velocity(0, scene.state.q, scene.state.v);
  Result result{scene.violation(Level::velocity), scene.violation(Level::position)};
  if (scene.run(method, 0.1).reached) result.q1 = scene.q1();
  return result;
}

Finding rk4(bool project, double published, const std::string& why) {
  ExplicitIndex1 method({.step = 5e-6});
  const Result result = from_published(project, method), projected = from_published(true, method);
  std::vector<Figure> figures{{"velocity residual at t = 0, m/s", result.residual, published},
                              {"position residual at t = 0, m", result.position}};
  if (!project) figures.push_back({"q1 off, relative", std::abs(result.q1 / projected.q1 - 1), 2e-8, 1});
  figures.push_back({"q1 at 0.1 s off the published projected one, relative", std::abs(result.q1 / kProjected - 1)});
  return {std::isfinite(result.q1) ? judged(result.residual, kLimit) : Outcome::unstable, figures, why};
}

/// assemble() projects by itself.
Finding ours() {
  FlexibleSliderCrank scene;
  scene.state = scene.system.initial_state();
  const double residual = scene.violation(Level::velocity);
  const auto course = scene.run(*runge_kutta(1e-10), 0.1);
  return {course.reached ? judged(residual, kLimit) : Outcome::unstable,
          {{"velocity residual at t = 0, m/s", residual},
           {"q1 at 0.1 s off the published projected one, relative", std::abs(scene.q1() / kProjected - 1)}}};
}

const Registered scene{{"S12",
                        "inconsistent published start",
                        {{"index 2 without velocity projection",
                          [] { return rk4(false, 1.2e-8, "every code answers differently in the 8th digit"); }},
                         {"start projected in the mass metric", [] { return rk4(true, NAN, "one start, one answer"); }},
                         {"assemble(), explicit Runge-Kutta 5(4), 1e-10", ours, Role::ours}}}};

}  // namespace
}  // namespace lithe::lab
