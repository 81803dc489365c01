#include "engine/analysis/describe.h"

#include <sstream>

#include "engine/analysis/free_motions.h"
#include "engine/assembly/evaluator.h"

namespace lithe {
namespace {

constexpr int kMaxDense = 1500;  // velocities
constexpr int kMaxListed = 40;   // free motions
constexpr double kMoves = 1e-8;  // m/s, rad/s beside the free velocity's 1

/// The other bodies that a free motion moves: ", with crank, rod".
std::string partners(const FreeMotion& motion, const Layout& layout) {
  std::string text;
  for (const Layout::BodySlice& b : layout.bodies()) {
    const int size = (b.frame ? 6 : 0) + b.linear;
    const bool own = motion.velocity >= b.v && motion.velocity < b.v + size;
    if (own || motion.motion.segment(b.v, size).lpNorm<Eigen::Infinity>() < kMoves) continue;
    text += (text.empty() ? ", with " : ", ") + b.name;
  }
  return text;
}

}  // namespace

std::string describe(const System& system) {
  const Layout& layout = system.layout();
  std::ostringstream out;
  out << system.graph().bodies().size() - 1 << " bodies, " << layout.q_count() << " coordinates, " << layout.v_count()
      << " velocities, " << layout.row_count() << " constraint rows of rank " << system.rank() << ", "
      << system.degrees_of_freedom() << " degrees of freedom\n";
  for (const auto& entry : system.graph().bodies()) {
    const Coordinates c = entry.body->coordinates();
    if (c.v_count() == 0) continue;  // ground
    out << "  '" << entry.body->name() << "': ";
    if (c.frames > 1)
      out << c.frames << " frames";
    else
      out << (c.frames == 1 ? "a frame" : "no frame");
    if (c.linear > 0) out << ", " << c.linear << " elastic coordinates";
    out << '\n';
  }
  if (!system.redundant_rows().empty()) out << "redundant rows, handled:\n";
  for (const RedundantRow& row : system.redundant_rows())
    out << "  " << row.name << (row.repeats.empty() ? " restrains nothing" : " repeats " + row.repeats) << '\n';

  if (system.degrees_of_freedom() == 0 || layout.v_count() > kMaxDense) return out.str();
  Evaluator equations(system);
  const State& start = system.initial_state();
  equations.evaluate(start.time, start.q, start.v, Level::velocity);
  const std::vector<FreeMotion> motions = free_motions(equations);
  out << "free motions at the start:\n";
  for (std::size_t k = 0; k < motions.size() && k < kMaxListed; ++k)
    out << "  " << k + 1 << ". " << motions[k].name << partners(motions[k], layout) << '\n';
  if (motions.size() > kMaxListed) out << "  and " << motions.size() - kMaxListed << " more\n";
  if (static_cast<int>(motions.size()) != system.degrees_of_freedom())
    out << "the start is a singular position: " << motions.size() - system.degrees_of_freedom()
        << " more motions are free there than elsewhere\n";
  return out.str();
}

}  // namespace lithe
