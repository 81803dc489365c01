// F22: a light shaft that turns slowly in a ball bearing: the contacts set the step of explicit methods, and a bearing
// with the stiffness of another load deflects too far.
#include "bodies/rigid_body.h"
#include "joints/bearings/ball_bearing.h"
#include "joints/planar_joint.h"
#include "tools/stability/bench.h"
#include "tools/stability/methods/explicit_index1.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

constexpr double kMass = 0.02, kLoad = 50, kSpeed = 20, kEnd = 0.1;  // kg, N along -y, rad/s, s
constexpr BallBearing::Parameters kBearing{.balls = 7,               // a 608
                                           .ball_diameter = 3.97e-3,
                                           .pitch_diameter = 15e-3,
                                           .inner_groove_radius = 2.06e-3,
                                           .outer_groove_radius = 2.1e-3};

/// The shaft where the load holds it, moving with 0.1 mm/s both ways.
class Shaft : public Bench {
 public:
  Shaft(double speed, const BearingLosses& losses)
      : Bench({0, -kLoad / kMass, 0}, [&](SystemGraph& graph) {
          BallBearing::Parameters p = kBearing;
          p.losses = losses;
          auto& shaft = graph.add<RigidBody>("shaft", {.mass = kMass,
                                                       .inertia = {1e-5, 1e-5, 1e-5},
                                                       .velocity = {1e-4, 1e-4, 0},
                                                       .angular_velocity = {0, 0, speed}});
          bearing = &graph.add<BallBearing>("bearing", {shaft.marker(), graph.ground().marker()}, p);
          graph.add<PlanarJoint>("plane", {graph.ground().marker(), shaft.marker()});
        }) {
    state.q.head<3>() = held(0).head<3>();
  }
  Vector5 held(double cage) const { return bearing->deflection(-kLoad * Vector5::Unit(1), cage); }

  const BallBearing* bearing;
};

Finding beyond() {
  const auto stable = [](double h) {
    Shaft shaft(0, {});
    ExplicitIndex1 method({.step = h});
    return shaft.run(method, 1500 * h, {}, 20 * 0.5 * kMass * 2e-8).reached;
  };
  Shaft shaft(0, {});
  const double fastest = std::sqrt(shaft.bearing->stiffness(shaft.held(0))(1, 1) / kMass);
  const double limit = largest_stable_step(stable, 2 / fastest, 4 / fastest, 1e-3);
  return {stable(2.9 / fastest) ? Outcome::converged : Outcome::unstable,
          {{"h ω at which the energy runs away", limit * fastest},
           {"steps in a turn of the shaft", 2 * M_PI / kSpeed / limit}},
          "imaginary-axis limit, 2 √2",
          limit};
}

Finding constant_stiffness() {
  const Shaft shaft(0, {});
  const Vector5 light = shaft.bearing->deflection(-0.1 * kLoad * Vector5::Unit(1));
  const double linear = -kLoad / shaft.bearing->stiffness(light)(1, 1);
  const double ratio = linear / shaft.held(0)[1];
  return {judged(ratio - 1, 0.01), {{"deflection over that of the bearing", ratio}}, "contacts stiffen: F ~ δ^1.5"};
}

/// Half a ball passes; at the end the shaft is where the load holds it.
Finding judge(Integrator& method) {
  Shaft shaft(kSpeed, {.damping_time = 2e-5});
  const auto course = shaft.run(method, kEnd);
  if (!course.reached) return {Outcome::unstable, {{"stopped at, s", course.end}}, course.why};
  const Vector5 held = shaft.held(shaft.bearing->frequencies(kSpeed).cage * kEnd);
  const double off = (shaft.state.q.head<2>() - held.head<2>()).norm() / held.norm();
  return {judged(off, 0.01, 10),
          {{"off the place where the load holds it, of the deflection", off},
           {"steps", static_cast<double>(course.steps)}}};
}

const Registered scene{
    with_candidates({"F22",
                     "a stiff bearing",
                     {{"RK4 beyond the limit of the contacts", beyond, Role::also},
                      {"stiffness of a tenth of the load, constant", constant_stiffness, Role::also}}},
                    {automatic(1e-7), radau(1e-7), alpha(1e-4), runge_kutta8(1e-7)}, {1e-7, 1e-4}, judge)};

}  // namespace
}  // namespace lithe::lab
