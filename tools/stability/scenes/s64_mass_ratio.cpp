// S64: a chain of unit masses with a heavy end: what Gauss-Seidel passes on a sweep is one link. As a pile of masses in
// touch, which has the same operator.
#include "joints/contact/bullet_mlcp.h"
#include "tools/stability/scenes/contacts.h"

namespace lithe::lab {
namespace {

constexpr double kLimit = 0.01;  // of the force
constexpr int kSweeps = 50;

/// Impulses over one second: forces. Contact i is under mass i.
struct Chain {
  ConeProblem problem;
  VectorX exact;

  Chain(int n, double ratio) {
    exact.setZero(3 * n);
    problem.rows = problem.velocities = 3 * n;
    problem.free.setZero(3 * n);
    problem.free[0] = -kGravity;  // the others fall alike
    for (int i = 0; i < n; ++i) {
      problem.groups.push_back({3 * i, 3});
      ConeProblem::Contact& contact = problem.contacts.emplace_back();
      contact.row = 3 * i;
      for (int side = i == 0 ? 1 : 0; side < 2; ++side) {
        const int body = i - 1 + side;
        const double sign = side == 0 ? -1 : 1, mass = body == n - 1 ? ratio : 1;
        contact.sides[side] = {.group = body, .first = 0, .count = 3, .H = add(sign), .Y = add(sign / mass)};
      }
      exact[3 * i] = kGravity * (n - 1 - i + ratio);
    }
  }
  double error(const VectorX& r) const { return (r - exact).norm() / exact.norm(); }
  double error(ConeSolver& solver) const {
    VectorX r = VectorX::Zero(problem.rows);
    solver.solve(problem, 0, r);
    return error(r);
  }
  /// Until the error is 0.1 %.
  double sweeps_needed() const {
    GaussSeidel one({.sweeps = 1});
    VectorX r = VectorX::Zero(problem.rows);
    long count = 0;
    for (; error(r) > 1e-3 && count < 1'000'000; ++count) one.solve(problem, 0, r);
    return static_cast<double>(count);
  }

 private:
  /// A diagonal block of 3 x 3; its place.
  int add(double value) {
    const int place = static_cast<int>(problem.values.size());
    for (int k = 0; k < 9; ++k) problem.values.push_back(k % 4 == 0 ? value : 0);
    return place;
  }
};

Finding sweeping() {
  std::vector<Figure> figures;
  const double published[] = {0.994, 0.944, 0.64, 0.27}, sweeps[] = {62355, 6403, 815, 277},
               ratios[] = {1000, 100, 10, 1};
  for (int i = 0; i < 4; ++i) {
    GaussSeidel solver({.sweeps = kSweeps});
    const Chain chain(10, ratios[i]);
    const std::string name = ", ratio " + std::to_string(static_cast<int>(ratios[i]));
    figures.push_back({"force error after 50 sweeps" + name, chain.error(solver), published[i], i < 2 ? 3 : 2});
    figures.push_back({"sweeps to 0.1 %" + name, chain.sweeps_needed(), sweeps[i], 3});
  }
  return {judged(figures[0].value, kLimit), figures, "a sweep passes the load on by one link"};
}

template <class Solver>
Finding judge(Solver&& solver) {
  double worst = 0;
  for (int n : {10, 20})
    for (double ratio : {1.0, 1000.0}) worst = std::max(worst, Chain(n, ratio).error(solver));
  return {judged(worst, kLimit), {{"force error, worst of 10 and 20 links, ratio 1 and 1000", worst}}};
}

const Registered scene{
    {"S64",
     "mass ratio",
     {{"projected Gauss-Seidel", sweeping},
      {"direct solver", [] { return judge(DirectConeSolver()); }},
      {"default solver (automatic)", [] { return judge(AutomaticConeSolver()); }, Role::ours},
      {"Bullet's projected Gauss-Seidel, 50 sweeps",
       [] { return judge(BulletMlcp({.method = BulletMlcp::Method::projected_gauss_seidel, .iterations = kSweeps})); },
       Role::also}}}};

}  // namespace
}  // namespace lithe::lab
