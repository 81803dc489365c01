#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "engine/base/math.h"

namespace lithe::differential {

/// Random choices: of one seed the same on every machine.
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : engine_(seed) {}
  double number(double from = -1, double to = 1) { return from + (to - from) * (engine_() / 4294967296.0); }
  /// Evenly in the logarithm.
  double magnitude(double from, double to) { return from * std::pow(to / from, number(0, 1)); }
  bool chance(double probability) { return number(0, 1) < probability; }
  /// 0 ... count - 1
  int pick(int count) { return static_cast<int>(engine_() % static_cast<std::uint32_t>(count)); }
  template <class T>
  const T& one_of(const std::vector<T>& all) {
    return all[static_cast<std::size_t>(pick(static_cast<int>(all.size())))];
  }
  Vector3 vector(double size = 1) {
    const double x = number(), y = number(), z = number();
    return size * Vector3(x, y, z);
  }
  Matrix3 rotation() { return rotation_exp(vector(2)); }

 private:
  std::mt19937 engine_;
};

}  // namespace lithe::differential
