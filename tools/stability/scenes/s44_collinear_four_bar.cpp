// S44: the flexible four-bar with a tilted axis through its collinear pose, where parallelogram and anti-parallelogram
// meet.
#include "engine/analysis/equilibrium.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/revolute_joint.h"
#include "tools/stability/scenes/beam.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kDegree = M_PI / 180, kSpeed = 0.6, kLast = 120 * kDegree;  // rad/s; crank angle of the end

/// A turn that takes z to `z` and x near to `x`.
Matrix3 axes(const Vector3& x, const Vector3& z) {
  Matrix3 R;
  R.col(2) = z.normalized();
  R.col(0) = (x - x.dot(R.col(2)) * R.col(2)).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return R;
}

/// F05 (Bauchau's benchmark), the axis at C tilted by 5 degrees about x or y. Each bar is one piece, the thin one
/// three.
class FourBar : public Bench {
 public:
  FourBar(const MotionLaw& crank_angle, bool about_y)
      : Bench(Vector3::Zero(), [&](SystemGraph& graph) {
          const Vector3 A(0, 0, 0), B(0, 0.12, 0), C(0.24, 0.12, 0), D(0.24, 0, 0);
          const Matrix3 E = Matrix3::Identity();
          const double s = std::sin(5 * kDegree), c = std::cos(5 * kDegree);
          const Matrix3 tilted = axes({1, 0, 0}, about_y ? Vector3(s, 0, c) : Vector3(0, -s, c));
          const auto crank = draw(graph, "crank", A, B, 0.016, 1, E, E);
          const auto coupler = draw(graph, "coupler", B, C, 0.016, 1, E, tilted);
          const auto rocker = draw(graph, "rocker", C, D, 0.008, 3, tilted, E);
          auto& at_A = graph.add<RevoluteJoint>("A", {graph.ground().marker(), crank.first});
          graph.add<RevoluteJoint>("B", {crank.last, coupler.first});
          graph.add<RevoluteJoint>("C", {coupler.last, rocker.first});
          graph.add<RevoluteJoint>("D", {rocker.last, graph.ground().marker(D)});
          graph.add<CoordinateDrive>("drive", {at_A.angle()}, {.motion = crank_angle});
        }) {}

  /// How far the rocker has turned (the frame of its first piece), rad, within half a turn.
  double rocker_angle(const State& s) const {
    const Vector3 x = rotation_matrix(s.q.segment<4>(2 * 13 + 3)).col(0);  // from -y
    return std::atan2(x.x(), -x.y());
  }

 private:
  struct Ends {
    Marker first, last;
  };
  static Ends draw(SystemGraph& graph, const std::string& name, const Vector3& from, const Vector3& to, double side,
                   int pieces, const Matrix3& first_axes, const Matrix3& last_axes) {
    const double length = (to - from).norm() / pieces;
    const auto basis = beam_piece(length, square(side, 2.07e11, 0.3, 7800), Freedom::space);
    const Matrix3 R = axes(to - from, Vector3::UnitZ()), E = Matrix3::Identity();
    Ends ends;
    for (int i = 0; i < pieces; ++i) {
      auto& piece =
          graph.add<FlexibleBody>(name + " " + std::to_string(i + 1), {.basis = basis,
                                                                       .damping = {.stiffness_proportional = 1e-4},
                                                                       .position = from + i * length * R.col(0),
                                                                       .orientation = R});
      const Marker here = piece.frame(i == 0 ? Matrix3(R.transpose() * first_axes) : E);
      if (i == 0)
        ends.first = here;
      else
        graph.add<FixedJoint>(name + " weld " + std::to_string(i), {ends.last, here});
      ends.last = piece.average(end_section(*basis), i + 1 == pieces ? Matrix3(R.transpose() * last_axes) : E);
    }
    return ends;
  }
};

Finding finding(double crank, double rocker, const std::string& why) {
  const double off = std::remainder(rocker - crank, 2 * M_PI);
  return {judged(off, 2 * kDegree),
          {{"rocker's angle less the crank's, deg", off / kDegree}, {"crank at the end, deg", crank / kDegree}},
          why};
}

/// Equilibria at a row of crank angles, each from the one before; time is the angle.
Finding continuation(double sign, bool about_y) {
  const double step = 1 * kDegree;
  FourBar scene([sign](double angle) { return Motion{sign * angle, 0, 0}; }, about_y);
  State state = scene.state;
  for (double angle = step; angle < kLast + step / 2; angle += step) {
    state.time = angle;
    state = find_equilibrium(scene.system, state).state;
  }
  return finding(sign * kLast, scene.rocker_angle(state), "branches 1 mm apart at the collinear pose");
}

/// From rest to 0.6 rad/s within a second.
Motion smooth_start(double t) {
  const double s = std::min(t, 1.0), s2 = s * s, s3 = s2 * s;
  return {kSpeed * (s3 * s * (2.5 - 3 * s + s2) + std::max(t - 1, 0.0)), kSpeed * s3 * (10 - 15 * s + 6 * s2),
          t < 1 ? kSpeed * s2 * (30 - 60 * s + 30 * s2) : 0};
}
Finding passage(Integrator& method, double sign, bool about_y) {
  FourBar scene(
      [sign](double t) {
        const Motion m = smooth_start(t);
        return Motion{sign * m.value, sign * m.rate, sign * m.acceleration};
      },
      about_y);
  const auto course = scene.run(method, kLast / kSpeed + 0.5);
  if (!course.reached) return {Outcome::refused, {{"stopped at, s", course.end}}, course.why};
  Finding out = finding(sign * smooth_start(course.end).value, scene.rocker_angle(scene.state), "");
  out.figures.push_back({"steps", static_cast<double>(course.steps)});
  return out;
}

Cell cell(const Candidate& candidate, double sign, bool about_y) {
  return {std::string("dynamics, tilt ") + (about_y ? "y" : "x") + (sign > 0 ? ", forwards, " : ", backwards, ") +
              candidate.name,
          [make = candidate.make, sign, about_y] { return passage(*make(), sign, about_y); }, Role::also};
}
Candidate damped() { return alpha(0.01, 0.2, GeneralizedAlpha::Form::stabilized_index2); }

const Registered scene{
    under_every_method({"S44",
                        "collinear pose of the flexible four-bar",
                        {{"static continuation", [] { return continuation(1, false); }},
                         {"static continuation, tilt x, backwards", [] { return continuation(-1, false); }, Role::also},
                         {"dynamics", [] { return passage(*damped().make(), 1, true); }},
                         cell(damped(), 1, false),
                         cell(damped(), -1, false),
                         cell(damped(), -1, true),
                         cell(automatic(1e-4), 1, false),
                         cell(automatic(1e-4), 1, true)}},
                       {1e-4, 0.01}, [](Integrator& method) { return passage(method, 1, true); })};

}  // namespace
}  // namespace lithe::lab
