#pragma once

#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "tools/bench/measure.h"

/// What the drivers of the other engines share: the command line, the reference files, the errors and the JSON line.
/// A driver is written against its engine's own headers and never links Lithe; SI units, z up.
///
///   --problem chain   --n 16   --joint spherical|revolute   --method ...   --T 1   --dt 1e-3 | --tol 1e-6
///   --reference FILE   --repeat 1  runs, the cheapest counts
namespace lithe::bench::peers {

constexpr double kGravity = 9.81;     // m/s^2, along -z unless the problem says otherwise
constexpr double kRodLength = 1;      // m
constexpr double kRodMass = 1;        // kg
constexpr double kAcross = 1.0 / 12;  // kg m^2, central
constexpr double kAlong = 1.25e-3;    // kg m^2, never excited: the chain's motion is planar
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// The stiff chain: a point of the rod's inboard end B and a point A of the rod before (the ground) are tied by
///   F = k d + c ḋ,   d = p_B - p_A,   ḋ = v_B - (velocity of A's body at p_B),
/// which acts on both bodies at p_B: an isotropic bushing in the axes of A.
constexpr double kBushingStiffness = 1e6;  // N/m
constexpr double kBushingDamping = 1e3;    // N s/m

using Point = std::array<double, 3>;  // m, or m/s, world axes

inline Point operator+(const Point& a, const Point& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Point operator*(double s, const Point& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double norm(const Point& a) { return std::sqrt(dot(a, a)); }
inline Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A rod of the chain in world axes; its axis points to the outboard end.
struct Rod {
  Point center, axis, velocity, angular_velocity;

  Point inboard() const { return center - (0.5 * kRodLength) * axis; }
  Point outboard() const { return center + (0.5 * kRodLength) * axis; }
  Point velocity_at(const Point& p) const { return velocity + cross(angular_velocity, p - center); }
};

/// Force of the bushing between two rods (the first: nothing before) on the outer one, at its inboard end.
inline Point bushing_force(const Rod* before, const Rod& rod) {
  const Point at = rod.inboard();
  Point stretch = at, speed = rod.velocity_at(at);
  if (before != nullptr) {
    stretch = stretch - before->outboard();
    speed = speed - before->velocity_at(at);
  }
  return -kBushingStiffness * stretch - kBushingDamping * speed;
}

/// Rows of numbers, separated by blanks or commas; comments (#) and column titles are passed over.
inline std::vector<std::vector<double>> read_table(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::invalid_argument("cannot read " + path);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    for (char& c : line)
      if (c == ',') c = ' ';
    std::istringstream words(line);
    std::vector<double> row;
    for (double value; words >> value;) row.push_back(value);
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

/// What one run has cost and how wrong it ended.
struct Outcome {
  double seconds = 0;  // CPU, of the stepping alone
  long steps = 0;
  double tip_error = kUnknown, joint_error = kUnknown;  // m: last and worst joint point of a chain
  double error = kUnknown;                              // of a loop, as its problem says
  double energy_error = kUnknown;                       // chains: of the energy exchanged; loops: J
  std::string note;                                     // what a reader of the figure should know
};

/// The cheapest of some runs.
template <class Run>
Outcome cheapest_of(int repeats, Run&& run) {
  Outcome best = run();
  for (int i = 1; i < repeats; ++i) {
    const Outcome again = run();
    if (again.seconds < best.seconds) best = again;
  }
  return best;
}

/// What an engine can be asked for; the first of each list is the default.
struct Engine {
  std::string name, version;
  std::vector<std::string> problems, methods;
  std::vector<std::string> joints = {"spherical", "revolute"};
  bool controls_error = false;  // understands --tol
};

/// One call of a driver. Throws std::invalid_argument for what the engine cannot do.
class Request {
 public:
  std::string problem, joint, method;
  int count, repeats;
  double end;        // s
  double tolerance;  // of an error-controlled run
  bool fixed;        // else error-controlled
  long steps = 0;    // of a fixed run
  double step = 0;   // s, end / steps

  Request(Arguments& arguments, Engine engine) : engine_(std::move(engine)) {
    problem = choice(arguments, "problem", engine_.problems);
    joint = choice(arguments, "joint", engine_.joints);
    method = choice(arguments, "method", engine_.methods);
    count = arguments.integer("n", 16);
    if (problem == "andrews") count = 7;
    if (problem == "bricard") count = 5;
    repeats = arguments.integer("repeat", 1);
    end = arguments.number("T", usual_end());
    step = arguments.number("dt", engine_.controls_error ? 0 : 1e-3);
    fixed = step > 0;
    tolerance = engine_.controls_error ? arguments.number("tol", 1e-6) : kUnknown;
    reference_ = arguments.text("reference", "");
    if (count < 1 || repeats < 1 || !(end > 0) || step < 0)
      throw std::invalid_argument("--n, --repeat, --T and --dt are positive");
    if (fixed) {
      steps = std::max(1L, std::lround(end / step));
      step = end / static_cast<double>(steps);
    }
    if (!reference_.empty()) table_ = read_table(reference_);
  }

  bool spherical() const { return joint == "spherical"; }
  bool is_chain() const { return problem == "chain" || problem == "stiff_chain"; }
  /// Rows of --reference; empty without it.
  const std::vector<std::vector<double>>& reference() const { return table_; }

  /// Errors of a chain, and |E(T) - E(0)| of the energy exchanged, which holds without bushings.
  void judge(const std::vector<Rod>& rods, Outcome& outcome) const {
    double kinetic = 0, potential = 0;  // both nothing at the start
    for (const Rod& rod : rods) {
      const double spin = dot(rod.angular_velocity, rod.axis);
      kinetic += 0.5 * kRodMass * dot(rod.velocity, rod.velocity) + 0.5 * kAlong * spin * spin +
                 0.5 * kAcross * (dot(rod.angular_velocity, rod.angular_velocity) - spin * spin);
      potential += kRodMass * kGravity * rod.center[2];
    }
    if (problem == "chain")
      outcome.energy_error = std::abs(kinetic + potential) / std::max(std::abs(kinetic), std::abs(potential));
    if (table_.empty()) return;
    if (table_.size() != rods.size())
      throw std::invalid_argument(reference_ + " has " + std::to_string(table_.size()) + " joint points, the chain " +
                                  std::to_string(rods.size()));
    outcome.joint_error = 0;
    for (std::size_t i = 0; i < rods.size(); ++i) {
      const std::vector<double>& row = table_[i];
      if (row.size() != 2) throw std::invalid_argument(reference_ + ": a row is 'x z' of a joint point");
      outcome.tip_error = norm(rods[i].outboard() - Point{row[0], 0, row[1]});
      if (!(outcome.tip_error <= outcome.joint_error)) outcome.joint_error = outcome.tip_error;  // no number wins too
    }
  }

  void print_json(const Outcome& outcome) const {
    JsonLine line;
    line.add("engine", engine_.name).add("version", engine_.version).add("problem", problem);
    if (problem == "chain") line.add("joint", joint);
    line.add("method", method).add("n", count).add(fixed ? "dt" : "tol", fixed ? step : tolerance);
    line.add("steps", outcome.steps).add("cpu_seconds", outcome.seconds);
    if (is_chain())
      line.add("tip_error", outcome.tip_error).add("joint_error", outcome.joint_error);
    else
      line.add("error", outcome.error);
    line.add("energy_error", outcome.energy_error);
    if (!outcome.note.empty()) line.add("note", outcome.note);
    line.print();
  }

 private:
  static std::string choice(Arguments& arguments, const std::string& name, const std::vector<std::string>& known) {
    const std::string given = arguments.text(name, known.front());
    std::string list;
    for (const std::string& one : known) {
      if (one == given) return given;
      list += (list.empty() ? "" : ", ") + one;
    }
    throw std::invalid_argument("no " + name + " '" + given + "' here; known are " + list);
  }
  double usual_end() const { return problem == "andrews" ? 0.03 : is_chain() ? 1 : 10; }
  Engine engine_;
  std::string reference_;
  std::vector<std::vector<double>> table_;
};

}  // namespace lithe::bench::peers
