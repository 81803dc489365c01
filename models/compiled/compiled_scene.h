#pragma once

#include <string>

namespace lithe {

class System;

/// A scene of rigid bodies in trees as C++ that needs nothing but the standard library: its accelerations in joint
/// coordinates, unrolled for this one scene, without allocation, exception, loop over its size or branch. Constants are
/// folded, zeros and ones left out. Over a scalar, so that it runs on doubles and on lanes of 4 or 8 of them.
/// What it may hold: RigidBody; fixed, revolute, prismatic, cylindrical, planar and spherical joints without loops;
/// gravity, CoordinateSpring and CoordinateMotor whose numbers are constant or Inputs. (docs/compiled.md)
struct CompiledScene {
  std::string name;            // of the struct in the header
  std::string header;          // NAME.h: the equations, and steps, lanes, sweeps over them
  std::string program;         // NAME.cpp: a main() that prints a histogram of step times
  int products = 0, sums = 0;  // of one evaluation of all accelerations

  struct Options {
    /// rad: axes of joints that are so near to parallel or a right angle are taken to be; round-off always is. A file
    /// that gives right angles as 1.5708 costs a fifth to a quarter more without.
    double right_angles_within = 0;
  };
  /// Throws SceneError, naming the element, for a scene that it cannot hold, for a name that C++ does not allow, and
  /// for an angle below zero or above 1e-3.
  static CompiledScene of(const System& system, const std::string& name, const Options& options);
  static CompiledScene of(const System& system, const std::string& name) { return of(system, name, {}); }
  /// Writes both files. Throws FileError.
  void write(const std::string& folder) const;
};

}  // namespace lithe
