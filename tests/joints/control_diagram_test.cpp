// Control diagrams: blocks and loops against closed forms, exact transfer functions and characteristic polynomials.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "engine/analysis/state_space.h"
#include "engine/archive/archive.h"
#include "engine/base/dense.h"
#include "engine/base/spline.h"
#include "engine/run/simulation.h"
#include "joints/control/control_force.h"
#include "joints/forces/first_order_states.h"
#include "joints/prismatic_joint.h"
#include "tests/joints/mechanisms.h"
#include "tests/support/joint_checks.h"
#include "tests/support/message_of.h"
#include "tests/support/pairs.h"

namespace lithe::test::control_diagram_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

ControlForce& add_small(SystemGraph& graph, const ControlDiagram& diagram) {
  auto& states = graph.add<FirstOrderStates>("states", {.start = diagram.start()});
  return graph.add<ControlForce>("control", diagram.markers(states), {diagram});
}

/// A diagram and nothing else; `draw` gives the signal that is looked at.
struct Alone {
  template <class Draw>
  explicit Alone(Draw draw)
      : signal(draw(diagram)), scene({0, 0, 0}, [this](SystemGraph& graph) { control = &add_small(graph, diagram); }) {}
  double value() { return read(scene, control->sensor(signal, "y")); }
  double at(Integrator& method, double t) {
    scene.run(method, t);
    return value();
  }

  ControlDiagram diagram;
  ControlSignal signal;
  ControlForce* control = nullptr;
  Scene scene;
};

struct Tried {
  const char* name;
  Method (*make)();
};
const Tried kMethods[] = {{"automatic", [] { return automatic(1e-8); }},
                          {"Runge-Kutta", [] { return runge_kutta(1e-9); }},
                          {"Radau", [] { return radau(1e-9); }},
                          {"BDF", [] { return bdf(1e-9); }},
                          {"IDA", [] { return ida(1e-9); }},
                          {"index 2", [] { return index2(5e-4); }}};

/// Value of a polynomial with coefficients by falling powers, and its derivative.
Complex value(const std::vector<double>& p, Complex s) {
  Complex sum = 0;
  for (const double c : p) sum = sum * s + c;
  return sum;
}
std::vector<double> slope(const std::vector<double>& p) {
  std::vector<double> out;
  for (std::size_t i = 0; i + 1 < p.size(); ++i) out.push_back(p[i] * static_cast<double>(p.size() - 1 - i));
  return out;
}
std::vector<Complex> roots(const std::vector<double>& p) {
  const auto n = static_cast<Eigen::Index>(p.size()) - 1;
  MatrixX companion = MatrixX::Zero(n, n);
  companion.diagonal(-1).setOnes();
  for (Eigen::Index i = 0; i < n; ++i) companion(i, n - 1) = -p[static_cast<std::size_t>(n - i)] / p[0];
  const Eigen::EigenSolver<MatrixX> solver(companion, false);
  return {solver.eigenvalues().begin(), solver.eigenvalues().end()};
}
/// Step response of numerator/denominator by its residues.
double step_response(const std::vector<double>& numerator, const std::vector<double>& denominator, double t) {
  Complex y = value(numerator, 0) / value(denominator, 0);
  for (const Complex s : roots(denominator))
    y += value(numerator, s) / (s * value(slope(denominator), s)) * std::exp(s * t);
  return y.real();
}

TEST(ControlDiagram, AnswersAStepAsItsTransferFunctionSays) {
  const std::vector<std::pair<std::vector<double>, std::vector<double>>> functions = {
      {{25}, {1, 2 * 0.3 * 5, 25}}, {{4, 2}, {2, 6}}, {{1, 3, 5, 7}, {1, 4, 24, 40}}};
  for (const Tried& tried : kMethods) {
    SCOPED_TRACE(tried.name);
    for (const auto& [numerator, denominator] : functions) {
      Alone block([&](ControlDiagram& d) { return d.transfer_function(d.number(1), numerator, denominator); });
      const Method method = tried.make();
      for (const double t : {0.2, 1.0, 2.5})
        EXPECT_NEAR(block.at(*method, t), step_response(numerator, denominator, t), 2e-6) << t;
    }
  }
  // The second order in closed form: 1 - e^(-ζωt) (cos ω_d t + ζω/ω_d sin ω_d t).
  const double decay = 1.5, omega = std::sqrt(25 - decay * decay), t = 0.8;
  EXPECT_NEAR(step_response({25}, {1, 3, 25}, t),
              1 - std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t)), 1e-12);
}

