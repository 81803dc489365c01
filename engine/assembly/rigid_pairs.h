#pragma once

#include "engine/assembly/batch.h"
#include "engine/base/lane_rotations.h"
#include "engine/model/rigid_rows.h"

/// Joints of RigidRows between rigid bodies, or one and ground: residuals, blocks of G and the stiffness under load,
/// straight from the poses. The same numbers as by wrenches (connector_blocks.h), to round-off.
namespace lithe::rigid_pairs {

using lanes::Columns;
using lanes::load3;
using lanes::load3x3;
using lanes::store3;

/// Axis 0, 1 or 2 of a marker, world axes.
inline Lanes axis(const MarkerKinematics& k, int i) { return load3(k.R.data() + 3 * i); }

/// Writes G of one body: rows that hold a point by sign · [E, -A r~], then the torques, in body axes, of those on axes.
template <int Rows, bool Point, int Angles>
void write_jacobian(double* G, double sign, const Columns& A, const Lanes& r, const Lanes* torques) {
  if constexpr (Point) {
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < Rows; ++i) G[i + Rows * j] = i == j ? sign : 0;
    const Lanes s = sign * r;
    store3(A.c[2] * s[1] - A.c[1] * s[2], G + Rows * 3);
    store3(A.c[0] * s[2] - A.c[2] * s[0], G + Rows * 4);
    store3(A.c[1] * s[0] - A.c[0] * s[1], G + Rows * 5);
  } else {
    for (int i = 0; i < 3 * Rows; ++i) G[i] = 0;
  }
  constexpr int first = Point ? 3 : 0;
  for (int k = 0; k < Angles; ++k)
    for (int j = 0; j < 3; ++j) G[first + k + Rows * (3 + j)] = torques[k][j];
}

/// g and G of the rows, for Level::position and velocity: they do not depend on time.
template <const RigidRows& Kind>
void evaluate(Workspace& work, const BlockStructure& blocks, const ConnectorRecord& record) {
  constexpr int kRows = Kind.rows(), kAngles = Kind.angles;
  const MarkerKinematics* markers[] = {&work.markers[record.slots[0].marker], &work.markers[record.slots[1].marker]};
  double* g = work.residual.data() + record.first_row;
  if constexpr (Kind.point) {
    store3(load3(markers[1]->p.data()) - load3(markers[0]->p.data()), g);
    g += 3;
  }
  Lanes n[kAngles > 0 ? kAngles : 1];
  for (int k = 0; k < kAngles; ++k) {
    const Lanes a = axis(*markers[0], Kind.perpendicular[k].a), b = axis(*markers[1], Kind.perpendicular[k].b);
    g[k] = lanes::dot(a, b);
    n[k] = lanes::cross(a, b);
  }
  for (int side = 0; side < 2; ++side) {
    const MarkerSlot& slot = record.slots[side];
    if (slot.jacobian < 0) continue;
    const Columns A = load3x3(markers[side]->A->data());
    const double sign = side == 0 ? -1 : 1;
    Lanes torques[kAngles > 0 ? kAngles : 1];
    for (int k = 0; k < kAngles; ++k) torques[k] = A.transposed_times(n[k]) * -sign;
    write_jacobian<kRows, Kind.point, kAngles>(work.values.data() + blocks.jacobians[slot.jacobian].values, sign, A,
                                               load3(markers[side]->r.data()), torques);
  }
}

/// Adds a 3 x 3 to the turns' part of a 6 x 6 block.
inline void add_turning(double* block, const Columns& K) {
  double* to = block + 21;
  lanes::store3x3(load3x3(to, 6) + K, to, 6);
}

