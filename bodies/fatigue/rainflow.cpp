#include "bodies/fatigue/rainflow.h"

#include "engine/base/checks.h"

namespace lithe {

std::vector<LoadCycle> rainflow(std::span<const double> history) {
  require::finite(Eigen::Map<const VectorX>(history.data(), static_cast<Eigen::Index>(history.size())),
                  "the history whose cycles are counted");
  RainflowCounter counter;
  std::vector<LoadCycle> cycles;
  const auto take = [&](const LoadCycle& cycle) { cycles.push_back(cycle); };
  for (const double value : history) counter.add(value, take);
  counter.finish(take);
  return cycles;
}

}  // namespace lithe
