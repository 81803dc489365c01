#pragma once

#include <vector>

#include "engine/assembly/system.h"
#include "engine/model/input.h"

namespace lithe {

class Archive;

/// The inputs of a scene as a run comes by their samples: steps end at jumps and bends, up to which the old values
/// hold, and the run learns when other ones hold from there on, whoever has set them.
class FollowedInputs {
 public:
  /// None where nothing in the scene depends on time.
  explicit FollowedInputs(const System& system);
  ~FollowedInputs() { release(); }
  FollowedInputs(const FollowedInputs&) = delete;
  FollowedInputs& operator=(const FollowedInputs&) = delete;

  /// The next jump or bend, or `stop` if that comes first.
  double next_stop(double time, double stop) const;
  /// Evaluations see what holds before `time`; until release().
  void end_at(double time) const;
  void release() const;
  /// Remembers what holds at the end of a step.
  void see(double time);
  /// Whether values or rates are other ones from `time` on than those seen; they are seen then.
  bool changed(double time);
  /// Samples, and what was seen.
  void history(Archive& archive);

 private:
  std::vector<Input*> inputs_;
  std::vector<double> seen_;  // value, rate of each
};

/// While it lives, all inputs of a graph have the values they were drawn with, and no element remembers events.
class InputsAsDrawn {
 public:
  explicit InputsAsDrawn(const SystemGraph& graph);
  ~InputsAsDrawn();
  InputsAsDrawn(const InputsAsDrawn&) = delete;
  InputsAsDrawn& operator=(const InputsAsDrawn&) = delete;

 private:
  const SystemGraph& graph_;
};

}  // namespace lithe
