// beam_motion: large motions of very flexible beams at equal error, beside other packages' beams (peers/*_beam.py).
//
//   --problem falling_rod  a rubber rod of 1 m falls from a pin, level at first, for 1.8 s
//             spin_up      a hub turns a beam of 10 m up to 6 rad/s in 15 s (Simo & Vu-Quoc 1986)
//   --n 16  elements   --mass lumped|consistent   --method automatic|radau|rk8|...   --tol 1e-4   --repeat 5
//   --reference FILE  columns t, ... x_mid, ... x_tip ... (spin_up: tools/bench/data/beam_spin_up.csv); the error is
//   the
//                     largest distance of middle and tip at its instants, every 0.05 s or 0.5 s, m
//   --write FILE      these points instead of a JSON line, extrapolated from --n and twice as many elements
#include <stdexcept>

#include "bodies/beam/beam.h"
#include "engine/assembly/evaluated.h"
#include "engine/assembly/evaluator.h"
#include "engine/output/csv.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "tools/bench/runs.h"
#include "tools/bench/scenes.h"

namespace {

using namespace lithe;
using namespace lithe::bench;

struct Problem {
  std::string name;
  double length, end, period;  // m, s, s between instants
  BeamSection section;
  Vector3 gravity;

  explicit Problem(const std::string& called) : name(called) {
    if (name == "falling_rod") {
      const double EI = 0.039269908169872414, GA = 471.238898038469, J = 8.63937979737193e-6;
      length = 1, end = 1.8, period = 0.05, gravity = {0, 0, -9.81};
      section = BeamSection::diagonal({1570.796326794897, GA, GA, 0.026179938779914945, EI, EI}, 0.3455751918948773,
                                      {2 * J, J, J});
    } else if (name == "spin_up") {
      length = 10, end = 15, period = 0.5, gravity = {0, 0, 0};
      section = BeamSection::diagonal({2.8e7, 1e7, 1e7, 1.4e4, 1.4e4, 1.4e4}, 1.2, {1.2e-3, 6e-4, 6e-4});
    } else {
      throw std::invalid_argument("no problem '" + name + "'; falling_rod and spin_up are");
    }
  }
  std::vector<double> times() const {
    std::vector<double> out;
    for (int i = 1; i <= std::lround(end / period); ++i) out.push_back(i * period);
    return out;
  }
};

Motion spin(double t) {
  const double speed = 6, T = 15, w = 2 * M_PI / T;
  return {speed / T * (t * t / 2 + (std::cos(w * t) - 1) / (w * w)), speed / T * (t - std::sin(w * t) / w),
          speed / T * (1 - std::cos(w * t))};
}

struct Drawn {
  SystemGraph graph;
  Marker middle, tip;
  System system;

  Drawn(const Problem& problem, int elements, Beam::Mass mass)
      : graph{{.gravity = problem.gravity}}, system(draw(problem, elements, mass)) {}

  System draw(const Problem& problem, int elements, Beam::Mass mass) {
    const double L = problem.length;
    auto& beam = graph.add<Beam>("beam", {.axis = BeamAxis::straight({0, 0, 0}, {L, 0, 0}, {0, 1, 0}),
                                          .sections = {{0, problem.section}},
                                          .elements = elements,
                                          .mass = mass});
    if (problem.name == "spin_up") {
      auto& hub = graph.add<RevoluteJoint>("hub", {graph.ground().marker(), beam.marker(0)});
      graph.add<CoordinateDrive>("drive", {hub.angle()}, {.motion = spin});
    } else {
      graph.add<SphericalJoint>("pin", {graph.ground().marker(), beam.marker(0)});
    }
    middle = beam.marker(L / 2), tip = beam.marker(L);
    return assemble(graph);
  }
};

/// Middle and tip at the instants, a column each.
struct Flight {
  Run run;
  MatrixX points;
};
Flight fly(const Problem& problem, const Setting& setting, int elements, Beam::Mass mass) {
  const Drawn drawn(problem, elements, mass);
  const std::vector<double> times = problem.times();
  Evaluator equations(drawn.system);
  Flight flight{.points = MatrixX(6, static_cast<int>(times.size()))};
  flight.run = follow(drawn.system, setting, drawn.system.initial_state(), times, [&](int row, const State& state) {
    equations.evaluate(state.time, state.q, state.v, Level::position);
    flight.points.col(row) << marker_kinematics(equations, drawn.middle, Level::position).p,
        marker_kinematics(equations, drawn.tip, Level::position).p;
  });
  return flight;
}

/// Of middle and tip from a table of their places, m.
double error(const Flight& flight, const Problem& problem, const Table& reference) {
  std::vector<std::vector<double>> columns;
  for (const char* place : {"_mid", "_tip"})
    for (const char* axis : {"x", "y", "z"}) columns.push_back(reference.column(axis + std::string(place)));
  const std::vector<double> t = reference.column("t"), times = problem.times();
  double worst = 0;
  std::size_t row = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    while (row < t.size() && t[row] < times[i] - 1e-9) ++row;
    if (row == t.size() || t[row] > times[i] + 1e-9) throw std::invalid_argument("the reference lacks an instant");
    Vector6 exact;
    for (int k = 0; k < 6; ++k) exact[k] = columns[static_cast<std::size_t>(k)][row];
    const Vector6 off = flight.points.col(static_cast<int>(i)) - exact;
    worst = std::max({worst, off.head<3>().norm(), off.tail<3>().norm()});
  }
  return worst;
}

void write(const std::string& path, const Problem& problem, const Setting& setting, int n, Beam::Mass mass) {
  const MatrixX coarse = fly(problem, setting, n, mass).points, fine = fly(problem, setting, 2 * n, mass).points,
                finest = fly(problem, setting, 4 * n, mass).points;
  const MatrixX first = (4 * fine - coarse) / 3, second = (4 * finest - fine) / 3, best = (16 * second - first) / 15;
  Table table{.columns = {"t", "x_mid", "y_mid", "z_mid", "x_tip", "y_tip", "z_tip"}};
  const std::vector<double> times = problem.times();
  for (std::size_t i = 0; i < times.size(); ++i) {
    std::vector<double> row{times[i]};
    for (int k = 0; k < 6; ++k) row.push_back(best(k, static_cast<int>(i)));
    table.add_row(row);
  }
  write_csv(table, path);
  std::printf("finest mesh less extrapolated: %.2e m, extrapolated once less twice: %.2e m\n",
              (finest - best).cwiseAbs().maxCoeff(), (second - best).cwiseAbs().maxCoeff());
}

}  // namespace

int main(int argument_count, char** words) {
  return run_program(argument_count, words, [](Arguments& arguments) {
    const Problem problem(arguments.text("problem", "falling_rod"));
    const int n = arguments.integer("n", 16);
    const std::string mass = arguments.text("mass", "lumped"), reference = arguments.text("reference", ""),
                      path = arguments.text("write", "");
    const Setting setting = read_setting(arguments);
    arguments.finish();
    if (mass != "lumped" && mass != "consistent")
      throw std::invalid_argument("--mass " + mass + " is unknown; lumped and consistent are");
    const Beam::Mass kind = mass == "lumped" ? Beam::Mass::lumped : Beam::Mass::consistent;
    if (!path.empty()) return write(path, problem, setting, n, kind);
    const Flight flight = fly(problem, setting, n, kind);
    JsonLine line;
    line.add("engine", "Lithe").add("problem", problem.name).add("mass", mass).add("n", n);
    flight.run.add_to(line, setting);
    if (!reference.empty()) line.add("error", error(flight, problem, read_csv(reference)), 4);
    line.print();
  });
}
