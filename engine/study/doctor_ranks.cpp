#include <Eigen/SparseCholesky>
#include <Eigen/SparseQR>
#include <numbers>
#include <set>

#include "engine/analysis/free_motions.h"
#include "engine/study/doctor_internal.h"

namespace lithe::doctor {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

constexpr int kNamed = 3;  // joints in a text

/// A vector without any symmetry of a scene.
VectorX scattered(Eigen::Index size) {
  VectorX x(size);
  for (Eigen::Index i = 0; i < size; ++i) x[i] = std::sin(1 + 2.4 * static_cast<double>(i)) + 0.1;
  return x;
}

/// L⁻¹ Gᵀ of the kept rows, M = L Lᵀ with the inertia of each body over its mass, each column of length 1: its singular
/// values tell of the geometry alone, however light a body is beside its neighbours.
Sparse scaled_rows(const Evaluator& equations, const std::vector<int>& kept) {
  const int n = equations.layout().v_count();
  std::vector<int> column_of(static_cast<std::size_t>(equations.layout().row_count()), -1);
  for (std::size_t k = 0; k < kept.size(); ++k) column_of[kept[k]] = static_cast<int>(k);
  std::vector<Eigen::Triplet<double>> of_mass, of_rows;
  equations.visit_blocks([&](int row, int column, ConstMatrixRef block) {
    if (column >= n) return;
    for (int i = 0; i < block.rows(); ++i)
      for (int j = 0; j < block.cols(); ++j)
        if (row < n)
          of_mass.emplace_back(row + i, column + j, block(i, j));
        else if (row + i < n + equations.layout().row_count() && column_of[row + i - n] >= 0)
          of_rows.emplace_back(column + j, column_of[row + i - n], block(i, j));
  });
  Sparse mass(n, n), rows(n, static_cast<Eigen::Index>(kept.size()));
  mass.setFromTriplets(of_mass.begin(), of_mass.end());
  rows.setFromTriplets(of_rows.begin(), of_rows.end());
  const Eigen::SimplicialLLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> factor(mass);
  if (factor.info() == Eigen::Success) factor.matrixL().solveInPlace(rows);
  VectorX scale = VectorX::Ones(n);
  for (const Layout::BodySlice& b : equations.layout().bodies())
    if (b.frame) scale.segment(b.v, 6 + b.linear).setConstant(std::sqrt(mass.coeff(b.v, b.v)));
  rows = scale.asDiagonal() * rows;
  for (Eigen::Index k = 0; k < rows.cols(); ++k)
    if (const double length = rows.col(k).norm(); length > 0) rows.col(k) /= length;
  rows.prune(0.0);
  return rows;
}

/// Which bodies a chain of welds holds to ground.
std::set<const Body*> welded_to_ground(const SystemGraph& graph) {
  std::set<const Body*> held{graph.bodies().front().body};
  for (bool more = true; more;) {
    more = false;
    for (const auto& c : graph.constraints()) {
      const auto free = c.constraint->freedom();
      if (!free || free->x || free->y || free->z || free->rotation != JointFreedom::Rotation::none) continue;
      if (std::ranges::any_of(c.markers, [&](const Marker& m) { return held.contains(m.body); }))
        for (const Marker& m : c.markers) more |= held.insert(m.body).second;
    }
  }
  return held;
}

/// Bodies that joints hold at rest, whatever pushes them: under forces that would accelerate each velocity by about 1
/// they do not move.
std::set<const Body*> held_bodies(const System& system, const State& start) {
  const Layout& layout = system.layout();
  const auto equations = factorized(system, start);
  VectorX motion = VectorX::Zero(layout.v_count()), no_load = VectorX::Zero(layout.row_count());
  equations->visit_blocks([&](int row, int column, ConstMatrixRef block) {
    if (row == column && row < motion.size()) motion.segment(row, block.rows()) += block.diagonal();
  });
  motion.array() *= scattered(motion.size()).array();
  equations->solve(motion, no_load);
  std::set<const Body*> held, moving;
  for (const Layout::BodySlice& b : layout.bodies())
    (motion.segment(b.v, (b.frame ? 6 : 0) + b.linear).lpNorm<Eigen::Infinity>() > 1e-9 ? moving : held).insert(b.body);
  std::erase_if(held, [&](const Body* b) { return moving.contains(b); });
  return held;
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(kNamed, names.size()); ++i)
    text += (i > 0 ? ", " : "") + quoted(names[i]);
  return text + (names.size() > kNamed ? " and " + std::to_string(names.size() - kNamed) + " more" : "");
}

