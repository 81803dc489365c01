#pragma once

#include "engine/base/lanes.h"

/// A vector of each of four bodies, entry by entry: what depends on one body alone is found for four at once, with no
/// entry of a register left empty.
namespace lithe::lanes {

inline Lanes all(double a) { return Lanes{a, a, a, a}; }

/// Three entries of each of four vectors.
struct FourVectors {
  Lanes x, y, z;
  static FourVectors load(const double (*a)[4]) { return {load4(a[0]), load4(a[1]), load4(a[2])}; }
  void store(double (*to)[4]) const { store4(x, to[0]), store4(y, to[1]), store4(z, to[2]); }
  FourVectors operator+(const FourVectors& b) const { return {x + b.x, y + b.y, z + b.z}; }
  FourVectors operator-(const FourVectors& b) const { return {x - b.x, y - b.y, z - b.z}; }
  FourVectors operator*(const Lanes& s) const { return {x * s, y * s, z * s}; }
  Lanes dot(const FourVectors& b) const { return x * b.x + y * b.y + z * b.z; }
  FourVectors cross(const FourVectors& b) const { return {y * b.z - z * b.y, z * b.x - x * b.z, x * b.y - y * b.x}; }
};

}  // namespace lithe::lanes
