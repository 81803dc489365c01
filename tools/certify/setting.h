#pragma once

#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/certify/scenes.h"

namespace lithe::certify {

/// What a user sets by hand: the first so many modes and how they deflect, or exact beams of so many elements.
struct Model {
  Deflection deflection = Deflection::linear;
  int modes = 0;
  int elements = 0;
  auto operator<=>(const Model&) const = default;
};

/// Automatic at a tolerance, or generalized-alpha at a fixed step (s).
struct Setting {
  Model model;
  bool fixed_step = false;
  double value = 0;
  auto operator<=>(const Setting&) const = default;
};
/// "8 modes, stiffened; generalized-alpha, step 0.00125 s"
std::string text(const Setting& setting);
nlohmann::json described(const Setting& setting);
/// The inverse.
Setting read_setting(const nlohmann::json& json);

struct Outcome {
  double error = std::numeric_limits<double>::infinity();  // of the worst watched quantity, part of its change
  double cpu = std::numeric_limits<double>::infinity();    // s
  std::vector<double> errors{};                            // of each
};
/// Infinite where the model breaks down or the step is too long.
Outcome run_setting(const Scene& scene, ElasticParts& parts, const Setting& setting, const Table& reference);

}  // namespace lithe::certify
