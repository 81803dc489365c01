#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/base/math.h"

namespace lithe {

/// Impulses r of rigid contacts that keep bodies apart, and the velocities u they leave. Contact i has rows (normal,
/// across 1, across 2), or six: these and (roll 1, roll 2, spin) as angular velocities.
///   v = v₀ + Σ Y r,   u = H v + b₀,          Y = S⁻¹ Hᵀ,  W = H Y (Delassus' operator)
///   u_n >= 0 ⊥ r_n >= 0;   |r_t| <= μ r_n, and where u_t ≠ 0: r_t = -μ r_n u_t / |u_t|;  moments likewise with their
///   lengths: |r_roll| <= ρ r_n, |r_spin| <= σ r_n.
/// Not the convex relaxation: sliding surfaces do not lift. Bodies that joints tie are one group: S⁻¹ couples them.
class ConeProblem {
 public:
  struct Side {
    int group = -1;            // index into groups; -1: a side that does not move
    int first = 0, count = 0;  // H: columns first ... of the group's own velocities
    int H = 0, Y = 0;          // places in `values`: rows x count; group size x rows; column-major
  };
  struct Contact {
    int row = 0, rows = 3;  // first row in r and u
    double friction = 0, rolling = 0, spinning = 0;
    Side sides[2];  // u = H v summed over both; both may be of one group
  };
  struct Group {
    int first = 0, size = 0;  // of v: the group's velocities lie side by side here
  };
  std::vector<Contact> contacts;
  std::vector<Group> groups;
  std::vector<double> values;
  VectorX free;        // H v₀ + b₀: u without impulses
  int rows = 0;        // of all contacts
  int velocities = 0;  // of all groups

  /// u = W r + free, by way of velocities: linear cost.
  void velocity(const VectorX& r, VectorX& u) const;
  /// The same without allocation; leaves in v what r adds to the groups' velocities, Σ Y r.
  void velocity(const VectorX& r, VectorX& u, VectorX& v) const;
  /// The block of W that couples contacts i and j, rows x rows; zero where they share no group.
  MatrixX block(int i, int j) const;
  /// W, rows x rows, dense.
  MatrixX delassus() const;
  /// Largest violation of the conditions by (r, u), each as the way from r to its projection, in impulses:
  /// |r - P(r - t (u + μ|u_t| n))| with t = 1 / (largest diagonal entry of the contact's block); moments likewise, in
  /// N m s, with the largest diagonal entry of their own rows.
  double residual(const VectorX& r, const VectorX& u) const;
  /// That of one contact.
  double violation(const Contact& contact, const VectorX& r, const VectorX& u) const;
};

struct ConeResult {
  bool converged = false;
  int iterations = 0;
  double residual = 0;  // ConeProblem::residual at the end
};

/// Finds r, from the r given (warm start). One a thread: keeps scratch.
class ConeSolver {
 public:
  virtual ~ConeSolver() = default;
  virtual std::string name() const = 0;
  /// Down to `tolerance`, an impulse in N s. Where it is not reached r is the best found, of finite numbers.
  virtual ConeResult solve(const ConeProblem& problem, double tolerance, VectorX& r) = 0;
  virtual std::unique_ptr<ConeSolver> clone() const = 0;
};

}  // namespace lithe
