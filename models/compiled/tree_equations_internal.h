#pragma once

#include <vector>

#include "models/compiled/spatial_internal.h"
#include "models/compiled/tree_internal.h"

namespace lithe {

/// The same for doubles as for what is written down.
inline void sine_cosine(double x, double& sine, double& cosine) { sine = std::sin(x), cosine = std::cos(x); }

/// Accelerations of a tree in joint coordinates by the articulated-body recursion (Featherstone, Rigid Body Dynamics
/// Algorithms, 2008, ch. 7), each link in its own axes about its own origin; accelerations are those of points, less
/// gravity, so that no linear velocity is needed. Over any scalar: doubles calculate it, CompiledNumbers write it down.
///   [n; f] = [J, H; Hᵀ, M] [ω̇; a] + [n_0; f_0] of a link and what lies beyond it
template <class S>
class CompiledEquations {
 public:
  explicit CompiledEquations(const CompiledTree& tree) : tree_(tree), states_(tree.links.size()) {}

  /// q, v, u in the order of the tree; u: efforts of the velocities, then inputs.
  std::vector<S> accelerations(const std::vector<S>& q, const std::vector<S>& v, const std::vector<S>& u) {
    const int n = static_cast<int>(states_.size());
    std::vector<S> effort(u.begin(), u.begin() + tree_.velocity_count()), v_dot(v.size());
    for (const auto& spring : tree_.springs) add_spring(spring, q, v, u, effort);
    for (int i = 0; i < n; ++i) move(i, q, v);
    for (int i = n; i-- > 0;) eliminate(i, effort);
    for (int i = 0; i < n; ++i) find(i, v_dot);
    return v_dot;
  }

 private:
  using Vector = CompiledVector<S>;
  using Matrix = std::array<Vector, 3>;
  using Motion = CompiledTree::Motion;
  struct State {
    std::vector<CompiledTurn<S>> turns;  // from the parent's axes
    Matrix R;                            // of a ball and a free link: link axes to the joint's, the world's
    S slid = 0;
    Vector w, bias_w{}, bias{}, swing{};  // ω; what ω̇ and a have besides; ω × (ω × shift) of the parent, its axes
    CompiledSymmetric<S> J, M, inverse_J;
    Matrix H{}, gain{};
    Vector n, f, a, alpha;
    Vector gain_n{}, gain_f{};  // of one freedom: v̇ = rest - gain · (ω̇, a)
    S rest = 0;
    Vector rests{};
  };

  static Vector vector(const Vector3& a) { return {S(a[0]), S(a[1]), S(a[2])}; }
  static Vector at(const std::vector<S>& all, int i) { return {all[i], all[i + 1], all[i + 2]}; }
  static Matrix rotation(const S& w, const S& x, const S& y, const S& z) {
    const S X = x + x, Y = y + y, Z = z + z;
    return {{{S(1) - (y * Y + z * Z), x * Y - w * Z, x * Z + w * Y},
             {x * Y + w * Z, S(1) - (x * X + z * Z), y * Z - w * X},
             {x * Z - w * Y, y * Z + w * X, S(1) - (x * X + y * Y)}}};
  }
  static Vector times(const Matrix& A, const Vector& b) {
    Vector r;
    for (int i = 0; i < 3; ++i) r[i] = A[i][0] * b[0] + A[i][1] * b[1] + A[i][2] * b[2];
    return r;
  }
  static Vector transposed_times(const Matrix& A, const Vector& b) {
    Vector r;
    for (int i = 0; i < 3; ++i) r[i] = A[0][i] * b[0] + A[1][i] * b[1] + A[2][i] * b[2];
    return r;
  }
  /// ω × (ω × r).
  static Vector swing(const Vector& w, const Vector& r) {
    const S xx = w[0] * w[0], yy = w[1] * w[1], zz = w[2] * w[2], xy = w[0] * w[1], xz = w[0] * w[2], yz = w[1] * w[2];
    return {xy * r[1] + xz * r[2] - (yy + zz) * r[0], xy * r[0] + yz * r[2] - (xx + zz) * r[1],
            xz * r[0] + yz * r[1] - (xx + yy) * r[2]};
  }

