#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/model/joint_coordinate.h"
#include "engine/observe/observer.h"

namespace lithe {

/// A measurement of a state: some named numbers, a pure function of a snapshot. A value, passed and kept by copy.
/// The functions below make the usual ones; a scene may write its own:
///   Sensor{"sag", {"sag"}, [&](Snapshot& now, std::span<double> out) { out[0] = -now.marker(tip).p.z(); }}
/// Columns of the usual ones start with the sensor's name: a vector called "tip" has "tip_x", "tip_y", "tip_z", a
/// single number is "tip" itself; without a name they are named after the body or joint: "link_m3_x" (marker 3 of
/// 'link', in the body's own numbering). A scene's own sensor has its columns as written, without a prefix: its name is
/// for messages.
class Sensor {
 public:
  using Reading = std::function<void(Snapshot& snapshot, std::span<double> values)>;
  /// `units` ("m", "N m"): one a column, or one for all; none: not known. `path`: the marker whose position it
  /// measures. Throws SceneError without columns, and for another number of units.
  Sensor(Located name, std::vector<std::string> columns, Reading reading, std::vector<std::string> units = {},
         Marker path = {});

  const std::string& name() const { return name_.text; }
  std::string where() const { return to_string(name_.where); }  // "scene.cpp:12"
  const std::vector<std::string>& columns() const { return columns_; }
  /// Of a column; empty: not known, or none.
  std::string unit(std::size_t column) const;
  /// The marker whose position this is, for drawing its path; without a body: the sensor measures something else.
  const Marker& path() const { return path_; }
  /// Writes one value a column.
  void evaluate(Snapshot& snapshot, std::span<double> values) const { reading_(snapshot, values); }
  double value(Snapshot& snapshot, int column = 0) const;

 private:
  Located name_;
  std::vector<std::string> columns_;
  Reading reading_;
  std::vector<std::string> units_;
  Marker path_;
};

// ---- motion of a marker, world axes, SI units ----

Sensor position(Marker marker, Located name = "");              // m: x, y, z
Sensor height(Marker marker, Located name = "");                // m: world z
Sensor orientation(Marker marker, Located name = "");           // marker axes to world axes, quaternion: w, x, y, z
Sensor velocity(Marker marker, Located name = "");              // m/s: x, y, z
Sensor angular_velocity(Marker marker, Located name = "");      // rad/s: x, y, z
Sensor acceleration(Marker marker, Located name = "");          // m/s²: x, y, z
Sensor angular_acceleration(Marker marker, Located name = "");  // rad/s²: x, y, z

// ---- coordinates of a body ----

/// q: p_x, p_y, p_z (m), e_w … e_z, eta_1 …; as many as the body has.
Sensor coordinates(const Body& body, Located name = "");
/// v: p_dot_x … (m/s), omega_x … (rad/s, body axes), eta_dot_1 …
Sensor generalized_velocities(const Body& body, Located name = "");
/// eta alone, and its rates: eta_1 … and eta_dot_1 …; SceneError for a body that has none.
Sensor modal_coordinates(const Body& body, Located name = "");
Sensor modal_rates(const Body& body, Located name = "");

// ---- loads ----

/// In place of a marker: write a vector in world axes.
inline constexpr Marker kWorldAxes{};

/// Force (N) and moment (N m) of a joint on the body at its marker number `marker` (from 0, in the joint's list), about
/// that marker's point:  -Σ_rows W λ  (docs/equations.md 7.4); in world axes, or in those of a marker as they turn.
/// Columns force_x … moment_z. Where rows are redundant the sharing among them is not unique: it is that of least λ.
Sensor reaction(const Constraint& joint, int marker, Marker axes = kWorldAxes, Located name = "");
/// What a joint transmits, in its own frame: force and moment on the body of its second marker, in the axes of the
/// first.
Sensor joint_reaction(const Constraint& joint, Located name = "");
/// The total reaction of several joints on one body: the sum of their forces at all of their markers on it (N), and of
/// their moments about the point of `about` (N m), in world axes or in the axes of a marker. Unique where rows are
/// redundant, too: four feet carry the weight, however they share it. Throws SceneError for a joint that does not hold
/// the body.
Sensor total_reaction(const Body& body, std::vector<const Constraint*> joints, Marker about, Marker axes = kWorldAxes,
                      Located name = "");
/// λ of the joint's rows, 1 … n; of least norm where rows are redundant.
Sensor multipliers(const Constraint& joint, Located name = "");
/// Force and moment of a force element on the body at its marker number `marker`, likewise.
Sensor applied_force(const ForceElement& element, int marker, Marker axes = kWorldAxes, Located name = "");

/// W: power of a joint or a force element on the bodies that it connects; for a driven joint that of its drive.
Sensor power(const Constraint& joint, Located name = "");
Sensor power(const ForceElement& element, Located name = "");

// ---- joint coordinates: rad or m, whole turns counted where a joint or another element of the scene measures them
// ----

Sensor coordinate(const JointCoordinate& coordinate, Located name);
Sensor coordinate_rate(const JointCoordinate& coordinate, Located name);  // rad/s, m/s
Sensor coordinate_acceleration(const JointCoordinate& coordinate, Located name);

// ---- what is given from outside ----

Sensor input_value(const Input& input, Located name = "");  // in its unit

// ---- energies, J; gravity's counted from the origin of the world ----

Sensor kinetic_energy(Located name = "");
Sensor kinetic_energy(const Body& body, Located name = "");
Sensor elastic_energy(Located name = "");  // of all bodies and force elements
Sensor elastic_energy(const Body& body, Located name = "");
Sensor potential_energy(Located name = "");  // elastic and gravity
Sensor potential_energy(const Body& body, Located name = "");
Sensor potential_energy(const ForceElement& element, Located name = "");  // zero for what has none
Sensor total_energy(Located name = "");
Sensor total_energy(const Body& body, Located name = "");

// ---- how well the constraints hold, in the units of the rows ----

Sensor constraint_residual(Located name = "");  // largest |g|
Sensor velocity_residual(Located name = "");    // largest |G v + ∂g/∂t|

}  // namespace lithe
