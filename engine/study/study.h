#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/model/system_graph.h"
#include "engine/motion/make_integrator.h"
#include "engine/observe/sensors.h"

namespace lithe {

/// A scene as studies run it: drawn afresh for every run, into a graph of its own.
struct StudyScene {
  std::string name;
  double duration = 1;               // s, from t = 0
  Vector3 gravity{0, 0, -9.81};      // m/s², world axes
  double characteristic_length = 1;  // m, rad …: the unit of errors in the watched quantities
  /// Adds bodies, joints and forces and says which quantities are watched (positions of markers, coordinates,
  /// energies).
  std::function<std::vector<Sensor>(SystemGraph&)> draw;
};

/// A method as studies run it: an integrator made for a tolerance (relative and absolute alike) or for a fixed step.
struct StudyMethod {
  enum class Setting { tolerance, step };  // what make() is given: a number, or seconds
  std::string name;
  Setting setting = Setting::tolerance;
  MakeIntegratorBy<double> make;
};

}  // namespace lithe
