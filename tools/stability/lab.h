#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "engine/motion/integrator.h"
#include "engine/study/stability_map.h"

/// The laboratory's scenes: what each file of scenes/ registers.
namespace lithe::lab {

using Outcome = StabilityOutcome;

/// A measured figure, and the one of the published table if it has it.
struct Figure {
  std::string what;  // with its unit: "|g| at 100 s, m"
  double value;
  double published = std::numeric_limits<double>::quiet_NaN();
  int digits =
      2;  // that must agree; 1: one digit; 0: the order of magnitude (round-off, random numbers, other programs)
};
/// Whether a figure has the digits of the published one: within half a unit of the last of them, and a hundredth.
bool agrees(const Figure& figure);

/// How one method did: the first figure is the cell's own.
struct Finding {
  Outcome outcome;
  std::vector<Figure> figures;
  std::string why{};
  double largest_stable_step = std::numeric_limits<double>::quiet_NaN();  // s
};

enum class Role {
  published,  // a method of the published table, named as there
  ours,       // the library with its defaults: must pass wherever any method passes
  also,       // others that are worth showing
};
enum class Cost { quick, slow };  // slow: more than some seconds, left out of the tests

struct Cell {
  std::string method;
  std::function<Finding()> run;
  Role role = Role::published;
  Cost cost = Cost::quick;
};
/// What every method of the engine is given on a scene.
struct Settings {
  double tolerance, step;  // s
};
struct Scene {
  std::string id, title;  // "S01", "constraint drift"
  std::vector<Cell> cells;
  // Where all methods can be tried: it makes as many of one as it needs, with the settings.
  std::function<Finding(const std::function<std::unique_ptr<Integrator>()>& make)> judge{};
  Settings settings{};
};

/// All scenes of the executable, by id.
std::vector<Scene> scenes();

/// A scene's file has one of these at namespace scope: the list of scenes is the folder scenes/, and adding one touches
/// no other file. (The one place where this project registers by a global.)
struct Registered {
  explicit Registered(Scene scene);
};

/// All methods of the engine, those for rigid contacts too.
std::vector<StudyMethod> methods_of_the_engine();
/// A scene that has a judge under one of them. What takes more than ten seconds of CPU counts as a collapsed step.
StabilityCell run(const Scene& scene, const StudyMethod& method);

/// A cell of the map; an Error that the method throws is a refusal with its words, of no figure.
StabilityCell run(const Scene& scene, const Cell& cell);
Finding run(const Cell& cell);

/// The outcome of a detector: unstable if it is not finite or beyond `unbounded`, converged within `limit`.
Outcome judged(double detector, double limit, double unbounded = std::numeric_limits<double>::infinity());

}  // namespace lithe::lab