TEST(ControlDiagram, HasTheFrequencyResponseOfItsBlocks) {
  const std::vector<double> numerator = {2, 3, 50}, denominator = {1, 6, 30, 40};
  MatrixX A(2, 2), B(2, 1), C(1, 2), D(1, 1);
  A << -1, 4, -9, -2;
  B << 1, 2;
  C << 3, -1;
  D << 0.5;
  ControlDiagram diagram;
  SystemGraph graph;
  auto& input = graph.add<Input>("u");
  const ControlSignal u = diagram.law(input);
  const ControlSignal y[] = {diagram.transfer_function(u, numerator, denominator),
                             diagram.state_space({u}, A, B, C, D)[0], diagram.lag(diagram.integral(u), 0.2)};
  auto& control = add_small(graph, diagram);
  const System system = assemble(graph);
  const StateSpace linear =
      linearize(system, system.initial_state(), {&input},
                {control.sensor(y[0], "a"), control.sensor(y[1], "b"), control.sensor(y[2], "c")});
  for (const double omega : {0.1, 1.0, 5.0, 40.0}) {
    const Complex s(0, omega);
    const auto H = linear.response(s);
    const Eigen::Matrix2cd resolvent = (s * Eigen::Matrix2cd::Identity() - A.cast<Complex>()).inverse();
    const Complex by_states = (C.cast<Complex>() * resolvent * B.cast<Complex>())(0, 0) + D(0, 0);
    EXPECT_LT(std::abs(H(0, 0) - value(numerator, s) / value(denominator, s)), 1e-8 * std::abs(H(0, 0)));
    EXPECT_LT(std::abs(H(1, 0) - by_states), 1e-8 * std::abs(by_states));
    EXPECT_LT(std::abs(H(2, 0) - 1.0 / (s * (0.2 * s + 1.0))), 1e-8 * std::abs(H(2, 0)));
  }
}

// ---- loops ----

const double kInertia = 0.5, kP = 60, kI = 80, kD = 9, kFilter = 40, kGoal = 1.5;
/// Of the servo below: J s² + k_p + k_i/s + k_d N s/(s + N), times s (s + N).
const std::vector<double> kCharacteristic = {kInertia, kInertia* kFilter, kP + kD* kFilter, kP* kFilter + kI,
                                             kI* kFilter};
const std::vector<double> kServo = {kP + kD * kFilter, kP* kFilter + kI, kI* kFilter};

struct Servo {
  explicit Servo(const ControlPid& pid = {kP, kI, kD, kFilter})
      : scene({0, 0, 0}, [&](SystemGraph& graph) {
          shaft = draw_shaft(graph, "shaft", kInertia);
          diagram.push(shaft.angle(), diagram.pid(kGoal - diagram.value(shaft.angle()), pid));
          control = &add_small(graph, diagram);
        }) {}
  double angle() { return read(scene, coordinate(shaft.angle(), "phi")); }

  ControlDiagram diagram;
  Shaft shaft;
  ControlForce* control = nullptr;
  Scene scene;
};

TEST(ControlDiagram, ClosesALoopWithTheRootsOfItsCharacteristicPolynomial) {
  Servo servo;
  State state = servo.scene.system.initial_state();
  std::vector<Complex> poles;
  for (const Mode& mode : linearize(servo.scene.system, state).modes) {
    poles.push_back(mode.eigenvalue);
    poles.push_back(std::conj(mode.eigenvalue));
  }
  for (const Complex root : roots(kCharacteristic)) {
    double nearest = kInfinity;
    for (const Complex pole : poles) nearest = std::min(nearest, std::abs(pole - root));
    EXPECT_LT(nearest, 1e-6 * std::abs(root)) << root;
  }
}

TEST(ControlDiagram, RunsAPidWithFilterAsItsResiduesSay) {
  for (const Tried& tried : kMethods) {
    SCOPED_TRACE(tried.name);
    Servo servo;
    const Method method = tried.make();
    for (const double t : {0.1, 0.5, 2.0}) {
      servo.scene.run(*method, t);
      EXPECT_NEAR(servo.angle(), kGoal * step_response(kServo, kCharacteristic, t), 1e-5) << t;
    }
  }
}

