#include "engine/forward/ball_tree.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "engine/base/four_vectors.h"

namespace lithe {
namespace {

using lanes::all;
using lanes::FourVectors;
using lanes::load4;
using lanes::store4;

/// That of one link.
Vector3 number(const double (&a)[3][4], int k) { return {a[0][k], a[1][k], a[2][k]}; }

Matrix3 matrix(const double (&a)[9][4], int k) {
  Matrix3 A;
  for (int i = 0; i < 9; ++i) A(i / 3, i % 3) = a[i][k];
  return A;
}

}  // namespace

inline Vector3 BallTree::Symmetric::operator*(const Vector3& a) const {
  return {xx * a[0] + xy * a[1] + xz * a[2], xy * a[0] + yy * a[1] + yz * a[2], xz * a[0] + yz * a[1] + zz * a[2]};
}

BallTree::BallTree(const std::vector<Link>& links, std::span<const Range> branches, std::span<const int> trunk,
                   const Vector3& gravity)
    : gravity_(gravity) {
  std::vector<int> node_of(links.size());
  const auto range_of = [&](std::span<const int> chosen) {
    const int first = append(links, chosen, node_of);
    return Range{first, first + static_cast<int>(chosen.size())};
  };
  trunk_ = range_of(trunk);
  for (const Range& branch : branches) {
    std::vector<int> chosen(branch.last - branch.first);
    std::iota(chosen.begin(), chosen.end(), branch.first);
    branches_.push_back(range_of(chosen));
  }
  for (std::size_t i = links.size(); i-- > 0;) {
    if (links[i].parent < 0) continue;
    Node &node = nodes_[node_of[i]], &parent = nodes_[node_of[links[i].parent]];
    node.hangs = true;
    node.arm = links[i].r_parent - links[links[i].parent].r;
    node.sibling = std::exchange(parent.child, node_of[i]);
    for (int k = 0; k < 3; ++k) fours_[node_of[links[i].parent] / 4].arm[k][node_of[links[i].parent] % 4] = node.arm[k];
  }
}

/// Their nodes, from the next multiple of four on; places left over repeat the last link. The first of them.
int BallTree::append(const std::vector<Link>& links, std::span<const int> chosen, std::vector<int>& node_of) {
  const int first = static_cast<int>(nodes_.size()), count = static_cast<int>(chosen.size());
  for (int k = 0; k < count + (-count & 3); ++k) {
    const Link& link = links[chosen[std::min(k, count - 1)]];
    if (k < count) node_of[chosen[k]] = first + k;
    Node& node = nodes_.emplace_back();
    node.q = link.q, node.v = link.v, node.held = link.held;
    if (k % 4 == 0) fours_.emplace_back();
    Four& four = fours_.back();
    const Matrix3 about_ball =
        link.inertia + link.mass * (link.r.squaredNorm() * Matrix3::Identity() - link.r * link.r.transpose());
    four.mass[k % 4] = link.mass;
    int entry = 0;
    for (int i = 0; i < 3; ++i) {
      four.r[i][k % 4] = link.r[i];
      for (int j = i; j < 3; ++j) four.inertia[entry++][k % 4] = about_ball(i, j);
    }
  }
  return first;
}

/// Four links at their state: what does not depend on others.
void BallTree::place(int number, const double* q, const double* v, const double* loads) {
  Four& four = fours_[number];
  const Node* n = &nodes_[4 * number];
  const auto at_q = [&](int i) { return Lanes{q[n[0].q + i], q[n[1].q + i], q[n[2].q + i], q[n[3].q + i]}; };
  const auto at_v = [&](const double* of, int i) {
    return Lanes{of[n[0].v + i], of[n[1].v + i], of[n[2].v + i], of[n[3].v + i]};
  };
  // 1. Attitude (rotation_matrix), row by row, and the centre of mass from the ball.
  const Lanes e = at_q(3), x = at_q(4), y = at_q(5), z = at_q(6), one = all(1), two = all(2);
  const FourVectors rows[3] = {{one - two * (y * y + z * z), two * (x * y - e * z), two * (x * z + e * y)},
                               {two * (x * y + e * z), one - two * (x * x + z * z), two * (y * z - e * x)},
                               {two * (x * z - e * y), two * (y * z + e * x), one - two * (x * x + y * y)}};
  const auto in_world = [&](const FourVectors& a) {
    return FourVectors{rows[0].dot(a), rows[1].dot(a), rows[2].dot(a)};
  };
  for (int i = 0; i < 3; ++i) rows[i].store(four.A + 3 * i);
  const Lanes mass = load4(four.mass);
  const FourVectors w_body{at_v(v, 3), at_v(v, 4), at_v(v, 5)}, w = in_world(w_body);
  const FourVectors ball = in_world(FourVectors::load(four.r));
  const FourVectors center = ball * all(-1);
  w.store(four.w), center.store(four.x);
  // 2. Inertia about the ball: A J Aᵀ.
  Lanes I[6];
  for (int k = 0; k < 6; ++k) I[k] = load4(four.inertia[k]);
  const auto times_inertia = [&](const FourVectors& a) {
    return FourVectors{I[0] * a.x + I[1] * a.y + I[2] * a.z, I[1] * a.x + I[3] * a.y + I[4] * a.z,
                       I[2] * a.x + I[4] * a.y + I[5] * a.z};
  };
  const FourVectors JA[3] = {times_inertia(rows[0]), times_inertia(rows[1]), times_inertia(rows[2])};
  for (int i = 0, entry = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) store4(rows[i].dot(JA[j]), four.J[entry++]);
  // 3. Force and torque about the ball at no acceleration of the ball and of the turning.
  const auto swing_of = [&](const FourVectors& a) { return w * w.dot(a) - a * w.dot(w); };
  const FourVectors d = in_world(FourVectors::load(four.arm)), swing = swing_of(center);
  FourVectors turning = w_body.cross(times_inertia(w_body));
  FourVectors applied = FourVectors{all(gravity_[0]), all(gravity_[1]), all(gravity_[2])} * mass;
  if (loads) {
    applied = applied + FourVectors{at_v(loads, 0), at_v(loads, 1), at_v(loads, 2)};
    turning = turning - FourVectors{at_v(loads, 3), at_v(loads, 4), at_v(loads, 5)};
  }
  d.store(four.d), swing_of(d).store(four.d_swing);
  swing.store(four.swing);
  (swing * mass - applied).store(four.force);
  (in_world(turning) - center.cross(applied)).store(four.torque);
}

/// What hangs on the node, and itself, onto its ball.
void BallTree::eliminate(int i) {
  Node& node = nodes_[i];
  const Four& four = fours_[i / 4];
  const int k = i % 4;
  const double mass = four.mass[k];
  Symmetric M{mass, 0, 0, mass, 0, mass};
  Symmetric J{four.J[0][k], four.J[1][k], four.J[2][k], four.J[3][k], four.J[4][k], four.J[5][k]};
  Vector3 force = number(four.force, k), torque = number(four.torque, k);
  const Vector3 h = mass * number(four.x, k);
  Matrix3 H;  // of which column j is m e_j × x
  H << 0, h[2], -h[1], -h[2], 0, h[0], h[1], -h[0], 0;
  for (int c = node.child; c >= 0; c = nodes_[c].sibling) {
    Node& child = nodes_[c];
    if (c != node.child) {
      const Vector3 w = number(four.w, k);
      child.d = matrix(four.A, k) * child.arm;
      child.swing = w * w.dot(child.d) - child.d * w.squaredNorm();
    }
    const Symmetric& m = child.M;
    const Vector3 d = c == node.child ? number(four.d, k) : child.d,
                  push = child.f + m * (c == node.child ? number(four.d_swing, k) : child.swing);
    force += push, torque += d.cross(push);
    M.xx += m.xx, M.xy += m.xy, M.xz += m.xz, M.yy += m.yy, M.yz += m.yz, M.zz += m.zz;
    // Of a mass at d: columns m (e_j × d), and d × those.
    Matrix3 shifted;
    shifted << m.xz * d[1] - m.xy * d[2], m.xx * d[2] - m.xz * d[0], m.xy * d[0] - m.xx * d[1],
        m.yz * d[1] - m.yy * d[2], m.xy * d[2] - m.yz * d[0], m.yy * d[0] - m.xy * d[1], m.zz * d[1] - m.yz * d[2],
        m.xz * d[2] - m.zz * d[0], m.yz * d[0] - m.xz * d[1];
    H += shifted;
    J.xx = J.xx + d[1] * shifted(2, 0) - d[2] * shifted(1, 0);
    J.xy = J.xy + d[1] * shifted(2, 1) - d[2] * shifted(1, 1);
    J.xz = J.xz + d[1] * shifted(2, 2) - d[2] * shifted(1, 2);
    J.yy = J.yy + d[2] * shifted(0, 1) - d[0] * shifted(2, 1);
    J.yz = J.yz + d[2] * shifted(0, 2) - d[0] * shifted(2, 2);
    J.zz = J.zz + d[0] * shifted(1, 2) - d[1] * shifted(0, 2);
  }
  // J = L D Lᵀ: one turn after the other goes out. Backward stable, where J's cofactors lose digits of a slender link.
  const double dx = 1 / J.xx, yx = J.xy * dx, zx = J.xz * dx;
  const double yz = J.yz - yx * J.xz, dy = J.xx / (J.xx * J.yy - J.xy * J.xy), zy = yz * dy;
  const double dz = 1 / (J.zz - zx * J.xz - zy * yz);
  const Vector3 ux = H.col(0), uy = H.col(1) - yx * ux, uz = H.col(2) - zx * ux - zy * uy;
  const Vector3 gx = dx * ux, gy = dy * uy, gz = dz * uz;
  const auto left = [&](int a, int b) { return ux[a] * gx[b] + uy[a] * gy[b] + uz[a] * gz[b]; };
  node.M = {M.xx - left(0, 0), M.xy - left(0, 1), M.xz - left(0, 2),
            M.yy - left(1, 1), M.yz - left(1, 2), M.zz - left(2, 2)};
  const double ty = torque[1] - yx * torque[0], tz = torque[2] - zx * torque[0] - zy * ty;
  node.f = force - torque[0] * gx - ty * gy - tz * gz;
  node.yx = yx, node.zx = zx, node.zy = zy;
  node.gain[0] = gx, node.gain[1] = gy, node.gain[2] = gz;
  node.rest = {dx * torque[0], dy * ty, dz * tz};
}

void BallTree::inwards(const Range& range, const double* q, const double* v, const double* load) {
  for (int i = range.last; i-- > range.first;) {
    if (i % 4 == 3 || i + 1 == range.last) place(i / 4, q, v, load);
    eliminate(i);
  }
}

/// Its own ω̇, and the accelerations of the balls beyond.
void BallTree::find(int i) {
  Node& node = nodes_[i];
  Four& four = fours_[i / 4];
  const int k = i % 4;
  if (!node.hangs) {
    node.a.setZero();
    if (!node.held) {
      const Symmetric& M = node.M;
      Matrix3 all;
      all << M.xx, M.xy, M.xz, M.xy, M.yy, M.yz, M.xz, M.yz, M.zz;
      node.a = -all.llt().solve(node.f);
    }
  }
  Vector3 alpha;
  alpha[2] = -(node.gain[2].dot(node.a) + node.rest[2]);
  alpha[1] = -(node.gain[1].dot(node.a) + node.rest[1]) - node.zy * alpha[2];
  alpha[0] = -(node.gain[0].dot(node.a) + node.rest[0]) - node.yx * alpha[1] - node.zx * alpha[2];
  for (int c = node.child; c >= 0; c = nodes_[c].sibling) {
    Node& child = nodes_[c];
    const bool first = c == node.child;
    const Vector3 d = first ? number(four.d, k) : child.d, swing = first ? number(four.d_swing, k) : child.swing;
    child.a = node.a + alpha.cross(d) + swing;
  }
  for (int j = 0; j < 3; ++j) four.a[j][k] = node.a[j], four.alpha[j][k] = alpha[j];
}

void BallTree::outwards(const Range& range, double* v_dot) {
  // Four behind: a wide load of what was just written piece by piece waits.
  const auto write_four = [&](int first) { write(first / 4, std::min(range.last - first, 4), v_dot); };
  for (int i = range.first; i < range.last; ++i) {
    find(i);
    if (i % 4 == 3 && i - 4 > range.first) write_four(i - 7);
  }
  for (int first = std::max(range.first, (range.last - 1) / 4 * 4 - 4); first < range.last; first += 4)
    write_four(first);
}

/// Accelerations of the centres of mass, and ω̇ in body axes, of the first `count` of four links.
void BallTree::write(int number, int count, double* v_dot) const {
  const Four& four = fours_[number];
  const FourVectors a = FourVectors::load(four.a), alpha = FourVectors::load(four.alpha),
                    linear = a + alpha.cross(FourVectors::load(four.x)) + FourVectors::load(four.swing),
                    angular = FourVectors::load(four.A) * alpha.x + FourVectors::load(four.A + 3) * alpha.y +
                              FourVectors::load(four.A + 6) * alpha.z;
  alignas(32) double found[6][4];
  linear.store(found), angular.store(found + 3);
  for (int k = 0; k < count; ++k)
    for (int j = 0; j < 6; ++j) v_dot[nodes_[4 * number + k].v + j] = found[j][k];
}

void BallTree::accelerations(const double* q, const double* v, const double* load, double* v_dot, ThreadTeam& threads) {
  const int branches = static_cast<int>(branches_.size());
  threads.run(branches, [&](int k) { inwards(branches_[k], q, v, load); });
  inwards(trunk_, q, v, load);
  outwards(trunk_, v_dot);
  threads.run(branches, [&](int k) { outwards(branches_[k], v_dot); });
}

}  // namespace lithe
