#pragma once

#include <vector>

#include "lithe/lithe.h"

namespace machine {

/// Follows the bodies' energy and the power that goes into it, step by step.
class EnergyAccount final : public lithe::Observer {
 public:
  /// `more`: W on the bodies, of what is neither a force element nor a CoordinateDrive.
  EnergyAccount(const lithe::SystemGraph& graph, std::vector<lithe::Sensor> more);
  void observe(lithe::Snapshot& now) override;

  /// J: change of the bodies' energy, work of forces and drives less what damping in bodies took, and what was turned
  /// over: ∫ |power| dt and the largest change.
  struct Sum {
    double change, work, turned_over;
    double missing() const { return turned_over > 0 ? std::abs(change - work) / turned_over : 0; }
  };
  Sum sum() const;

 private:
  const lithe::SystemGraph& graph_;
  std::vector<lithe::Sensor> gains_, stored_;  // W, J
  std::vector<double> times_, energies_, powers_;
};

}  // namespace machine
