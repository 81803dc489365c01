#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/math.h"
#include "models/adams/adams_function.h"

namespace lithe {

/// What one unit of a data set is in SI: of mass (kg), length (m), time (s), force (N).
struct AdamsUnits {
  double mass = 1, length = 1, time = 1, force = 1;
  double torque() const { return force * length; }
};

/// What an Adams data set has beside parts: markers, joints, loads, outputs, by the numbers of the file. Lengths,
/// masses, velocities and matrices in SI; functions in the units of the file.
struct AdamsModel {
  struct Part {
    int id = 0;
    bool ground = false;
    Vector3 position{0, 0, 0};                  // of its frame in the world, m
    Matrix3 orientation = Matrix3::Identity();  // part axes to world axes
    Vector3 velocity{0, 0, 0};                  // of the centre of mass, world axes, m/s
    Vector3 angular_velocity{0, 0, 0};          // world axes, rad/s
  };
  struct MarkerFrame {
    int part = 0;                               // place in parts
    Vector3 position{0, 0, 0};                  // in the part's frame, m
    Matrix3 orientation = Matrix3::Identity();  // marker axes to part axes
    int line = 0;
  };
  /// A JOINT or JPRIM between markers I and J.
  struct Joint {
    std::string kind;  // "REVOLUTE", "INPLANE", ...
    bool primitive = false;
    int i = 0, j = 0;
    double value = 0;  // pitch of a SCREW (m a turn), pitch diameter of a RACKPIN (m)
  };
  /// A joint's coordinate or the displacement of markers as a function of time; or its rate.
  struct Motion {
    int joint = 0, i = 0, j = 0;  // joint 0: of markers I and J
    bool rotation = false, rate = false;
    int axis = 2;  // of J
    AdamsFunction function;
  };
  /// A load by functions, on I and its opposite on J.
  struct Load {
    enum class Kind { along_line, about_z, on_i_along_z, on_i_about_z, components } kind;
    int i = 0, j = 0, axes = 0;  // J of components: of the part that takes the reaction, at the place of I
    std::array<std::optional<AdamsFunction>, 6> functions{};  // the first alone, or force x, y, z, torque x, y, z
  };
  /// SPRINGDAMPER.
  struct Spring {
    int i = 0, j = 0;
    bool rotation = false;
    double stiffness = 0, damping = 0, free_value = 0, preload = 0;  // preload: as Adams counts it, positive pushes
  };
  /// BUSHING, BEAM, FIELD: on I, in the axes of J: preload - K (x - free) - D x', x: displacement of I from J, and
  /// angles.
  struct Field {
    int i = 0, j = 0;
    Matrix6 stiffness = Matrix6::Zero(), damping = Matrix6::Zero();
    Vector6 free = Vector6::Zero(), preload = Vector6::Zero();
  };
  /// Σ factor * coordinate = as drawn; a coordinate of a cylindrical joint: its angle or its displacement.
  struct Coupler {
    std::vector<int> joints;
    std::vector<bool> rotation;
    std::vector<double> factors;  // of rad and m
  };
  struct Gear {
    int first = 0, second = 0, contact = 0;  // joints, marker
  };
  /// A function of poses that stays zero.
  struct Constraint {
    AdamsFunction function;
  };
  struct Request {
    std::string comment;
    char kind = 0;  // D, V, A, F; 0: functions
    int i = 0, j = 0, axes = 0;
    std::map<int, AdamsFunction> functions{};  // by the number of their column, 2 to 8
  };
  /// An element and where it stands in the file; `name`: "JOINT/3".
  template <class T>
  struct Element {
    std::string name;
    int line;
    T what;
  };

  AdamsUnits units;
  std::vector<Part> parts;
  std::map<int, MarkerFrame> markers;
  std::map<int, Element<Joint>> joints;  // JPRIMs too, by -id
  std::vector<Element<Motion>> motions;
  std::vector<Element<Load>> loads;
  std::vector<Element<Spring>> springs;
  std::vector<Element<Field>> fields;
  std::vector<Element<Coupler>> couplers;
  std::vector<Element<Gear>> gears;
  std::vector<Element<Constraint>> constraints;
  std::vector<Element<Request>> requests;
  std::vector<Element<AdamsFunction>> variables;
};

}  // namespace lithe
