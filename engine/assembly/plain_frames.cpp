#include "engine/assembly/plain_frames.h"

#include <algorithm>

namespace lithe {
namespace {

// Of many joints on one body each would come to know all others where its translations are eliminated first.
constexpr int kMostJoints = 2;

}  // namespace

const RigidRows* PlainFrames::rows_of(std::size_t i) {
  const auto& entry = graph_.constraints()[i];
  const auto [at, fresh] = by_type_.try_emplace(entry.type, nullptr);
  if (fresh) at->second = entry.make_batch()->rigid_rows();
  return at->second;
}

void PlainFrames::exclude(const ConnectorRecord& record) {
  for (int i = 0; i < record.slot_count; ++i)
    if (record.slots[i].frame >= 0) blocks_.frames[record.slots[i].frame].plain = false;
}

void PlainFrames::exclude_by(const std::vector<ConnectorRecord>& constraints) {
  std::vector<int> joints(blocks_.frames.size(), 0);
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const ConnectorRecord& record = constraints[i];
    const int frames[] = {record.slots[0].frame, record.slots[record.slot_count - 1].frame};
    if (!rows_of(i) || frames[0] == frames[1]) exclude(record);
    for (int frame : frames)
      if (frame >= 0 && ++joints[frame] > kMostJoints) blocks_.frames[frame].plain = false;
  }
}

void PlainFrames::mark(std::vector<ConnectorRecord>& constraints) {
  const auto is_plain = [&](const MarkerSlot& slot) { return slot.frame >= 0 && blocks_.frames[slot.frame].plain; };
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const RigidRows* rows = rows_of(i);
    if (!rows) continue;
    ConnectorRecord& record = constraints[i];
    for (int k = 0; rows->point && k < record.slot_count; ++k)
      if (const MarkerSlot& slot = record.slots[k]; is_plain(slot))
        blocks_.jacobians[slot.jacobian].point = slot.place == 0 ? -1 : 1;
    const MarkerSlot &A = record.slots[0], &B = record.slots[1];
    record.rigid = record.slot_count == 2 && (A.velocity < 0 || is_plain(A)) && (B.velocity < 0 || is_plain(B));
    if (!record.rigid) continue;
    const std::pair<int, int> frames = std::minmax(A.frame, B.frame);
    const auto at = std::lower_bound(blocks_.couplings.begin(), blocks_.couplings.end(), frames,
                                     [](const auto& c, const auto& key) { return std::pair(c.a, c.b) < key; });
    if (at == blocks_.couplings.end() || std::pair(at->a, at->b) != frames) continue;
    record.ab = A.frame < B.frame ? at->ab : at->ba;
    record.ba = A.frame < B.frame ? at->ba : at->ab;
  }
}

}  // namespace lithe
