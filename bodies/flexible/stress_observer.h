#pragma once

#include <memory>
#include <string>

#include "bodies/flexible/body_stress.h"
#include "engine/observe/observer.h"

namespace lithe {

/// Follows the von Mises stress of a flexible body through a run: the largest at each node and when, the largest of all
/// with time and place. Between observed states nothing is seen: observe as often as the fastest mode of interest asks.
class StressObserver final : public Observer {
 public:
  /// How stresses are recovered: as in BodyStress.
  explicit StressObserver(const FlexibleBody& body, std::shared_ptr<const StressRecovery> recovery = nullptr);
  void observe(Snapshot& snapshot) override;
  void history(Archive& archive) override;

  const StressExtrema& extrema() const { return extrema_; }
  int state_count() const { return states_; }
  /// The largest of all and the most stressed nodes: label, place in the mesh (m), Pa, s.
  std::string report(int nodes = 5) const;
  /// The undeformed mesh (mesh axes) with the fields largest_von_mises (Pa) and time_of_largest (s). SceneError before
  /// the first state.
  void write_vtu(const std::string& path) const;

 private:
  void require_states() const;

  BodyStress stress_;
  StressExtrema extrema_;
  int states_ = 0;
  double first_time_ = 0, last_time_ = 0;
};

}  // namespace lithe
