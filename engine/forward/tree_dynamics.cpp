#include "engine/forward/tree_dynamics.h"

#include <cmath>

namespace lithe {
namespace {

/// r~ X.
[[gnu::always_inline]] inline Matrix3 skew_times(const Vector3& r, const Matrix3& X) {
  Matrix3 Y;
  for (int j = 0; j < 3; ++j) {
    Y(0, j) = r[1] * X(2, j) - r[2] * X(1, j);
    Y(1, j) = r[2] * X(0, j) - r[0] * X(2, j);
    Y(2, j) = r[0] * X(1, j) - r[1] * X(0, j);
  }
  return Y;
}

/// X r~.
[[gnu::always_inline]] inline Matrix3 times_skew(const Matrix3& X, const Vector3& r) {
  Matrix3 Y;
  Y.col(0) = X.col(1) * r[2] - X.col(2) * r[1];
  Y.col(1) = X.col(2) * r[0] - X.col(0) * r[2];
  Y.col(2) = X.col(0) * r[1] - X.col(1) * r[0];
  return Y;
}

[[gnu::always_inline]] inline Matrix3 inverse_of_symmetric(const Matrix3& S) {
  const double a = S(0, 0), b = S(1, 0), c = S(2, 0), d = S(1, 1), e = S(2, 1), f = S(2, 2);
  const double A = d * f - e * e, B = c * e - b * f, C = b * e - c * d;
  const double scale = 1 / (a * A + b * B + c * C);
  Matrix3 I;
  I(0, 0) = A * scale;
  I(1, 0) = I(0, 1) = B * scale;
  I(2, 0) = I(0, 2) = C * scale;
  I(1, 1) = (a * f - c * c) * scale;
  I(2, 1) = I(1, 2) = (b * c - a * e) * scale;
  I(2, 2) = (a * d - b * b) * scale;
  return I;
}

/// Along axes of the matrix, those that are free.
template <class Add>
void for_free_shifts(const JointFreedom& freedom, const Matrix3& axes, Add&& add) {
  const bool free[] = {freedom.x, freedom.y, freedom.z};
  for (int i = 0; i < 3; ++i)
    if (free[i]) add(Vector3(axes.col(i)));
}

}  // namespace

inline void TreeDynamics::clear(Articulated& a) {
  for (Matrix3* x : {&a.M, &a.H, &a.J}) x->setZero();
  a.b.setZero(), a.t.setZero();
}

TreeDynamics::TreeDynamics(const RigidScene& scene) : gravity_(scene.gravity), motions_(1), threads_(scene.threads) {
  Motion& ground = motions_[0];
  ground.A.setIdentity();
  for (Vector3* x : {&ground.w, &ground.a, &ground.alpha}) x->setZero();
}

std::unique_ptr<TreeDynamics> TreeDynamics::make(const RigidScene& scene) {
  const int bodies = static_cast<int>(scene.bodies.size()), ground = bodies;
  std::vector<std::vector<int>> joints_of(bodies + 1);
  const auto vertex = [&](int body) { return body < 0 ? ground : body; };
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    for (const auto* side : {&scene.joints[j].A, &scene.joints[j].B})
      joints_of[vertex(side->body)].push_back(static_cast<int>(j));

  std::unique_ptr<TreeDynamics> tree(new TreeDynamics(scene));
  struct Found {
    int body, joint, parent;  // joint: by which it was found, -1: none; parent: index of a link
  };
  std::vector<Found> open;
  std::vector<char> seen(bodies + 1, 0);
  // Depth first, so that a subtree lies in one stretch of memory; a body met twice closes a loop, which is no tree.
  const auto look_beyond = [&](int from, int by, int link) {  // by depth, so that subtrees lie in a row
    for (auto j = joints_of[from].rbegin(); j != joints_of[from].rend(); ++j) {
      if (*j == by) continue;
      const auto& joint = scene.joints[*j];
      const int other = vertex(joint.A.body) == from ? vertex(joint.B.body) : vertex(joint.A.body);
      if (seen[other]) return false;
      seen[other] = 1;
      open.push_back({other, *j, link});
    }
    return true;
  };
  seen[ground] = 1;
  if (!look_beyond(ground, -1, -1)) return nullptr;
  for (int root = 0;;) {
    if (open.empty()) {  // what nothing holds
      while (root < bodies && seen[root]) ++root;
      if (root == bodies) break;
      seen[root] = 1;
      open.push_back({root, -1, -1});
    }
    const Found found = open.back();
    open.pop_back();
    const auto& body = scene.bodies[found.body];
    Link link{.kind = Kind::root, .q = body.q, .v = body.v, .mass = body.mass, .inertia = body.inertia};
    if (found.joint >= 0) {
      const auto& joint = scene.joints[found.joint];
      const bool outer_is_B = vertex(joint.B.body) == found.body;
      const auto &inner = outer_is_B ? joint.A : joint.B, &outer = outer_is_B ? joint.B : joint.A;
      link.parent = found.parent;
      link.r = outer.position, link.r_parent = inner.position;
      link.axes = outer.axes, link.axes_parent = inner.axes;
      link.freedom = joint.freedom;
      const bool shifts = joint.freedom.x || joint.freedom.y || joint.freedom.z;
      link.kind = Kind::other;
      if (!shifts && joint.freedom.rotation == JointFreedom::Rotation::any) link.kind = Kind::spherical;
      if (!shifts && joint.freedom.rotation == JointFreedom::Rotation::about_z) link.kind = Kind::revolute;
      if (link.kind == Kind::other) {
        // A ball that also slides would need its three turns eliminated one by one, in axes that turn with it: rare,
        // left to the general form.
        if (joint.freedom.rotation == JointFreedom::Rotation::any) return nullptr;
        link.other = static_cast<int>(tree->others_.size());
        tree->others_.emplace_back();
      }
    }
    tree->links_.push_back(link);
    if (!look_beyond(found.body, found.joint, static_cast<int>(tree->links_.size()) - 1)) return nullptr;
  }
  tree->motions_.resize(tree->links_.size() + 1, tree->motions_[0]);
  tree->divide();
  return tree;
}

/// Into branches of about kTogether links, whole subtrees, and the trunk that they hang on.
void TreeDynamics::divide() {
  constexpr int kTogether = 64;
  const int n = static_cast<int>(links_.size());
  std::vector<int> size(n, 1);
  for (int i = n - 1; i >= 0; --i)
    if (links_[i].parent >= 0) size[links_[i].parent] += size[i];
  for (int i = 0; i < n;) {
    if (size[i] > kTogether) {
      trunk_.push_back(i++);
      continue;
    }
    // Small neighbouring subtrees share a branch: a thread should get work for more than its own start.
    const bool joins =
        !branches_.empty() && branches_.back().last == i && i + size[i] - branches_.back().first <= kTogether;
    if (joins)
      branches_.back().last = i + size[i];
    else
      branches_.push_back({i, i + size[i]});
    if (const int parent = links_[i].parent; parent >= 0) {
      links_[i].handed = static_cast<int>(handed_to_.size());
      handed_to_.push_back(parent);
    }
    i += size[i];
  }
  handed_.resize(handed_to_.size());
}

/// About the point at r from the present one, whose own acceleration differs by ω̇ × r + swing.
TreeDynamics::Articulated TreeDynamics::shifted_out(const Articulated& own, const Vector3& r, const Vector3& swing) {
  Articulated at;
  at.M = own.M;
  at.H = own.H + times_skew(own.M, r);
  at.J = own.J + times_skew(own.H.transpose(), r) - skew_times(r, at.H);
  at.b = own.b - own.M * swing;
  at.t = own.t - own.H.transpose() * swing - r.cross(at.b);
  return at;
}

/// Adds what acts at the point at r from the parent's centre of mass.
void TreeDynamics::add_shifted_in(Articulated& parent, const Articulated& at, const Vector3& r, const Vector3& swing) {
  const Matrix3 H = at.H - times_skew(at.M, r);
  const Vector3 b = at.b + at.M * swing;
  parent.M += at.M;
  parent.H += H;
  parent.J += at.J - times_skew(at.H.transpose(), r) + skew_times(r, H);
  parent.b += b;
  parent.t += at.t + at.H.transpose() * swing + r.cross(b);
}

/// The joint bears no torque: ω̇ goes out.
void TreeDynamics::eliminate_spherical(Motion& m, Articulated& at) const {
  const Matrix3 inverse = inverse_of_symmetric(at.J);
  m.gain.noalias() = inverse * at.H.transpose();
  m.rest.noalias() = inverse * at.t;
  at.M.noalias() -= at.H * m.gain;
  at.b.noalias() -= at.H * m.rest;
}

void TreeDynamics::eliminate_revolute(const Link& link, Motion& m, const Motion& parent, Articulated& at) const {
  m.axis.noalias() = m.A * link.axes.col(2);
  m.turn_bias = parent.w.cross(m.w);  // ω_parent × (ω - ω_parent)
  const Vector3 pull = at.H * m.axis, twist = at.J * m.axis;
  const double inverse = 1 / m.axis.dot(twist);
  m.pull = inverse * pull;
  m.twist = inverse * twist;
  m.rest[0] = m.twist.dot(m.turn_bias) + inverse * m.axis.dot(at.t);
  at.b += at.H * m.turn_bias - pull * m.rest[0];
  at.t += at.J * m.turn_bias - twist * m.rest[0];
  at.M.noalias() -= pull * m.pull.transpose();
  at.H.noalias() -= pull * m.twist.transpose();
  at.J.noalias() -= twist * m.twist.transpose();
}

void TreeDynamics::eliminate_other(const Link& link, const Motion& m, const Motion& parent, const double* v,
                                   Articulated& at) {
  Other& o = others_[link.other];
  // 1. The free motions, and the rates at which they go now.
  const Eigen::Map<const Vector3> v_own(v + link.v);
  Vector3 v_parent = parent.w.cross(m.r_parent);
  if (link.parent >= 0) v_parent += Eigen::Map<const Vector3>(v + links_[link.parent].v);
  const Vector3 slide = v_own + m.w.cross(m.r) - v_parent, turn = m.w - parent.w;
  const Matrix3 axes = parent.A * link.axes_parent;
  o.count = 0;
  o.bias.setZero();
  for_free_shifts(link.freedom, axes, [&](const Vector3& axis) {
    o.motion[o.count++] << axis, Vector3::Zero();
    o.bias.head<3>() += 2 * axis.dot(slide) * parent.w.cross(axis);
  });
  if (link.freedom.rotation == JointFreedom::Rotation::about_z) {
    const Vector3 axis = axes.col(2);
    o.motion[o.count++] << Vector3::Zero(), axis;
    o.bias.tail<3>() = axis.dot(turn) * parent.w.cross(axis);
  }
  // 2. One after the other goes out; the inertia left is blind to those that have gone.
  Matrix6 I;
  I << at.M, at.H, at.H.transpose(), at.J;
  Vector6 f;
  f << at.b, at.t;
  f += I * o.bias;
  for (int k = 0; k < o.count; ++k) {
    const Vector6 push = I * o.motion[k];
    const double inverse = 1 / o.motion[k].dot(push);
    o.gain[k] = inverse * push;
    o.rest[k] = inverse * o.motion[k].dot(f);
    I.noalias() -= push * o.gain[k].transpose();
    f -= push * o.rest[k];
  }
  at.M = I.topLeftCorner<3, 3>(), at.H = I.topRightCorner<3, 3>(), at.J = I.bottomRightCorner<3, 3>();
  at.b = f.head<3>(), at.t = f.tail<3>();
}

/// Subtree and link itself, less what the joint leaves free, onto the parent.
void TreeDynamics::eliminate(int i, const double* q, const double* v, const double* load) {
  const Link& link = links_[i];
  Motion& m = motions_[i + 1];
  Motion& parent = motions_[link.parent + 1];
  Articulated& inwards = link.handed < 0 ? parent.subtree : handed_[link.handed];
  if (link.handed >= 0) clear(inwards);
  const Eigen::Map<const Vector3> w(v + link.v + 3);
  const Vector3 spin = link.inertia * w;
  Articulated own = m.subtree;
  // The link's own inertia about its centre of mass, in world axes; J is constant in body axes.
  own.M.diagonal().array() += link.mass;
  own.J += m.A * link.inertia * m.A.transpose();
  // b and t are the force and torque at zero acceleration: gyroscopic terms less gravity and loads.
  own.b -= link.mass * gravity_;
  Vector3 t = w.cross(spin);
  if (load) {
    own.b -= Eigen::Map<const Vector3>(load + link.v);
    t -= Eigen::Map<const Vector3>(load + link.v + 3);
  }
  own.t += m.A * t;
  if (link.kind == Kind::root) {
    m.subtree = own;
    return;
  }
  m.r = m.A * link.r;
  // ω × (ω × r): what a point at r accelerates by beyond ω̇ × r.
  m.swing = m.w.cross(m.w.cross(m.r));
  if (link.kind == Kind::other) {  // slides: the point is the outer marker's
    m.r_parent = Eigen::Map<const Vector3>(q + link.q) + m.r;
    if (link.parent >= 0) m.r_parent -= Eigen::Map<const Vector3>(q + links_[link.parent].q);
  } else {
    m.r_parent = parent.A * link.r_parent;
  }
  m.swing_parent = parent.w.cross(parent.w.cross(m.r_parent));
  Articulated at = shifted_out(own, m.r, m.swing);
  switch (link.kind) {
    case Kind::spherical:
      eliminate_spherical(m, at);
      if (link.parent < 0) return;
      // Force alone: the shift of a point.
      {
        const Matrix3 H = times_skew(at.M, m.r_parent);
        const Vector3 b = at.b + at.M * m.swing_parent;
        inwards.M += at.M;
        inwards.H -= H;
        inwards.J -= skew_times(m.r_parent, H);
        inwards.b += b;
        inwards.t += m.r_parent.cross(b);
      }
      return;
    case Kind::revolute:
      eliminate_revolute(link, m, parent, at);
      break;
    default:
      eliminate_other(link, m, parent, v, at);
  }
  if (link.parent >= 0) add_shifted_in(inwards, at, m.r_parent, m.swing_parent);
}

/// Accelerations of a link whose parent has its own.
void TreeDynamics::find(int i, double* v_dot) {
  const Link& link = links_[i];
  Motion& m = motions_[i + 1];
  const auto hand_out = [&] {
    Eigen::Map<Vector3>(v_dot + link.v) = m.a;
    Eigen::Map<Vector3>(v_dot + link.v + 3) = m.A.transpose() * m.alpha;
  };
  if (link.kind == Kind::root) {  // (a, ω̇) = -I⁻¹ (b, t)
    const Articulated& s = m.subtree;
    // No joint: all six accelerations are free, and the 6 x 6 is solved by its two 3 x 3 blocks.
    const Matrix3 inverse = inverse_of_symmetric(s.M), gain = inverse * s.H;
    const Vector3 rest = inverse * s.b;
    m.alpha = inverse_of_symmetric(s.J - s.H.transpose() * gain) * (s.H.transpose() * rest - s.t);
    m.a = -rest - gain * m.alpha;
    return hand_out();
  }
  const Motion& parent = motions_[link.parent + 1];
  Vector3 a = parent.a + parent.alpha.cross(m.r_parent) + m.swing_parent;  // of the joint's point
  switch (link.kind) {
    case Kind::spherical:
      m.alpha = -(m.gain * a) - m.rest;
      break;
    case Kind::revolute:
      m.alpha = parent.alpha + m.turn_bias - m.axis * (m.pull.dot(a) + m.twist.dot(parent.alpha) + m.rest[0]);
      break;
    default: {
      const Other& o = others_[link.other];
      Vector6 motion;
      motion << a, parent.alpha;
      Vector6 sum = motion + o.bias;
      // Back through the order of elimination: what went last knows only itself.
      for (int k = o.count - 1; k >= 0; --k) {
        double y = o.gain[k].dot(motion) + o.rest[k];
        motion -= y * o.motion[k];
        sum -= y * o.motion[k];
      }
      a = sum.head<3>();
      m.alpha = sum.tail<3>();
    }
  }
  m.a = a - m.alpha.cross(m.r) - m.swing;
  hand_out();
}

void TreeDynamics::place(int i, const double* q, const double* v) {
  Motion& m = motions_[i + 1];
  m.A = rotation_matrix(Eigen::Map<const Vector4>(q + links_[i].q + 3));
  m.w.noalias() = m.A * Eigen::Map<const Vector3>(v + links_[i].v + 3);
  clear(m.subtree);
}

void TreeDynamics::accelerations(const double* q, const double* v, const double* load, double* v_dot) {
  const int branches = static_cast<int>(branches_.size());
  // 1. Inwards: branches, then the trunk.
  for (int i : trunk_) place(i, q, v);
  const auto inwards = [&](int k) {
    const Branch& b = branches_[k];
    for (int i = b.first; i < b.last; ++i) place(i, q, v);
    for (int i = b.last; i-- > b.first;) eliminate(i, q, v, load);
  };
  threads_.run(branches, inwards);
  // In a fixed order, after all branches: sums are the same to the bit for any number of threads.
  for (std::size_t k = 0; k < handed_.size(); ++k) {
    Articulated& to = motions_[handed_to_[k] + 1].subtree;
    const Articulated& from = handed_[k];
    to.M += from.M, to.H += from.H, to.J += from.J, to.b += from.b, to.t += from.t;
  }
  for (auto i = trunk_.rbegin(); i != trunk_.rend(); ++i) eliminate(*i, q, v, load);
  // 2. Outwards.
  for (int i : trunk_) find(i, v_dot);
  const auto outwards = [&](int k) {
    for (int i = branches_[k].first; i < branches_[k].last; ++i) find(i, v_dot);
  };
  threads_.run(branches, outwards);
}

bool TreeDynamics::project(double* q, double* v, double) {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const Link& link = links_[i];
    Motion& m = motions_[i + 1];
    const Motion& parent = motions_[link.parent + 1];
    Eigen::Map<Vector3> p(q + link.q), v_own(v + link.v), w(v + link.v + 3);
    Eigen::Map<Vector4> e(q + link.q + 3);
    m.A = rotation_matrix(e);
    if (link.kind == Kind::root) {
      m.w = m.A * w;
      continue;
    }
    // 1. Axes: the turn that takes those that must agree onto the parent's, small, so that it squares in each round.
    const Matrix3 axes = parent.A * link.axes_parent;
    for (int round = 0; round < 4 && link.freedom.rotation != JointFreedom::Rotation::any; ++round) {
      const Matrix3 own = m.A * link.axes;
      Vector3 turn = own.col(2).cross(axes.col(2));
      if (link.freedom.rotation == JointFreedom::Rotation::none)
        turn = 0.5 * (turn + own.col(0).cross(axes.col(0)) + own.col(1).cross(axes.col(1)));
      if (turn.squaredNorm() == 0) break;
      e = rotated(e, m.A.transpose() * turn);
      m.A = rotation_matrix(e);
      if (turn.squaredNorm() < 1e-18) break;
    }
    // 2. Position and velocity of the joint's point, and the turning, but for what is free.
    const Eigen::Map<const Vector3> p_parent(link.parent < 0 ? ground_ : q + links_[link.parent].q),
        v_parent(link.parent < 0 ? ground_ : v + links_[link.parent].v);
    const Vector3 r = m.A * link.r, arm = parent.A * link.r_parent;
    Vector3 gap = p + r - p_parent - arm;
    for_free_shifts(link.freedom, axes, [&](const Vector3& axis) { gap -= axis * axis.dot(gap); });
    p -= gap;
    const Vector3 arm_now = p + r - p_parent;  // with what it has slid
    m.w = m.A * w;
    const Vector3 slide = v_own + m.w.cross(r) - v_parent - parent.w.cross(arm_now);
    if (link.freedom.rotation != JointFreedom::Rotation::any) {
      const Vector3 axis = axes.col(2);
      const double rate = link.freedom.rotation == JointFreedom::Rotation::none ? 0 : axis.dot(m.w - parent.w);
      m.w = parent.w + rate * axis;
      w = m.A.transpose() * m.w;
    }
    Vector3 free = Vector3::Zero();
    for_free_shifts(link.freedom, axes, [&](const Vector3& axis) { free += axis * axis.dot(slide); });
    v_own = v_parent + parent.w.cross(arm_now) + free - m.w.cross(r);
  }
  return true;
}

}  // namespace lithe
