#include "plugins/inertial_body/brick.h"

#include <cmath>

namespace lithe::brick {
namespace {

constexpr int kMaxNewton = 25;

/// K(i, k) += λ fa_i fb_k + μ fb_i fa_k + g μ b_ik + s δ_ik, the contribution of shapes a and b at one point:
/// fa = F ∇N_a, b = F Fᵀ, g = ∇N_a·∇N_b, s = ∇N_a·S∇N_b; λ, μ and S times the point's weight.
inline void add_pair(const Lanes& lambda, const Lanes& mu, const Lanes* fa, const Lanes* fb, const Lanes& g_mu,
                     const Lanes& s, const Lanes33& b, Lanes* K) {
  for (int i = 0; i < 3; ++i) {
    const Lanes first = lambda * fa[i], second = mu * fb[i];
    for (int k = 0; k < 3; ++k) K[3 * i + k] += first * fb[k] + second * fa[k] + g_mu * b(i, k);
    K[4 * i] += s;
  }
}

inline void dot(const Lanes* a, const Lanes* b, Lanes& out) { out = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// b = F Fᵀ.
inline void left_cauchy_green(const Lanes33& F, Lanes33& b) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) {
      dot(F.at + 3 * i, F.at + 3 * j, b(i, j));
      b(j, i) = b(i, j);
    }
}

/// What stiffness needs of one point: fa of shapes first ... last-1, S∇N_a likewise, and b.
struct PointTerms {
  Lanes f[kShapes][3], s[kShapes][3];
  Lanes33 b;
  void set(const Lanes33& F, const Lanes33& S, const Lanes (*gradient)[3], int first, int last) {
    left_cauchy_green(F, b);
    for (int a = first; a < last; ++a) {
      multiply(F, gradient[a], f[a]);
      multiply(S, gradient[a], s[a]);
    }
  }
};

}  // namespace

void Bricks::gather(const Batch& batch, const double* x, Lanes* out) const {
  // Relative to the first node, so that a far translation costs no digits of the strain.
  for (int l = 0; l < kLanes; ++l) {
    const double* origin = x + 3 * batch.node[0][l];
    for (int a = 0; a < kNodes; ++a)
      for (int i = 0; i < 3; ++i) out[3 * a + i][l] = x[3 * batch.node[a][l] + i] - origin[i];
  }
}

/// S times the weight of the point; returns the energy of the batch's own elements.
double Bricks::strain_energy_and_stress(const Batch& batch, int point, const Lanes33& F, Lanes33& S) const {
  const Lanes& w = batch.weight[point];
  Lanes33 E;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j <= i; ++j) {
      const Lanes c = F(0, i) * F(0, j) + F(1, i) * F(1, j) + F(2, i) * F(2, j);
      E(i, j) = 0.5 * (i == j ? c - 1.0 : c);
      E(j, i) = E(i, j);
    }
  const Lanes trace = E(0, 0) + E(1, 1) + E(2, 2), pressure = lambda_ * w * trace, twice_mu = 2 * mu_ * w;
  Lanes energy = pressure * trace;
  for (int i = 0; i < 9; ++i) {
    S.at[i] = twice_mu * E.at[i];
    energy += S.at[i] * E.at[i];
  }
  for (int i = 0; i < 3; ++i) S(i, i) += pressure;
  double sum = 0;
  for (int l = 0; l < batch.count; ++l) sum += 0.5 * energy[l];
  return sum;
}

bool Bricks::find_modes(const double* x, std::vector<Modes>& modes) const {
  bool found = true;
  for (int b = 0; b < batch_count(); ++b) {
    clear(modes[b].alpha, 3 * kModes);
    if (has_modes_) found &= find_modes(batches_[b], x, modes[b]);
  }
  return found;
}