/// Joints by their share in what holds the motion that is held least, the largest first.
std::vector<std::string> weakest_holders(const System& system, const RowRanks& ranks) {
  std::vector<std::pair<double, std::string>> shares;
  std::size_t k = 0;
  for (const Layout::RowSlice& joint : system.layout().rows()) {
    double sum = 0;
    for (; k < ranks.kept.size() && ranks.kept[k] < joint.first + joint.count; ++k)
      sum += ranks.weakest[static_cast<Eigen::Index>(k)] * ranks.weakest[static_cast<Eigen::Index>(k)];
    shares.emplace_back(sum, joint.name);
  }
  std::stable_sort(shares.begin(), shares.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> names;
  for (const auto& [share, name] : shares)
    if (share > 0.25 * shares.front().first) names.push_back(name);
  return names;
}

/// Hinges whose axes are off the direction that most of them share, and slides along it: such a mechanism would be
/// plane. Empty where there is no such direction, or no joint off it.
std::string odd_axes(const System& system, const State& start, const std::set<const Body*>& of) {
  constexpr double kOff = 1e-3;  // rad
  struct Axis {
    std::string name;
    Vector3 direction;
    bool slides;
  };
  std::vector<Axis> axes;
  Snapshot now(system, start);
  for (const auto& c : system.graph().constraints()) {
    const auto free = c.constraint->freedom();
    if (!free || free->x || !std::ranges::any_of(c.markers, [&](const Marker& m) { return of.contains(m.body); }))
      continue;
    const bool turns = free->rotation == JointFreedom::Rotation::about_z;
    if (turns != free->z) axes.push_back({c.constraint->name(), now.marker(c.markers[0]).R.col(2), free->z});
  }
  const auto off = [](const Axis& axis, const Vector3& common) {
    const double along = std::min(std::abs(axis.direction.dot(common)), 1.0);
    return axis.slides ? std::asin(along) : std::acos(along);
  };
  for (const Axis& candidate : axes) {
    if (candidate.slides) continue;
    std::string odd;
    std::size_t count = 0;
    for (const Axis& axis : axes)
      if (const double angle = off(axis, candidate.direction); angle > kOff && ++count <= kNamed)
        odd += (odd.empty() ? "" : ", ") + quoted(axis.name) + " by " + number(angle * 180 / std::numbers::pi) +
               " degrees";
    if (2 * count < axes.size()) return odd.empty() ? "" : "; axes that the others' plane does not allow: " + odd;
  }
  return "";
}

/// Bodies that their joints lock against each other, though none of these is a weld: beside others that move.
void look_at_locked_parts(const System& system, const State& start, std::vector<Finding>& out) {
  const SystemGraph& graph = system.graph();
  std::set<const Body*> held = held_bodies(system, start);
  const std::set<const Body*> meant = welded_to_ground(graph);
  std::erase_if(held, [&](const Body* b) { return meant.contains(b); });
  // What a drive holds, it may move, and all that is tied to it. A joint that does not say that it rests may drive.
  std::set<const Body*> driven;
  for (bool more = true; more;) {
    more = false;
    for (const auto& c : graph.constraints())
      if (c.constraint->depends_on_time() ||
          std::ranges::any_of(c.markers, [&](const Marker& m) { return driven.contains(m.body); }))
        for (const Marker& m : c.markers)
          if (!meant.contains(m.body)) more |= driven.insert(m.body).second;
  }
  std::erase_if(held, [&](const Body* b) { return driven.contains(b); });
  if (held.empty()) return;
  std::vector<std::string> bodies, joints;
  bool slides = false;
  for (const auto& entry : graph.bodies())
    if (held.contains(entry.body)) bodies.push_back(entry.body->name());
  for (const auto& c : graph.constraints()) {
    if (!std::ranges::any_of(c.markers, [&](const Marker& m) { return held.contains(m.body); })) continue;
    joints.push_back(c.constraint->name());
    const auto free = c.constraint->freedom();
    slides |= free && free->z && !free->x;
  }
  out.push_back({Cause::locked, slides, 0.85,
                 listed(bodies) + " cannot move: " + listed(joints) + " hold " + (bodies.size() > 1 ? "them" : "it") +
                     odd_axes(system, start, held),
                 "see whether each of these joints is on the bodies that are meant; a frame that is to stand needs no "
                 "joint that could turn or slide"});
}

}  // namespace

