#include "engine/contact/contact_rows.h"

#include <algorithm>
#include <cmath>

namespace lithe {
namespace {

/// Adds a marker's rows for a wrench in each of the frame's axes, at its point moved by `arm` (world axes).
void add_marker(const MarkerKinematics& k, const Matrix3& frame, const Vector3& arm, double weight, int first_axis,
                int axes, bool has_frame, int linear, int rows, double* H) {
  const Vector3 arm_b = k.A->transpose() * arm;
  for (int axis = 0; axis < axes; ++axis) {
    const int row = first_axis + axis;
    const bool turns = row >= 3;
    const Vector3 world = weight * frame.col(turns ? (row - 2) % 3 : row), f = k.A->transpose() * world;
    const Vector3 moment = turns ? f : arm_b.cross(f);  // about the marker's point, body axes
    double* to = H + row;
    if (has_frame) {
      const Vector3 turn = turns ? f : Vector3(moment + k.r.cross(f));
      for (int i = 0; i < 3; ++i, to += rows) *to += turns ? 0 : world[i];
      for (int i = 0; i < 3; ++i, to += rows) *to += turn[i];
    }
    if (!k.elastic) continue;  // `linear` is of another of the point's markers
    const double* E = k.elastic;
    for (int i = 0; i < linear; ++i, E += 6, to += rows) {
      if (!turns) *to += E[0] * f[0] + E[1] * f[1] + E[2] * f[2];
      *to += E[3] * moment[0] + E[4] * moment[1] + E[5] * moment[2];
    }
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
  add_side(places, point.A, -1, row, row.sides[0]);
  add_side(places, point.B, 1, row, row.sides[1]);
}

void ContactRows::add_side(const ContactPlaces& places, const ContactSide& at, double sign, Row& row, Side& side) {
  const Layout::BodySlice* slice = places.slice(at.collider);
  side.collider = at.collider;
  side.body = places.record().bodies[at.collider];
  if (!slice) return;
  const MarkerKinematics& base = places.collider(at.collider);
  MarkerKinematics nodes[3];
  bool elastic = base.elastic && (at.node_count == 0 || row.rows > 3);
  for (int i = 0; i < at.node_count; ++i) {
    places.node(at.collider, at.nodes[i], nodes[i]);
    elastic |= nodes[i].elastic != nullptr;
  }
  const bool frame = slice->frame;
  const int linear = elastic ? slice->linear : 0;
  side.velocity = slice->v;
  side.count = (frame ? 6 : 0) + linear;
  side.H = static_cast<int>(values_.size());
  values_.resize(values_.size() + static_cast<std::size_t>(row.rows * side.count), 0.0);
  double* H = values_.data() + side.H;
  if (at.node_count == 0)
    add_marker(base, row.frame, row.point.position - base.p, sign, 0, 3, frame, linear, row.rows, H);
  for (int i = 0; i < at.node_count; ++i)
    add_marker(nodes[i], row.frame, Vector3::Zero(), sign * at.weights[i], 0, 3, frame, linear, row.rows, H);
  if (row.rows > 3)  // turns with the collider's marker
    add_marker(base, row.frame, Vector3::Zero(), sign, 3, 3, frame, linear, row.rows, H);
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