/// Newton on ∂U/∂α = 0; quadratic, so a last correction of 1e-9 element sizes leaves nothing but round-off.
bool Bricks::find_modes(const Batch& batch, const double* x, Modes& modes) const {
  Lanes nodes[3 * kNodes];
  gather(batch, x, nodes);
  Lanes33 nodal[kPoints];
  for (int p = 0; p < kPoints; ++p) {
    clear(nodal[p].at, 9);
    add_gradient(nodes, batch.gradient[p], kNodes, nodal[p]);
  }
  for (int iteration = 0; iteration < kMaxNewton; ++iteration) {
    Lanes r[3 * kModes], K[kModes * (kModes + 1) / 2][9];
    clear(r, 3 * kModes);
    for (auto& block : K) clear(block, 9);
    for (int p = 0; p < kPoints; ++p) {
      const auto* g = batch.gradient[p] + kNodes;
      Lanes33 F = nodal[p], S;
      add_gradient(modes.alpha, g, kModes, F);
      strain_energy_and_stress(batch, p, F, S);
      PointTerms terms;
      terms.set(F, S, g, 0, kModes);
      const Lanes lambda = lambda_ * batch.weight[p], mu = mu_ * batch.weight[p];
      for (int k = 0, pair = 0; k < kModes; ++k) {
        Lanes pull[3];
        multiply(F, terms.s[k], pull);  // P g = F S g
        for (int i = 0; i < 3; ++i) r[3 * k + i] += pull[i];
        for (int l = 0; l <= k; ++l, ++pair) {
          Lanes slope, stress;
          dot(g[k], g[l], slope);
          dot(g[k], terms.s[l], stress);
          add_pair(lambda, mu, terms.f[k], terms.f[l], slope * mu, stress, terms.b, K[pair]);
        }
      }
    }
    Lanes A[3 * kModes][3 * kModes];
    for (int k = 0, pair = 0; k < kModes; ++k)
      for (int l = 0; l <= k; ++l, ++pair)
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) A[3 * k + i][3 * l + j] = K[pair][3 * i + j];
    factorize(A);
    solve(A, r);
    double moved = 0;
    for (int i = 0; i < 3 * kModes; ++i) {
      modes.alpha[i] -= r[i];
      moved = std::max(moved, largest(r[i]));
      if (!std::isfinite(r[i][0] + r[i][1] + r[i][2] + r[i][3])) return false;
    }
    if (moved <= 1e-9 * batch.size) return true;
  }
  return false;
}

double Bricks::add_elastic_force(const double* x, const std::vector<Modes>& modes, double* f) const {
  double energy = 0;
  for (int b = 0; b < batch_count(); ++b) {
    const Batch& batch = batches_[b];
    Lanes nodes[3 * kNodes], force[3 * kNodes];
    gather(batch, x, nodes);
    clear(force, 3 * kNodes);
    for (int p = 0; p < kPoints; ++p) {
      Lanes33 F, S, P;
      clear(F.at, 9);
      add_gradient(nodes, batch.gradient[p], kNodes, F);
      if (has_modes_) add_gradient(modes[b].alpha, batch.gradient[p] + kNodes, kModes, F);
      energy += strain_energy_and_stress(batch, p, F, S);
      multiply(F, S, P);
      for (int a = 0; a < kNodes; ++a) {
        Lanes pull[3];
        multiply(P, batch.gradient[p][a], pull);
        for (int i = 0; i < 3; ++i) force[3 * a + i] += pull[i];
      }
    }
    for (int l = 0; l < batch.count; ++l)
      for (int a = 0; a < kNodes; ++a)
        for (int i = 0; i < 3; ++i) f[3 * batch.node[a][l] + i] += force[3 * a + i][l];
  }
  return energy;
}

void Bricks::add_viscous_force(const double* x, const std::vector<Modes>& modes, const double* v, double beta,
                               double* f) const {
  for (int b = 0; b < batch_count(); ++b) {
    const Batch& batch = batches_[b];
    Lanes nodes[3 * kNodes], speeds[3 * kNodes], rates[3 * kModes], A[3 * kModes][3 * kModes];
    gather(batch, x, nodes);
    gather(batch, v, speeds);
    clear(rates, 3 * kModes);
    for (auto& row : A) clear(row, 3 * kModes);
    Lanes33 F[kPoints], rate[kPoints];
    // Σ = C : sym(FᵀḞ) times the point's weight
    const auto stress = [&](int p, Lanes33& S) {
      Lanes33 e;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          e(i, j) = F[p](0, i) * rate[p](0, j) + F[p](1, i) * rate[p](1, j) + F[p](2, i) * rate[p](2, j);
      const Lanes trace = lambda_ * batch.weight[p] * (e(0, 0) + e(1, 1) + e(2, 2)), mu = mu_ * batch.weight[p];
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) S(i, j) = mu * (e(i, j) + e(j, i));
        S(i, i) += trace;
      }
    };
    for (int p = 0; p < kPoints; ++p) {
      const auto* g = batch.gradient[p] + kNodes;
      clear(F[p].at, 9), clear(rate[p].at, 9);
      add_gradient(nodes, batch.gradient[p], kNodes, F[p]);
      add_gradient(speeds, batch.gradient[p], kNodes, rate[p]);
      if (!has_modes_) continue;
      add_gradient(modes[b].alpha, g, kModes, F[p]);
      Lanes33 S;
      stress(p, S);
      PointTerms terms;
      terms.set(F[p], S, g, 0, kModes);
      const Lanes lambda = lambda_ * batch.weight[p], mu = mu_ * batch.weight[p], none{};
      for (int k = 0; k < kModes; ++k) {
        Lanes pull[3];
        multiply(F[p], terms.s[k], pull);
        for (int i = 0; i < 3; ++i) rates[3 * k + i] -= pull[i];
        for (int l = 0; l <= k; ++l) {
          Lanes slope, block[9];
          dot(g[k], g[l], slope);
          clear(block, 9);
          add_pair(lambda, mu, terms.f[k], terms.f[l], slope * mu, none, terms.b, block);
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) A[3 * k + i][3 * l + j] += block[3 * i + j];
        }
      }
    }
    if (has_modes_) factorize(A), solve(A, rates);
    Lanes force[3 * kNodes];
    clear(force, 3 * kNodes);
    for (int p = 0; p < kPoints; ++p) {
      if (has_modes_) add_gradient(rates, batch.gradient[p] + kNodes, kModes, rate[p]);
      Lanes33 S, P;
      stress(p, S);
      multiply(F[p], S, P);
      for (int a = 0; a < kNodes; ++a) {
        Lanes pull[3];
        multiply(P, batch.gradient[p][a], pull);
        for (int i = 0; i < 3; ++i) force[3 * a + i] += pull[i];
      }
    }
    for (int l = 0; l < batch.count; ++l)
      for (int a = 0; a < kNodes; ++a)
        for (int i = 0; i < 3; ++i) f[3 * batch.node[a][l] + i] += beta * force[3 * a + i][l];
  }
}

