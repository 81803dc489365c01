#pragma once

#include <vector>

#include "engine/assembly/batch_of.h"

namespace lithe {

/// Elements of type T whose tangent is that of a stand-in made linear at each state, Linear(element, time, markers,
/// memory): differences over its markers' motions are exact, and do not evaluate what the element is made of.
template <class T, class Linear>
class LinearizedForceBatch final : public ForceBatch {
 public:
  void add(const ForceElement& force, ConnectorRecord record, ReactionRecord reaction) override {
    exact_.add(force, record, reaction);
    forces_.push_back(static_cast<const T*>(&force));
    records_.push_back(record);
  }
  void evaluate(Workspace& work, BatchRange range, const BlockStructure& blocks) const override {
    exact_.evaluate(work, range, blocks);
  }
  BatchRange all() const { return exact_.all(); }
  void add_tangent(Workspace& work, BatchRange range, const BlockStructure& blocks,
                   const TangentWeights& weights) const override {
    for_each_named(forces_, range, work.time, [&](std::size_t i) {
      ForceRows memory(records_[i].marker_count);
      memory.recall(work.quarter_turns.data() + records_[i].first_angle);
      connector::Views<T> views(work.markers.data(), records_[i]);
      ForceBatchOf<Linear>::add_tangent_of({*forces_[i], work.time, views, memory}, records_[i], work, blocks, weights);
    });
  }
  void react(Workspace&, const BlockStructure&, const double*) const override {}
  void write_reaction_tangent(Workspace&, const BlockStructure&, const double*) const override {}

 private:
  ForceBatchOf<T> exact_;
  std::vector<const T*> forces_;
  std::vector<ConnectorRecord> records_;
};

}  // namespace lithe
