#pragma once

#include <array>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/math.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/motion_law.h"

namespace lithe {

/// A signal of a control diagram and how it is computed.
struct ControlNode {
  enum class Kind { value, rate, law, state, function };
  /// Its value, and its slopes by each input.
  using Function = std::function<double(const double* inputs, double* slopes)>;

  std::string name;
  Kind kind = Kind::function;
  int place = 0;  // of the coordinate, of the state
  MotionLaw law{};
  std::vector<int> inputs{};
  Function function{};
  struct Corner {
    int input;  // its node
    double level;
  };
  std::vector<Corner> corners{};  // where the function has a kink
};

/// A control diagram in an order in which it can be computed.
struct ControlProgram {
  static constexpr int kMostSignals = 2000, kMostSlopes = 8000;  // kept on the stack

  struct State {
    int node, rate;  // rate: the node of its derivative; -1: not said
    double start;
  };
  struct Output {
    int coordinate, node;
  };
  struct Relay {
    int node, input, state;
    double lower, upper;
  };
  /// All signals at one state, and how each depends on its inputs.
  struct Signals {
    std::array<double, kMostSignals> value;
    std::array<double, kMostSlopes> slope;
  };

  std::vector<ControlNode> nodes;
  std::vector<JointCoordinate> coordinates;
  std::vector<State> states;
  std::vector<Output> outputs;
  std::vector<Relay> relays;
  std::vector<int> order;  // of the nodes; made by sort()

  /// Throws SceneError for an algebraic loop, naming its blocks, for what is not closed or derived, and for more
  /// signals than there is room for.
  void sort();
  /// Leaves out of the order what none of these needs.
  void keep(const std::vector<int>& nodes);
  /// `x`: value and rate of each coordinate, `z`: the states. Throws SimulationError, naming the block, where a signal
  /// is not finite.
  void evaluate(double time, const double* z, const double* x, Signals& signals) const;
  /// ∂node/∂(x, z), by one sweep backwards; `slopes`: 2 coordinates + states long.
  void differentiate(const Signals& signals, int node, double* slopes) const;
  /// Whether a relay has to switch.
  bool is_due(const Relay& relay, const Signals& signals) const;

 private:
  std::vector<int> first_slope_;
};

}  // namespace lithe
