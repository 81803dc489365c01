#pragma once

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "engine/model/joint_coordinate.h"
#include "engine/model/motion_law.h"
#include "joints/control/control_program.h"
#include "joints/forces/first_order_states.h"

namespace lithe {

class ControlDiagram;

/// A quantity of a control diagram. Sums, differences and products of signals and numbers are signals. Logical ones are
/// 1 (true) or 0: "a and b" is a * b, "a or b" a + b - a * b, "not a" 1 - a.
struct ControlSignal {
  ControlDiagram* diagram;
  int node;
};
ControlSignal operator+(ControlSignal a, ControlSignal b);
ControlSignal operator+(ControlSignal a, double b);
ControlSignal operator-(ControlSignal a, ControlSignal b);
ControlSignal operator-(ControlSignal a, double b);
ControlSignal operator-(double a, ControlSignal b);
ControlSignal operator-(ControlSignal a);
ControlSignal operator*(ControlSignal a, ControlSignal b);
ControlSignal operator*(double a, ControlSignal b);

/// PID controller of an error e with a filtered derivative, limited, without wind-up:
///   u = sat(k_p e + x_i + k_d N (e - x_f)),   ẋ_f = N (e - x_f)
///   ẋ_i = k_i e + (u - u_unlimited) / T_t     back-calculation (Åström and Hägglund 1995, section 3.5), or
///   ẋ_i = k_i e, zero while that drives u further beyond its limit      without T_t (conditional integration)
struct ControlPid {
  double proportional = 0;                                 // k_p
  double integral = 0;                                     // k_i, per second
  double derivative = 0;                                   // k_d, s
  double filter = 0;                                       // N, 1/s; a derivative needs it
  double limit = std::numeric_limits<double>::infinity();  // of |u|
  double tracking_time = 0;                                // T_t, s
};

/// A controller as a diagram of signals, whose dynamic blocks have states that are integrated with the scene, by any
/// method. Draw it, add its states and the ControlForce that evaluates it:
///   ControlDiagram servo;
///   const ControlSignal error = servo.law(target) - servo.value(hinge.angle());
///   servo.push(hinge.angle(), servo.pid(error, {.proportional = 80, .integral = 40}));
///   auto& states = graph.add<FirstOrderStates>("servo states", {.start = servo.start()});
///   auto& control = graph.add<ControlForce>("servo", servo.markers(states), {servo});
/// Blocks take a name for messages at the end. Each throws SceneError for numbers that are not finite or out of range,
/// and for a signal of another diagram; a function that gives what is not finite is a SimulationError that names its
/// block.
class ControlDiagram {
 public:
  ControlDiagram() = default;
  ControlDiagram(const ControlDiagram&) = delete;  // its signals refer to it
  ControlDiagram& operator=(const ControlDiagram&) = delete;

  // ---- sources ----
  ControlSignal number(double value);
  ControlSignal value(const JointCoordinate& x);  // m or rad, whole turns counted
  ControlSignal rate(const JointCoordinate& x);   // m/s or rad/s
  ControlSignal law(MotionLaw law);               // its value at the time; an Input of the scene too

  // ---- without memory ----
  ControlSignal saturated(ControlSignal u, double lower, double upper, std::string name = "saturation");
  /// u beyond ±width, less the width; zero within.
  ControlSignal dead_band(ControlSignal u, double width, std::string name = "dead band");
  /// Through a table, constant beyond it: straight lines (corners are switch points), or a natural cubic spline.
  ControlSignal table(ControlSignal u, std::vector<double> x, std::vector<double> y, std::string name = "table");
  ControlSignal spline(ControlSignal u, std::vector<double> x, std::vector<double> y, std::string name = "spline");
  /// f(x_i, y_j) = values(i, j), bilinear, constant beyond the table.
  ControlSignal table(ControlSignal u, ControlSignal v, std::vector<double> x, std::vector<double> y, MatrixX values,
                      std::string name = "table");
  /// Any smooth function; its slope is differenced.
  ControlSignal function(ControlSignal u, std::function<double(double)> f, std::string name = "function");

  // ---- switches: what they are changes at events that ControlForce::join() looks for ----
  /// 1 from where u rises above `upper` until it falls below `lower`, else 0.
  ControlSignal relay(ControlSignal u, double lower, double upper, std::string name = "relay");
  ControlSignal greater(ControlSignal a, ControlSignal b, std::string name = "comparison");
  /// a where `on` is 1, b where it is 0.
  ControlSignal chosen(ControlSignal on, ControlSignal a, ControlSignal b) { return on * a + (1 - on) * b; }

  // ---- dynamic blocks ----
  /// A state x, of any equation: ẋ is given by derive(x, rate).
  ControlSignal state(double start, std::string name);
  void derive(ControlSignal state, ControlSignal rate);
  /// ẋ = u, x within limits (it waits there, and leaves as soon as u turns).
  ControlSignal integral(ControlSignal u, double start = 0, double lower = -std::numeric_limits<double>::infinity(),
                         double upper = std::numeric_limits<double>::infinity(), std::string name = "integral");
  /// τ ẋ = u - x
  ControlSignal lag(ControlSignal u, double time_constant, double start = 0, std::string name = "lag");
  /// The same with |ẋ| at most `rate`: follows u no faster.
  ControlSignal rate_limited(ControlSignal u, double rate, double time_constant, double start = 0,
                             std::string name = "rate limiter");
  /// Coefficients by falling powers of s: {1}, {1, 2 ζ ω, ω²} is 1/(s² + 2 ζ ω s + ω²). Controllable canonical form,
  /// at rest. SceneError for an improper one (its numerator of higher degree).
  ControlSignal transfer_function(ControlSignal u, std::vector<double> numerator, std::vector<double> denominator,
                                  std::string name = "transfer function");
  /// ẋ = A x + B u, y = C x + D u; x starts at zero, or as given. SceneError for matrices that do not fit.
  std::vector<ControlSignal> state_space(const std::vector<ControlSignal>& u, const MatrixX& A, const MatrixX& B,
                                         const MatrixX& C, const MatrixX& D, const VectorX& start = {},
                                         std::string name = "state space");
  ControlSignal pid(ControlSignal error, const ControlPid& parameters, std::string name = "PID");

  // ---- feedback ----
  /// A signal that is said later, by close(). A loop without a state in it is algebraic: ControlForce refuses it.
  ControlSignal later(std::string name);
  void close(ControlSignal later, ControlSignal is);

  /// Pushes a coordinate with a force or torque, N or N m, positive as it grows; what is pushed twice feels the sum.
  /// A state of another element is such a coordinate, whose rate is the state and whose force its derivative:
  /// displacement_between(graph.ground().marker(), oil.point(0), 2).
  void push(const JointCoordinate& x, ControlSignal effort);

  // ---- for the graph ----
  /// The states at the start, as FirstOrderStates takes them.
  VectorX start() const;
  /// Those of the coordinates, then the points of the states.
  std::vector<Marker> markers(const FirstOrderStates& states) const;
  const ControlProgram& program() const { return program_; }

 private:
  friend ControlSignal operator*(ControlSignal, ControlSignal);
  friend ControlSignal weighted(ControlSignal, double, ControlSignal, double, double);
  int place(const JointCoordinate& x);
  ControlSignal add(ControlNode node);
  ControlSignal map(std::vector<ControlSignal> inputs, ControlNode::Function f, std::string name,
                    std::vector<ControlNode::Corner> corners = {});
  ControlSignal sum(const std::vector<std::pair<double, ControlSignal>>& terms, double offset, std::string name);

  ControlProgram program_;
};

}  // namespace lithe
