#include "engine/forward/planar_dynamics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "engine/factor/graph_topology.h"
#include "engine/forward/in_plane.h"

namespace lithe {
namespace {

/// m, rad, or parts of the fastest motion: what lies farther off is not where the step should have ended, but across a
/// singular position, where a small gap has a large answer. The step is tried again, shorter.
constexpr double kLargestMove = 0.02;
/// Where many loops are singular at one time (forty four-bars in a row), steps get through by constraints only.
constexpr int kMostLoops = 8;
constexpr std::size_t kMostJoints = 12;  // of a body: each pair of them costs a block

enum class InPlane { none, hinge, slider, free };

/// What a joint is to bodies that move in the plane normal to n; z is its own axis. Both in world axes.
InPlane in_plane(const JointFreedom& f, const Vector3& z, const Vector3& n) {
  using Rotation = JointFreedom::Rotation;
  const bool upright = are_parallel(z, n), shifts = f.x || f.y || f.z;
  if (f.rotation == Rotation::any) return shifts ? InPlane::none : InPlane::hinge;
  if (f.x && f.y && !f.z && f.rotation == Rotation::about_z && upright) return InPlane::free;
  if (f.x || f.y) return InPlane::none;
  if (upright && f.rotation == Rotation::about_z) return InPlane::hinge;
  return f.z && are_perpendicular(z, n) ? InPlane::slider : InPlane::none;
}

}  // namespace

std::unique_ptr<PlanarDynamics> PlanarDynamics::make(const RigidScene& scene) {
  const int n = static_cast<int>(scene.bodies.size());
  std::vector<Matrix3> A;
  for (const auto& b : scene.bodies)
    A.push_back(b.in_plane ? Matrix3(Matrix3::Identity()) : rotation_matrix(scene.q.segment<4>(b.q + 3)));
  const auto axes = [&](const RigidScene::Side& s) -> Matrix3 {
    return s.body < 0 ? s.axes : Matrix3(A[s.body] * s.axes);
  };

  for (int e3 = 0; e3 < 3; ++e3) {
    if (std::any_of(scene.bodies.begin(), scene.bodies.end(),
                    [&](const auto& b) { return b.in_plane && b.normal != e3; }))
      continue;
    // 1. What every joint is in this plane, and which bodies stay in it.
    const Vector3 up = Vector3::Unit(e3);
    std::vector<InPlane> kinds;
    std::vector<std::pair<int, int>> holds;
    for (const auto& j : scene.joints) {
      const Matrix3 R = axes(j.A);
      kinds.push_back(in_plane(j.freedom, R.col(2), up));
      if (kinds.back() == InPlane::none) break;
      if (holds_in_plane(j.freedom, R, up))
        holds.emplace_back(j.A.body < 0 ? n : j.A.body, j.B.body < 0 ? n : j.B.body);
    }
    if (kinds.back() == InPlane::none) continue;
    std::vector<char> held(n + 1, 0);
    held[n] = 1;  // ground
    for (int i = 0; i < n; ++i) held[i] = scene.bodies[i].in_plane;
    const std::vector<char> reached = reached_over(holds, std::move(held));
    if (std::count(reached.begin(), reached.end(), 1) != n + 1) continue;

    // 2. Bodies and joints in plane axes.
    std::unique_ptr<PlanarDynamics> plane(new PlanarDynamics);
    const int e1 = plane->e1_ = (e3 + 1) % 3, e2 = plane->e2_ = (e3 + 2) % 3;
    plane->e3_ = e3;
    plane->gravity_ = {scene.gravity[e1], scene.gravity[e2]};
    for (int i = 0; i < n; ++i) {
      const auto& b = scene.bodies[i];
      const Vector3 normal = A[i].transpose() * up;
      if (b.in_plane) {
        plane->bodies_.push_back(
            {b.q, b.v, true, 1 / b.mass, 1 / b.inertia(e3, e3), normal, {}, {}, {}, 0, scene.q[b.q + 2]});
        continue;
      }
      const Vector4 e = scene.q.segment<4>(b.q + 3);
      Vector4 turned;
      turned << -up.dot(e.tail<3>()), e[0] * up - Vector3(e.tail<3>()).cross(up);
      plane->bodies_.push_back({b.q, b.v, false, 1 / b.mass, 1 / normal.dot(b.inertia * normal), normal, e, e, turned,
                                scene.q[b.q + e3], 0});
    }
    std::vector<std::size_t> degree(n, 0);
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      if (kinds[j] == InPlane::free) continue;
      const auto& joint = scene.joints[j];
      const auto side = [&](const RigidScene::Side& s) -> Side {
        const Vector3 at = s.body < 0 ? s.position : Vector3(A[s.body] * s.position);
        if (s.body >= 0) ++degree[s.body];
        return {s.body, {at[e1], at[e2]}};
      };
      const Vector3 along = axes(joint.A).col(2);
      plane->joints_.push_back({side(joint.A), side(joint.B), kinds[j] == InPlane::slider, {-along[e2], along[e1]}});
    }
    if (plane->joints_.empty() || *std::max_element(degree.begin(), degree.end()) > kMostJoints) return nullptr;
    if (static_cast<int>(plane->joints_.size()) > n + kMostLoops) return nullptr;

    // 3. Redundant rows in the plane itself are the business of others.
    constexpr double kDependent = 1e-9;
    plane->plan();
    std::vector<double> v(scene.bodies.back().v + 6, 0.0);
    plane->place(scene.q.data(), v.data());
    plane->write_rows();
    double smallest = 1;
    plane->factorize(&smallest);
    if (smallest < kDependent) return nullptr;
    return plane;
  }
  return nullptr;
}

