#pragma once

#include <vector>

#include "engine/base/math.h"
#include "engine/factor/block_structure.h"
#include "engine/model/marker.h"

namespace lithe {

/// Scratch of one state, sized once; one a thread. Markers are evaluated once a state into one table that joints,
/// forces and sensors read; blocks are written at their final place.
struct Workspace {
  double time = 0;
  VectorX q, v;
  Vector3 gravity;
  std::vector<MarkerKinematics> markers;
  std::vector<double> values;          // BlockStructure: S, G
  VectorX residual, rate, bias;        // g, ∂g/∂t, velocity terms of g_dotdot; constraint rows
  VectorX tension;                     // of compliant rows
  VectorX row_stiffness, row_damping;  // of compliant rows
  VectorX load;                        // generalized force of loads, v_count
  VectorX force_energy;                // by force element and contact, as added, joules
  VectorX quarter_turns;               // of measured angles, as recalled
  bool friction_left_out = false;      // of joints, which time stepping finds (FrictionByImpulses)
};

/// Where a connector's marker acts: its place in the marker table and its body's blocks. A marker between two frames
/// has two slots, the second beyond those of all markers.
struct MarkerSlot {
  int marker;        // index into Workspace::markers
  int velocity;      // first velocity of the body; -1: ground
  int frame;         // index into frames, -1: none
  int linear, size;  // index into linears and its size, -1: the marker does not move with linear coordinates
  int eta;           // first of their velocities
  int jacobian;      // index into jacobians, -1: none
  // The first of the connector's markers on a frame, or moved by linear coordinates, writes their block, later ones
  // add.
  bool first_frame, first_linear;
  int place = 0;   // which of the connector's markers
  int share = -1;  // index into MarkerBetween::shares, -1: fixed in one frame
};

}  // namespace lithe