void Bricks::add_stiffness(const double* x, const std::vector<Modes>& modes, Stiffness which, double weight,
                           double* values) const {
  constexpr int kPairs = kShapes * (kShapes + 1) / 2;
  const int shapes = has_modes_ ? kShapes : kNodes;
  for (int b = 0; b < batch_count(); ++b) {
    const Batch& batch = batches_[b];
    Lanes nodes[3 * kNodes], K[kPairs][9];
    gather(batch, x, nodes);
    for (auto& block : K) clear(block, 9);
    for (int p = 0; p < kPoints; ++p) {
      Lanes33 F, S;
      clear(F.at, 9);
      add_gradient(nodes, batch.gradient[p], kNodes, F);
      if (has_modes_) add_gradient(modes[b].alpha, batch.gradient[p] + kNodes, kModes, F);
      if (which == Stiffness::tangent)
        strain_energy_and_stress(batch, p, F, S);
      else
        clear(S.at, 9);
      PointTerms terms;
      terms.set(F, S, batch.gradient[p], 0, shapes);
      const Lanes lambda = lambda_ * batch.weight[p], mu = mu_ * batch.weight[p];
      for (int a = 0, pair = 0; a < shapes; ++a)
        for (int c = 0; c <= a; ++c, ++pair) {
          Lanes slope, stress;
          dot(batch.gradient[p][a], batch.gradient[p][c], slope);
          dot(batch.gradient[p][a], terms.s[c], stress);
          add_pair(lambda, mu, terms.f[a], terms.f[c], slope * mu, stress, terms.b, K[pair]);
        }
    }
    if (has_modes_) {
      // Condensed: K_uu - K_uα K_αα⁻¹ K_αu, by K_αα = L D Lᵀ and Y = L⁻¹ K_αu.
      constexpr int n = 3 * kModes;
      const auto block = [&](int a, int c) { return K[a * (a + 1) / 2 + c]; };
      Lanes A[n][n];
      for (int k = 0; k < kModes; ++k)
        for (int l = 0; l <= k; ++l)
          for (int i = 0; i < 9; ++i) A[3 * k + i / 3][3 * l + i % 3] = block(kNodes + k, kNodes + l)[i];
      factorize(A);
      Lanes Y[3 * kNodes][n];
      for (int a = 0; a < kNodes; ++a)
        for (int j = 0; j < 3; ++j) {
          Lanes* y = Y[3 * a + j];
          for (int k = 0; k < kModes; ++k)
            for (int i = 0; i < 3; ++i) y[3 * k + i] = block(kNodes + k, a)[3 * i + j];
          forward(A, y);
        }
      for (int a = 0, pair = 0; a < kNodes; ++a) {
        Lanes scaled[3][n];
        for (int i = 0; i < 3; ++i)
          for (int m = 0; m < n; ++m) scaled[i][m] = Y[3 * a + i][m] * A[m][m];
        for (int c = 0; c <= a; ++c, ++pair)
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
              Lanes sum{};
              for (int m = 0; m < n; ++m) sum += scaled[i][m] * Y[3 * c + j][m];
              K[pair][3 * i + j] -= sum;
            }
      }
    }
    for (int l = 0; l < batch.count; ++l)
      for (int a = 0, pair = 0; a < kNodes; ++a)
        for (int c = 0; c <= a; ++c, ++pair) {
          const int* place = batch.place[pair][l];
          const bool swapped = batch.swapped[pair][l];
          for (int j = 0; j < 3; ++j)
            for (int i = a == c ? j : 0; i < 3; ++i)  // a block on the diagonal: its lower triangle
              values[place[j] + i] += weight * K[pair][swapped ? 3 * j + i : 3 * i + j][l];
        }
  }
}

}  // namespace lithe::brick
