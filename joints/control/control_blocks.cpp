// Dynamic blocks: states and what drives them.
#include <algorithm>
#include <cmath>

#include "engine/base/checks.h"
#include "joints/control/control_diagram.h"

namespace lithe {

ControlSignal ControlDiagram::state(double start, std::string name) {
  require::finite(start, "start of " + name);
  const ControlSignal x = add(
      {.name = std::move(name), .kind = ControlNode::Kind::state, .place = static_cast<int>(program_.states.size())});
  program_.states.push_back({x.node, -1, start});
  return x;
}

void ControlDiagram::derive(ControlSignal state, ControlSignal rate) {
  const ControlNode& node = program_.nodes[state.node];
  if (node.kind != ControlNode::Kind::state || program_.states[node.place].rate >= 0)
    throw SceneError("'" + node.name + "' is no state, or has its derivative already", "",
                     "give it once for each state");
  const int place = node.place;  // sum() adds a node: the reference is gone
  program_.states[place].rate = sum({{1, rate}}, 0, "rate of " + node.name).node;
}

ControlSignal ControlDiagram::integral(ControlSignal u, double start, double lower, double upper, std::string name) {
  const ControlSignal x = state(start, name);
  if (std::isinf(lower) && std::isinf(upper)) {
    derive(x, u);
    return x;
  }
  if (!(start >= lower && start <= upper))
    throw SceneError("the start of " + name + " is not within its limits", "", "give lower <= start <= upper");
  std::vector<ControlNode::Corner> corners = {{u.node, 0}};
  for (const double limit : {lower, upper})
    if (std::isfinite(limit)) corners.push_back({x.node, limit});
  derive(x, map(
                {x, u},
                [lower, upper](const double* in, double* slopes) {
                  const bool waits = (in[0] >= upper && in[1] > 0) || (in[0] <= lower && in[1] < 0);
                  slopes[0] = 0, slopes[1] = waits ? 0 : 1;
                  return waits ? 0 : in[1];
                },
                name, std::move(corners)));
  return saturated(x, lower, upper, name);
}

ControlSignal ControlDiagram::lag(ControlSignal u, double time_constant, double start, std::string name) {
  require::positive(time_constant, "time constant of " + name);
  const ControlSignal x = state(start, std::move(name));
  derive(x, (1 / time_constant) * (u - x));
  return x;
}

ControlSignal ControlDiagram::rate_limited(ControlSignal u, double rate, double time_constant, double start,
                                           std::string name) {
  require::positive(rate, "rate of " + name);
  require::positive(time_constant, "time constant of " + name);
  const ControlSignal x = state(start, name);
  derive(x, saturated((1 / time_constant) * (u - x), -rate, rate, name));
  return x;
}

ControlSignal ControlDiagram::transfer_function(ControlSignal u, std::vector<double> numerator,
                                                std::vector<double> denominator, std::string name) {
  for (auto* coefficients : {&numerator, &denominator}) {
    for (const double c : *coefficients) require::finite(c, "coefficients of " + name);
    const auto leading = std::find_if(coefficients->begin(), coefficients->end(), [](double c) { return c != 0; });
    coefficients->erase(coefficients->begin(), leading);
  }
  if (denominator.empty()) throw SceneError("the denominator of " + name + " is zero", "", "give its coefficients");
  if (numerator.size() > denominator.size())
    throw SceneError(name + " is improper: its numerator has degree " + std::to_string(numerator.size() - 1) +
                         ", its denominator " + std::to_string(denominator.size() - 1),
                     "", "add poles that are fast enough: (s T + 1) in the denominator");
  // ẋ_i = x_{i+1}, ẋ_n = u - Σ a_i x_i, y = Σ (b_i - a_i b_n) x_i + b_n u, a and b over the leading coefficient.
  const std::size_t n = denominator.size() - 1;
  numerator.insert(numerator.begin(), n + 1 - numerator.size(), 0);
  std::vector<ControlSignal> x;
  for (std::size_t i = 0; i < n; ++i) x.push_back(state(0, name));
  std::vector<std::pair<double, ControlSignal>> last = {{1, u}}, y;
  const double leading = denominator[0], direct = numerator[0] / leading;
  for (std::size_t i = 0; i < n; ++i) {
    const double a = denominator[n - i] / leading, b = numerator[n - i] / leading;
    last.push_back({-a, x[i]});
    y.push_back({b - a * direct, x[i]});
    if (i > 0) derive(x[i - 1], x[i]);
  }
  y.push_back({direct, u});
  if (n > 0) derive(x[n - 1], sum(last, 0, name));
  return sum(y, 0, name);
}

std::vector<ControlSignal> ControlDiagram::state_space(const std::vector<ControlSignal>& u, const MatrixX& A,
                                                       const MatrixX& B, const MatrixX& C, const MatrixX& D,
                                                       const VectorX& start, std::string name) {
  const Eigen::Index n = A.rows(), inputs = static_cast<Eigen::Index>(u.size()), outputs = C.rows();
  const auto refuse = [&](const char* matrix, const MatrixX& is, Eigen::Index rows, Eigen::Index columns) {
    if (is.rows() != rows || is.cols() != columns || !is.allFinite())
      throw SceneError(std::string(matrix) + " of " + name + " is " + std::to_string(is.rows()) + " x " +
                           std::to_string(is.cols()) + (is.allFinite() ? "" : " and not finite"),
                       "",
                       "give " + std::to_string(rows) + " x " + std::to_string(columns) +
                           " finite numbers: " + std::to_string(n) + " states, " + std::to_string(inputs) + " inputs");
  };
  refuse("A", A, n, n), refuse("B", B, n, inputs), refuse("C", C, outputs, n), refuse("D", D, outputs, inputs);
  if (start.size() != 0) refuse("start", start, n, 1);
  std::vector<ControlSignal> x, y;
  for (Eigen::Index i = 0; i < n; ++i) x.push_back(state(start.size() == 0 ? 0 : start[i], name));
  const auto row = [&](const MatrixX& by_x, const MatrixX& by_u, Eigen::Index i) {
    std::vector<std::pair<double, ControlSignal>> terms;
    for (Eigen::Index j = 0; j < n; ++j) terms.push_back({by_x(i, j), x[static_cast<std::size_t>(j)]});
    for (Eigen::Index j = 0; j < inputs; ++j) terms.push_back({by_u(i, j), u[static_cast<std::size_t>(j)]});
    return sum(terms, 0, name);
  };
  for (Eigen::Index i = 0; i < n; ++i) derive(x[static_cast<std::size_t>(i)], row(A, B, i));
  for (Eigen::Index i = 0; i < outputs; ++i) y.push_back(row(C, D, i));
  return y;
}

ControlSignal ControlDiagram::pid(ControlSignal error, const ControlPid& p, std::string name) {
  for (const auto& [value, what] : {std::pair(p.proportional, "proportional"), std::pair(p.integral, "integral"),
                                    std::pair(p.derivative, "derivative"), std::pair(p.filter, "filter"),
                                    std::pair(p.tracking_time, "tracking_time")})
    require::not_negative(value, what);
  if (p.derivative > 0 && !(p.filter > 0))
    throw SceneError("the derivative of " + name + " has no filter", "",
                     "give .filter, 1/s: some 10 times its bandwidth");
  if (!(p.limit > 0)) throw SceneError("the limit of " + name + " is not positive", "", "give the largest output");
  std::vector<std::pair<double, ControlSignal>> parts = {{p.proportional, error}};
  if (p.derivative > 0) {
    const ControlSignal slow = lag(error, 1 / p.filter, 0, name);
    parts.push_back({p.derivative * p.filter, error});
    parts.push_back({-p.derivative * p.filter, slow});
  }
  if (p.integral == 0) {
    const ControlSignal u = sum(parts, 0, name);
    return std::isinf(p.limit) ? u : saturated(u, -p.limit, p.limit, name);
  }
  const ControlSignal x = state(0, name);
  parts.push_back({1, x});
  const ControlSignal wanted = sum(parts, 0, name);
  if (std::isinf(p.limit)) {
    derive(x, p.integral * error);
    return wanted;
  }
  const ControlSignal u = saturated(wanted, -p.limit, p.limit, name);
  if (p.tracking_time > 0) {
    derive(x, p.integral * error + (1 / p.tracking_time) * (u - wanted));
    return u;
  }
  derive(x, map(
                {wanted, error},
                [limit = p.limit, k = p.integral](const double* in, double* slopes) {
                  const bool waits = std::abs(in[0]) >= limit && in[0] * in[1] > 0;
                  slopes[0] = 0, slopes[1] = waits ? 0 : k;
                  return waits ? 0 : k * in[1];
                },
                name));
  return u;
}

}  // namespace lithe
