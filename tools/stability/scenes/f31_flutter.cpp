// F31: a wing section on springs, 2 % beyond the speed at which it flutters: it swings up slowly. Methods that damp say
// that it flies.
#include "bodies/rigid_body.h"
#include "engine/base/dense.h"
#include "joints/aerodynamics/airfoil_strip.h"
#include "joints/forces/coordinate_spring.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

// A section 1 m wide with a chord of 1 m: kg, kg m² about the centre of mass, N/m, N m/rad; lengths from the elastic
// axis, backwards, m.
constexpr double kMass = 20, kInertia = 1.5, kPlunge = 2e4, kPitch = 4e3, kBehind = 0.12, kAhead = 0.15, kChord = 1;
constexpr double kDensity = 1.225, kSeconds = 20;

/// Rates of (h, α, h', α') at an air speed: h upwards, α nose up about the elastic axis, small. Flow at three quarters
/// of the chord, lift at a quarter, thin-airfoil damping in pitch (AirfoilStrip).
MatrixX rates(double speed) {
  const double q = 0.5 * kDensity * speed * speed * kChord, back = kChord / 2 - kAhead;  // of the flow's point
  const Eigen::Matrix2d M{{kMass, -kMass * kBehind}, {-kMass * kBehind, kInertia + kMass * kBehind * kBehind}};
  // Lift 2π q (α - (h' - back α') / U), up at kAhead before the axis.
  const Eigen::RowVector2d by_place = 2 * M_PI * q * Eigen::RowVector2d(0, 1),
                           by_speed = 2 * M_PI * q / speed * Eigen::RowVector2d(-1, back);
  const Eigen::Vector2d acts(1, kAhead);
  Eigen::Matrix2d K = acts * by_place, D = acts * by_speed;
  K -= Eigen::Vector2d(kPlunge, kPitch).asDiagonal();
  D(1, 1) -= q / speed * kChord * kChord * M_PI / 8;
  MatrixX A = MatrixX::Zero(4, 4);
  A.topRightCorner<2, 2>().setIdentity();
  A.bottomLeftCorner<2, 2>() = M.inverse() * K;
  A.bottomRightCorner<2, 2>() = M.inverse() * D;
  return A;
}

struct Mode {
  explicit Mode(double speed) {
    const Eigen::EigenSolver<MatrixX> solver(rates(speed));
    Eigen::Index fastest = 0;
    growth = solver.eigenvalues().real().maxCoeff(&fastest);
    frequency = std::abs(solver.eigenvalues()[fastest].imag());
    shape = solver.eigenvectors().col(fastest);
    part = solver.eigenvectors().inverse().row(fastest);
    shape *= 1e-4 / shape[1];
  }
  /// How much of the mode is in a motion (h, α, h', α').
  double share(const Eigen::Vector4d& motion) const { return std::abs((part * motion)(0)); }

  double growth, frequency;
  Eigen::VectorXcd shape;
  Eigen::RowVectorXcd part;
};

double flutter_speed() {
  double low = 5, high = 200;
  for (int i = 0; i < 60; ++i) (Mode((low + high) / 2).growth < 0 ? low : high) = (low + high) / 2;
  return low;
}

/// Body axes as the world's: x back, z up; y along the wing.
class Section : public Bench {
 public:
  explicit Section(double speed)
      : Bench({0, 0, 0}, [&](SystemGraph& graph) {
          auto& carriage = graph.add<RigidBody>("carriage", {.mass = 1e-6, .inertia = {1e-6, 1e-6, 1e-6}});
          auto& wing = graph.add<RigidBody>(
              "wing", {.mass = kMass, .inertia = {kInertia, kInertia, kInertia}, .position = {kBehind, 0, 0}});
          auto& plunge = graph.add<PrismaticJoint>("plunge", {graph.ground().marker(), carriage.marker()});
          const Matrix3 axle = rotation_about({1, 0, 0}, -M_PI / 2);  // z along y
          auto& pitch =
              graph.add<RevoluteJoint>("pitch", {carriage.marker({}, axle), wing.marker({-kBehind, 0, 0}, axle)});
          graph.add<CoordinateSpring>("bends", {plunge.displacement()}, {.stiffness = kPlunge});
          graph.add<CoordinateSpring>("twists", {pitch.angle()}, {.stiffness = kPitch});
          Matrix3 strip;  // x along the span, y to the leading edge, z up
          strip.col(0) = Vector3(0, 1, 0), strip.col(1) = Vector3(-1, 0, 0), strip.col(2) = Vector3(0, 0, 1);
          graph.add<AirfoilStrip>("strip", {wing.marker({-kBehind, 0, 0}, strip)},
                                  {.width = 1,
                                   .chord = kChord,
                                   .ahead = kAhead,
                                   .airfoil = linear_airfoil(),
                                   .wind = [speed](const Vector3&, double) { return Vector3(speed, 0, 0); },
                                   .density = kDensity});
        }) {
    // Along the mode that grows: α nose up turns about +y.
    const Mode mode(speed);
    const Eigen::Vector4d y = mode.shape.real();
    const Matrix3 turned = rotation_about({0, 1, 0}, y[1]);
    state.q[2] = y[0];
    state.q.segment<3>(7) = Vector3(0, 0, y[0]) + turned * Vector3(kBehind, 0, 0);
    state.q.segment<4>(10) << std::cos(y[1] / 2), 0, std::sin(y[1] / 2), 0;
    state.v[2] = y[2];
    state.v.segment<3>(6) = Vector3(0, 0, y[2]) + Vector3(0, y[3], 0).cross(turned * Vector3(kBehind, 0, 0));
    state.v[10] = y[3];
  }
  /// (h, α, h', α')
  Eigen::Vector4d motion() const {
    return {state.q[2], 2 * std::atan2(state.q[12], state.q[10]), state.v[2], state.v[10]};
  }
};

/// By how much of the mode is in the motion at its end.
Finding swings_up(Integrator& method) {
  const double speed = 1.02 * flutter_speed();
  const Mode mode(speed);
  Section section(speed);
  const double before = mode.share(section.motion());
  const Bench::Course course = section.run(method, kSeconds);
  const double growth = std::log(mode.share(section.motion()) / before) / kSeconds;
  return {course.reached ? judged(growth / mode.growth - 1, 0.05) : Outcome::unstable,
          {{"growth, 1/s", growth},
           {"of the eigenvalue, 1/s", mode.growth},
           {"speed of flutter, m/s", flutter_speed()},
           {"steps a cycle", static_cast<double>(course.steps) * 2 * M_PI / mode.frequency / kSeconds}},
          course.why};
}

const Registered scene{with_candidates(
    {"F31", "a wing 2 % beyond flutter", {}},
    {automatic(1e-8), radau(1e-8), runge_kutta8(1e-8), alpha(1e-2), alpha(1e-3), hht(2e-3), linearly_implicit(1e-3)},
    {1e-8, 1e-3}, swings_up)};

}  // namespace
}  // namespace lithe::lab
