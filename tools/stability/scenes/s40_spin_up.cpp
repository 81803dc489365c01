// S40: a beam spun up beyond its first frequency: without geometric stiffening its deflection grows without bound.
#include "engine/assembly/evaluated.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/revolute_joint.h"
#include "tools/stability/methods/exact_beam.h"
#include "tools/stability/methods/ordinary.h"
#include "tools/stability/scenes/beam.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

/// F03: a hub of no radius turns to `speed` (rad/s) in 15 s.
struct Case {
  std::string name;
  double length, speed;
  Section section;
  double largest;  // deflection of the geometrically exact beam, m
};
const Case& case_A() {  // Simo & Vu-Quoc 1988
  static const Case c{"A", 10, 6, {.bending = 1.4e4, .line = 1.2, .radius = std::sqrt(6e-4 / 1.2)}, -0.573834760};
  return c;
}
const Case& case_B() {  // Kane 1987, Wu & Haug 1988
  static const Case c{
      "B",
      8,
      4,
      {.bending = 566.7095928, .line = 0.20187837656, .radius = std::sqrt(2.2738984e-5 / 0.20187837656)},
      -0.53361077};
  return c;
}
constexpr double kRise = 15, kEnd = 20;  // s
constexpr int kModes = 4;

Motion spin_up(double t, double speed) {
  const double w = 2 * M_PI / kRise;
  if (t >= kRise) return {speed * (t - kRise / 2), speed, 0};
  return {speed / kRise * (t * t / 2 + (std::cos(w * t) - 1) / (w * w)), speed / kRise * (t - std::sin(w * t) / w),
          speed / kRise * (1 - std::cos(w * t))};
}

/// One floating frame with the first modes of the cantilever.
class OneBody : private EndMarker, public Bench {
 public:
  OneBody(const Case& c, const std::shared_ptr<const ModalBasis>& basis)
      : Bench(Vector3::Zero(),
              [&](SystemGraph& graph) {
                auto& rod = graph.add<FlexibleBody>("beam", {.basis = basis, .position = -basis->origin});
                auto& hub = graph.add<RevoluteJoint>("hub", {graph.ground().marker(), rod.frame()});
                graph.add<CoordinateDrive>("motor", {hub.angle()},
                                           {.motion = [speed = c.speed](double t) { return spin_up(t, speed); }});
                end = rod.average(basis->node_sets.contains("x_max") ? basis->node_set("x_max") : end_section(*basis));
              }),
        speed_(c.speed) {}
  /// Across the hub's axis, m.
  double tip() {
    equations.evaluate(state.time, state.q, state.v, Level::velocity);
    const Vector3 p = marker_kinematics(equations, end, Level::position).p;
    const double angle = spin_up(state.time, speed_).value;
    return -std::sin(angle) * p.x() + std::cos(angle) * p.y();
  }

 private:
  double speed_;
};

struct Tips {
  double at_rise = NAN, at_end = NAN;  // m, at 15 and 20 s
  double rate() const { return std::log(at_end / at_rise) / (kEnd - kRise); }
};
Tips diverge(const Case& c, const std::shared_ptr<const ModalBasis>& basis) {
  OneBody scene(c, basis);
  const Method method = runge_kutta_step(2e-3);  // the fourth mode has 130 rad/s
  Tips tips;
  if (scene.run(*method, kRise).reached) tips.at_rise = scene.tip();
  if (scene.go_on(*method, kEnd).reached) tips.at_end = scene.tip();
  return tips;
}
/// sqrt(Om² - omega_1²), 1/s.
double growth(const Case& c) {
  const double first = std::sqrt(c.section.bending / c.section.line) * std::pow(kCantileverRoots[0] / c.length, 2);
  return std::sqrt(c.speed * c.speed - first * first);
}
Finding linear() {
  const auto tips = [](const Case& c) { return diverge(c, cantilever(c.length, c.section, kModes)); };
  const Tips A = tips(case_A()), B = tips(case_B());
  return {judged(A.at_rise, 1, 10),
          {{"tip of A at 15 s, m", A.at_rise, -8.1e10},
           {"at 20 s", A.at_end, -9.9e20},
           {"tip of B at 15 s, m", B.at_rise, -8.8e5},
           {"at 20 s", B.at_end, -8.0e11},
           {"growth of A, 1/s", A.rate(), growth(case_A()), 3},
           {"of B", B.rate(), growth(case_B()), 3}},
          "a flexible body of the library: grows as exp(sqrt(Om² - omega_1²) t)"};
}

