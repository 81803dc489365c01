#pragma once

#include <array>
#include <optional>
#include <vector>

#include "engine/assembly/batch.h"
#include "engine/base/dual.h"
#include "engine/model/constraint.h"
#include "engine/model/force_element.h"
#include "engine/model/joint_coordinate.h"
#include "models/adams/adams_model.h"

/// What draws the elements of an Adams data set that the catalogue does not have.
namespace lithe::adams {

/// A function and where the markers that it reads stand in the element's list.
struct PlacedFunction {
  AdamsFunction function;
  struct Places {
    int i, j, k, l;
    int angle;  // in angles(); -1: not an angle whose turns count
  };
  std::vector<Places> places{};  // of the measures
};

/// SFORCE, VFORCE, VTORQUE, GFORCE: functions of time and markers. Markers: I, that of the reaction, that of the axes,
/// then those that the functions read, at most kMaxMarkers.
class FunctionForce final : public ForceElement {
 public:
  struct Parameters {
    AdamsModel::Load::Kind kind;
    std::array<std::optional<PlacedFunction>, 6> functions;
    AdamsUnits units;
    int axes = 0;  // place of the marker of the axes
    std::vector<MeasuredAngle> angles;
    int markers = 0;
    bool timed = true;
  };
  explicit FunctionForce(Parameters parameters) : p_(std::move(parameters)) {}

  int marker_count() const override { return p_.markers; }
  int row_count() const override { return 0; }
  std::vector<MeasuredAngle> angles() const override { return p_.angles; }
  bool depends_on_time() const override { return p_.timed; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;

 private:
  const Parameters p_;
};

/// BUSHING, BEAM, FIELD. Markers: J, I.
///   F = preload - K (x - free) - D x',  x = (displacement of I from J, AX, AY, AZ), in the axes of J; on I, its
///   opposite on the body of J at the place of I
class FieldForce final : public Force</*markers=*/2, /*rows=*/0> {
 public:
  using Parameters = AdamsModel::Field;
  explicit FieldForce(Parameters parameters) : p_(std::move(parameters)) {}
  std::vector<MeasuredAngle> angles() const override { return {{0, 1, 0}, {0, 1, 1}, {0, 1, 2}}; }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;

 private:
  const Parameters p_;
};

/// GCON: a function of poses and time that stays zero. Markers: those that it reads, at most four.
class FunctionConstraint final : public Constraint {
 public:
  static constexpr int kRows = 1;
  struct Parameters {
    PlacedFunction function;
    AdamsUnits units;
    std::vector<MeasuredAngle> angles;
    int markers = 0;  // 2 or 4
  };
  explicit FunctionConstraint(Parameters parameters) : p_(std::move(parameters)) {}

  int marker_count() const override { return p_.markers; }
  int row_count() const override { return 1; }
  std::vector<MeasuredAngle> angles() const override { return p_.angles; }
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override;

 private:
  const Parameters p_;
};

/// MOTION with VELOCITY: the rate of a coordinate is a function of time, a row on velocities.
class RateDrive final : public Constraint {
 public:
  static constexpr int kMarkers = 2, kRows = 1;
  struct Parameters {
    AdamsFunction function;
    double time = 1, scale = 1;  // units: s; rad/s or m/s
  };
  RateDrive(CoordinateSet coordinate, Parameters parameters)
      : coordinate_(std::move(coordinate)), p_(std::move(parameters)) {}

  int marker_count() const override { return 2; }
  int row_count() const override { return 1; }
  std::vector<MeasuredAngle> angles() const override { return coordinate_.angles(); }
  void evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const override;

 private:
  const CoordinateSet coordinate_;
  const Parameters p_;
};

/// Value and first two derivatives by time of a function of time alone, as it is: units of the file.
InTime in_time(const AdamsFunction& function, const InTime& time);

/// What a snapshot says of markers and loads, SI; acceleration: (v_dot, w_dot), world axes.
struct Observed {
  std::function<MarkerKinematics(int marker)> marker;
  std::function<Vector6(int marker)> acceleration;
  std::function<double(const AdamsMeasure&)> load, angle;  // of a load, in the units of the file
};
double observed_value(const AdamsFunction& function, const AdamsUnits& units, double time, const Observed& from);
double observed_measure(const AdamsMeasure& measure, const AdamsUnits& units, const Observed& from);

}  // namespace lithe::adams