void PlanarDynamics::plan() {
  const int n = static_cast<int>(joints_.size());
  poses_.resize(bodies_.size());
  rows_.resize(2 * n);
  gamma_.resize(2 * n), rhs_.resize(2 * n);
  free_.resize(3 * bodies_.size()), response_.resize(3 * bodies_.size());
  compliance_.resize(2 * n);
  saved_.resize(7 * bodies_.size());
  inverse_.resize(n);
  for (int j = 0; j < n; ++j)
    if (!joints_[j].slides) rows_[2 * j] = {{-1, 0}, {0, -1}, {}}, rows_[2 * j + 1] = {{1, 0}, {0, 1}, {}};
  // 1. Joints that share a body, and an order of their elimination.
  struct Tie {
    int joint, rows;
  };
  std::vector<std::vector<Tie>> ties(bodies_.size());
  for (int j = 0; j < n; ++j) {
    if (joints_[j].A.body >= 0) ties[joints_[j].A.body].push_back({j, 2 * j});
    if (joints_[j].B.body >= 0) ties[joints_[j].B.body].push_back({j, 2 * j + 1});
  }
  std::vector<std::pair<int, int>> couplings;
  for (const auto& at : ties)
    for (const Tie& a : at)
      for (const Tie& b : at)
        if (a.joint < b.joint) couplings.emplace_back(a.joint, b.joint);
  Elimination elimination = plan_elimination({n, {}}, std::vector<int>(n, 2), couplings);
  std::vector<int> position(n);
  for (int i = 0; i < n; ++i) position[elimination.order[i]] = i;

  // 2. Blocks: the diagonal ones, then those below, in the column of whichever goes first.
  std::vector<std::map<int, int>> below(n);  // by joint
  int count = n;
  const auto block = [&](int j, int k) {
    if (j == k) return j;
    const int column = position[j] < position[k] ? j : k, row = column == j ? k : j;
    const auto [place, fresh] = below[column].try_emplace(row, count);
    if (fresh) ++count;
    return place->second;
  };
  for (std::size_t b = 0; b < ties.size(); ++b)
    for (const Tie& j : ties[b])
      for (const Tie& k : ties[b]) {
        if (position[j.joint] < position[k.joint]) continue;
        if (j.joint == k.joint && j.rows != k.rows) continue;
        const Body& body = bodies_[b];
        Product product{block(j.joint, k.joint), j.rows, k.rows, body.inverse_mass, body.inverse_inertia};
        if (joints_[j.joint].slides || joints_[k.joint].slides) {
          products_.push_back(product);
        } else {
          if ((j.rows - k.rows) % 2 != 0) product.inverse_mass *= -1;
          hinge_products_.push_back(product);
        }
      }
  for (int j : elimination.order) {
    Pivot pivot{j, static_cast<int>(neighbours_.size()), 0, static_cast<int>(updates_.size()), 0};
    std::vector<int>& rest = elimination.neighbours[j];
    std::sort(rest.begin(), rest.end(), [&](int a, int b) { return position[a] < position[b]; });
    for (int k : rest) neighbours_.push_back({k, block(j, k)});
    pivot.last_neighbour = static_cast<int>(neighbours_.size());
    for (int i = pivot.first_neighbour; i < pivot.last_neighbour; ++i)
      for (int k = pivot.first_neighbour; k <= i; ++k)
        updates_.push_back({block(neighbours_[i].joint, neighbours_[k].joint), i, k});
    pivot.last_update = static_cast<int>(updates_.size());
    pivots_.push_back(pivot);
  }
  blocks_.resize(count);
  eliminated_.resize(neighbours_.size());
}