/// A solid bar of the library, Deflection::stiffened: largest deflection, m.
double stiffened(const Case& c) {
  OneBody scene(c, solid_cantilever(c.length, c.section, kModes + 2, Deflection::stiffened));  // two across the plane
  double largest = 0;
  const auto course = scene.run(*runge_kutta_step(2e-3), kEnd, [&] { largest = std::min(largest, scene.tip()); });
  return course.reached ? largest : NAN;
}
Finding with_stiffening() {
  const double A = stiffened(case_A()), B = stiffened(case_B());
  return {judged(A - case_A().largest, 0.006),
          {{"largest deflection of A, m", A, -0.57433, 2},
           {"of B, m", B, -0.53436, 2},
           {"less that of the exact beam, m", A - case_A().largest},
           {"for B", B - case_B().largest}},
          "a flexible body of the library with displacements of second order (Deflection::stiffened)"};
}

/// Simo's and Vu-Quoc's beam as they have it, outside the engine; until after its largest deflection.
Finding exact() {
  const Case& c = case_A();
  const ExactBeam beam{c.length, 2.8e7, 1e7, c.section.bending, c.section.line, 6e-4};
  const double largest = beam.smallest_deflection([&](double t) { return spin_up(t, c.speed); }, 7.2, 8);
  return {judged(largest - c.largest, 0.006),
          {{"largest deflection of A, m", largest, -0.5738348, 5}},
          "a spectral element of degree 8"};
}

/// Pieces in a row, each with a floating frame: each turns with its part of the beam, so that tension stiffens.
class InPieces : public Bench {
 public:
  InPieces(const Case& c, int pieces)
      : Bench(Vector3::Zero(),
              [&](SystemGraph& graph) {
                const double length = c.length / pieces;
                const auto basis = beam_piece(length, c.section, Freedom::plane);
                Marker last;
                for (int i = 0; i < pieces; ++i) {
                  auto& piece = graph.add<FlexibleBody>("piece " + std::to_string(i + 1),
                                                        {.basis = basis, .position = {i * length, 0, 0}});
                  if (i == 0) {
                    auto& hub = graph.add<RevoluteJoint>("hub", {graph.ground().marker(), piece.frame()});
                    graph.add<CoordinateDrive>("motor", {hub.angle()},
                                               {.motion = [speed = c.speed](double t) { return spin_up(t, speed); }});
                  } else {
                    graph.add<FixedJoint>("weld " + std::to_string(i), {last, piece.frame()});
                  }
                  last = piece.average(end_section(*basis));
                }
              }),
        slice_(9 * (pieces - 1)),
        length_(c.length / pieces) {}
  /// Across the hub's axis, m: of the last piece's end.
  double tip(double speed) const {
    const Vector3 in_piece(length_, state.q.segment<2>(slice_ + 7).sum(), 0);
    const Vector3 p = state.q.segment<3>(slice_) + rotation_matrix(state.q.segment<4>(slice_ + 3)) * in_piece;
    const double angle = spin_up(state.time, speed).value;
    return -std::sin(angle) * p.x() + std::cos(angle) * p.y();
  }

 private:
  int slice_;      // of the last piece in q
  double length_;  // of a piece, m
};

Finding in_pieces(Integrator& method, int pieces, const Case& c) {
  InPieces scene(c, pieces);
  double largest = 0;
  const auto course = scene.run(method, kEnd, [&] { largest = std::min(largest, scene.tip(c.speed)); });
  if (!course.reached) return {Outcome::unstable, {{"stopped at, s", course.end}}, course.why};
  return {judged(largest - c.largest, 0.006, 1),
          {{"largest deflection of " + c.name + ", m", largest},
           {"less that of the exact beam, m", largest - c.largest},
           {"steps", static_cast<double>(course.steps)}},
          "a row of floating frames is stiffened by its tension"};
}
Cell cell_in_pieces(int pieces, const Candidate& candidate, const Case& c) {
  return {std::to_string(pieces) + " floating frames (" + c.name + "), " + candidate.name,
          [pieces, make = candidate.make, &c] { return in_pieces(*make(), pieces, c); }, candidate.role};
}

const Registered scene{under_every_method({"S40",
                                           "spin-up beyond the critical speed",
                                           {{"linear FFRF, no geometric stiffness", linear},
                                            {"with centrifugal stiffness matrix", with_stiffening},
                                            {"geometrically exact beam", exact},
                                            cell_in_pieces(16, automatic(1e-4), case_A()),
                                            cell_in_pieces(16, alpha(0.01), case_A()),
                                            cell_in_pieces(8, alpha(0.01), case_B()),
                                            cell_in_pieces(8, alpha(0.01), case_A())}},
                                          {1e-4, 0.01},
                                          [](Integrator& method) { return in_pieces(method, 8, case_A()); })};

}  // namespace
}  // namespace lithe::lab
