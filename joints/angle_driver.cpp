#include "joints/angle_driver.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"

namespace lithe {

AngleDriver::AngleDriver(Parameters parameters) : motion_(std::move(parameters.motion)) {
  if (!motion_)
    throw SceneError("has no motion", "", "give .motion = [](double t) { return Motion{value, rate, acceleration}; }");
}

void AngleDriver::evaluate(double time, std::span<const MarkerView> markers, ConstraintRows& rows) const {
  const auto &A = markers[0], &B = markers[1];
  const Motion f = motion_(time);
  const double c = std::cos(f.value), s = std::sin(f.value);
  const Vector3 n = c * A.y() - s * A.x(), n_by_f = -s * A.y() - c * A.x(), x = B.x();
  // The row of perpendicular(n, x_B) with f frozen, then what the turning n adds:
  //   ∂g/∂t = ḟ n'·x,   g̈ adds 2 ḟ d/dt(n'·x)|_f - ḟ² n·x + f̈ n'·x
  perpendicular(A, n, B, x, rows);
  const double rate = f.rate * n_by_f.dot(x);
  const double bias = 2 * f.rate * (A.w.cross(n_by_f).dot(x) + n_by_f.dot(B.w.cross(x))) - f.rate * f.rate * n.dot(x) +
                      f.acceleration * n_by_f.dot(x);
  rows.drive_last(0, -rate, -bias);
}

template std::unique_ptr<ConstraintBatch> make_constraint_batch<AngleDriver>();

}  // namespace lithe