void PlanarDynamics::place(const double* q, const double* v) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Body& b = bodies_[i];
    if (b.in_plane) {
      const double *x = q + b.q, *x_dot = v + b.v;
      double sine, cosine;
      ::sincos(x[2] - b.angle, &sine, &cosine);  // both for the price of one
      poses_[i] = {x[0], x[1], cosine, sine, x_dot[0], x_dot[1], x_dot[2]};
      continue;
    }
    const double *e = q + b.q + 3, *w = v + b.v + 3;
    double cosine = 0, sine = 0;
    for (int k = 0; k < 4; ++k) cosine += b.upright[k] * e[k], sine += b.turned[k] * e[k];
    const double scale = 1 / (cosine * cosine + sine * sine);
    poses_[i] = {q[b.q + e1_],
                 q[b.q + e2_],
                 (cosine * cosine - sine * sine) * scale,
                 2 * cosine * sine * scale,
                 v[b.v + e1_],
                 v[b.v + e2_],
                 b.normal[0] * w[0] + b.normal[1] * w[1] + b.normal[2] * w[2]};
  }
}

double PlanarDynamics::write_gaps() {
  double largest = 0;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    const Pose &A = joint.A.body < 0 ? ground_ : poses_[joint.A.body],
               &B = joint.B.body < 0 ? ground_ : poses_[joint.B.body];
    const Point &a = joint.A.at, &b = joint.B.at;
    double g1 = B.x + B.c * b.x - B.s * b.y - (A.x + A.c * a.x - A.s * a.y);
    double g2 = B.y + B.s * b.x + B.c * b.y - (A.y + A.s * a.x + A.c * a.y);
    if (joint.slides) {
      const Point& n = joint.normal;
      g1 = (A.c * n.x - A.s * n.y) * g1 + (A.s * n.x + A.c * n.y) * g2;
      g2 = B.s * A.c - B.c * A.s;
    }
    rhs_[2 * j] = g1, rhs_[2 * j + 1] = g2;
    const double size = std::max(std::abs(g1), std::abs(g2));
    if (!(size <= largest)) largest = size;
  }
  return largest;
}

void PlanarDynamics::write_rows() {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    const Pose &A = joint.A.body < 0 ? ground_ : poses_[joint.A.body],
               &B = joint.B.body < 0 ? ground_ : poses_[joint.B.body];
    const double ax = A.c * joint.A.at.x - A.s * joint.A.at.y, ay = A.s * joint.A.at.x + A.c * joint.A.at.y;
    const double bx = B.c * joint.B.at.x - B.s * joint.B.at.y, by = B.s * joint.B.at.x + B.c * joint.B.at.y;
    const double a2 = A.rate * A.rate, b2 = B.rate * B.rate;
    const double gx = b2 * bx - a2 * ax, gy = b2 * by - a2 * ay;
    if (!joint.slides) {
      double *of_A = rows_[2 * j].turn, *of_B = rows_[2 * j + 1].turn;
      of_A[0] = ay, of_A[1] = -ax, of_B[0] = -by, of_B[1] = bx;
      gamma_[2 * j] = gx, gamma_[2 * j + 1] = gy;
      continue;
    }
    const double nx = A.c * joint.normal.x - A.s * joint.normal.y, ny = A.s * joint.normal.x + A.c * joint.normal.y;
    const double dx = B.x + bx - A.x - ax, dy = B.y + by - A.y - ay;
    const double ux = B.vx - B.rate * by - A.vx + A.rate * ay, uy = B.vy + B.rate * bx - A.vy - A.rate * ax;
    rows_[2 * j] = {{-nx, 0}, {-ny, 0}, {nx * ay - ny * ax - dx * ny + dy * nx, -1}};
    rows_[2 * j + 1] = {{nx, 0}, {ny, 0}, {ny * bx - nx * by, 1}};
    gamma_[2 * j] = nx * gx + ny * gy - 2 * A.rate * (nx * uy - ny * ux) + a2 * (nx * dx + ny * dy);
    gamma_[2 * j + 1] = 0;
  }
}

