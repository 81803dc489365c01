#include "joints/control/control_diagram.h"

#include <algorithm>
#include <cmath>

#include "engine/base/checks.h"
#include "engine/base/spline.h"

namespace lithe {
namespace {

bool same(const JointCoordinate& a, const JointCoordinate& b) {
  return a.kind == b.kind && a.A == b.A && a.B == b.B && a.axis == b.axis && a.sign == b.sign;
}

/// Refuses a table's axis that does not grow.
void require_axis(const std::vector<double>& x, const std::string& name) {
  bool grows = x.size() > 1;
  for (std::size_t i = 0; i < x.size(); ++i) grows &= std::isfinite(x[i]) && (i == 0 || x[i] > x[i - 1]);
  if (!grows) throw SceneError("the axis of " + name + " does not grow", "", "give two values or more, ascending");
}

/// Where u lies on an axis: the interval, the part of it (0 … 1), and its slope by u; constant beyond the axis.
struct OnAxis {
  OnAxis(const std::vector<double>& x, double u) {
    i = static_cast<std::size_t>(std::upper_bound(x.begin() + 1, x.end() - 1, u) - x.begin()) - 1;
    const double width = x[i + 1] - x[i], s = (u - x[i]) / width;
    part = std::clamp(s, 0.0, 1.0);
    slope = s == part ? 1 / width : 0;
  }
  std::size_t i;
  double part, slope;
};

}  // namespace

ControlSignal weighted(ControlSignal a, double by_a, ControlSignal b, double by_b, double offset) {
  return a.diagram->sum({{by_a, a}, {by_b, b}}, offset, "sum");
}
ControlSignal operator+(ControlSignal a, ControlSignal b) { return weighted(a, 1, b, 1, 0); }
ControlSignal operator+(ControlSignal a, double b) { return weighted(a, 1, a, 0, b); }
ControlSignal operator-(ControlSignal a, ControlSignal b) { return weighted(a, 1, b, -1, 0); }
ControlSignal operator-(ControlSignal a, double b) { return a + -b; }
ControlSignal operator-(double a, ControlSignal b) { return weighted(b, -1, b, 0, a); }
ControlSignal operator-(ControlSignal a) { return -1 * a; }
ControlSignal operator*(double a, ControlSignal b) { return weighted(b, a, b, 0, 0); }
ControlSignal operator*(ControlSignal a, ControlSignal b) {
  return a.diagram->map(
      {a, b},
      [](const double* u, double* slopes) {
        slopes[0] = u[1], slopes[1] = u[0];
        return u[0] * u[1];
      },
      "product");
}

// ---- drawing ----

int ControlDiagram::place(const JointCoordinate& x) {
  auto& all = program_.coordinates;
  const auto at = std::find_if(all.begin(), all.end(), [&](const auto& known) { return same(known, x); });
  const auto place = static_cast<int>(at - all.begin());
  if (at == all.end()) all.push_back(x);
  return place;
}

ControlSignal ControlDiagram::add(ControlNode node) {
  program_.nodes.push_back(std::move(node));
  return {this, static_cast<int>(program_.nodes.size()) - 1};
}

ControlSignal ControlDiagram::map(std::vector<ControlSignal> inputs, ControlNode::Function f, std::string name,
                                  std::vector<ControlNode::Corner> corners) {
  ControlNode node{.name = std::move(name), .function = std::move(f), .corners = std::move(corners)};
  for (const ControlSignal& u : inputs) {
    if (u.diagram != this)
      throw SceneError("block '" + node.name + "' takes a signal of another diagram", "",
                       "draw both in one diagram, or read a state of the other one by rate()");
    node.inputs.push_back(u.node);
  }
  return add(std::move(node));
}

ControlSignal ControlDiagram::sum(const std::vector<std::pair<double, ControlSignal>>& terms, double offset,
                                  std::string name) {
  require::finite(offset, name);
  std::vector<ControlSignal> inputs;
  std::vector<double> by;
  for (const auto& [factor, u] : terms) {
    require::finite(factor, name);
    if (factor != 0) inputs.push_back(u), by.push_back(factor);
  }
  return map(
      std::move(inputs),
      [by, offset](const double* u, double* slopes) {
        double y = offset;
        for (std::size_t i = 0; i < by.size(); ++i) y += by[i] * u[i], slopes[i] = by[i];
        return y;
      },
      std::move(name));
}

ControlSignal ControlDiagram::number(double value) { return sum({}, value, "number"); }
ControlSignal ControlDiagram::value(const JointCoordinate& x) {
  return add({.name = "value", .kind = ControlNode::Kind::value, .place = place(x)});
}
ControlSignal ControlDiagram::rate(const JointCoordinate& x) {
  return add({.name = "rate", .kind = ControlNode::Kind::rate, .place = place(x)});
}
ControlSignal ControlDiagram::law(MotionLaw law) {
  if (!law) throw SceneError("a law is empty", "", "give one, as in constant(1), or an Input");
  return add({.name = "law", .kind = ControlNode::Kind::law, .law = std::move(law)});
}

ControlSignal ControlDiagram::saturated(ControlSignal u, double lower, double upper, std::string name) {
  if (!(lower < upper)) throw SceneError("the lower limit of " + name + " is not below the upper", "", "exchange them");
  std::vector<ControlNode::Corner> corners;
  for (const double limit : {lower, upper})
    if (std::isfinite(limit)) corners.push_back({u.node, limit});
  return map(
      {u},
      [lower, upper](const double* in, double* slopes) {
        slopes[0] = *in > lower && *in < upper ? 1 : 0;
        return std::isnan(*in) ? *in : std::clamp(*in, lower, upper);
      },
      std::move(name), std::move(corners));
}

ControlSignal ControlDiagram::dead_band(ControlSignal u, double width, std::string name) {
  require::positive(width, "width of " + name);
  return map({u},
             [width](const double* in, double* slopes) {
               slopes[0] = std::abs(*in) > width ? 1 : 0;
               return std::abs(*in) <= width ? 0 : *in - std::copysign(width, *in);
             },
             std::move(name), {{u.node, -width}, {u.node, width}});
}

ControlSignal ControlDiagram::table(ControlSignal u, std::vector<double> x, std::vector<double> y, std::string name) {
  require_axis(x, name);
  if (y.size() != x.size())
    throw SceneError(name + " has " + std::to_string(x.size()) + " x and " + std::to_string(y.size()) + " y", "",
                     "give one y for each x");
  for (const double value : y) require::finite(value, name);
  std::vector<ControlNode::Corner> corners;
  for (const double level : x) corners.push_back({u.node, level});
  return map(
      {u},
      [x = std::move(x), y = std::move(y)](const double* in, double* slopes) {
        const OnAxis at(x, *in);
        const double rise = y[at.i + 1] - y[at.i];
        slopes[0] = rise * at.slope;
        return y[at.i] + rise * at.part;
      },
      std::move(name), std::move(corners));
}

ControlSignal ControlDiagram::spline(ControlSignal u, std::vector<double> x, std::vector<double> y, std::string name) {
  require_axis(x, name);
  const double first = x.front(), last = x.back();
  return map({u},
             [curve = CubicSpline(std::move(x), std::move(y), name), first, last](const double* in, double* slopes) {
               const auto at = curve(std::isnan(*in) ? *in : std::clamp(*in, first, last));
               slopes[0] = *in >= first && *in <= last ? at.slope : 0;
               return at.value;
             },
             name, {{u.node, first}, {u.node, last}});
}

ControlSignal ControlDiagram::table(ControlSignal u, ControlSignal v, std::vector<double> x, std::vector<double> y,
                                    MatrixX values, std::string name) {
  require_axis(x, name), require_axis(y, name);
  if (values.rows() != static_cast<Eigen::Index>(x.size()) || values.cols() != static_cast<Eigen::Index>(y.size()) ||
      !values.allFinite())
    throw SceneError(name + " is not a finite value for each x (rows) and y (columns)", "",
                     "give " + std::to_string(x.size()) + " rows and " + std::to_string(y.size()) + " columns");
  return map(
      {u, v},
      [x = std::move(x), y = std::move(y), f = std::move(values)](const double* in, double* slopes) {
        const OnAxis a(x, in[0]), b(y, in[1]);
        const auto i = static_cast<Eigen::Index>(a.i), j = static_cast<Eigen::Index>(b.i);
        const double low = f(i, j) + a.part * (f(i + 1, j) - f(i, j)),
                     high = f(i, j + 1) + a.part * (f(i + 1, j + 1) - f(i, j + 1));
        slopes[0] = a.slope * ((1 - b.part) * (f(i + 1, j) - f(i, j)) + b.part * (f(i + 1, j + 1) - f(i, j + 1)));
        slopes[1] = b.slope * (high - low);
        return low + b.part * (high - low);
      },
      std::move(name));
}

ControlSignal ControlDiagram::function(ControlSignal u, std::function<double(double)> f, std::string name) {
  if (!f) throw SceneError("block '" + name + "' has no function", "", "give one");
  return map(
      {u},
      [f = std::move(f)](const double* in, double* slopes) {
        const double step = 1e-5 * std::max(1.0, std::abs(*in));
        slopes[0] = (f(*in + step) - f(*in - step)) / (2 * step);
        return f(*in);
      },
      std::move(name));
}

ControlSignal ControlDiagram::relay(ControlSignal u, double lower, double upper, std::string name) {
  if (!(lower <= upper)) throw SceneError("the lower level of " + name + " is above the upper", "", "exchange them");
  const ControlSignal on = state(0, std::move(name));
  derive(on, number(0));
  const int input = sum({{1, u}}, 0, "input of a relay").node;
  program_.relays.push_back({on.node, input, program_.nodes[on.node].place, lower, upper});
  return on;
}
ControlSignal ControlDiagram::greater(ControlSignal a, ControlSignal b, std::string name) {
  return relay(a - b, 0, 0, std::move(name));
}

ControlSignal ControlDiagram::later(std::string name) {
  ControlNode node{.name = std::move(name), .inputs = {-1}, .function = [](const double* u, double* slopes) {
                     slopes[0] = 1;
                     return *u;
                   }};
  return add(std::move(node));
}
void ControlDiagram::close(ControlSignal later, ControlSignal is) {
  ControlNode& node = program_.nodes[later.node];
  if (node.inputs != std::vector{-1})
    throw SceneError("signal '" + node.name + "' is closed already, or was not made by later()", "", "close it once");
  node.inputs = {is.node};
}

void ControlDiagram::push(const JointCoordinate& x, ControlSignal effort) {
  const int at = place(x);
  for (ControlProgram::Output& output : program_.outputs)
    if (output.coordinate == at) {
      output.node = (ControlSignal{this, output.node} + effort).node;
      return;
    }
  program_.outputs.push_back({at, sum({{1, effort}}, 0, "effort").node});
}

VectorX ControlDiagram::start() const {
  VectorX z(static_cast<Eigen::Index>(program_.states.size()));
  for (std::size_t i = 0; i < program_.states.size(); ++i) z[static_cast<Eigen::Index>(i)] = program_.states[i].start;
  return z;
}

std::vector<Marker> ControlDiagram::markers(const FirstOrderStates& states) const {
  std::vector<Marker> markers = CoordinateSet(program_.coordinates).markers();
  for (int i = 0; i < states.point_count(); ++i) markers.push_back(states.point(i));
  return markers;
}

}  // namespace lithe
