#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace lithe {

/// A curve of an Adams data set (SPLINE), as AKISPL and CUBSPL read it: cubic pieces through the points, with the
/// slopes of Akima (1970), or those of a spline whose second derivative is continuous and whose third is at the second
/// and the last but one point. Beyond the ends the parabola through the last three points goes on, or, with
/// LINEAR_EXTRAPOLATE, the straight line through the last two: the curve itself is continuous there, its slope is not.
class AdamsCurve {
 public:
  enum class Kind { akima, cubic };
  struct Value {
    double value, slope, curvature;
  };
  /// x rises. At least four points.
  AdamsCurve(std::vector<double> x, std::vector<double> y, bool linear_ends, Kind kind);
  Value operator()(double x) const;

 private:
  std::vector<double> x_, y_, slope_;
  bool linear_ends_;
};

/// What a function of an Adams data set reads of a model: a displacement, velocity, angle or acceleration of marker I
/// against marker J, along the axes of K, seen from L; or a component of a load. Markers by their number, 0: the global
/// frame.
struct AdamsMeasure {
  enum class Kind {
    DM,
    DX,
    DY,
    DZ,
    AX,
    AY,
    AZ,
    PSI,
    THETA,
    PHI,
    YAW,
    PITCH,
    ROLL,
    E0,
    E1,
    E2,
    E3,  // of the pose
    VM,
    VR,
    VX,
    VY,
    VZ,
    WM,
    WX,
    WY,
    WZ,  // of velocities
    ACCM,
    ACCX,
    ACCY,
    ACCZ,
    WDTM,
    WDTX,
    WDTY,
    WDTZ,  // of accelerations
    between,
    of_element  // of loads
  };
  Kind kind;
  int i = 0, j = 0, k = 0, l = 0;
  // Loads: component 1 to 8 (|F|, x, y, z, |T|, x, y, z) along the axes of k. `between`: on i, of all that acts between
  // i and j. `of_element`: of the element, on its marker I or (on_j) J.
  int component = 0;
  std::string element{};  // "JOINT/3"
  bool on_j = false;

  bool of_pose() const { return kind <= Kind::E3; }
  bool of_velocity() const { return kind > Kind::E3 && kind <= Kind::WZ; }
  bool of_acceleration() const { return kind > Kind::WZ && kind <= Kind::WDTZ; }
  bool of_load() const { return kind >= Kind::between; }
  bool is_angle() const { return kind >= Kind::AX && kind <= Kind::AZ; }
};

/// An expression of Adams' function language as a tree: read once, then evaluated without allocation, over numbers or
/// over numbers that carry derivatives (models/adams/function_value_internal.h). In the units of the file.
struct AdamsFunction {
  enum class Operation {
    number,
    time,
    measure,
    add,
    multiply,
    divide,
    power,
    negate,
    branch,
    absolute,
    arc_cosine,
    truncated,
    rounded,
    arc_sine,
    arc_tangent,
    quadrant_arc_tangent,
    cosine,
    hyperbolic_cosine,
    excess,
    exponential,
    logarithm,
    decimal_logarithm,
    maximum,
    minimum,
    remainder,
    with_sign,
    sine,
    hyperbolic_sine,
    square_root,
    tangent,
    hyperbolic_tangent,
    cubic_step,
    quintic_step,
    haversine_step,
    bistop,
    impact,
    polynomial,
    harmonic,
    cosine_series,
    sine_series,
    chebyshev,
    curve
  };
  struct Node {
    Operation operation = Operation::number;
    int first = 0, count = 0;  // places of arguments
    double number = 0;
    int index = 0;  // of a measure or a curve
    int order = 0;  // of a curve's derivative
  };
  std::vector<Node> nodes;
  std::vector<int> arguments;  // nodes
  std::vector<AdamsMeasure> measures;
  std::vector<AdamsCurve> curves;
  int root = 0;
  int line = 0;  // of the file

  /// A number alone.
  static AdamsFunction constant(double value);
};

/// Where a function looks up what it names.
struct AdamsNames {
  std::function<std::string(int variable)> variable;              // text of VARIABLE/id; throws if there is none
  std::function<AdamsCurve(int spline, AdamsCurve::Kind)> curve;  // throws likewise
  std::function<void(const std::string& problem, const std::string& fix)> fail;  // throws, naming the line
};

/// Reads an expression. Calls names.fail for one that is cut, an unknown function or name, a wrong number of arguments,
/// a VARIABLE that reads itself, and one that is too long or nested too deep.
AdamsFunction read_adams_function(const std::string& text, int line, const AdamsNames& names);
/// It as text, VARIABLEs written out: read again it is the same tree, but for signs of numbers. Throws SceneError for
/// one that reads a SPLINE or a load.
std::string adams_text(const AdamsFunction& function);

}  // namespace lithe
