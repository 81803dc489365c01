#include "engine/contact/contact_rows.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace lithe {
namespace {

Vector3 mean(const ContactSide& side, const MarkerKinematics* nodes) {
  Vector3 p = Vector3::Zero();
  for (int i = 0; i < side.node_count; ++i) p += side.weights[i] * nodes[i].p;
  return p;
}

/// Forces on three nodes with no sum and the moments in the columns of `moments`: θ × d_i, as a rigid triangle has
/// them.
void add_couple(const MarkerKinematics* nodes, const Matrix3& moments, Matrix3* forces) {
  const Vector3 centre = (nodes[0].p + nodes[1].p + nodes[2].p) / 3;
  Matrix3 spread = Matrix3::Zero();
  for (int i = 0; i < 3; ++i) spread -= skew(nodes[i].p - centre) * skew(nodes[i].p - centre);
  const Matrix3 turn = spread.inverse() * moments;
  for (int i = 0; i < 3; ++i) forces[i] -= skew(nodes[i].p - centre) * turn;
}

/// Adds a marker's rows for a wrench along each column of `axes`, at its point moved by `arm` (world axes).
void add_marker(const MarkerKinematics& k, const Matrix3& axes, const Vector3& arm, int first_row, bool has_frame,
                int linear, int rows, double* H, double* eta) {
  const Vector3 arm_b = k.A->transpose() * arm;
  const bool turns = first_row >= 3;
  for (int i = 0; i < 3; ++i) {
    const int row = first_row + i;
    const Vector3 world = axes.col(turns ? (i + 1) % 3 : i), f = k.A->transpose() * world;
    const Vector3 moment = turns ? f : arm_b.cross(f);  // about the marker's point, body axes
    double* to = H + row;
    if (has_frame) {
      const Vector3 turn = turns ? f : Vector3(moment + k.r.cross(f));
      for (int c = 0; c < 3; ++c, to += rows) *to += turns ? 0 : world[c];
      for (int c = 0; c < 3; ++c, to += rows) *to += turn[c];
    }
    if (!k.elastic) continue;  // `linear` is of another of the point's markers
    const double* E = k.elastic;
    to = eta + row;
    for (int c = 0; c < linear; ++c, E += 6, to += rows) {
      if (!turns) *to += E[0] * f[0] + E[1] * f[1] + E[2] * f[2];
      *to += E[3] * moment[0] + E[4] * moment[1] + E[5] * moment[2];
    }
  }
}

/// The same of a marker between two frames, for one of them.
void add_share(const Matrix6& J, const Matrix3& axes, int first_row, int rows, double* H) {
  const bool turns = first_row >= 3;
  for (int i = 0; i < 3; ++i) {
    const Vector3 world = axes.col(turns ? (i + 1) % 3 : i);
    const Vector6 force = (turns ? J.bottomRows<3>() : J.topRows<3>()).transpose() * world;
    for (int c = 0; c < 6; ++c) H[first_row + i + rows * c] += force[c];
  }
}

}  // namespace

Matrix3 contact_frame(const Vector3& n) {
  // Without a branch where it matters, and smooth but at one pole (Duff et al. 2017).
  const double sign = std::copysign(1.0, n[2]), a = -1 / (sign + n[2]), b = n[0] * n[1] * a;
  Matrix3 frame;
  frame.col(0) = n;
  frame.col(1) = Vector3(1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]);
  frame.col(2) = Vector3(b, sign + n[1] * n[1] * a, -n[1]);
  return frame;
}

void ContactRows::clear() {
  points_.clear();
  values_.clear();
  count_ = 0;
}

void ContactRows::add(const ContactPlaces& places, const ContactPoint& point, int rows) {
  Row& row = points_.emplace_back(Row{places.record().number, point, contact_frame(point.normal), count_, rows, {}});
  count_ += rows;
  const ContactSide* const sides[2] = {&point.A, &point.B};
  for (int s = 0; s < 2; ++s)
    for (int i = 0; i < sides[s]->node_count; ++i) {
      nodes_[s][i].between = nullptr, nodes_[s][i].elastic = nullptr;  // bodies that have neither say nothing
      places.node(sides[s]->collider, sides[s]->nodes[i], nodes_[s][i]);
    }
  // Both sides' loads act at one point, so that their moments balance: at a node where one touches.
  const int a = point.A.node_count, b = point.B.node_count;
  if (a > 0 && (b == 0 || a <= b))
    row.point.position = mean(point.A, nodes_[0]);
  else if (b > 0)
    row.point.position = mean(point.B, nodes_[1]);
  add_side(places, point.A, nodes_[0], -1, row, row.sides[0]);
  add_side(places, point.B, nodes_[1], 1, row, row.sides[1]);
}

