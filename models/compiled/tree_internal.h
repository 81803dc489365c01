#pragma once

#include <string>
#include <vector>

#include "engine/base/math.h"

namespace lithe {

class System;
class Input;

/// A scene of rigid bodies in trees, in joint coordinates. Bodies welded to each other are one link; a joint of several
/// freedoms is a row of links without mass, each of one freedom or of a ball.
struct CompiledTree {
  enum class Motion {
    turn,   // about z: q, v = q̇, rad
    slide,  // along z: q, v = q̇, m
    ball,   // q: quaternion (w, x, y, z) of the link's axes in the joint's, v: ω relative to the parent, link axes
    free,   // q: position of the centre of mass and quaternion in the world, v: (ṗ, world axes; ω, link axes)
  };
  struct Link {
    int parent;  // before this one; -1: ground
    Motion motion;
    Vector3 shift = Vector3::Zero();  // of the joint's frame from the parent's, parent's axes
    // The joint's axes are Rz Rx Rz of these angles in the parent's; those of the last add to the joint's own angle.
    struct Angle {
      double c = 1, s = 0;
    } first{}, tilt{}, last{};
    double mass = 0;
    Vector3 moment = Vector3::Zero();   // mass times centre of mass, from the link's origin, link axes
    Matrix3 inertia = Matrix3::Zero();  // about the link's origin, link axes
    int q, v;
  };
  /// c (coordinate) + offset = x of an element that acts on it with -(stiffness (x - free) + damping ẋ + preload).
  struct Number {
    double value = 0;
    int input = -1;  // index; -1: the value
  };
  struct Spring {
    int q, v;
    double sign = 1, offset = 0;                     // x = sign q + offset
    Number stiffness, damping, free_value, preload;  // a motor: preload alone, its effort negative
  };
  std::vector<Link> links;  // parents first
  std::vector<Spring> springs;
  Vector3 gravity;
  std::vector<std::string> position_names, velocity_names;
  VectorX q, v;  // at t = 0
  std::vector<const Input*> inputs;

  /// Throws SceneError, naming the element, for what a compiled scene cannot hold.
  static CompiledTree of(const System& system, double right_angles_within = 0);
  int position_count() const { return static_cast<int>(position_names.size()); }
  int velocity_count() const { return static_cast<int>(velocity_names.size()); }
  /// Efforts of the velocities, then the scene's inputs.
  int input_count() const { return velocity_count() + static_cast<int>(inputs.size()); }
};

}  // namespace lithe
