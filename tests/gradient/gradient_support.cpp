#include "tests/gradient/gradient_support.h"

#include <algorithm>
#include <array>

#include "engine/base/log.h"
#include "engine/gradient/recorded_run.h"
#include "engine/gradient/sample_weights.h"
#include "engine/observe/snapshot.h"

namespace lithe::test {
namespace {

/// Of quantities at rest: a gradient by one parameter that nothing depends on.
VectorX values_at_rest(const ParametricScene& scene, const std::vector<Quantity>& quantities,
                       const std::vector<DesignParameter>& parameters) {
  ParametricScene fixed = scene;
  Table table;
  for (const DesignParameter& p : parameters) table.columns.push_back(p.name), table.values.push_back(p.value);
  fixed.draw = [&](SystemGraph& graph, const SweepPoint&) { return scene.draw(graph, SweepPoint(table, 0)); };
  for (ParametricEvent& event : fixed.events)
    event.change = [&table, change = event.change](State& state, const SweepPoint&) {
      change(state, SweepPoint(table, 0));
    };
  return gradient(fixed, quantities, {{"nothing", 1}}, {.mode = GradientOptions::Mode::tangent}).values;
}

/// The quantities' values alone, of the run that gradient() takes, without its derivatives.
VectorX values(const ParametricScene& scene, const std::vector<Quantity>& quantities,
               const std::vector<DesignParameter>& parameters) {
  using Kind = Quantity::Kind;
  const log::Quiet quiet;  // of rows that repeat others, once a run
  if (std::any_of(quantities.begin(), quantities.end(),
                  [](const Quantity& q) { return q.kind == Kind::at_rest || q.kind == Kind::frequency; }))
    return values_at_rest(scene, quantities, parameters);
  const Drawing drawing(scene, parameters);
  std::vector<State> states;
  const RecordedRun run(scene, drawing, GradientOptions{}.memory, [&](const State& state) { states.push_back(state); });
  Snapshot now(drawing.system());
  VectorX sums = VectorX::Zero(static_cast<Eigen::Index>(quantities.size()));
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    Quantity q = quantities[i];
    if (q.kind == Kind::integral && q.to < 0) q.to = run.times().back();
    const Drawing::Place place = drawing.find(q.column);
    const auto read = [&](const State& state) {
      now.evaluate(state, Accelerations::solved);
      return drawing.sensor(place.sensor).value(now, place.column);
    };
    std::vector<double> samples;
    if (q.kind == Kind::largest || q.kind == Kind::smallest)
      for (const State& state : states) samples.push_back(read(state));
    for (const SampleWeight& w : sample_weights(q, run.times(), samples))
      sums[static_cast<Eigen::Index>(i)] += w.weight * read(states[static_cast<std::size_t>(w.step)]);
  }
  return sums;
}

/// Romberg's extrapolation of central differences with steps h, h/2, h/4: error h⁶.
VectorX difference(const ParametricScene& scene, const std::vector<Quantity>& quantities,
                   const std::vector<DesignParameter>& parameters, std::size_t k) {
  const double h = 4e-3 * (parameters[k].value == 0 ? 1 : std::abs(parameters[k].value));
  std::array<VectorX, 3> table;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double step = h / static_cast<double>(1 << i);
    std::vector<DesignParameter> up = parameters, down = parameters;
    up[k].value += step, down[k].value -= step;
    table[i] = (values(scene, quantities, up) - values(scene, quantities, down)) / (2 * step);
  }
  for (std::size_t order = 1; order < table.size(); ++order)
    for (std::size_t i = table.size() - 1; i >= order; --i)
      table[i] += (table[i] - table[i - 1]) / (std::pow(4.0, static_cast<double>(order)) - 1);
  return table.back();
}

}  // namespace

void expect_gradient(const ParametricScene& scene, const std::vector<Quantity>& quantities,
                     const std::vector<DesignParameter>& parameters, double tolerance, bool has_adjoint) {
  MatrixX expected(static_cast<Eigen::Index>(quantities.size()), static_cast<Eigen::Index>(parameters.size()));
  VectorX scales(expected.cols());
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    expected.col(static_cast<Eigen::Index>(k)) = difference(scene, quantities, parameters, k);
    scales[static_cast<Eigen::Index>(k)] = parameters[k].value == 0 ? 1 : std::abs(parameters[k].value);
  }
  for (const auto mode : {GradientOptions::Mode::tangent, GradientOptions::Mode::adjoint}) {
    if (mode == GradientOptions::Mode::adjoint && !has_adjoint) continue;
    const Gradient found = gradient(scene, quantities, parameters, {.mode = mode});
    for (Eigen::Index i = 0; i < expected.rows(); ++i) {
      const double size = (expected.row(i).transpose().cwiseProduct(scales)).lpNorm<Eigen::Infinity>();
      for (Eigen::Index k = 0; k < expected.cols(); ++k)
        EXPECT_NEAR(found.derivatives(i, k) * scales[k], expected(i, k) * scales[k], tolerance * size)
            << scene.name << ", " << found.quantities[i] << " by " << found.parameters[k]
            << (mode == GradientOptions::Mode::tangent ? ", tangent" : ", adjoint")
            << (found.differenced ? ", columns differenced" : "") << "; largest " << size;
      if (std::getenv("LITHE_SHOW_ERRORS"))
        std::printf(
            "%s: %s %s: largest error %.1e\n", scene.name.c_str(), found.quantities[i].c_str(),
            mode == GradientOptions::Mode::tangent ? "tangent" : (found.differenced ? "adjoint-d" : "adjoint"),
            ((found.derivatives.row(i) - expected.row(i)).transpose().cwiseProduct(scales)).lpNorm<Eigen::Infinity>() /
                size);
    }
  }
}

