#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "engine/base/math.h"

/// Compares the engine with a file of expected values (format: reference oracle, one JSON file a case).
namespace lithe::oracle {

/// Largest error of each quantity, relative to the largest expected entry or to the natural scale where that vanishes.
struct Findings {
  std::map<std::string, double> worst;
  std::string note;  // what the case holds that was not compared

  void compare(const std::string& quantity, const MatrixX& got, const MatrixX& want, double scale = 0);
  double largest() const;
};

MatrixX matrix(const nlohmann::json& rows);  // nested or flat list; a flat list is a column

Findings check_body(const nlohmann::json& data);        // kinds solid, particles, beam, anisotropic, invariants
Findings check_joints(const nlohmann::json& data);      // kind joints
Findings check_stiffness(const nlohmann::json& data);   // kind geo
Findings check_trajectory(const nlohmann::json& data);  // kind trajectory

/// Chooses by kind; a kind it does not know is an error.
Findings check_case(const nlohmann::json& data);
/// Bound that a case of this kind has to keep: 1e-10, trajectories 1e-8.
double bound(const nlohmann::json& data);

}  // namespace lithe::oracle