void PlanarDynamics::factorize(double* smallest) {
  constexpr double kRoundOff = 1e-13, kGives = 1e-10;  // of a row's own compliance, as in BlockFactor
  std::fill(blocks_.begin(), blocks_.end(), Block{});
  for (const Product& p : hinge_products_) {  // ±1/m I + 1/J left rightᵀ
    const double *l = rows_[p.left].turn, *r = rows_[p.right].turn;
    const double left0 = p.inverse_inertia * l[0], left1 = p.inverse_inertia * l[1];
    Block& k = blocks_[p.block];
    k.a += p.inverse_mass + left0 * r[0];
    k.b += left1 * r[0];
    k.c += left0 * r[1];
    k.d += p.inverse_mass + left1 * r[1];
  }
  for (const Product& p : products_) {
    const Rows &l = rows_[p.left], &r = rows_[p.right];
    const double m = p.inverse_mass, i = p.inverse_inertia;
    Block& k = blocks_[p.block];
    k.a += m * (l.x[0] * r.x[0] + l.y[0] * r.y[0]) + i * l.turn[0] * r.turn[0];
    k.b += m * (l.x[1] * r.x[0] + l.y[1] * r.y[0]) + i * l.turn[1] * r.turn[0];
    k.c += m * (l.x[0] * r.x[1] + l.y[0] * r.y[1]) + i * l.turn[0] * r.turn[1];
    k.d += m * (l.x[1] * r.x[1] + l.y[1] * r.y[1]) + i * l.turn[1] * r.turn[1];
  }
  for (std::size_t j = 0; j < joints_.size(); ++j)
    compliance_[2 * j] = blocks_[j].a, compliance_[2 * j + 1] = blocks_[j].d;
  for (const Pivot& pivot : pivots_) {
    // 1. The pivot by L D Lᵀ: a, and the determinant over it. One that is round-off, where loops pass a singular
    // position, gives way a little.
    double a = blocks_[pivot.joint].a, d = blocks_[pivot.joint].d;
    const double b = blocks_[pivot.joint].b;  // and c
    const double* own = compliance_.data() + 2 * pivot.joint;
    if (smallest) *smallest = std::min(*smallest, a / own[0]);
    if (a < kRoundOff * own[0]) a += kGives * own[0];
    double determinant = a * d - b * b;
    if (smallest) *smallest = std::min(*smallest, determinant / (a * own[1]));
    if (determinant < kRoundOff * own[1] * a) d += kGives * own[1], determinant += kGives * own[1] * a;
    // Each pivot waits for the one before it: for one division, and a product with what is ready by then.
    const double scale = 1 / determinant;
    inverse_[pivot.joint] = {d * scale, -b * scale, -b * scale, a * scale};
    // 2. Its neighbours, times the determinant.
    for (int n = pivot.first_neighbour; n < pivot.last_neighbour; ++n) {
      const Block& K = blocks_[neighbours_[n].block];
      eliminated_[n] = {K.a * d - K.c * b, K.b * d - K.d * b, K.c * a - K.a * b, K.d * a - K.b * b};
    }
    for (int u = pivot.first_update; u < pivot.last_update; ++u) {
      const Block &W = eliminated_[updates_[u].left], &K = blocks_[neighbours_[updates_[u].right].block];
      Block& to = blocks_[updates_[u].block];
      to.a -= (W.a * K.a + W.c * K.c) * scale;
      to.b -= (W.b * K.a + W.d * K.c) * scale;
      to.c -= (W.a * K.b + W.c * K.d) * scale;
      to.d -= (W.b * K.b + W.d * K.d) * scale;
    }
    for (int n = pivot.first_neighbour; n < pivot.last_neighbour; ++n) {
      Block& W = eliminated_[n];
      W.a *= scale, W.b *= scale, W.c *= scale, W.d *= scale;
    }
  }
}

