#pragma once

#include <string>

namespace lithe {

class System;

/// A scene of rigid bodies in trees as C++ that needs nothing but the standard library: its accelerations in joint
/// coordinates, unrolled for this one scene, without allocation, exception, loop over its size or branch. Constants are
/// folded, zeros and ones left out. Over a scalar, so that it runs on doubles and on lanes of 4 or 8 of them.
/// What it may hold: RigidBody; fixed, revolute, prismatic, cylindrical, planar and spherical joints without loops;
/// gravity, CoordinateSpring and CoordinateMotor whose numbers are constant or Inputs. (docs/site/compiled.md)
struct CompiledScene {
  std::string name;            // of the struct in the header
  std::string header;          // NAME.h: the equations, and steps, lanes, sweeps over them
  std::string program;         // NAME.cpp: a main() that prints a histogram of step times
  int products = 0, sums = 0;  // of one evaluation of all accelerations

  /// Throws SceneError, naming the element, for a scene that it cannot hold, and for a name that C++ does not allow.
  static CompiledScene of(const System& system, const std::string& name);
  /// Writes both files. Throws FileError.
  void write(const std::string& folder) const;
};

}  // namespace lithe
