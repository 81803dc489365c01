#include "joints/control/control_program.h"

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/number_text.h"

namespace lithe {

void ControlProgram::sort() {
  enum class Mark : char { unseen, open, done };
  std::vector<Mark> marks(nodes.size(), Mark::unseen);
  std::vector<int> path;
  order.clear();
  const auto visit = [&](auto&& self, int i) -> void {
    if (marks[i] == Mark::done) return;
    if (marks[i] == Mark::open) {
      std::string loop;
      for (auto at = std::find(path.begin(), path.end(), i); at != path.end(); ++at) loop += nodes[*at].name + " <- ";
      throw SceneError("it has an algebraic loop: " + loop + nodes[i].name, "",
                       "put a state into the loop: a lag, an integral, a proper transfer function");
    }
    marks[i] = Mark::open;
    path.push_back(i);
    for (const int input : nodes[i].inputs) {
      if (input < 0)
        throw SceneError("signal '" + nodes[i].name + "' is not closed", "", "say what it is by close(later, signal)");
      self(self, input);
    }
    path.pop_back();
    marks[i] = Mark::done;
    order.push_back(i);
  };
  for (int i = 0; i < static_cast<int>(nodes.size()); ++i) visit(visit, i);
  for (const State& state : states)
    if (state.rate < 0)
      throw SceneError("state '" + nodes[state.node].name + "' has no derivative", "",
                       "give it by derive(state, rate)");
  int slopes = 0;
  first_slope_.clear();
  for (const ControlNode& node : nodes) {
    first_slope_.push_back(slopes);
    slopes += static_cast<int>(node.inputs.size());
  }
  if (nodes.size() > kMostSignals || slopes > kMostSlopes)
    throw SceneError("it has " + std::to_string(nodes.size()) + " signals and " + std::to_string(slopes) +
                         " connections; there is room for " + std::to_string(kMostSignals) + " and " +
                         std::to_string(kMostSlopes),
                     "", "draw several diagrams");
}

void ControlProgram::keep(const std::vector<int>& kept) {
  std::vector<char> needed(nodes.size(), 0);
  for (const int i : kept) needed[i] = 1;
  for (auto at = order.rbegin(); at != order.rend(); ++at)
    if (needed[*at])
      for (const int input : nodes[*at].inputs) needed[input] = 1;
  std::erase_if(order, [&](int i) { return !needed[i]; });
}

void ControlProgram::evaluate(double time, const double* z, const double* x, Signals& signals) const {
  double in[kMostSlopes];
  for (const int i : order) {
    const ControlNode& node = nodes[i];
    double& value = signals.value[i];
    switch (node.kind) {
      case ControlNode::Kind::value:
        value = x[2 * node.place];
        break;
      case ControlNode::Kind::rate:
        value = x[2 * node.place + 1];
        break;
      case ControlNode::Kind::state:
        value = z[node.place];
        break;
      case ControlNode::Kind::law:
        value = node.law(time).value;
        break;
      case ControlNode::Kind::function:
        for (std::size_t k = 0; k < node.inputs.size(); ++k) in[k] = signals.value[node.inputs[k]];
        value = node.function(in, signals.slope.data() + first_slope_[i]);
    }
    if (std::isfinite(value)) continue;
    std::string from;
    for (const int k : node.inputs)
      from += (from.empty() ? ", of " : " and ") + nodes[k].name + " = " + number_text(signals.value[k]);
    throw SimulationError(
        "block '" + node.name + "' gives " + number_text(value) + from + " at " + time_text(time) + ".", "",
        "look at its function and its inputs, or take smaller steps.");
  }
}

void ControlProgram::differentiate(const Signals& signals, int node, double* slopes) const {
  const int n = 2 * static_cast<int>(coordinates.size());
  std::fill_n(slopes, n + static_cast<int>(states.size()), 0.0);
  double by[kMostSignals];  // ∂node/∂signal
  std::fill_n(by, nodes.size(), 0.0);
  by[node] = 1;
  for (auto at = order.rbegin(); at != order.rend(); ++at) {
    const ControlNode& here = nodes[*at];
    const double seen = by[*at];
    if (seen == 0) continue;
    if (here.kind == ControlNode::Kind::value) slopes[2 * here.place] += seen;
    if (here.kind == ControlNode::Kind::rate) slopes[2 * here.place + 1] += seen;
    if (here.kind == ControlNode::Kind::state) slopes[n + here.place] += seen;
    for (std::size_t k = 0; k < here.inputs.size(); ++k)
      by[here.inputs[k]] += seen * signals.slope[first_slope_[*at] + static_cast<int>(k)];
  }
}

bool ControlProgram::is_due(const Relay& relay, const Signals& signals) const {
  const double u = signals.value[relay.input];
  return signals.value[relay.node] > 0.5 ? u < relay.lower : u > relay.upper;
}

}  // namespace lithe
