#include "engine/cones/direct_cone_solver.h"

#include <algorithm>
#include <limits>

#include "engine/cones/contact_islands.h"

namespace lithe {
namespace {

/// Lists of contacts that share groups, directly or through others; contacts of nothing that moves are in none.
std::vector<std::vector<int>> find_islands(const ConeProblem& problem) {
  ContactIslands tied;
  tied.form(problem, [](int) { return true; });
  std::vector<int> places(problem.groups.size(), -1);
  std::vector<std::vector<int>> islands;
  for (int i = 0; i < static_cast<int>(problem.contacts.size()); ++i) {
    const auto& sides = problem.contacts[i].sides;
    const int group = std::max(sides[0].group, sides[1].group);
    if (group < 0) continue;
    int& place = places[tied.of_group(group)];
    if (place < 0) {
      place = static_cast<int>(islands.size());
      islands.emplace_back();
    }
    islands[place].push_back(i);
  }
  return islands;
}

/// The contacts of one island as a problem of its own.
ConeProblem part(const ConeProblem& problem, const std::vector<int>& contacts, std::vector<int>& places) {
  ConeProblem part;
  places.assign(problem.groups.size(), -1);
  const auto copy = [&](int from, int count) {
    const int to = static_cast<int>(part.values.size());
    part.values.insert(part.values.end(), problem.values.begin() + from, problem.values.begin() + from + count);
    return to;
  };
  for (const int i : contacts) {
    ConeProblem::Contact contact = problem.contacts[i];
    contact.row = part.rows;
    part.rows += contact.rows;
    for (auto& side : contact.sides) {
      if (side.group < 0) continue;
      const int size = problem.groups[side.group].size;
      int& place = places[side.group];
      if (place < 0) {
        place = static_cast<int>(part.groups.size());
        part.groups.push_back({part.velocities, size});
        part.velocities += size;
      }
      side.H = copy(side.H, contact.rows * side.count);
      side.Y = copy(side.Y, contact.rows * size);
      side.group = place;
    }
    part.contacts.push_back(contact);
  }
  part.free.resize(part.rows);
  for (std::size_t k = 0; k < contacts.size(); ++k)
    part.free.segment(part.contacts[k].row, part.contacts[k].rows) =
        problem.free.segment(problem.contacts[contacts[k]].row, part.contacts[k].rows);
  return part;
}

/// The best impulses so far, by the residual of the problem.
class Best {
 public:
  Best(const ConeProblem& problem, double tolerance) : problem_(problem), tolerance_(tolerance) {}

  /// Whether r solves the problem.
  bool offer(const VectorX& candidate) {
    problem_.velocity(candidate, u_, v_);
    const double found = problem_.residual(candidate, u_);
    if (found < residual) {
      residual = found;
      r = candidate;
    }
    return solved();
  }
  bool solved() const { return residual <= std::max(tolerance_, 1e-13 * r.lpNorm<Eigen::Infinity>()); }

  VectorX r;
  double residual = std::numeric_limits<double>::infinity();

 private:
  const ConeProblem& problem_;
  double tolerance_;
  VectorX u_, v_;
};

}  // namespace

ConeResult DirectConeSolver::solve_island(const ConeProblem& island, double tolerance, VectorX& r) {
  Best best(island, tolerance);
  best.r.setZero(island.rows);
  if (best.offer(r)) return {true, 0, best.residual};
  // A dense factor costs rows³: beyond some hundreds of rows sweeps are cheaper, if less exact.
  if (island.rows > parameters_.most_rows)
    return GaussSeidel({.sweeps = parameters_.sweeps}).solve(island, tolerance, r);

  constexpr int kFirstSteps = 15, kSteps = 40, kInteriorSteps = 60, kSweeps = 50;
  const DenseCones cones(island);
  VectorX x = cones.scaled(r), impulses;
  int factorizations = 0;
  const auto solved = [&](const VectorX& point) {
    cones.unscale(point, impulses);
    return best.offer(impulses);
  };
  const auto polish = [&](int steps) {
    if (!solved(x)) factorizations += newton_.solve(cones, steps, solved, x);
    return best.solved();
  };
  const auto sweep = [&](int sweeps) {
    impulses = r;
    GaussSeidel({.sweeps = sweeps}).solve(island, tolerance, impulses);
    x = cones.scaled(impulses);
    return polish(kSteps);
  };
  const auto cross = [&](ConeInterior::SlipTerm slip_term, double start) {
    factorizations += interior_.solve(cones, slip_term, kInteriorSteps, 1e-4, x, start);
    return polish(kSteps);
  };
  using enum ConeInterior::SlipTerm;
  // Newton from the last step's impulses solves nearly all problems of a run. The others need a point in the right
  // basin: an interior path, a few sweeps, the path of the associated law (lagged: always solvable), then interior
  // paths from farther out and nearer in.
  if (polish(kFirstSteps) || cross(linearized, 1) || sweep(kSweeps) || cross(lagged, 1) || cross(linearized, 100) ||
      cross(linearized, 0.01) || sweep(parameters_.sweeps)) {
    // Where impulses are not unique, those of least norm are taken, if they solve the problem as well.
    x = newton_.least_norm(cones, cones.scaled(best.r));
    Best least(island, std::max(tolerance, best.residual));
    cones.unscale(x, impulses);
    if (least.offer(impulses)) {
      best.r = least.r;
      best.residual = least.residual;
    }
  }
  r = best.r;
  return {best.solved(), factorizations, best.residual};
}

ConeResult DirectConeSolver::solve(const ConeProblem& problem, double tolerance, VectorX& r) {
  if (r.size() != problem.rows || !r.allFinite()) r.setZero(problem.rows);
  const auto islands = find_islands(problem);
  // Islands are solved apart: the cost of the direct method grows with the cube of the rows.
  if (islands.size() == 1 && islands[0].size() == problem.contacts.size()) return solve_island(problem, tolerance, r);

  ConeResult result{true, 0, 0};
  VectorX all = VectorX::Zero(problem.rows), some, u, v;
  std::vector<int> places;
  for (const auto& contacts : islands) {
    const ConeProblem island = part(problem, contacts, places);
    some.resize(island.rows);
    for (std::size_t k = 0; k < contacts.size(); ++k)
      some.segment(island.contacts[k].row, island.contacts[k].rows) =
          r.segment(problem.contacts[contacts[k]].row, island.contacts[k].rows);
    const ConeResult found = solve_island(island, tolerance, some);
    for (std::size_t k = 0; k < contacts.size(); ++k)
      all.segment(problem.contacts[contacts[k]].row, island.contacts[k].rows) =
          some.segment(island.contacts[k].row, island.contacts[k].rows);
    result.converged = result.converged && found.converged;
    result.iterations = std::max(result.iterations, found.iterations);
  }
  r = all;
  problem.velocity(r, u, v);
  result.residual = problem.residual(r, u);
  return result;
}

ConeResult AutomaticConeSolver::solve(const ConeProblem& problem, double tolerance, VectorX& r) {
  const ConeResult swept = sweeps_.solve(problem, tolerance, r);
  if (swept.converged) return swept;
  ConeResult result = direct_.solve(problem, tolerance, r);
  result.iterations += swept.iterations;
  return result;
}

}  // namespace lithe
