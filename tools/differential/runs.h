#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/differential/drawn_scene.h"

/// One scene moved in several ways.
namespace lithe::differential {

enum class Method { automatic, runge_kutta8, radau, bdf, moreau_jean, nonsmooth_alpha };

/// How a scene is run.
struct Way {
  std::string name;
  Method method = Method::automatic;
  double tolerance = 1e-8;  // relative; of time stepping: the step over the scene's time, times 1e-5
  std::uint32_t order = 0;  // of elements: a seed; 0: as drawn
  bool simplify = false;
  bool resume = false;  // saved half-way and continued by a scene drawn anew
  double nudge = 0;     // disturbs gravity and drawn velocities by that much of their units
};

/// What is compared; each kind by its own scale.
enum class Kind { position, velocity, energy, force, torque, count };
constexpr const char* kKindNames[] = {"position", "velocity", "energy", "reaction force", "reaction torque"};

struct Track {
  std::vector<std::string> columns;
  std::vector<Kind> kinds;                  // of the columns
  std::vector<std::vector<double>> values;  // a row a time
  std::string refused;                      // the error's type and text; empty: it ran
  std::string problem;                      // its first sentence
};

/// Runs the scene; what it refuses is in the track. Other exceptions than lithe::Error pass.
Track run(const DrawnScene& scene, const Way& way);

/// Largest difference of each kind, in the size of what is compared (`first`'s largest value, at least a thousandth of
/// its unit). Both ran.
struct Difference {
  double of[static_cast<int>(Kind::count)] = {};
  std::string where[static_cast<int>(Kind::count)];  // column and time
};
Difference difference(const Units& units, const Track& first, const Track& second);

}  // namespace lithe::differential
