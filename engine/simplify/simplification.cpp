#include "engine/simplify/simplification.h"

#include "engine/simplify/simplification_internal.h"
#include "engine/simplify/stand_in.h"

namespace lithe {
namespace {

Vector4 inverse(const Vector4& e) { return {e[0], -e[1], -e[2], -e[3]}; }

void check_size(const State& state, int q, int v, const std::string& what) {
  if (state.q.size() != q || state.v.size() != v || state.v_dot.size() != v)
    throw SceneError("the state has " + std::to_string(state.q.size()) + " coordinates, " +
                         std::to_string(state.v.size()) + " velocities and " + std::to_string(state.v_dot.size()) +
                         " accelerations; the " + what + " system has " + std::to_string(q) + ", " + std::to_string(v) +
                         " and " + std::to_string(v),
                     "Simplification", "expand() states of the smaller system, reduce() states of the whole");
}

}  // namespace

Simplification::Simplification(SystemGraph& whole, SimplificationOptions options) : whole_(assemble(whole)) {
  Simplifier(whole, options, *this).run();
}

/// Of a stand-in's frame, world axes.
struct Simplification::Motion {
  Vector3 p, v, a, w, alpha;
  Vector4 e;
};

Simplification::Motion Simplification::motion(const Moved& moved, const State& small) const {
  Motion m;
  const double *q = small.q.data() + moved.q, *v = small.v.data() + moved.v, *a = small.v_dot.data() + moved.v;
  if (!moved.planar) {
    m.e = Eigen::Map<const Vector4>(q + 3);
    const Matrix3 R = rotation_matrix(m.e);
    m.p = Eigen::Map<const Vector3>(q), m.v = Eigen::Map<const Vector3>(v), m.a = Eigen::Map<const Vector3>(a);
    m.w = R * Eigen::Map<const Vector3>(v + 3), m.alpha = R * Eigen::Map<const Vector3>(a + 3);
    return m;
  }
  const Matrix3& plane = moved.planar->plane().axes;
  Vector4 turn;
  turn << std::cos(q[2] / 2), std::sin(q[2] / 2) * plane.col(2);
  m.e = quaternion_product(turn, moved.reference);
  m.p = moved.planar->center(q);
  m.v = plane.col(0) * v[0] + plane.col(1) * v[1], m.a = plane.col(0) * a[0] + plane.col(1) * a[1];
  m.w = plane.col(2) * v[2], m.alpha = plane.col(2) * a[2];
  return m;
}

void Simplification::expand(const State& small, State& whole) const {
  check_size(small, q_count_, v_count_, "smaller");
  const Layout& layout = whole_.layout();
  whole.time = small.time;
  whole.q = still_;
  whole.v.setZero(layout.v_count());
  whole.v_dot.setZero(layout.v_count());
  whole.lambda.resize(0);
  const int row_count = static_cast<int>(rows_.size());
  if (row_count == layout.row_count() && row_count == small.lambda.size()) whole.lambda = small.lambda;
  whole.quarter_turns = whole_.initial_state().quarter_turns;
  for (const Copied& c : q_) whole.q.segment(c.whole, c.count) = small.q.segment(c.small, c.count);
  for (const Copied& c : v_) {
    whole.v.segment(c.whole, c.count) = small.v.segment(c.small, c.count);
    whole.v_dot.segment(c.whole, c.count) = small.v_dot.segment(c.small, c.count);
  }
  for (const Copied& c : angles_)
    whole.quarter_turns.segment(c.whole, c.count) = small.quarter_turns.segment(c.small, c.count);
  whole.contacts = small.contacts;  // colliders keep their places and axes
  for (const Moved& moved : moved_) {
    const Motion m = motion(moved, small);
    const Matrix3 R = rotation_matrix(m.e);
    for (const Piece& piece : moved.pieces) {
      const Vector4 e = quaternion_product(m.e, piece.turned);
      const Matrix3 to_body = rotation_matrix(e).transpose();
      const Vector3 r = R * piece.at, swing = m.w.cross(r);
      whole.q.segment<3>(piece.q) = m.p + r;
      whole.q.segment<4>(piece.q + 3) = e;
      whole.v.segment<3>(piece.v) = m.v + swing;
      whole.v.segment<3>(piece.v + 3) = to_body * m.w;
      whole.v_dot.segment<3>(piece.v) = m.a + m.alpha.cross(r) + m.w.cross(swing);
      whole.v_dot.segment<3>(piece.v + 3) = to_body * m.alpha;
    }
  }
}

State Simplification::reduce(const State& whole) const {
  check_size(whole, whole_.layout().q_count(), whole_.layout().v_count(), "whole");
  State small{whole.time,
              VectorX::Zero(q_count_),
              VectorX::Zero(v_count_),
              VectorX::Zero(v_count_),
              VectorX::Zero(static_cast<int>(rows_.size())),
              VectorX::Zero(angle_count_)};
  for (const Copied& c : q_) small.q.segment(c.small, c.count) = whole.q.segment(c.whole, c.count);
  for (const Copied& c : v_) {
    small.v.segment(c.small, c.count) = whole.v.segment(c.whole, c.count);
    small.v_dot.segment(c.small, c.count) = whole.v_dot.segment(c.whole, c.count);
  }
  if (whole.lambda.size() == whole_.layout().row_count())
    for (std::size_t r = 0; r < rows_.size(); ++r) small.lambda[static_cast<int>(r)] = whole.lambda[rows_[r]];
  for (const Copied& c : angles_)
    small.quarter_turns.segment(c.small, c.count) = whole.quarter_turns.segment(c.whole, c.count);
  small.contacts = whole.contacts;
  for (const Moved& moved : moved_) {
    // The frame's motion from that of the first body, which has its axes.
    const Piece& first = moved.pieces[0];
    const Vector4 e = whole.q.segment<4>(first.q + 3);
    const Matrix3 R = rotation_matrix(e);
    const Vector3 r = -(R * first.at), w = R * whole.v.segment<3>(first.v + 3),
                  alpha = R * whole.v_dot.segment<3>(first.v + 3);
    const Vector3 p = whole.q.segment<3>(first.q) + r, v = whole.v.segment<3>(first.v) + w.cross(r),
                  a = whole.v_dot.segment<3>(first.v) + alpha.cross(r) + w.cross(w.cross(r));
    if (!moved.planar) {
      small.q.segment<3>(moved.q) = p;
      small.q.segment<4>(moved.q + 3) = e;
      small.v.segment<6>(moved.v) << v, whole.v.segment<3>(first.v + 3);
      small.v_dot.segment<6>(moved.v) << a, whole.v_dot.segment<3>(first.v + 3);
      continue;
    }
    const Matrix3& plane = moved.planar->plane().axes;
    const Vector4 turn = quaternion_product(e, inverse(moved.reference));
    const double angle = 2 * std::atan2(plane.col(2).dot(turn.tail<3>()), turn[0]);
    small.q.segment<3>(moved.q) << plane.col(0).dot(p), plane.col(1).dot(p), angle;
    small.v.segment<3>(moved.v) << plane.col(0).dot(v), plane.col(1).dot(v), plane.col(2).dot(w);
    small.v_dot.segment<3>(moved.v) << plane.col(0).dot(a), plane.col(1).dot(a), plane.col(2).dot(alpha);
  }
  return small;
}

std::string Simplification::report() const {
  std::string text;
  for (const std::string& line : report_) text += line + "\n";
  return text;
}

}  // namespace lithe
