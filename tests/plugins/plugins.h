#pragma once

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/plugin/registry.h"

/// Where plug-ins lie as libraries.
namespace lithe::test {

inline std::filesystem::path shipped(const std::string& name) {
  return std::filesystem::path(LITHE_BINARY_DIR) / "plugins" / (name + ".so");
}
inline std::filesystem::path library(const std::string& name) {
  return std::filesystem::path(LITHE_TEST_PLUGINS) / (name + ".so");
}

/// x1, y1, x2, y2 … of r(φ) at n equal angles, counter-clockwise.
template <class Radius>
std::vector<double> profile_of(int n, Radius&& r) {
  std::vector<double> xy;
  for (int i = 0; i < n; ++i) {
    const double phi = 2 * M_PI * i / n;
    xy.push_back(r(phi) * std::cos(phi));
    xy.push_back(r(phi) * std::sin(phi));
  }
  return xy;
}
/// An egg with a flank nearly straight.
inline std::vector<double> egg(int n = 60) {
  return profile_of(n, [](double phi) { return 2 + 0.25 * std::cos(phi) + 0.1 * std::cos(2 * phi + 0.3); });
}

}  // namespace lithe::test