void ContactRows::add_side(const ContactPlaces& places, const ContactSide& at, const MarkerKinematics* nodes,
                           double sign, Row& row, Side& side) {
  const Layout::BodySlice* slice = places.slice(at.collider);
  side.collider = at.collider;
  side.body = places.record().bodies[at.collider];
  if (!slice) return;
  const MarkerKinematics& base = places.collider(at.collider);
  // 1. Columns of all frames from the first to the last that carry the point; with linear coordinates, which lie behind
  // all frames, to the last of the body.
  const Coordinates has = places.record().markers[at.collider].body->coordinates();
  const bool several = has.frames > 1, turns = row.rows > 3;
  const bool by_base = at.node_count == 0 || (turns && !several);
  bool elastic = by_base && base.elastic;
  int low = at.node_count == 0 ? base.frame : std::numeric_limits<int>::max(), high = at.node_count == 0 ? low : -1;
  for (int i = 0; i < at.node_count; ++i) {
    const MarkerKinematics& k = nodes[i];
    elastic |= k.elastic != nullptr;
    low = std::min(low, k.between ? std::min(k.between->shares[0].frame, k.between->shares[1].frame) : k.frame);
    high = std::max(high, k.between ? std::max(k.between->shares[0].frame, k.between->shares[1].frame) : k.frame);
  }
  const Layout::BodySlice& first = several ? frame_slice(places, at.collider, low) : *slice;
  const int linear = elastic ? has.linear : 0;
  if (several && linear > 0) high = has.frames - 1;
  side.velocity = first.v;
  side.frames = !slice->frame ? 0 : several ? high - low + 1 : 1;
  side.count = 6 * side.frames + linear;
  side.H = static_cast<int>(values_.size());
  values_.resize(values_.size() + static_cast<std::size_t>(row.rows * side.count), 0.0);
  double* H = values_.data() + side.H;
  // 2. What each marker of the point adds.
  const auto add = [&](const MarkerKinematics& k, const Matrix3& axes, const Vector3& arm, int first_row) {
    if (k.between)
      for (const auto& share : k.between->shares)
        add_share(share.J, axes, first_row, row.rows, H + 6 * row.rows * (share.frame - low));
    else
      add_marker(k, axes, arm, first_row, slice->frame, linear, row.rows,
                 several ? H + 6 * row.rows * (k.frame - low) : H, H + 6 * row.rows * side.frames);
  };
  const Matrix3 axes = sign * row.frame;
  if (at.node_count == 0) {
    add(base, axes, row.point.position - base.p, 0);
  } else {
    Matrix3 forces[3];
    for (int i = 0; i < at.node_count; ++i) forces[i] = at.weights[i] * axes;
    const Vector3 arm = row.point.position - mean(at, nodes);
    if (at.node_count == 3 && !arm.isZero(0)) add_couple(nodes, skew(arm) * axes, forces);
    for (int i = 0; i < at.node_count; ++i) add(nodes[i], forces[i], Vector3::Zero(), 0);
  }
  if (!turns) return;
  if (by_base) return add(base, axes, Vector3::Zero(), 3);  // turns with the collider
  for (int i = 0; i < at.node_count; ++i) add(nodes[i], at.weights[i] * axes, Vector3::Zero(), 3);
}

void ContactRows::velocity(const Row& row, const double* v, double* u) const {
  for (int i = 0; i < row.rows; ++i) u[i] = 0;
  for (const Side& side : row.sides) {
    const double* H = values_.data() + side.H;
    for (int c = 0; c < side.count; ++c, H += row.rows)
      for (int i = 0; i < row.rows; ++i) u[i] += H[i] * v[side.velocity + c];
  }
}

void ContactRows::add_force(const Row& row, const double* f, double* p) const {
  for (const Side& side : row.sides) {
    const double* H = values_.data() + side.H;
    for (int c = 0; c < side.count; ++c, H += row.rows)
      for (int i = 0; i < row.rows; ++i) p[side.velocity + c] += H[i] * f[i];
  }
}

void ContactRows::release(const std::vector<int>& velocities) {
  for (const Row& row : points_)
    for (const Side& side : row.sides)
      for (int velocity : velocities)
        if (velocity >= side.velocity && velocity < side.velocity + side.count)
          std::fill_n(values_.data() + side.H + row.rows * (velocity - side.velocity), row.rows, 0.0);
}

}  // namespace lithe
