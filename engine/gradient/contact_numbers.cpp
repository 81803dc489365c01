#include "engine/gradient/contact_numbers.h"

#include <cmath>
#include <type_traits>
#include <utility>

namespace lithe {
namespace {

constexpr double kSticks = 1e-9;  // m/s: surfaces that slide more slowly stick, to the tolerance of impulses
constexpr double kActs = 1e-20;   // N, of rigid points: solvers may leave less than any round-off

bool acts(const ContactTrace& trace) {
  return !std::holds_alternative<RigidMemory>(trace.memory) || trace.force.norm() > kActs;
}

/// Calls visit(number) for all that traces which act remember.
template <class Memory, class Visit>
void visit_numbers(Memory& memory, const Visit& visit) {
  const auto all = [&](auto& vector) {
    for (auto& x : vector) visit(x);
  };
  for (auto& trace : memory) {
    if (!acts(trace)) continue;
    std::visit(
        [&](auto& kept) {
          if constexpr (std::is_same_v<std::decay_t<decltype(kept)>, RigidMemory>) {
            all(kept.velocity);
            for (auto* slip : {&kept.slip_at_start, &kept.slip_at_end})
              if (!std::isnan(*slip)) visit(*slip);
          } else {
            all(kept.on_A), all(kept.on_B), all(kept.bristle);
            visit(kept.impact_speed);
          }
        },
        trace.memory);
  }
}

bool sticks(const ContactTrace& trace) {
  const auto* kept = std::get_if<RigidMemory>(&trace.memory);
  const Vector3& n = trace.point.normal;
  return kept && (kept->velocity - n * n.dot(kept->velocity)).norm() <= kSticks;
}

}  // namespace

VectorX contact_numbers(const ContactMemory& memory) {
  std::vector<double> numbers;
  visit_numbers(memory, [&](double x) { numbers.push_back(x); });
  return Eigen::Map<const VectorX>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

void set_contact_numbers(ConstVectorRef numbers, ContactMemory& memory) {
  Eigen::Index next = 0;
  visit_numbers(memory, [&](double& x) { x = numbers[next++]; });
}

Eigen::Index velocity_number(const ContactMemory& memory, const ContactKey& key) {
  for (auto trace = memory.begin(); trace != memory.end(); ++trace)
    if (acts(*trace) && std::holds_alternative<RigidMemory>(trace->memory) &&
        contact_key(trace->element, trace->point) == key)
      return contact_numbers({memory.begin(), trace}).size();
  return -1;
}

bool same_contact_set(const ContactMemory& a, const ContactMemory& b) {
  const auto set = [](const ContactMemory& memory) {
    std::vector<std::pair<ContactKey, bool>> points;
    for (const ContactTrace& trace : memory)
      if (acts(trace)) points.emplace_back(contact_key(trace.element, trace.point), sticks(trace));
    return points;
  };
  return contact_numbers(a).size() == contact_numbers(b).size() && set(a) == set(b);
}

}  // namespace lithe
