#pragma once

namespace lithe {

/// Isotropic linear elastic material.
struct Material {
  double young = 0;    // E, Pa; 0: not known
  double poisson = 0;  // ν
  double density = 0;  // kg/m³
};

}  // namespace lithe
