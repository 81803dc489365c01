#include "engine/forward/tree_dynamics.h"

#include <cmath>

#include "engine/factor/graph_topology.h"

namespace lithe {
namespace {

using lanes::cross;
using lanes::dot;
using lanes::Spatial;

/// ω × (ω × r): what a point at r accelerates by beyond ω̇ × r.
inline Lanes swing(const Lanes& w, const Lanes& r) { return w * dot(w, r) - r * dot(w, w); }

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

Matrix3 matrix(const lanes::Columns& A) {
  Matrix3 M;
  for (int k = 0; k < 3; ++k) M.col(k) = lanes::vector(A.c[k]);
  return M;
}

/// Of a body that no joint holds, (a, ω̇) = -I⁻¹ p by its 3 x 3 blocks; the reference is its centre of mass.
Spatial free_acceleration(const Spatial* I, const Spatial& p) {
  Matrix3 M, H, J;
  for (int k = 0; k < 3; ++k)
    M.col(k) = lanes::vector(I[k].linear), H.col(k) = lanes::vector(I[3 + k].linear),
    J.col(k) = lanes::vector(I[3 + k].angular);
  const Matrix3 inverse = inverse_of_symmetric(M), gain = inverse * H;
  const Vector3 rest = inverse * lanes::vector(p.linear);
  const Vector3 alpha =
      inverse_of_symmetric(J - H.transpose() * gain) * (H.transpose() * rest - lanes::vector(p.angular));
  return {lanes::of(-rest - gain * alpha), lanes::of(alpha)};
}

}  // namespace

inline void TreeDynamics::Articulated::clear() {
  for (Spatial& k : column) k = {lanes::none(), lanes::none()};
  p = {lanes::none(), lanes::none()};
}

inline void TreeDynamics::Articulated::add(const Articulated& other) {
  for (int k = 0; k < 6; ++k) column[k] += other.column[k];
  p += other.p;
}

inline Spatial TreeDynamics::Articulated::times(const Spatial& s) const {
  Spatial of_linear = column[0] * s.linear[0], of_angular = column[3] * s.angular[0];
  for (int k = 1; k < 3; ++k) of_linear += column[k] * s.linear[k], of_angular += column[3 + k] * s.angular[k];
  return of_linear + of_angular;
}

inline void TreeDynamics::Articulated::subtract(const Spatial& u, const Spatial& g, double rest) {
  for (int k = 0; k < 3; ++k) column[k] -= u * g.linear[k], column[3 + k] -= u * g.angular[k];
  p -= u * rest;
}

TreeDynamics::TreeDynamics(const RigidScene& scene)
    : gravity_(lanes::of(scene.gravity)), motions_(1), threads_(scene.threads) {
  Motion& ground = motions_[0];
  ground.A = lanes::columns(Matrix3::Identity());
  ground.w = ground.x = ground.shift = lanes::none();
  ground.a = ground.c = {lanes::none(), lanes::none()};
}

bool TreeDynamics::serves(const RigidScene& scene) {
  Topology topology{static_cast<int>(scene.bodies.size()), {}};
  topology.ties.reserve(scene.joints.size());
  for (const auto& joint : scene.joints) {
    const JointFreedom& free = joint.freedom;
    if (free.rotation == JointFreedom::Rotation::any && (free.x || free.y || free.z)) return false;  // rare
    topology.ties.push_back({joint.A.body, joint.B.body});
  }
  return !has_loops(topology);
}

std::unique_ptr<TreeDynamics> TreeDynamics::make(const RigidScene& scene) {
  if (!serves(scene)) return nullptr;
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
  // Depth first, so that a subtree lies in one stretch of memory.
  const auto look_beyond = [&](int from, int by, int link) {  // by depth, so that subtrees lie in a row
    for (auto j = joints_of[from].rbegin(); j != joints_of[from].rend(); ++j) {
      if (*j == by) continue;
      const auto& joint = scene.joints[*j];
      const int other = vertex(joint.A.body) == from ? vertex(joint.B.body) : vertex(joint.A.body);
      seen[other] = 1;
      open.push_back({other, *j, link});
    }
  };
  seen[ground] = 1;
  look_beyond(ground, -1, -1);
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
    link.first_free = static_cast<int>(tree->free_.size());
    if (found.joint >= 0) {
      const auto& joint = scene.joints[found.joint];
      const bool outer_is_B = vertex(joint.B.body) == found.body;
      const auto &inner = outer_is_B ? joint.A : joint.B, &outer = outer_is_B ? joint.B : joint.A;
      link.parent = found.parent;
      link.r = outer.position, link.r_parent = inner.position;
      link.axes = outer.axes, link.axes_parent = inner.axes;
      link.freedom = joint.freedom;
      link.depth = found.parent < 0 ? 0 : tree->links_[found.parent].depth + 1;
      const bool any = joint.freedom.rotation == JointFreedom::Rotation::any;
      const bool turns = joint.freedom.rotation == JointFreedom::Rotation::about_z;
      link.kind = any ? Kind::spherical : turns && !link.slides() ? Kind::revolute : Kind::other;
      const int count = joint.freedom.x + joint.freedom.y + joint.freedom.z + (any ? 3 : turns ? 1 : 0);
      tree->free_.resize(tree->free_.size() + count);
    }
    tree->links_.push_back(link);
    look_beyond(found.body, found.joint, static_cast<int>(tree->links_.size()) - 1);
  }
  tree->motions_.resize(tree->links_.size() + 1, tree->motions_[0]);
  tree->divide();
  std::vector<BallTree::Link> balls;
  for (const Link& link : tree->links_)
    if (link.kind == Kind::spherical)
      balls.push_back({link.q, link.v, link.parent, true, link.mass, link.inertia, link.r, link.r_parent});
    else if (link.kind == Kind::root)
      balls.push_back({link.q, link.v, -1, false, link.mass, link.inertia, Vector3::Zero(), Vector3::Zero()});
  if (balls.size() == tree->links_.size()) {
    tree->balls_.emplace(balls, tree->branches_, tree->trunk_, scene.gravity);
    tree->free_ = {};  // of the general recursion alone
  }
  return tree;
}