void expect_of_near_runs(const ParametricScene& scene, const std::vector<Quantity>& quantities,
                         const std::vector<DesignParameter>& parameters, double tolerance, bool has_adjoint) {
  constexpr double kNear = 1e-5;  // of the parameters
  MatrixX expected(static_cast<Eigen::Index>(quantities.size()), static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto moved = [&](double steps) {
      std::vector<DesignParameter> near = parameters;
      near[k].value *= 1 + steps * kNear;
      return values(scene, quantities, near);
    };
    expected.col(static_cast<Eigen::Index>(k)) = (8 * (moved(1) - moved(-1)) - (moved(2) - moved(-2))) / (12 * kNear);
  }
  for (const auto mode : {GradientOptions::Mode::automatic, GradientOptions::Mode::adjoint}) {
    if (mode == GradientOptions::Mode::adjoint && !has_adjoint) continue;
    MatrixX found = gradient(scene, quantities, parameters, {.mode = mode}).derivatives;
    for (std::size_t k = 0; k < parameters.size(); ++k) found.col(static_cast<Eigen::Index>(k)) *= parameters[k].value;
    for (Eigen::Index i = 0; i < found.rows(); ++i) {
      const double off =
          (found.row(i) - expected.row(i)).lpNorm<Eigen::Infinity>() / expected.row(i).lpNorm<Eigen::Infinity>();
      EXPECT_LE(off, tolerance) << scene.name << ", " << quantities[static_cast<std::size_t>(i)].name() << ": "
                                << found.row(i) << "; of runs: " << expected.row(i);
      if (std::getenv("LITHE_SHOW_ERRORS"))
        std::printf("%s, %s: off %.1e of near runs\n", scene.name.c_str(),
                    quantities[static_cast<std::size_t>(i)].name().c_str(), off);
    }
  }
}

void expect_close(const Gradient& found, const Gradient& expected, const std::vector<DesignParameter>& parameters,
                  double tolerance) {
  VectorX scales(found.derivatives.cols());
  for (std::size_t k = 0; k < parameters.size(); ++k) scales[static_cast<Eigen::Index>(k)] = parameters[k].value;
  for (Eigen::Index i = 0; i < found.derivatives.rows(); ++i) {
    const VectorX scaled = expected.derivatives.row(i).transpose().cwiseProduct(scales);
    const VectorX off = found.derivatives.row(i).transpose().cwiseProduct(scales) - scaled;
    const double error = off.lpNorm<Eigen::Infinity>() / scaled.lpNorm<Eigen::Infinity>();
    EXPECT_LE(error, tolerance) << found.quantities[static_cast<std::size_t>(i)];
    if (std::getenv("LITHE_SHOW_ERRORS")) std::printf("%ld steps: off %.1e\n", found.steps, error);
  }
}

void expect_bits_of_the_run(const ParametricScene& scene, const std::vector<DesignParameter>& parameters,
                            const std::vector<std::string>& columns) {
  std::vector<Quantity> quantities;
  for (const std::string& column : columns) quantities.push_back(value_at(column, scene.duration));
  const Gradient found = gradient(scene, quantities, parameters);
  Table table;
  for (const DesignParameter& parameter : parameters)
    table.columns.push_back(parameter.name), table.values.push_back(parameter.value);
  SystemGraph graph{{.gravity = scene.gravity}};
  const std::vector<Sensor> sensors = scene.draw(graph, SweepPoint(table, 0));
  const System system = assemble(graph);
  State state = system.initial_state();
  const auto integrator = scene.integrator();
  Simulation simulation(system, *integrator);
  simulation.run(state, scene.duration);
  Snapshot now(system);
  now.evaluate(state, Accelerations::solved);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    int seen = 0;
    for (const Sensor& sensor : sensors)
      for (std::size_t c = 0; c < sensor.columns().size(); ++c)
        if (sensor.columns()[c] == columns[i]) {
          EXPECT_EQ(found.values[i], sensor.value(now, static_cast<int>(c))) << columns[i];
          ++seen;
        }
    EXPECT_EQ(seen, 1) << columns[i];
  }
}

}  // namespace lithe::test
