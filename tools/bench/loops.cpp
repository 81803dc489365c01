// loops: closed mechanisms by an error-controlled method, against the reference tables of tests/data/benchmarks.
//
//   --problem andrews    relative error of the worst angle at 0.03 s (R03)
//             four_bar   largest error of the first upright's top over 20 s, m; --n 40 windows (R02). Also its LIM
//                        error: the root mean square of the errors of x, y, vx, vy, each relative to its value or 1e-3
//             bricard    largest error of P3 over 10 s, m (R04)
//             governor   largest error of the slider over 10 s, m (R05)
//   --reference FILE     the table   --method automatic  --tol 1e-6   --repeat 5
#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/output/csv.h"
#include "engine/simplify/simplification.h"
#include "tests/reference/loops.h"
#include "tools/bench/runs.h"
#include "tools/bench/scenes.h"
#include "tools/bench/studies.h"

namespace {

using namespace lithe;
using namespace lithe::bench;

/// A scene, how long it moves, and its error at a row of the table, given without the row's time.
struct Problem {
  using Error = std::function<double(const State&, const double* row)>;
  std::function<void(SystemGraph&)> draw;
  Vector3 gravity;
  double end;  // s
  Error error;
  double first = 0;             // s, of the rows compared
  Error mean_square = nullptr;  // averaged over the rows, or none
  bool planar = false;          // all of it moves in one plane
};

Vector3 position(const State& state, int body) { return state.q.segment<3>(7 * body); }
Matrix3 axes(const State& state, int body) { return rotation_matrix(state.q.segment<4>(7 * body + 3)); }

/// Angle of a body's x axis in the plane less `expected`, whole turns left out.
double turned(const State& state, int body, double expected) {
  const Vector3 x = axes(state, body).col(0);
  return std::remainder(std::atan2(x.y(), x.x()) - expected, 2 * M_PI);
}

double andrews_error(const State& state, const double* row) {
  const double beta = row[0], theta = row[1], gamma = row[2], phi = row[3], delta = row[4], omega = row[5],
               epsilon = row[6];
  const double expected[] = {beta, beta + theta, gamma, phi + delta, delta, omega + epsilon, epsilon};
  double off[7];  // of the bodies K1 .. K7
  for (int i = 0; i < 7; ++i) off[i] = turned(state, i, expected[i]);
  const double error[] = {off[0], off[1] - off[0], off[2], off[3] - off[4], off[4], off[5] - off[6], off[6]};
  double worst = 0;
  for (int i = 0; i < 7; ++i) worst = std::max(worst, std::abs(error[i] / row[i]));
  return worst;
}

/// Position and velocity of the first upright's top, twice as far from its pin as its centre.
double four_bar_error(const State& state, const double* row) {
  return std::hypot(2 * state.q[0] - row[2], 2 * state.q[1] - row[3]);
}
double four_bar_mean_square(const State& state, const double* row) {
  const double seen[] = {2 * state.q[0], 2 * state.q[1], 2 * state.v[0], 2 * state.v[1]};
  double sum = 0;
  for (int i = 0; i < 4; ++i) sum += std::pow((seen[i] - row[i + 2]) / std::max(std::abs(row[i + 2]), 1e-3), 2) / 4;
  return sum;
}

double bricard_error(const State& state, const double* row) {
  const Vector3 P3 = position(state, 1) + 0.5 * axes(state, 1).col(0);
  return (P3 - Vector3(row[0], row[1], row[2])).norm();
}

double governor_error(const State& state, const double* row) { return std::abs(position(state, 1).z() - row[2]); }

Problem problem(const std::string& name, int windows) {
  const Vector3 down_y(0, -9.81, 0), down_z(0, 0, -9.81);
  if (name == "andrews") {
    const StudyScene study = andrews_squeezer::scene();
    return {study.draw, study.gravity, 0.03, andrews_error, 0.03, nullptr, true};
  }
  if (name == "four_bar")
    return {[=](SystemGraph& graph) { test::draw_four_bars(graph, windows); },
            down_y,
            20,
            four_bar_error,
            0,
            four_bar_mean_square,
            true};
  if (name == "bricard") return {test::draw_bricard, down_y, 10, bricard_error};
  if (name == "governor") return {flyball_governor::scene().draw, down_z, 10, governor_error};
  throw std::invalid_argument("no problem '" + name + "'; known are andrews, bricard, four_bar, governor");
}

}  // namespace

int main(int argument_count, char** words) {
  return run_program(argument_count, words, [](Arguments& arguments) {
    const std::string name = arguments.text("problem", "andrews"), reference = arguments.text("reference", "");
    const int windows = arguments.integer("n", 40);
    const Setting setting = read_setting(arguments);
    arguments.finish();

    const Problem asked = problem(name, windows);
    const Table table = read_csv(reference);
    std::vector<double> times;
    std::vector<const double*> rows;
    for (int row = 0; row < table.row_count(); ++row) {
      const double time = table.at(row, 0), slack = 1e-9 * asked.end;
      if (time < asked.first - slack || time > asked.end + slack) continue;
      times.push_back(time);
      rows.push_back(table.values.data() + row * table.columns.size() + 1);
    }
    if (times.empty()) throw std::runtime_error(reference + " holds no row that belongs to " + name);

    SystemGraph graph{{.gravity = asked.gravity}};
    asked.draw(graph);
    Simplification simple{graph, {.planar = asked.planar}};  // in a plane: three coordinates, and the rows within it
    const System system = assemble(simple.graph());
    std::vector<double> errors(times.size()), squares(times.size());
    State state = simple.whole().initial_state();
    const Run run = follow(system, setting, simple.start(), times, [&](int row, const State& small) {
      if (simple.smaller()) simple.expand(small, state);
      const State& whole = simple.smaller() ? state : small;
      errors[row] = asked.error(whole, rows[row]);
      if (asked.mean_square) squares[row] = asked.mean_square(whole, rows[row]);
    });
    const double error = *std::max_element(errors.begin(), errors.end());

    JsonLine line;
    line.add("engine", "Lithe").add("problem", name);
    if (name == "four_bar") line.add("n", windows);
    run.add_to(line, setting).add("error", error, 4).add("digits", -std::log10(error), 4);
    if (asked.mean_square)
      line.add("lim_error",
               std::sqrt(std::accumulate(squares.begin(), squares.end(), 0.0) / static_cast<double>(squares.size())),
               4);
    line.print();
  });
}