/// Into branches of about kSmall links, whole subtrees, and the trunk that they hang on.
void TreeDynamics::divide() {
  constexpr int kSmall = 64;
  const int n = static_cast<int>(links_.size());
  std::vector<int> size(n, 1);
  for (int i = n - 1; i >= 0; --i)
    if (links_[i].parent >= 0) size[links_[i].parent] += size[i];
  for (int i = 0; i < n;) {
    if (size[i] > kSmall) {
      trunk_.push_back(i++);
      continue;
    }
    // Small neighbouring subtrees share a branch: a thread should get work for more than its own start.
    const bool joins =
        !branches_.empty() && branches_.back().last == i && i + size[i] - branches_.back().first <= kSmall;
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

/// The link's own inertia, and the force and torque at zero acceleration: gyroscopic terms less gravity and loads.
inline void TreeDynamics::add_own(const Link& link, Motion& m, const double* v, const double* load) const {
  const Eigen::Map<const Vector3> w(v + link.v + 3);  // body axes, in which the inertia is constant
  const Lanes x = m.x, h = x * link.mass;
  const double mass = link.mass, far = dot(h, x);
  Spatial* I = m.subtree.column;
  // m E, m e_k × x and its transpose, J + m (x² E - x xᵀ)
  const Lanes along[] = {lanes::of(0, -h[2], h[1]), lanes::of(h[2], 0, -h[0]), lanes::of(-h[1], h[0], 0)};
  const Lanes unit[] = {lanes::of(1, 0, 0), lanes::of(0, 1, 0), lanes::of(0, 0, 1)};
  lanes::Columns AJ;
  for (int k = 0; k < 3; ++k) AJ.c[k] = m.A * Vector3(link.inertia.col(k));
  for (int k = 0; k < 3; ++k) {
    I[k].linear += unit[k] * mass;
    I[k].angular -= along[k];
    I[3 + k].linear += along[k];
    const Lanes J = AJ.c[0] * m.A.c[0][k] + AJ.c[1] * m.A.c[1][k] + AJ.c[2] * m.A.c[2][k];
    I[3 + k].angular += J + unit[k] * far - h * x[k];
  }
  Lanes force = swing(m.w, x) * mass - gravity_ * mass;
  Vector3 torque = w.cross(link.inertia * w);
  if (load) {
    force -= lanes::from(load + link.v);
    torque -= Eigen::Map<const Vector3>(load + link.v + 3);
  }
  m.subtree.p += Spatial{force, cross(x, force) + m.A * torque};
}

/// What the joint leaves free, and what accelerations beyond it differ by besides: how many motions.
inline int TreeDynamics::find_free_motions(const Link& link, Motion& m, const Motion& parent, const double* q,
                                           const double* v) {
  FreeMotion* free = free_.data() + link.first_free;
  const Lanes r = m.A * link.r, at = m.x + r;  // the joint's point
  const Lanes apart = swing(parent.w, at) - swing(m.w, at);
  switch (link.kind) {
    case Kind::spherical:
      m.c = {apart, lanes::none()};
      free[0].S = {lanes::of(0, at[2], -at[1]), lanes::of(1, 0, 0)};  // at × e_k, e_k
      free[1].S = {lanes::of(-at[2], 0, at[0]), lanes::of(0, 1, 0)};
      free[2].S = {lanes::of(at[1], -at[0], 0), lanes::of(0, 0, 1)};
      return 3;
    case Kind::revolute: {
      const Lanes axis = m.A * Vector3(link.axes.col(2));
      const Lanes turn = cross(parent.w, m.w);  // ω_parent × (ω - ω_parent)
      m.c = {cross(at, turn) + apart, turn};
      free[0].S = {cross(at, axis), axis};
      return 1;
    }
    default: {
      // The point is the outer marker's, which slides on the parent.
      Lanes r_parent = lanes::from(q + link.q) + r, v_parent = lanes::none();
      if (link.parent >= 0) {
        r_parent -= lanes::from(q + links_[link.parent].q);
        v_parent = lanes::from(v + links_[link.parent].v) + cross(parent.w, r_parent);
      }
      const Lanes slide = lanes::from(v + link.v) + cross(m.w, r) - v_parent;
      const Matrix3 axes = matrix(parent.A) * link.axes_parent;
      Lanes bias = apart, turn = lanes::none();
      int count = 0;
      for_free_shifts(link.freedom, axes, [&](const Vector3& a) {
        const Lanes axis = lanes::of(a);
        free[count++].S = {axis, lanes::none()};
        bias += cross(parent.w, axis) * (2 * dot(axis, slide));
      });
      if (link.freedom.rotation == JointFreedom::Rotation::about_z) {
        const Lanes axis = lanes::of(axes.col(2));
        free[count++].S = {cross(at, axis), axis};
        turn = cross(parent.w, axis) * dot(axis, m.w - parent.w);
      }
      m.c = {bias + cross(at, turn), turn};
      return count;
    }
  }
}

/// To a reference from which the present one is at d.
inline void TreeDynamics::shift(Articulated& subtree, const Lanes& d, const Lanes& w_parent) {
  Spatial* I = subtree.column;
  const Lanes apart = swing(w_parent, d);
  subtree.p += I[0] * apart[0] + I[1] * apart[1] + I[2] * apart[2];
  I[3] += I[2] * d[1], I[3] -= I[1] * d[2];
  I[4] += I[0] * d[2], I[4] -= I[2] * d[0];
  I[5] += I[1] * d[0], I[5] -= I[0] * d[1];
  for (int k = 0; k < 6; ++k) I[k].angular += cross(d, I[k].linear);
  subtree.p.angular += cross(d, subtree.p.linear);
}

/// Subtree and link itself, less what the joint leaves free, onto the parent.
void TreeDynamics::eliminate(int i, const double* q, const double* v, const double* load) {
  const Link& link = links_[i];
  Motion& m = motions_[i + 1];
  Articulated& subtree = m.subtree;
  add_own(link, m, v, load);
  if (link.kind == Kind::root) return;
  Motion& parent = motions_[link.parent + 1];
  const int count = find_free_motions(link, m, parent, q, v);
  FreeMotion* free = free_.data() + link.first_free;
  // One after the other goes out; the inertia left is blind to those that have gone.
  const auto take_out = [&subtree](FreeMotion& motion, const Spatial& push) {
    const double inverse = 1 / dot(motion.S, push);
    motion.gain = push * inverse;
    motion.rest = inverse * dot(motion.S, subtree.p);
    subtree.subtract(push, motion.gain, motion.rest);
  };
  if (link.kind == Kind::spherical) {  // S and c are zero where terms are missing
    const Spatial* I = subtree.column;
    subtree.p += I[0] * m.c.linear[0] + I[1] * m.c.linear[1] + I[2] * m.c.linear[2];
    const Lanes x = free[0].S.linear, y = free[1].S.linear, z = free[2].S.linear;
    take_out(free[0], I[3] + I[1] * x[1] + I[2] * x[2]);
    take_out(free[1], I[4] + I[0] * y[0] + I[2] * y[2]);
    take_out(free[2], I[5] + I[0] * z[0] + I[1] * z[1]);
  } else {
    subtree.p += subtree.times(m.c);
    for (int k = 0; k < count; ++k) take_out(free[k], subtree.times(free[k].S));
  }
  if (link.parent < 0) return;
  if (link.leads()) shift(subtree, m.shift, parent.w);
  if (link.handed >= 0)
    handed_[link.handed] = subtree;
  else
    parent.subtree.add(subtree);
}

/// Accelerations of a link whose parent has its own.
void TreeDynamics::find(int i, double* v_dot) {
  const Link& link = links_[i];
  Motion& m = motions_[i + 1];
  if (link.kind == Kind::root) {
    m.a = free_acceleration(m.subtree.column, m.subtree.p);
  } else {
    const Motion& parent = motions_[link.parent + 1];
    Spatial a = parent.a;
    if (link.leads() && link.parent >= 0) a.linear += cross(a.angular, m.shift) + swing(parent.w, m.shift);
    m.a = a + m.c;
    // Back through the order of elimination: what went last knows only itself.
    const int end = i + 1 < static_cast<int>(links_.size()) ? links_[i + 1].first_free : static_cast<int>(free_.size());
    for (int k = end; k-- > link.first_free;) {
      const FreeMotion& free = free_[k];
      const Spatial moved = free.S * (dot(free.gain, a) + free.rest);
      a -= moved;
      m.a -= moved;
    }
  }
  lanes::store(m.a.linear + cross(m.a.angular, m.x) + swing(m.w, m.x), v_dot + link.v);
  lanes::store(m.A.transposed_times(m.a.angular), v_dot + link.v + 3);
}

/// Of a link whose parent is placed.
void TreeDynamics::place(int i, const double* q, const double* v) {
  const Link& link = links_[i];
  Motion& m = motions_[i + 1];
  const Motion& parent = motions_[link.parent + 1];
  m.A = lanes::columns(rotation_matrix(Eigen::Map<const Vector4>(q + link.q + 3)));
  m.w = m.A * Vector3(Eigen::Map<const Vector3>(v + link.v + 3));
  m.subtree.clear();
  m.x = m.shift = lanes::none();
  if (link.parent < 0) return;  // which leads
  Lanes from_parent;
  if (link.slides())
    from_parent = lanes::from(q + link.q) - lanes::from(q + links_[link.parent].q);
  else
    from_parent = parent.A * link.r_parent - m.A * link.r;
  (link.leads() ? m.shift : m.x) = parent.x + from_parent;
}

void TreeDynamics::accelerations(const double* q, const double* v, const double* load, double* v_dot) {
  if (balls_) return balls_->accelerations(q, v, load, v_dot, threads_);
  const int branches = static_cast<int>(branches_.size());
  // 1. Inwards: branches, then the trunk.
  for (int i : trunk_) place(i, q, v);
  const auto inwards = [&](int k) {
    const BallTree::Range& b = branches_[k];
    for (int i = b.first; i < b.last; ++i) place(i, q, v);
    for (int i = b.last; i-- > b.first;) eliminate(i, q, v, load);
  };
  threads_.run(branches, inwards);
  // In a fixed order, after all branches: sums are the same to the bit for any number of threads.
  for (std::size_t k = 0; k < handed_.size(); ++k) {
    motions_[handed_to_[k] + 1].subtree.add(handed_[k]);
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
    Matrix3 A = rotation_matrix(e);
    const auto keep = [&] { m.A = lanes::columns(A), m.w = lanes::of(A * w); };  // for the links beyond
    if (link.kind == Kind::root) {
      keep();
      continue;
    }
    const Matrix3 A_parent = matrix(parent.A);
    const Vector3 w_parent = lanes::vector(parent.w);
    // 1. Axes: the turn that takes those that must agree onto the parent's, small, so that it squares in each round.
    const Matrix3 axes = A_parent * link.axes_parent;
    for (int round = 0; round < 4 && link.freedom.rotation != JointFreedom::Rotation::any; ++round) {
      const Matrix3 own = A * link.axes;
      Vector3 turn = own.col(2).cross(axes.col(2));
      if (link.freedom.rotation == JointFreedom::Rotation::none)
        turn = 0.5 * (turn + own.col(0).cross(axes.col(0)) + own.col(1).cross(axes.col(1)));
      if (turn.squaredNorm() == 0) break;
      e = rotated(e, A.transpose() * turn);
      A = rotation_matrix(e);
      if (turn.squaredNorm() < 1e-18) break;
    }
    // 2. Position and velocity of the joint's point, and the turning, but for what is free.
    const Eigen::Map<const Vector3> p_parent(link.parent < 0 ? ground_ : q + links_[link.parent].q),
        v_parent(link.parent < 0 ? ground_ : v + links_[link.parent].v);
    const Vector3 r = A * link.r, arm = A_parent * link.r_parent;
    Vector3 gap = p + r - p_parent - arm;
    for_free_shifts(link.freedom, axes, [&](const Vector3& axis) { gap -= axis * axis.dot(gap); });
    p -= gap;
    const Vector3 arm_now = p + r - p_parent;  // with what it has slid
    Vector3 turning = A * w;
    const Vector3 slide = v_own + turning.cross(r) - v_parent - w_parent.cross(arm_now);
    if (link.freedom.rotation != JointFreedom::Rotation::any) {
      const Vector3 axis = axes.col(2);
      const double rate = link.freedom.rotation == JointFreedom::Rotation::none ? 0 : axis.dot(turning - w_parent);
      turning = w_parent + rate * axis;
      w = A.transpose() * turning;
    }
    Vector3 free = Vector3::Zero();
    for_free_shifts(link.freedom, axes, [&](const Vector3& axis) { free += axis * axis.dot(slide); });
    v_own = v_parent + w_parent.cross(arm_now) + free - turning.cross(r);
    keep();
  }
  return true;
}

}  // namespace lithe
