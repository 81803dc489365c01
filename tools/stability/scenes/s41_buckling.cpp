// S41: a column under nine tenths of its Euler load: a body that is linear in its deformation does not feel the load.
#include "engine/analysis/equilibrium.h"
#include "engine/assembly/evaluated.h"
#include "joints/fixed_joint.h"
#include "joints/forces/point_force.h"
#include "tools/stability/scenes/beam.h"
#include "tools/stability/scenes/candidates.h"

namespace lithe::lab {
namespace {

// F09: steel, 10 x 10 mm, 1 m, clamped and free; a lateral load of 1 mN at the tip.
constexpr double kLength = 1, kLateral = 1e-3, kExact = 9.874793308653146;
const Section& section() {
  static const Section s = square(0.01, 2.1e11, 0.3, 7850);
  return s;
}
double euler_load() { return M_PI * M_PI / 4 * section().bending / (kLength * kLength); }

class Column : public Bench {
 public:
  Column(int pieces, double load)
      : Bench(Vector3::Zero(),
              [&](SystemGraph& graph) {
                const double length = kLength / pieces;
                const auto basis = beam_piece(length, section(), Freedom::plane);
                Marker last = graph.ground().marker();
                for (int i = 0; i < pieces; ++i) {
                  const std::string number = std::to_string(i + 1);
                  auto& piece =
                      graph.add<FlexibleBody>("piece " + number, {.basis = basis, .position = {i * length, 0, 0}});
                  graph.add<FixedJoint>("weld " + number, {last, piece.frame()});
                  last = piece.average(end_section(*basis));
                }
                graph.add<PointForce>("load", {last}, {.force = {-load, kLateral, 0}});
              }),
        slice_(9 * (pieces - 1)),
        length_(kLength / pieces) {}

  double deflection() const {
    const State s = find_equilibrium(system, state, {.tolerance = 1e-13}).state;
    const Vector3 in_piece(length_, s.q.segment<2>(slice_ + 7).sum(), 0);
    return (s.q.segment<3>(slice_) + rotation_matrix(s.q.segment<4>(slice_ + 3)) * in_piece).y();
  }

 private:
  int slice_;      // of the last piece in q
  double length_;  // of a piece, m
};

/// One body: a solid bar of the library with its first modes.
class OneBody : private EndMarker, public Bench {
 public:
  OneBody(double load, Deflection deflection)
      : Bench(Vector3::Zero(), [&](SystemGraph& graph) {
          const auto basis = solid_cantilever(kLength, section(), 12, deflection);
          auto& column = graph.add<FlexibleBody>("column", {.basis = basis, .position = -basis->origin});
          graph.add<FixedJoint>("clamp", {graph.ground().marker(), column.frame()});
          end = column.average(basis->node_set("x_max"));
          graph.add<PointForce>("load", {end}, {.force = {-load, kLateral, 0}});
        }) {}
  double deflection() {
    const State s = find_equilibrium(system, state, {.tolerance = 1e-13}).state;
    equations.evaluate(s.time, s.q, s.v, Level::velocity);
    return marker_kinematics(equations, end, Level::position).p.y();
  }
};

double amplification(int pieces, double share) {
  return Column(pieces, share * euler_load()).deflection() / Column(pieces, 0).deflection();
}
double amplification(Deflection deflection, double share) {
  return OneBody(share * euler_load(), deflection).deflection() / OneBody(0, deflection).deflection();
}
Finding finding(double at_nine_tenths, double published, double beyond, const std::string& why) {
  return {judged(at_nine_tenths / kExact - 1, 0.01),
          {{"amplification at 0.9 P_cr", at_nine_tenths, published, 4}, {"at 1.1 P_cr", beyond}},
          why};
}
Finding linear() {
  return finding(amplification(Deflection::linear, 0.9), 1, amplification(Deflection::linear, 1.1),
                 "no geometric stiffness: passes above the critical load without lateral motion");
}
Finding stiffened() {
  const double measured = amplification(Deflection::stiffened, 0.9);
  int found = 0;
  try {
    OneBody(1.1 * euler_load(), Deflection::stiffened).deflection();
    ++found;
  } catch (const SimulationError&) {
  }
  return {judged(measured / kExact - 1, 0.01),
          {{"amplification at 0.9 P_cr", measured, 9.8712},
           {"equilibria found at 1.1 P_cr", static_cast<double>(found), 0}},
          "a flexible body of the library with displacements of second order (Deflection::stiffened)"};
}
Finding in_pieces(int pieces) {
  const double measured = amplification(pieces, 0.9);
  return {judged(measured / kExact - 1, 0.01),
          {{"amplification at 0.9 P_cr", measured}},
          "a row of floating frames feels the load through its turns; error of order 1/pieces²"};
}

const Registered scene{{"S41",
                        "buckling",
                        {{"linear FFRF", linear},
                         {"with geometric stiffness", stiffened},
                         {"32 floating frames, equilibrium", [] { return in_pieces(32); }, Role::ours},
                         {"8 floating frames, equilibrium", [] { return in_pieces(8); }, Role::also}}}};

}  // namespace
}  // namespace lithe::lab
