#pragma once

#include <vector>

#include "engine/assembly/linearized_batch.h"

namespace lithe {

/// Elements of type T that act on many bodies: such as are whole (T::is_whole()), linearized as of
/// LinearizedForceBatch, and such as come in parts, of which the first (T::is_first()) makes the tangent of all:
/// Wide(element, record).add_tangent(work, blocks, weights).
template <class T, class Linear, class Wide>
class ForceBatchInParts final : public ForceBatch {
 public:
  void add(const ForceElement& force, ConnectorRecord record, ReactionRecord reaction) override {
    const auto& element = static_cast<const T&>(force);
    if (element.is_whole()) return whole_.add(force, record, reaction);
    parts_.add(force, record, reaction);
    if (!element.is_first()) return;
    first_.push_back(&element);
    wide_.emplace_back(element, record);
  }
  bool shares() const override { return false; }
  void evaluate(Workspace& work, BatchRange, const BlockStructure& blocks) const override {
    whole_.evaluate(work, whole_.all(), blocks);
    parts_.evaluate(work, parts_.all(), blocks);
  }
  void add_tangent(Workspace& work, BatchRange, const BlockStructure& blocks,
                   const TangentWeights& weights) const override {
    whole_.add_tangent(work, whole_.all(), blocks, weights);
    for_each_named(first_, {0, static_cast<int>(first_.size())}, work.time,
                   [&](std::size_t i) { wide_[i].add_tangent(work, blocks, weights); });
  }
  void react(Workspace&, const BlockStructure&, const double*) const override {}
  void write_reaction_tangent(Workspace&, const BlockStructure&, const double*) const override {}

 private:
  LinearizedForceBatch<T, Linear> whole_;
  ForceBatchOf<T> parts_;
  std::vector<const T*> first_;  // of each element in parts
  std::vector<Wide> wide_;
};

}  // namespace lithe
