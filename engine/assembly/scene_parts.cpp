#include "engine/assembly/scene_parts.h"

#include <algorithm>
#include <cstdint>

namespace lithe {

std::vector<int> cut_into_parts(const Layout& layout, const BlockStructure& blocks,
                                const std::vector<BodyRecord>& records, std::vector<System::Part>& parts) {
  constexpr int kVelocities = 300, kMost = 64;
  const int all = layout.v_count(), count = std::clamp(all / kVelocities, 1, kMost);
  parts.assign(count, {});
  const auto part_at = [&](int v) { return count == 1 ? 0 : static_cast<int>(std::int64_t(v) * count / all); };
  std::vector<int> parts_of_bodies, parts_of_frames;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const int part = part_at(records[i].v);
    parts_of_bodies.push_back(part);
    parts_of_frames.insert(parts_of_frames.end(), records[i].frame < 0 ? 0 : records[i].frames, part);
    System::Part& of = parts[part];
    if (of.last_v == 0) of.first_q = records[i].q, of.first_v = records[i].v;
    const bool last = i + 1 == records.size();
    of.last_q = last ? layout.q_count() : records[i + 1].q, of.last_v = last ? all : records[i + 1].v;
  }
  const auto number = [&](int velocity) {  // of the body
    const auto after = std::upper_bound(records.begin(), records.end(), velocity,
                                        [](int v, const BodyRecord& record) { return v < record.v; });
    return static_cast<int>(after - records.begin()) - 1;
  };
  for (std::size_t j = 0; j < blocks.jacobians.size(); ++j)
    parts[parts_of_bodies[number(blocks.jacobians[j].velocity)]].jacobians.push_back(static_cast<int>(j));
  for (std::size_t c = 0; c < blocks.couplings.size(); ++c) {
    System::Part& of = parts[parts_of_frames[blocks.couplings[c].a]];
    if (of.last_coupling == 0) of.first_coupling = static_cast<int>(c);
    of.last_coupling = static_cast<int>(c) + 1;
  }
  return parts_of_bodies;
}

}  // namespace lithe
