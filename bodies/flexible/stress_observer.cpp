#include "bodies/flexible/stress_observer.h"

#include <algorithm>
#include <cstdio>
#include <numeric>

#include "bodies/flexible/deformation_writer.h"
#include "engine/archive/archive.h"
#include "engine/base/error.h"

namespace lithe {
StressObserver::StressObserver(const FlexibleBody& body, std::shared_ptr<const StressRecovery> recovery)
    : stress_(body, std::move(recovery)) {}

void StressObserver::observe(Snapshot& snapshot) {
  extrema_.add(snapshot.time(), stress_.stress(snapshot));
  if (states_++ == 0) first_time_ = snapshot.time();
  last_time_ = snapshot.time();
}

void StressObserver::history(Archive& archive) {
  archive("largest", extrema_.largest);
  archive("times", extrema_.times);
  archive("value", extrema_.value);
  archive("time", extrema_.time);
  archive("node", extrema_.node);
  archive("states", states_);
  archive("first_time", first_time_);
  archive("last_time", last_time_);
}

void StressObserver::require_states() const {
  if (states_ > 0) return;
  throw SceneError("the largest stresses of '" + stress_.body().name() + "' before any state was observed",
                   stress_.body().where(), "call simulation.observe(stress, every(...)) and run first");
}

std::string StressObserver::report(int nodes) const {
  require_states();
  const ModalBasis& basis = stress_.body().basis();
  const Matrix3X places = mesh_nodes(basis);
  char line[200];
  std::snprintf(line, sizeof line, "von Mises stress of '%s' over %d states, t = %.6g to %.6g s: at most %.4e Pa\n",
                stress_.body().name().c_str(), states_, first_time_, last_time_, extrema_.value);
  std::string text = line;
  std::vector<int> order(static_cast<size_t>(places.cols()));
  std::iota(order.begin(), order.end(), 0);
  const auto shown = std::min(order.size(), static_cast<size_t>(std::max(nodes, 0)));
  std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(shown), order.end(),
                    [&](int a, int b) { return extrema_.largest[a] > extrema_.largest[b]; });
  for (size_t k = 0; k < shown; ++k) {
    const int i = order[k];
    std::snprintf(line, sizeof line, "  node %8d at (%11.4e, %11.4e, %11.4e) m: %.4e Pa at t = %.6g s\n",
                  basis.node_ids[static_cast<size_t>(i)], places(0, i), places(1, i), places(2, i), extrema_.largest[i],
                  extrema_.times[i]);
    text += line;
  }
  return text;
}

void StressObserver::write_vtu(const std::string& path) const {
  require_states();
  const ModalBasis& basis = stress_.body().basis();
  lithe::write_vtu(
      path, mesh_nodes(basis), vtu_cells(basis),
      {{"largest_von_mises", extrema_.largest.transpose()}, {"time_of_largest", extrema_.times.transpose()}});
}

}  // namespace lithe