/// A weak servo far from its goal, against the test's own integration of the same law.
TEST(ControlDiagram, DoesNotWindUpAtItsLimit) {
  const double limit = 3;
  const auto peak_of = [&](double tracking, bool waits, std::vector<double>& at) {
    std::array<double, 4> y{};  // angle, speed, integral, filtered error
    y[3] = 0;
    const auto rates = [&](const std::array<double, 4>& s) {
      const double e = kGoal - s[0], wanted = kP * e + s[2] + kD * kFilter * (e - s[3]);
      const double u = std::clamp(wanted, -limit, limit);
      double integral = kI * e;
      if (tracking > 0)
        integral += (u - wanted) / tracking;
      else if (waits && u != wanted && wanted * e > 0)
        integral = 0;
      return std::array<double, 4>{s[1], u / kInertia, integral, kFilter * (e - s[3])};
    };
    const double h = 2e-5;
    double peak = 0;
    for (int k = 0; k < 100000; ++k) {
      const auto moved = [&](const std::array<double, 4>& d, double by) {
        std::array<double, 4> out = y;
        for (std::size_t i = 0; i < 4; ++i) out[i] += by * d[i];
        return out;
      };
      const auto a = rates(y), b = rates(moved(a, h / 2)), c = rates(moved(b, h / 2)), d = rates(moved(c, h));
      for (std::size_t i = 0; i < 4; ++i) y[i] += h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]);
      peak = std::max(peak, y[0]);
      if ((k + 1) % 25000 == 0) at.push_back(y[0]);
    }
    return peak;
  };
  std::vector<double> wound;
  const double wound_peak = peak_of(0, false, wound);
  for (const double tracking : {0.0, 0.2}) {
    Servo servo({kP, kI, kD, kFilter, limit, tracking});
    const Method method = radau(1e-8);
    std::vector<double> expected;
    EXPECT_LT(peak_of(tracking, true, expected), wound_peak - 0.2);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      servo.scene.run(*method, 0.5 * static_cast<double>(i + 1));
      EXPECT_NEAR(servo.angle(), expected[i], 2e-4);
      EXPECT_GT(std::abs(expected[i] - wound[i]), i == 0 ? -1 : 1e-2);
    }
  }
}

// ---- blocks without memory, limits ----

TEST(ControlDiagram, LooksUpTables) {
  const auto of = [](auto draw) { return Alone(draw).value(); };
  const std::vector<double> x = {-1, 0, 2}, y = {5, 1, 4};
  for (const auto& [u, expected] : {std::pair(-3.0, 5.0), {-0.25, 2.0}, {1.0, 2.5}, {9.0, 4.0}})
    EXPECT_DOUBLE_EQ(of([&, u](ControlDiagram& d) { return d.table(d.number(u), x, y); }), expected);
  const CubicSpline curve(x, y, "");
  for (const auto& [u, at] : {std::pair(-3.0, -1.0), {1.2, 1.2}, {9.0, 2.0}})
    EXPECT_DOUBLE_EQ(of([&, u](ControlDiagram& d) { return d.spline(d.number(u), x, y); }), curve(at).value);
  MatrixX f(3, 2);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 2; ++j) f(i, j) = (1 + 2 * x[i]) * (3 - j);  // bilinear
  EXPECT_DOUBLE_EQ(of([&](ControlDiagram& d) {
                     return d.table(d.number(0.7), d.number(0.3), x, {0, 1}, f);
                   }),
                   (1 + 1.4) * (3 - 0.3));
  for (const auto& [u, expected] : {std::pair(-0.5, -0.3), {0.1, 0.0}, {0.7, 0.5}})
    EXPECT_NEAR(of([u](ControlDiagram& d) { return d.dead_band(d.number(u), 0.2); }), expected, 1e-15);
  EXPECT_EQ(of([](ControlDiagram& d) { return d.saturated(d.number(7) * d.number(2), -1, 3); }), 3);
  EXPECT_DOUBLE_EQ(of([](ControlDiagram& d) { return d.function(d.number(2), [](double u) { return std::exp(u); }); }),
                   std::exp(2.0));
}