void PlanarDynamics::solve() {
  double* y = rhs_.data();
  for (const Pivot& pivot : pivots_) {
    double* own = y + 2 * pivot.joint;
    for (int n = pivot.first_neighbour; n < pivot.last_neighbour; ++n) {
      const Block& W = eliminated_[n];
      double* to = y + 2 * neighbours_[n].joint;
      to[0] -= W.a * own[0] + W.c * own[1];
      to[1] -= W.b * own[0] + W.d * own[1];
    }
  }
  for (auto pivot = pivots_.rbegin(); pivot != pivots_.rend(); ++pivot) {
    double* own = y + 2 * pivot->joint;
    const Block& D = inverse_[pivot->joint];
    double x0 = D.a * own[0] + D.c * own[1], x1 = D.b * own[0] + D.d * own[1];
    for (int n = pivot->first_neighbour; n < pivot->last_neighbour; ++n) {
      const Block& W = eliminated_[n];
      const double* from = y + 2 * neighbours_[n].joint;
      x0 -= W.a * from[0] + W.b * from[1];
      x1 -= W.c * from[0] + W.d * from[1];
    }
    own[0] = x0, own[1] = x1;
  }
}

void PlanarDynamics::respond() {
  std::fill(response_.begin(), response_.end(), 0.0);
  const auto add = [&](int body, const Rows& rows, double sign, bool slides, const double* force) {
    if (body < 0) return;
    double* to = response_.data() + 3 * body;
    if (slides) {
      to[0] -= rows.x[0] * force[0] + rows.x[1] * force[1];
      to[1] -= rows.y[0] * force[0] + rows.y[1] * force[1];
    } else {
      to[0] -= sign * force[0], to[1] -= sign * force[1];
    }
    to[2] -= rows.turn[0] * force[0] + rows.turn[1] * force[1];
  };
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    add(joints_[j].A.body, rows_[2 * j], -1, joints_[j].slides, rhs_.data() + 2 * j);
    add(joints_[j].B.body, rows_[2 * j + 1], 1, joints_[j].slides, rhs_.data() + 2 * j);
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    response_[3 * b] *= bodies_[b].inverse_mass;
    response_[3 * b + 1] *= bodies_[b].inverse_mass;
    response_[3 * b + 2] *= bodies_[b].inverse_inertia;
  }
}

/// rhs_ += G x for motions x of the bodies, three a body.
void PlanarDynamics::add_rates(const double* x) {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    double* to = rhs_.data() + 2 * j;
    const auto add = [&](int body, const Rows& rows, double sign, bool slides) {
      if (body < 0) return;
      const double* of = x + 3 * body;
      for (int i = 0; i < 2; ++i)
        to[i] += (slides ? rows.x[i] * of[0] + rows.y[i] * of[1] : sign * of[i]) + rows.turn[i] * of[2];
    };
    add(joints_[j].A.body, rows_[2 * j], -1, joints_[j].slides);
    add(joints_[j].B.body, rows_[2 * j + 1], 1, joints_[j].slides);
  }
}

/// Sum of two motions in the plane, as rates of the body's coordinates.
inline void PlanarDynamics::write_motion(const Body& body, const double* a, const double* b, double* rates) const {
  double* to = rates + body.v;
  if (body.in_plane) {
    for (int i = 0; i < 3; ++i) to[i] = a[i] + b[i];
    return;
  }
  to[e1_] = a[0] + b[0], to[e2_] = a[1] + b[1], to[e3_] = 0;
  for (int i = 0; i < 3; ++i) to[3 + i] = body.normal[i] * (a[2] + b[2]);
}