/// Adds weight · ∂(Gᵀ λ)/∂q to the blocks of the bodies and between them.
template <const RigidRows& Kind>
void add_stiffness(Workspace& work, const BlockStructure& blocks, const ConnectorRecord& record, double weight,
                   const double* lambda) {
  double* values = work.values.data();
  const MarkerSlot &at_A = record.slots[0], &at_B = record.slots[1];
  const MarkerKinematics &mA = work.markers[at_A.marker], &mB = work.markers[at_B.marker];
  const Columns A = load3x3(mA.A->data()), B = load3x3(mB.A->data());
  Columns K_A = lanes::scalar(0), K_B = K_A, K_AB = K_A, K_BA = K_A;
  if constexpr (Kind.point) {
    // Force f at r in body axes: f rᵀ - (r·f) E.
    const Lanes load = weight * load3(lambda);
    const auto of_force = [](const Lanes& f, const Lanes& r) {
      return lanes::dyad(f, r) - lanes::scalar(lanes::dot(f, r));
    };
    if (at_A.frame >= 0) K_A = of_force(A.transposed_times(-load), load3(mA.r.data()));
    if (at_B.frame >= 0) K_B = of_force(B.transposed_times(load), load3(mB.r.data()));
  }
  // Rows a · b, those with the same b together: with t = Σ λ a, torques t × b on A and b × t on B,
  //   A: b tᵀ - (t·b) E,  B: t bᵀ - (t·b) E,  between them (t·b) E - b tᵀ and (t·b) E - t bᵀ.
  constexpr int first = Kind.point ? 3 : 0;
  for (int axis_b = 0; axis_b < 3; ++axis_b) {
    Lanes t = lanes::none();
    bool any = false;
    for (int k = 0; k < Kind.angles; ++k)
      if (Kind.perpendicular[k].b == axis_b)
        t += axis(mA, Kind.perpendicular[k].a) * (weight * lambda[first + k]), any = true;
    if (!any) continue;
    const Lanes b = axis(mB, axis_b);
    const double tb = lanes::dot(t, b);
    const Lanes t_A = A.transposed_times(t), b_A = A.transposed_times(b), t_B = B.transposed_times(t),
                b_B = B.transposed_times(b);
    const Columns turned = lanes::scalar(tb);
    K_A = K_A + lanes::dyad(b_A, t_A) - turned;
    K_B = K_B + lanes::dyad(t_B, b_B) - turned;
    if (record.ab < 0) continue;
    const Columns between = lanes::transposed(A) * B;
    K_AB = K_AB + tb * between - lanes::dyad(b_A, t_B);
    K_BA = K_BA + tb * lanes::transposed(between) - lanes::dyad(t_B, b_A);
  }
  if (at_A.frame >= 0) add_turning(values + blocks.frames[at_A.frame].values, K_A);
  if (at_B.frame >= 0) add_turning(values + blocks.frames[at_B.frame].values, K_B);
  if (Kind.angles == 0 || record.ab < 0) return;
  add_turning(values + record.ab, K_AB);
  add_turning(values + record.ba, K_BA);
}

/// The tangent block of a rigid body (engine/model/rigid_frame_body.h), written: m E and a J + d (ω~ J - (J ω)~), the
/// latter times the chart's Jr⁻¹ of the increment's turn, if one is given.
inline void write_tangent(double* frame, double mass, const Matrix3& inertia, const double* omega,
                          const TangentWeights& weights, const double* turn) {
  const Columns J = load3x3(inertia.data());
  Columns K = weights.acceleration * J;
  if (weights.velocity != 0) {
    const Lanes w = load3(omega);
    const Columns spin = lanes::skewed(J * w);
    for (int j = 0; j < 3; ++j) K.c[j] += weights.velocity * (lanes::cross(w, J.c[j]) - spin.c[j]);
  }
  if (turn) K = lanes::times_chart(K, load3(turn));
  for (int i = 0; i < 36; i += 4) lanes::store4(lanes::none(), frame + i);
  for (int i = 0; i < 3; ++i) frame[7 * i] = weights.acceleration * mass;
  lanes::store3x3(K, frame + 21, 6);
}

}  // namespace lithe::rigid_pairs