TEST(ControlDiagram, LimitsIntegralsAndRates) {
  // u = 1 - t: the integral reaches its limit 0.3 at 1 - sqrt(0.4), waits there until t = 1, and falls.
  Alone integral([](ControlDiagram& d) { return d.integral(d.law(ramp(1, -1)), 0, -1, 0.3); });
  const Method method = radau(1e-9);
  Simulation simulation{integral.scene.system, *method};
  integral.control->join(simulation, integral.scene.state);
  for (const auto& [t, expected] : {std::pair(0.2, 0.18), {0.9, 0.3}, {1.4, 0.3 - 0.08}, {2.0, 0.3 - 0.5}}) {
    simulation.run(integral.scene.state, t);
    EXPECT_NEAR(integral.value(), expected, 1e-6) << t;  // it passes its limit by a little before it waits
  }
  Alone limited([](ControlDiagram& d) { return d.rate_limited(d.number(1), 2, 1e-3); });
  const Method other = radau(1e-8);
  EXPECT_NEAR(limited.at(*other, 0.3), 0.6, 1e-7);
  EXPECT_NEAR(limited.at(*other, 1), 1, 1e-7);
}

// ---- switches ----

/// ẋ = ∓a between the levels ±h of a relay: a triangle of period 4 h / a.
TEST(ControlDiagram, RelayCyclesBetweenItsLevels) {
  const double a = 2, h = 0.25;
  for (const Tried& tried : kMethods) {
    SCOPED_TRACE(tried.name);
    Alone cycle([&](ControlDiagram& d) {
      const ControlSignal x = d.state(0, "x"), on = d.relay(x, -h, h);
      d.derive(x, d.chosen(on, d.number(-a), d.number(a)));
      return x;
    });
    const Method method = tried.make();
    Simulation simulation{cycle.scene.system, *method};
    cycle.control->join(simulation, cycle.scene.state);
    simulation.run(cycle.scene.state, 2.6);
    ASSERT_EQ(simulation.events().size(), 10u);
    for (int i = 0; i < 10; ++i) EXPECT_NEAR(simulation.events()[i].time, (h + 2 * h * i) / a, 1e-9);
    EXPECT_EQ(simulation.events()[0].name, "control: relay");
    EXPECT_NEAR(cycle.value(), -h + a * (2.6 - 2.375), 1e-8);
  }
}

TEST(ControlDiagram, LogicSwitchesTogetherAndStartsAsItsSignalsSay) {
  // On within 1 < t < 2 by two comparisons; the integral is the time within.
  for (const double start : {0.0, 1.5}) {
    Alone window([&](ControlDiagram& d) {
      const ControlSignal t = d.law(ramp(start, 1));
      return d.integral(d.greater(t, d.number(1), "late") * d.greater(d.number(2), t, "early"));
    });
    const Method method = runge_kutta(1e-9);
    Simulation simulation{window.scene.system, *method};
    window.control->join(simulation, window.scene.state);
    simulation.run(window.scene.state, 3);
    EXPECT_NEAR(window.value(), start > 1 ? 0.5 : 1, 1e-12);
  }
}

TEST(ControlDiagram, SaysThatRelaysNeedARun) {
  Alone late([](ControlDiagram& d) { return d.greater(d.law(ramp(0, 1)), d.number(0.5), "late"); });
  const Method method = runge_kutta(1e-9);
  expect_says(message_of<SimulationError>([&] { late.scene.run(*method, 1); }), {"relay 'late'", "join(simulation"});
}

// ---- as an element ----

TEST(ControlForce, IsExactInNewtonsMatrixBetweenAllBodies) {
  for (const Pair& pair : pairs()) {
    SCOPED_TRACE(pair.name);
    SystemGraph graph{{.gravity = Vector3::Zero()}};
    const std::vector<Marker> ends = pair.draw(graph, {0.3, 0.5, -0.4});
    const JointCoordinate length{JointCoordinate::Kind::distance, ends[0], ends[1]};
    const JointCoordinate along = displacement_between(ends[0], ends[1], 1);
    ControlDiagram d;
    const ControlSignal x = d.value(length), slow = d.lag(x * d.rate(along), 0.3);
    d.push(length, d.transfer_function(x - 0.4, {2, 30}, {1, 5, 40}) - 3 * d.rate(length) - 5 * x);
    d.push(along, d.function(slow + d.value(along), [](double u) { return std::sin(u); }) * x);
    auto& control = add_small(graph, d);
    check_force(graph, control, {.conservative = false, .tolerance = 1e-7});
  }
}

