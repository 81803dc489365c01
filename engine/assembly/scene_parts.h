#pragma once

#include <map>
#include <typeindex>
#include <vector>

#include "engine/assembly/system.h"

namespace lithe {

/// Cuts a scene into `parts`: bodies in the graph's order, of some velocities each. Returns the part of each body.
/// `records`: of the bodies, without ground.
std::vector<int> cut_into_parts(const Layout& layout, const BlockStructure& blocks,
                                const std::vector<BodyRecord>& records, std::vector<System::Part>& parts);

/// The part that all these markers belong to; `between` if they belong to several, or to ground alone. `part_of(body)`:
/// -1 of ground.
template <class PartOf>
int common_part(const std::vector<Marker>& markers, int between, const PartOf& part_of) {
  int part = -1;
  for (const Marker& m : markers) {
    const int own = part_of(*m.body);
    if (own < 0) continue;
    if (part >= 0 && own != part) return between;
    part = own;
  }
  return part < 0 ? between : part;
}

/// Fills a batch for each type, elements in the order of their parts. `part_of(batch, i)`: of the i-th entry, `between`
/// if it belongs to none; `add(batch, index, i)` adds it as that element of that batch.
template <class Entries, class Batches, class PartOf, class Add>
void fill_by_part(const Entries& entries, Batches& batches, int between, const PartOf& part_of, const Add& add) {
  std::map<std::type_index, int> number;
  std::vector<int> batch_of;
  std::vector<std::vector<int>> by_part(between + 1);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const auto [it, fresh] = number.try_emplace(entries[i].type, static_cast<int>(batches.size()));
    if (fresh) batches.push_back(entries[i].make_batch());
    batch_of.push_back(it->second);
    by_part[part_of(*batches[it->second], i)].push_back(static_cast<int>(i));
  }
  std::vector<int> sizes(batches.size(), 0);
  std::vector<std::vector<int>> ends(batches.size());
  for (const std::vector<int>& part : by_part) {
    for (int i : part) add(batch_of[i], sizes[batch_of[i]]++, static_cast<std::size_t>(i));
    for (std::size_t b = 0; b < batches.size(); ++b) ends[b].push_back(sizes[b]);
  }
  for (std::size_t b = 0; b < batches.size(); ++b) batches[b]->set_ends(std::move(ends[b]));
}

}  // namespace lithe