RowRanks row_ranks(const System& system, const State& state) {
  const auto equations = factorized(system, state);
  RowRanks out;
  out.kept = independent_rows(*equations);
  if (out.kept.empty()) return out;
  const Sparse rows = scaled_rows(*equations, out.kept);
  if (!rows.coeffs().allFinite()) return out;
  // 1. The largest singular value by powers, the smallest by inverse powers with R of rows P = Q R.
  constexpr int kPowers = 30;
  VectorX x = scattered(rows.cols()).normalized();
  for (int i = 0; i < kPowers; ++i) {
    x = rows.transpose() * (rows * x);
    out.largest = std::sqrt(x.norm());
    if (!(x.norm() > 0)) return out;
    x.normalize();
  }
  const Eigen::SparseQR<Sparse, Eigen::COLAMDOrdering<int>> qr(rows);
  const auto rank = qr.rank();
  const Sparse R = qr.matrixR().topLeftCorner(rank, rank);
  x = VectorX::Zero(rows.cols());
  if (rank < rows.cols()) {  // a dependent row, and what makes it of the others
    const Sparse rest = qr.matrixR().topRightCorner(rank, rows.cols() - rank);
    x.head(rank) = -R.triangularView<Eigen::Upper>().solve(VectorX(rest.col(0)));
    x[rank] = 1;
    x.normalize();
    out.smallest = 0;
  } else {
    x = scattered(rank).normalized();
    for (int i = 0; i < kPowers; ++i) {
      R.transpose().triangularView<Eigen::Lower>().solveInPlace(x);
      R.triangularView<Eigen::Upper>().solveInPlace(x);
      out.smallest = 1 / std::sqrt(x.norm());
      x.normalize();
    }
  }
  // 2. Whose rows they are.
  int weakest = 0;
  out.weakest = (qr.colsPermutation() * x).cwiseAbs();
  out.weakest.maxCoeff(&weakest);
  out.weakest_row = out.kept[weakest];
  return out;
}

void look_at_rank(const System& system, const State& start, std::vector<Finding>& out) {
  const Layout& layout = system.layout();
  if (layout.row_count() == 0) return;
  const VectorX drives = drive_rates(system), g_dot = rows_at(system, start.time, start, Level::velocity);
  const VectorX g = rows_at(system, start.time, start, Level::position);
  std::string rows;
  int count = 0;
  for (const RedundantRow& r : system.redundant_rows()) {
    const std::string repeats = r.repeats.empty() ? " restrains nothing" : " repeats " + r.repeats;
    if (++count <= 4) rows += (rows.empty() ? "" : "; ") + r.name + repeats;
    if (std::abs(g_dot[r.row]) > 1e-8 * (1 + start.v.cwiseAbs().maxCoeff()) || std::abs(g[r.row]) > 1e-8) {
      const bool driven = drives.maxCoeff() > 0;
      out.push_back({driven ? Cause::incompatible_drive : Cause::open_joint, true, 0.96,
                     "joint " + r.name + repeats + " but asks for another motion: it opens at " + number(g_dot[r.row]) +
                         " a second",
                     driven ? "drive every freedom once; let two drives of one freedom give the same motion"
                            : "leave one of them out, or make their lengths agree"});
      return;
    }
  }
  if (!rows.empty())
    out.push_back(
        {Cause::redundant_rows, false, 0.6,
         "constraint rows repeat others (rank " + std::to_string(system.rank()) + " of " +
             std::to_string(layout.row_count()) + "): " + rows,
         "drop these rows, as a spherical or cylindrical joint in place of a revolute one does, or keep them: "
         "they are borne, but how forces are shared among them is not told by rigid bodies"});
  const RowRanks ranks = row_ranks(system, start);
  std::set<const Body*> all;
  for (const auto& entry : system.graph().bodies()) all.insert(entry.body);
  if (system.degrees_of_freedom() == 0 && drives.maxCoeff() == 0)
    out.push_back({Cause::locked, true, 0.97,
                   "nothing can move: " + std::to_string(layout.v_count()) + " velocities, held by " +
                       std::to_string(system.rank()) +
                       " independent rows, and no drive; the motion that is held least is held by " +
                       listed(weakest_holders(system, ranks)) + odd_axes(system, start, all),
                   "see whether the axes of these joints are right, or give one of them more freedom; "
                   "describe(system) lists who holds what"});
  else
    look_at_locked_parts(system, start, out);
  if (ranks.conditioning() < 1e-7)
    out.push_back({Cause::singular_position, true, 0.9,
                   "the start is a singular position: rows lose rank there, " + layout.row_name(ranks.weakest_row) +
                       " most (singular values " + number(ranks.smallest) + " to " + number(ranks.largest) + ")",
                   "start beside that position, by a degree or so, with the velocity of the branch that is meant"});
}

}  // namespace lithe::doctor