TEST(ControlForce, ResumesWithTheSameBits) {
  const auto draw = [](ControlDiagram& d) {
    const ControlSignal x = d.state(0, "x"), on = d.relay(x, -0.25, 0.25);
    d.derive(x, d.chosen(on, d.number(-2), d.number(2)) + 0.1 * d.transfer_function(x, {1}, {1, 1, 30}));
    return x;
  };
  for (const Tried& tried : kMethods) {
    if (tried.name == std::string("IDA")) continue;  // it cannot tell its history
    SCOPED_TRACE(tried.name);
    Alone whole(draw), first(draw), second(draw);
    const Method a = tried.make(), b = tried.make(), c = tried.make();
    Simulation all{whole.scene.system, *a}, begins{first.scene.system, *b}, goes_on{second.scene.system, *c};
    whole.control->join(all, whole.scene.state), first.control->join(begins, first.scene.state);
    second.control->join(goes_on, second.scene.state);
    all.run(whole.scene.state, 0.9), all.run(whole.scene.state, 2);
    begins.run(first.scene.state, 0.9);
    Archive archive;
    begins.save(first.scene.state, archive);
    archive.rewind();
    State state = goes_on.resume(archive);
    goes_on.run(state, 2);
    EXPECT_EQ(state.v, whole.scene.state.v);
    EXPECT_EQ(state.q, whole.scene.state.q);
  }
}

TEST(ControlDiagram, SaysWhatIsWrongAndHowToFixIt) {
  const auto refused = [](auto draw) {
    return message_of<SceneError>([&] { Alone alone([&](ControlDiagram& d) { return draw(d), d.number(0); }); });
  };
  expect_says(refused([](ControlDiagram& d) {
                d.transfer_function(d.number(1), {1, 0, 1}, {1, 1}, "lead");
              }),
              {"lead is improper", "degree 2", "denominator 1", "fast enough"});
  expect_says(refused([](ControlDiagram& d) {
                d.state_space({d.number(1)}, MatrixX::Identity(2, 2), MatrixX(2, 2), MatrixX(1, 2), MatrixX(1, 1));
              }),
              {"B of state space is 2 x 2", "2 x 1"});
  expect_says(refused([](ControlDiagram& d) {
                const ControlSignal y = d.later("y"), e = d.number(1) - y;
                d.close(y, d.saturated(3 * e, -1, 1, "gain"));
              }),
              {"algebraic loop", "y <- gain", "<- y", "put a state"});
  expect_says(refused([](ControlDiagram& d) { d.later("speed"); }), {"'speed' is not closed"});
  expect_says(refused([](ControlDiagram& d) { d.state(0, "heat"); }), {"'heat' has no derivative"});
  expect_says(refused([](ControlDiagram& d) { d.pid(d.number(1), {.derivative = 1}); }), {"no filter"});
  expect_says(refused([](ControlDiagram& d) { d.lag(d.number(1), 0); }), {"time constant of lag"});
  expect_says(refused([](ControlDiagram& d) { d.table(d.number(1), {1, 1}, {2, 3}); }), {"does not grow"});
  expect_says(refused([](ControlDiagram& d) {
                ControlDiagram other;
                d.saturated(other.number(1), 0, 1);
              }),
              {"another diagram"});
  expect_says(refused([](ControlDiagram& d) {
                for (int i = 0; i < 25; ++i) d.lag(d.number(1), 1);
              }),
              {"25 states", "one element", "add_control"});
  expect_says(refused([](ControlDiagram& d) {
                ControlSignal y = d.number(1);
                for (int i = 0; i < ControlProgram::kMostSignals; ++i) y = 2 * y;
              }),
              {"2002 signals", "several diagrams"});
  // A loop through a state is none, and a signal that is not a number names its block.
  Alone loop([](ControlDiagram& d) {
    const ControlSignal y = d.later("y");
    d.close(y, d.lag(1 - y, 0.5));
    return y;
  });
  const Method method = radau(1e-9);
  EXPECT_NEAR(loop.at(*method, 1), 0.5 * (1 - std::exp(-4.0)), 1e-8);
  Alone root([](ControlDiagram& d) {
    return d.integral(d.function(
        d.law(ramp(0.5, -1)), [](double u) { return std::sqrt(u); }, "orifice"));
  });
  expect_says(message_of<SimulationError>([&] { root.scene.run(*method, 1); }),
              {"block 'orifice' gives", "of law = -"});
}

}  // namespace
}  // namespace lithe::test::control_diagram_test
