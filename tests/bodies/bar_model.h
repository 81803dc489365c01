#pragma once

#include <array>
#include <vector>

#include "bodies/flexible/finite_element_model.h"

/// Straight bars of 8-node bricks with incompatible modes (C3D8I): they bend like beams with few bricks.
namespace lithe::test {

struct Bar {
  Vector3 size{1, 0.1, 0.1};              // m; x from 0 to size.x, the section about its middle
  std::array<int, 3> bricks{8, 2, 2};     // along x, y, z
  double young = 2.07e11, poisson = 0.3;  // Pa
  double density = 7800;                  // kg/m³
};

/// Node sets "start" and "end": the faces x = 0 and x = size.x, both in the order of face_weights().
FiniteElementModel bar_model(const Bar& bar);

/// Shares of the end face's area that its nodes stand for.
std::vector<double> face_weights(const Bar& bar);

}  // namespace lithe::test