void PlanarDynamics::accelerations(const double* q, const double* v, const double* load, double* v_dot) {
  place(q, v);
  write_rows();
  factorize();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    double* a = free_.data() + 3 * b;
    a[0] = gravity_.x, a[1] = gravity_.y, a[2] = 0;
    if (!load) continue;
    const Body& body = bodies_[b];
    const double* f = load + body.v;
    if (body.in_plane) {
      a[0] += f[0] * body.inverse_mass, a[1] += f[1] * body.inverse_mass, a[2] = f[2] * body.inverse_inertia;
      continue;
    }
    a[0] += f[e1_] * body.inverse_mass, a[1] += f[e2_] * body.inverse_mass;
    a[2] = (body.normal[0] * f[3] + body.normal[1] * f[4] + body.normal[2] * f[5]) * body.inverse_inertia;
  }
  for (std::size_t i = 0; i < rhs_.size(); ++i) rhs_[i] = -gamma_[i];
  add_rates(free_.data());
  solve();
  respond();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    write_motion(bodies_[b], free_.data() + 3 * b, response_.data() + 3 * b, v_dot);
  }
}

bool PlanarDynamics::project(double* q, double* v, double tolerance) {
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    std::copy_n(q + bodies_[b].q, bodies_[b].in_plane ? 3 : 7, saved_.data() + 7 * b);
  if (project_onto(q, v, tolerance)) return true;
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    std::copy_n(saved_.data() + 7 * b, bodies_[b].in_plane ? 3 : 7, q + bodies_[b].q);
  return false;
}

bool PlanarDynamics::project_onto(double* q, double* v, double tolerance) {
  constexpr int kMaxIterations = 10;
  double before = 0;
  for (int k = 0;; ++k) {
    place(q, v);
    const double gap = write_gaps();
    const double least = round_off();
    if (gap <= std::max(tolerance, 4 * least)) break;
    const bool stuck = k > 1 && gap >= 0.5 * before;
    if (stuck && gap <= 1e3 * least) break;
    if (stuck || k == kMaxIterations) return false;
    if (!std::isfinite(gap)) return false;
    before = gap;
    write_rows();
    factorize();
    solve();
    respond();
    if (!(largest_response() < kLargestMove)) return false;
    for (std::size_t b = 0; b < bodies_.size(); ++b) move(b, q);
  }
  // Velocities likewise.
  write_rows();
  factorize();
  std::fill(rhs_.begin(), rhs_.end(), 0.0);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    double* x = free_.data() + 3 * b;
    x[0] = poses_[b].vx, x[1] = poses_[b].vy, x[2] = poses_[b].rate;
  }
  add_rates(free_.data());
  solve();
  respond();
  double fastest = 1;
  for (double rate : free_) fastest = std::max(fastest, std::abs(rate));
  if (!(largest_response() < kLargestMove * fastest)) return false;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    write_motion(bodies_[b], free_.data() + 3 * b, response_.data() + 3 * b, v);
  }
  return true;
}

double PlanarDynamics::largest_response() const {
  double largest = 0;
  for (double x : response_)
    if (!(std::abs(x) <= largest)) largest = std::abs(x);
  return largest;
}

/// Of the gaps, by the largest coordinate.
double PlanarDynamics::round_off() const {
  double largest = 1;
  for (const Pose& p : poses_) largest = std::max({largest, std::abs(p.x), std::abs(p.y)});
  return std::numeric_limits<double>::epsilon() * largest;
}

/// By the response of the body, and onto its plane.
void PlanarDynamics::move(std::size_t b, double* q) const {
  const Body& body = bodies_[b];
  const double* by = response_.data() + 3 * b;
  if (body.in_plane) {
    for (int i = 0; i < 3; ++i) q[body.q + i] += by[i];
    return;
  }
  q[body.q + e1_] += by[0];
  q[body.q + e2_] += by[1];
  q[body.q + e3_] = body.height;
  Eigen::Map<Vector4> e(q + body.q + 3);
  const double c = body.upright.dot(e), s = body.turned.dot(e), turn = by[2] / 2;
  Vector4 since = Vector4::Zero();
  since[0] = c * std::cos(turn) - s * std::sin(turn);
  since[1 + e3_] = s * std::cos(turn) + c * std::sin(turn);
  e = quaternion_product(since.normalized(), body.start);
}

}  // namespace lithe
