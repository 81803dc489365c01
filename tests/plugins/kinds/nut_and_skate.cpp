#include "engine/plugin.h"

using namespace lithe;

/// A nut on its bolt: g = s - h α, s the displacement along z, α the angle about it with all its turns, h the pitch.
class Nut final : public Joint</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    double pitch = 0.01;  // h, m/rad
  };
  static constexpr Field<Parameters> kParameters[] = {{"pitch", &Parameters::pitch}};
  explicit Nut(Parameters parameters) : pitch_(parameters.pitch) {}

  std::vector<MeasuredAngle> angles() const override { return {{0, 1, 2}}; }
  void evaluate(double, std::span<const MarkerView> m, ConstraintRows& rows) const override {
    const auto s = measure(JointCoordinate::Kind::displacement, 2, m[0], m[1]);
    const auto a = measure(JointCoordinate::Kind::angle, 2, m[0], m[1]);
    rows.add(s.value - pitch_ * rows.wound(0, a.value), {s.on_A - pitch_ * a.on_A, s.on_B - pitch_ * a.on_B},
             s.bias - pitch_ * a.bias);
  }

 private:
  const double pitch_;
};

/// The blade of a skate: its point does not move along y, a row on velocities alone.
class Skate final : public Joint</*markers=*/1, /*rows=*/1> {
 public:
  void evaluate(double, std::span<const MarkerView> m, ConstraintRows& rows) const override {
    rows.add_velocity({force(m[0].y())}, m[0].w.cross(m[0].y()).dot(m[0].v));
  }
};

LITHE_EXPORT_JOINT(Nut, "nut")
LITHE_EXPORT_JOINT(Skate, "skate")