  S number(const CompiledTree::Number& x, const std::vector<S>& u) const {
    return x.input < 0 ? S(x.value) : u[tree_.velocity_count() + x.input];
  }
  void add_spring(const CompiledTree::Spring& spring, const std::vector<S>& q, const std::vector<S>& v,
                  const std::vector<S>& u, std::vector<S>& effort) const {
    const S sign(spring.sign), stretch = sign * q[spring.q] + S(spring.offset) - number(spring.free_value, u);
    const S tension = number(spring.stiffness, u) * stretch + number(spring.damping, u) * (sign * v[spring.v]) +
                      number(spring.preload, u);
    effort[spring.v] = effort[spring.v] - sign * tension;
  }

  /// Where a link turns to and how fast, and its own inertia and forces.
  void move(int i, const std::vector<S>& q, const std::vector<S>& v) {
    const auto& link = tree_.links[i];
    State& m = states_[i];
    Vector w{};  // of the parent
    if (link.parent >= 0) w = states_[link.parent].w, m.swing = swing(w, vector(link.shift));
    m.turns.clear();
    add_turn(m, 0, 1, link.first);
    add_turn(m, 1, 2, link.tilt);
    if (link.motion == Motion::turn)
      m.turns.push_back(own_turn(link, q[link.q]));
    else
      add_turn(m, 0, 1, link.last);
    for (const auto& turn : m.turns) w = turn.back(w);
    switch (link.motion) {
      case Motion::turn:
        m.bias_w = {w[1] * v[link.v], -(w[0] * v[link.v]), S(0)};
        w[2] = w[2] + v[link.v];
        break;
      case Motion::slide: {
        m.slid = q[link.q];
        const S twice = S(2) * v[link.v];
        m.bias = swing(w, {S(0), S(0), m.slid}) + Vector{twice * w[1], -(twice * w[0]), S(0)};
        break;
      }
      case Motion::ball: {
        m.R = rotation(q[link.q], q[link.q + 1], q[link.q + 2], q[link.q + 3]);
        const Vector relative = at(v, link.v);
        w = transposed_times(m.R, w);
        m.bias_w = compiled_cross(w, relative);
        w = w + relative;
        break;
      }
      case Motion::free:
        m.R = rotation(q[link.q + 3], q[link.q + 4], q[link.q + 5], q[link.q + 6]);
        w = at(v, link.v + 3);
        break;
    }
    m.w = w;
    add_own(link, m);
  }

  static void add_turn(State& m, int i, int j, const CompiledTree::Link::Angle& angle) {
    if (angle.c != 1) m.turns.push_back({i, j, S(angle.c), S(angle.s), angle.c == 0 || angle.s == 0});
  }
  CompiledTurn<S> own_turn(const CompiledTree::Link& link, const S& angle) const {
    S s, c;
    const auto& more = link.last;
    if (more.c == 0 || more.s == 0) {  // a quarter turn or two cost nothing
      sine_cosine(angle, s, c);
      return {0, 1, S(more.c) * c - S(more.s) * s, S(more.c) * s + S(more.s) * c};
    }
    sine_cosine(angle + S(std::atan2(more.s, more.c)), s, c);
    return {0, 1, c, s};
  }

  static void add_own(const CompiledTree::Link& link, State& m) {
    const Matrix3& J = link.inertia;
    const Vector3& h = link.moment;
    m.J = {S(J(0, 0)), S(J(1, 1)), S(J(2, 2)), S(J(1, 0)), S(J(2, 0)), S(J(2, 1))};
    m.M = {S(link.mass), S(link.mass), S(link.mass), S(0), S(0), S(0)};
    m.H = {{{S(0), S(-h[2]), S(h[1])}, {S(h[2]), S(0), S(-h[0])}, {S(-h[1]), S(h[0]), S(0)}}};
    const Vector& w = m.w;
    m.f = swing(w, vector(h));
    // ω × (J ω) by products of ω, which are there already.
    const S xx = w[0] * w[0], yy = w[1] * w[1], zz = w[2] * w[2], xy = w[0] * w[1], xz = w[0] * w[2], yz = w[1] * w[2];
    m.n = {S(J(2, 0)) * xy + S(J(2, 1)) * (yy - zz) + S(J(2, 2) - J(1, 1)) * yz - S(J(1, 0)) * xz,
           S(J(1, 0)) * yz + S(J(2, 0)) * (zz - xx) + S(J(0, 0) - J(2, 2)) * xz - S(J(2, 1)) * xy,
           S(J(2, 1)) * xz + S(J(1, 0)) * (xx - yy) + S(J(1, 1) - J(0, 0)) * xy - S(J(2, 0)) * yz};
  }

