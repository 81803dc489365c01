// F08: Beck's column: a thrust that follows the end of a clamped column. It flutters at 20.05 EI/L²; what looks for a
// static loss of stability finds nothing or something else, and damping methods hide the flutter.
#include <Eigen/LU>

#include "bodies/beam/beam.h"
#include "engine/analysis/equilibrium.h"
#include "engine/analysis/linearization.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "tools/stability/bench.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

// M. Beck, ZAMP 3 (1952) 225; length, EI and mass per length are 1. With 12 elements it flutters 1.6 % later.
constexpr double kBeck = 20.050954, kSlender = 1e4, kLimit = 0.03;
constexpr int kElements = 12;

class Column : public Bench {
 public:
  Column(double load, PointForce::Axes axes)
      : Bench(Vector3::Zero(), [&](SystemGraph& graph) {
          auto& beam = graph.add<Beam>(
              "column", {.axis = BeamAxis::straight({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                         .sections = {{0, BeamSection::diagonal({kSlender, kSlender, kSlender, 100, 1000, 1}, 1,
                                                                {2 / kSlender, 1 / kSlender, 1 / kSlender})}},
                         .elements = kElements});
          graph.add<FixedJoint>("clamp", {graph.ground().marker(), beam.marker(0)});
          graph.add<PointForce>("thrust", {beam.marker(1)}, {.force = {-load, 0, 0}, .axes = axes});
        }) {
    state = find_equilibrium(system, state).state;
  }
  Linearization linearized() const { return linearize(system, state); }
};

/// The lowest share of Beck's load up to 2 at which a figure of the column is no longer positive; NaN: none.
template <class Positive>
double lowest_share(PointForce::Axes axes, Positive&& positive) {
  const auto at = [&](double share) { return positive(Column(share * kBeck, axes).linearized()); };
  double below = 0, above = NAN;
  for (double share = 0.05; share < 2.01 && !(above > 0); share += 0.15) {
    if (at(share) > 0) {
      below = share;
    } else {
      above = share;
    }
  }
  if (!(above > 0)) return NAN;
  while (above - below > 1e-3) (at((below + above) / 2) > 0 ? below : above) = (below + above) / 2;
  return above;
}
Finding finding(double share, const std::string& why) {
  // None found: nothing is said to happen below twice the load.
  return {judged(std::isnan(share) ? 1 : share - 1, kLimit),
          {{"critical load found, of 20.05 EI/L² (2: none below)", std::isnan(share) ? 2 : share}},
          why};
}
double flutter_share() {
  return lowest_share(PointForce::Axes::marker, [](const Linearization& l) { return 0.05 - l.largest_growth(); });
}

// In time: at 1.1 of the load at which this mesh flutters, pushed aside at its end.
constexpr double kShare = 1.12, kPush = 1e-4, kBegin = 1.6, kEnd = 3.2;

/// Rate of growth of the largest speed between two windows, against the linearization's.
Finding grows(Integrator& method) {
  Column column(kShare * kBeck, PointForce::Axes::marker);
  const double rate = column.linearized().largest_growth();
  for (const auto& body : column.system.layout().bodies())
    if (body.frame) column.state.v[body.v + 1] = kPush * std::pow(column.state.q[body.q], 2);
  double early = 0, late = 0;
  const auto course = column.run(method, kEnd, [&] {
    const double t = column.state.time, speed = column.state.v.cwiseAbs().maxCoeff();
    if (t > kBegin - 0.6 && t <= kBegin) early = std::max(early, speed);
    if (t > kEnd - 0.6) late = std::max(late, speed);
  });
  if (!course.reached) return {Outcome::unstable, {{"stopped at, s", course.end}}, course.why};
  const double measured = std::log(late / early) / (kEnd - kBegin);
  return {judged(measured / rate - 1, 0.05),
          {{"rate of growth, 1/s", measured},
           {"by eigenvalues", rate},
           {"largest turn at the end, rad", late / 11},
           {"steps", static_cast<double>(course.steps)}}};
}
Cell in_time(const std::string& name, const std::string& why, std::function<Method()> make) {
  return {name,
          [make, why] {
            const Method method = make();
            Finding finding = grows(*method);
            finding.why = why;
            return finding;
          },
          Role::also};
}

const Registered scene{with_candidates(
    {"F08",
     "a follower load",
     {{"determinant of the stiffness",
       [] {
         return finding(lowest_share(PointForce::Axes::marker,
                                     [](const Linearization& l) {
                                       const VectorX scale = l.K.diagonal().cwiseAbs().cwiseSqrt().cwiseInverse();
                                       return MatrixX(scale.asDiagonal() * l.K * scale.asDiagonal()).determinant();
                                     }),
                        "there is no neighbouring equilibrium at any load: the loss of stability is dynamic");
       },
       Role::also},
      {"smallest eigenvalue of the symmetric part of the stiffness",
       [] {
         return finding(
             lowest_share(PointForce::Axes::marker, [](const Linearization& l) { return l.lowest_stiffness(); }),
             "a sufficient condition, far from necessary");
       },
       Role::also},
      {"the load taken for dead",
       [] {
         return finding(
             lowest_share(PointForce::Axes::world, [](const Linearization& l) { return l.lowest_stiffness(); }),
             "Euler's load π²/4 is that of another column");
       },
       Role::also},
      {"eigenvalues of linearize()", [] { return finding(flutter_share(), "two frequencies meet"); }, Role::ours},
      in_time("linearly implicit Euler, h = 0.08, in time",
              "its damping exceeds the growth: it calls the column stable",
              [] { return std::make_unique<LinearlyImplicit>(LinearlyImplicit::Parameters{.step = 0.08}); })}},
    {automatic(1e-6), radau(1e-8), alpha(2e-3)}, {1e-6, 2e-3}, grows)};

}  // namespace
}  // namespace lithe::lab
