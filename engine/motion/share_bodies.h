#pragma once

#include <algorithm>

#include "engine/base/thread_team.h"
#include "engine/model/layout.h"

namespace lithe {

constexpr int kMostRanges = 64;

/// job(range, first, last) for ranges of a layout's bodies, which threads share: at most kMostRanges of them, one where
/// there is no team. A job must be such that its bits do not depend on the ranges.
template <class Job>
void share_bodies(const Layout& layout, ThreadTeam* team, const Job& job) {
  constexpr int kEach = 4;  // of a thread: some are slower than others
  const auto count = static_cast<int>(layout.bodies().size());
  const int threads = team ? team->size() : 1;
  if (threads == 1) return job(0, 0, count);
  const int ranges = std::min(kEach * threads, kMostRanges);
  const auto start = [&](int range) { return static_cast<int>(static_cast<long>(count) * range / ranges); };
  team->run(ranges, [&](int range) { job(range, start(range), start(range + 1)); });
}

/// Where the velocities of the bodies from that one on begin.
inline int velocity_at(const Layout& layout, int body) {
  const auto& bodies = layout.bodies();
  return body < static_cast<int>(bodies.size()) ? bodies[body].v : layout.v_count();
}

}  // namespace lithe