  /// A link and what lies beyond it, less what its joint leaves free, onto the parent.
  void eliminate(int i, const std::vector<S>& effort) {
    const auto& link = tree_.links[i];
    State& m = states_[i];
    switch (link.motion) {
      case Motion::turn:
        eliminate_one(m, {m.J.xz, m.J.yz, m.J.zz}, m.H[2], m.J.zz, effort[link.v] - m.n[2]);
        m.J.xz = m.J.yz = m.J.zz = S(0);
        m.H[2] = {S(0), S(0), S(0)};
        add_bias(m);
        m.n[2] = effort[link.v];
        break;
      case Motion::slide:
        eliminate_one(m, {m.H[0][2], m.H[1][2], m.H[2][2]}, {m.M.xz, m.M.yz, m.M.zz}, m.M.zz, effort[link.v] - m.f[2]);
        m.M.xz = m.M.yz = m.M.zz = S(0);
        for (Vector& row : m.H) row[2] = S(0);
        add_bias(m);
        m.f[2] = effort[link.v];
        break;
      case Motion::ball:
        eliminate_ball(m, at(effort, link.v));
        break;
      case Motion::free:  // it hangs on nothing
        solve_free(m, at(effort, link.v), at(effort, link.v + 3));
        return;
    }
    if (link.parent >= 0) hand_on(link, m);
  }

