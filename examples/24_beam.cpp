// 24_beam: a strip of spring steel, bent far and swinging: a geometrically exact beam.
//
// Shows: a beam made of a section and a line; its equilibrium under a load that bends it by 0.7 of its length; how its
//        error falls with the elements; its swing from a hinge beside that of a rigid rod; the moment inside.
// Expect: extrapolated from 20 and 40 elements the end is where the elastica has it, to 1e-5 of the length, and the
//         error falls by four; the strip's energy stays to 1e-6 J; its end is more than 5 cm away from the rod's.
#include <cstdio>

#include "lithe/lithe.h"

using namespace lithe;

int main() {
  // 1. A strip of spring steel: 1 m long, 20 mm wide, 0.5 mm thick. Axis 1 runs along it, axis 2 across.
  const double length = 1;
  const BeamSection strip = BeamSection::rectangle(0.02, 0.0005, {2.1e11, 0.3, 7850});
  const double EI = strip.stiffness(4, 4);  // about axis 2
  const auto axis = BeamAxis::straight({0, 0, 0}, {length, 0, 0}, {0, 1, 0});

  // 2. Statics: clamped, pushed up at its end by 5 EI/L², without weight.
  const auto pushed = [&](int elements) {
    SystemGraph graph{{.gravity = {0, 0, 0}}};
    auto& beam = graph.add<Beam>("strip", {.axis = axis, .sections = {{0, strip}}, .elements = elements});
    graph.add<FixedJoint>("clamp", {graph.ground().marker({}, beam.axes(0)), beam.marker(0)});
    graph.add<PointForce>("push", {beam.marker(length)}, {.force = {0, 0, 5 * EI / (length * length)}});
    const System system = assemble(graph);
    const Equilibrium bent = find_equilibrium(system, system.initial_state());
    Snapshot now(system, bent.state);
    const Vector3 tip = now.marker(beam.marker(length)).p;
    std::printf("%d elements: tip at x %.6f m, z %.6f m; %d iterations\n", elements, tip.x(), tip.z(), bent.iterations);
    return tip;
  };
  const Vector3 coarse = pushed(20), fine = pushed(40), limit = (4 * fine - coarse) / 3;
  const Vector3 elastica(0.6123716392755701, 0, 0.7137915236119128);  // elliptic integrals, without stretch
  const double off = (limit - elastica).norm();
  const double fall = (coarse - elastica).norm() / (fine - elastica).norm();
  std::printf("extrapolated: x %.6f m, z %.6f m, off the elastica by %.1e m; error falls by %.2f\n", limit.x(),
              limit.z(), off, fall);

  // 3. Dynamics: hung from a hinge, let go level, as a beam and as a rigid rod beside it.
  SystemGraph graph;
  auto& beam = graph.add<Beam>("strip", {.axis = axis, .sections = {{0, strip}}});
  const MassProperties m = box({length, 0.02, 0.0005}, 7850);
  auto& rod = graph.add<RigidBody>("rod", {.mass = m.mass, .inertia = m.inertia, .position = {length / 2, 0, 0}});
  const Matrix3 hinge = rotation_about({1, 0, 0}, M_PI / 2);  // its z along -y
  graph.add<RevoluteJoint>("hinge of the strip", {graph.ground().marker({}, hinge), beam.marker(0, {}, hinge)});
  graph.add<RevoluteJoint>("hinge of the rod",
                           {graph.ground().marker({}, hinge), rod.marker({-length / 2, 0, 0}, hinge)});
  const System system = assemble(graph);
  State state = system.initial_state();
  Recorder recorder{{position(beam.marker(length), "strip"), position(rod.marker({length / 2, 0, 0}), "rod"),
                     total_energy("energy"), beam.resultants(10, "middle")}};
  Radau radau{{.tolerance = {.relative = 1e-5, .absolute = 1e-6}}};
  Simulation simulation{system, radau};
  simulation.observe(recorder, every(1e-2));
  simulation.run(state, 1.0);
  recorder.write_csv("results/beam/motion.csv");

  // 4. Check the answer.
  const Table& table = recorder.table();
  double apart = 0, drift = 0, moment = 0;
  for (std::size_t i = 0; i < table.column("t").size(); ++i) {
    apart = std::max(apart, std::hypot(table.column("strip_x")[i] - table.column("rod_x")[i],
                                       table.column("strip_z")[i] - table.column("rod_z")[i]));
    drift = std::max(drift, std::abs(table.column("energy")[i] - table.column("energy")[0]));
    moment = std::max(moment, std::abs(table.column("middle_m_2")[i]));
  }
  std::printf("ends of strip and rod up to %.3f m apart; moment in the middle up to %.4f N m; energy kept to %.1e J\n",
              apart, moment, drift);
  return off < 1e-5 && std::abs(fall - 4) < 0.1 && drift < 1e-6 && apart > 0.05 ? 0 : 1;
}
