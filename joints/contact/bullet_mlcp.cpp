#include "joints/contact/bullet_mlcp.h"

#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btLemkeSolver.h>
#include <BulletDynamics/MLCPSolvers/btSolveProjectedGaussSeidel.h>

#include <algorithm>

namespace lithe {
namespace mlcp {

constexpr double kUnbounded = 1e18;  // dantzig, projected Gauss-Seidel: no limit
constexpr double kLargest = 1e5;     // lemke: its own; larger ones cost it digits

/// The problem in Bullet's words.
struct Rows {
  btMatrixXu A;
  btVectorXu b, x, low, high;
  btAlignedObjectArray<int> normal;  // row whose impulse scales the limits; -1: none

  Rows(const ConeProblem& problem, double compliance) {
    const int n = problem.rows;
    const MatrixX W = problem.delassus();
    A.resize(n, n);
    for (auto* vector : {&b, &x, &low, &high}) vector->resize(n);
    normal.resize(n);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) A.setElem(i, j, W(i, j) * (i == j ? 1 + compliance : 1));
      b[i] = -problem.free[i];
      x[i] = low[i] = high[i] = 0;
      normal[i] = -1;
    }
    for (const auto& contact : problem.contacts) {
      high[contact.row] = kUnbounded;
      for (int k = 1; k < contact.rows; ++k) {
        const double limit = k < 3 ? contact.friction : k < 5 ? contact.rolling : contact.spinning;
        low[contact.row + k] = -limit;
        high[contact.row + k] = limit;
        normal[contact.row + k] = contact.row;
      }
    }
    for (int i = 0; i < n; ++i) {
      if (W(i, i) > 0) continue;
      A.setElem(i, i, 1);  // nothing moves along this row: no impulse
      low[i] = high[i] = 0;
    }
  }
};

bool solve_lemke(const Rows& rows, int iterations, btVectorXu& x) {
  btLemkeSolver solver;
  btVectorXu low = rows.low, high = rows.high;
  for (int k = 0; k < iterations; ++k) {
    double change = 0;
    for (int i = 0; i < x.size(); ++i) {
      const int n = rows.normal[i];
      const double scale = n < 0 ? 1 : std::max(0.0, x[n]);
      low[i] = scale * rows.low[i];
      high[i] = std::min(kLargest, scale * rows.high[i]);
    }
    const btVectorXu before = x;
    if (!solver.solveMLCP(rows.A, rows.b, x, low, high, rows.normal, 1)) return false;
    for (int i = 0; i < x.size(); ++i) change = std::max(change, std::abs(x[i] - before[i]));
    if (change == 0) break;
  }
  return true;
}

}  // namespace mlcp

std::string BulletMlcp::name() const {
  switch (parameters_.method) {
    case Method::dantzig:
      return "bullet_dantzig";
    case Method::lemke:
      return "bullet_lemke";
    case Method::projected_gauss_seidel:
      return "bullet_projected_gauss_seidel";
  }
  return "";
}

ConeResult BulletMlcp::solve(const ConeProblem& problem, double tolerance, VectorX& r) {
  const bool warm = r.size() == problem.rows && r.allFinite();
  if (!warm) r.setZero(problem.rows);
  mlcp::Rows rows(problem, parameters_.compliance);
  bool found = false;
  switch (parameters_.method) {
    case Method::dantzig:
      found = btDantzigSolver().solveMLCP(rows.A, rows.b, rows.x, rows.low, rows.high, rows.normal, 1);
      break;
    case Method::lemke:
      found = mlcp::solve_lemke(rows, parameters_.iterations, rows.x);
      break;
    case Method::projected_gauss_seidel:
      for (int i = 0; i < problem.rows; ++i) rows.x[i] = r[i];
      found = btSolveProjectedGaussSeidel().solveMLCP(rows.A, rows.b, rows.x, rows.low, rows.high, rows.normal,
                                                      parameters_.iterations);
      break;
  }
  for (int i = 0; i < problem.rows; ++i) r[i] = found ? rows.x[i] : 0;
  if (!r.allFinite()) r.setZero();
  VectorX u;
  problem.velocity(r, u);
  const double residual = problem.residual(r, u);
  const bool one_pass = parameters_.method == Method::dantzig;
  return {residual <= tolerance, one_pass ? 1 : parameters_.iterations, residual};
}

}  // namespace lithe