  /// I -= U Uᵀ / D, p += U (effort left) / D for the freedom that U = I S belongs to.
  static void eliminate_one(State& m, const Vector n, const Vector f, const S D, const S& effort) {
    const S inverse = S(1) / D;
    for (int i = 0; i < 3; ++i) m.gain_n[i] = n[i] * inverse, m.gain_f[i] = f[i] * inverse;
    m.rest = effort * inverse;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) {
        m.J.at(i, j) = m.J.at(i, j) - m.gain_n[i] * n[j];
        m.M.at(i, j) = m.M.at(i, j) - m.gain_f[i] * f[j];
      }
      for (int j = 0; j < 3; ++j) m.H[i][j] = m.H[i][j] - n[i] * m.gain_f[j];
      m.n[i] = m.n[i] + n[i] * m.rest;
      m.f[i] = m.f[i] + f[i] * m.rest;
    }
  }
  static void add_bias(State& m) {
    m.n = m.n + m.J.times(m.bias_w) + times(m.H, m.bias);
    m.f = m.f + transposed_times(m.H, m.bias_w) + m.M.times(m.bias);
  }
  /// ω̇ = J⁻¹ (effort - n - H a): the torque on the parent is the effort, M -= Hᵀ J⁻¹ H.
  static void eliminate_ball(State& m, const Vector& effort) {
    m.inverse_J = m.J.inverse();
    Vector left;
    for (int i = 0; i < 3; ++i) left[i] = effort[i] - m.n[i];
    m.rests = m.inverse_J.times(left);
    for (int j = 0; j < 3; ++j) {
      const Vector column = m.inverse_J.times({m.H[0][j], m.H[1][j], m.H[2][j]});
      for (int i = 0; i < 3; ++i) m.gain[i][j] = column[i];
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j)
        m.M.at(i, j) = m.M.at(i, j) - (m.H[0][i] * m.gain[0][j] + m.H[1][i] * m.gain[1][j] + m.H[2][i] * m.gain[2][j]);
    m.f = m.f + transposed_times(m.H, m.rests);
    m.n = effort;
    m.J = {}, m.H = {};
  }
  void solve_free(State& m, const Vector& force, const Vector& torque) const {
    eliminate_ball(m, torque);
    const Vector applied = transposed_times(m.R, force);
    Vector left;
    for (int i = 0; i < 3; ++i) left[i] = applied[i] - m.f[i];
    m.a = m.M.inverse().times(left);
    const Vector lost = times(m.gain, m.a);
    for (int i = 0; i < 3; ++i) m.alpha[i] = m.rests[i] - lost[i];
  }

  /// To the parent's axes and origin.
  void hand_on(const CompiledTree::Link& link, State& m) {
    State& parent = states_[link.parent];
    if (link.motion == Motion::slide) shift(m, {S(0), S(0), m.slid});
    if (link.motion == Motion::ball) turn_ball(m);
    for (auto turn = m.turns.rbegin(); turn != m.turns.rend(); ++turn) {
      turn->apply(m.J), turn->apply(m.M), turn->apply(m.H);
      m.n = turn->apply(m.n), m.f = turn->apply(m.f);
    }
    m.f = m.f + m.M.times(m.swing);
    m.n = m.n + times(m.H, m.swing);
    shift(m, vector(link.shift));
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) {
        parent.J.at(i, j) = parent.J.at(i, j) + m.J.at(i, j);
        parent.M.at(i, j) = parent.M.at(i, j) + m.M.at(i, j);
      }
      parent.H[i] = parent.H[i] + m.H[i];
    }
    parent.n = parent.n + m.n, parent.f = parent.f + m.f;
  }
  /// Of a ball, whose J and H are gone.
  static void turn_ball(State& m) {
    Matrix half;  // R M
    for (int i = 0; i < 3; ++i) half[i] = m.M.times(m.R[i]);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j)
        m.M.at(i, j) = half[i][0] * m.R[j][0] + half[i][1] * m.R[j][1] + half[i][2] * m.R[j][2];
    m.n = times(m.R, m.n), m.f = times(m.R, m.f);
  }
  /// To an origin from which the present one is at r:  H' = H + r~ M,  J' = J - H r~ᵀ... = J + r~ Hᵀ + (r~ H'ᵀ)ᵀ.
  static void shift(State& m, const Vector& r) {
    const Matrix before = m.H;
    for (int j = 0; j < 3; ++j) {
      const Vector column = compiled_cross(r, {m.M.at(0, j), m.M.at(1, j), m.M.at(2, j)});
      for (int i = 0; i < 3; ++i) m.H[i][j] = m.H[i][j] + column[i];
    }
    Matrix crossed, crossed_after;  // row k: r × (row k of H): column k of r~ Hᵀ
    for (int k = 0; k < 3; ++k) crossed[k] = compiled_cross(r, before[k]), crossed_after[k] = compiled_cross(r, m.H[k]);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j) m.J.at(i, j) = m.J.at(i, j) + crossed[j][i] + crossed_after[i][j];
    m.n = m.n + compiled_cross(r, m.f);
  }

  /// Accelerations, of a link whose parent has its own.
  void find(int i, std::vector<S>& v_dot) {
    const auto& link = tree_.links[i];
    State& m = states_[i];
    if (link.motion == Motion::free) {
      const Vector a = times(m.R, m.a) + vector(tree_.gravity);
      for (int k = 0; k < 3; ++k) v_dot[link.v + k] = a[k], v_dot[link.v + 3 + k] = m.alpha[k];
      return;
    }
    Vector alpha{}, a = vector(-tree_.gravity);
    if (link.parent >= 0) {
      const State& parent = states_[link.parent];
      alpha = parent.alpha;
      a = parent.a + compiled_cross(alpha, vector(link.shift)) + m.swing;
    }
    for (const auto& turn : m.turns) alpha = turn.back(alpha), a = turn.back(a);
    if (link.motion == Motion::ball) alpha = transposed_times(m.R, alpha), a = transposed_times(m.R, a);
    if (link.motion == Motion::slide) a = a + compiled_cross(alpha, {S(0), S(0), m.slid});
    alpha = alpha + m.bias_w, a = a + m.bias;
    if (link.motion == Motion::ball) {
      const Vector lost = times(m.gain, a);
      for (int k = 0; k < 3; ++k) {
        const S own = m.rests[k] - lost[k];
        v_dot[link.v + k] = own - alpha[k];
        alpha[k] = own;
      }
    } else {
      S own = m.rest;
      for (int k = 0; k < 3; ++k) own = own - m.gain_n[k] * alpha[k] - m.gain_f[k] * a[k];
      v_dot[link.v] = own;
      (link.motion == Motion::turn ? alpha : a)[2] = (link.motion == Motion::turn ? alpha : a)[2] + own;
    }
    m.alpha = alpha, m.a = a;
  }

  const CompiledTree& tree_;
  std::vector<State> states_;
};

}  // namespace lithe
