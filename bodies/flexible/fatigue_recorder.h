#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bodies/fatigue/sn_curve.h"
#include "bodies/flexible/body_stress.h"
#include "engine/observe/observer.h"
#include "engine/output/table.h"

namespace lithe {

/// The stress whose cycles are counted at a node.
enum class FatigueStress {
  signed_von_mises,  // equivalent stress with the sign of the principal stress that is largest in amount
  critical_plane,    // normal stress on each of 373 planes (at most 5.3 degrees beside any: 0.9 % of the range);
                     // the plane of most damage counts
};

struct FatigueCriterion {
  SnCurve curve{};
  FatigueStress stress = FatigueStress::signed_von_mises;
  std::vector<int> nodes{};  // labels (ModalBasis::node_set); none: all of the mesh
};

/// Damage at the nodes of a flexible body by the stresses of a run: rainflow counting, an S-N curve and Miner's sum.
/// It keeps the elastic coordinates alone, so that many curves and sets can be asked of one run; a run that starts anew
/// starts it anew. Observe often enough that peaks are met: 20 states a period of the fastest mode of interest miss
/// 1.2 % of its range at most.
///   FatigueRecorder fatigue(shaft);
///   simulation.observe(fatigue, every(1e-4));
///   simulation.run(state, 2);
///   write_csv(fatigue.table({.curve = steel, .nodes = shaft.basis().node_set("fillet")}), "fatigue.csv");
class FatigueRecorder final : public Observer {
 public:
  /// How stresses are recovered: as in BodyStress.
  explicit FatigueRecorder(const FlexibleBody& body, std::shared_ptr<const StressRecovery> recovery = nullptr);
  void observe(Snapshot& snapshot) override;
  void history(Archive& archive) override;

  /// A longer life (s) than any: no cycle does damage.
  static constexpr double kEndless = 1e99;
  /// A row a node: node (label), cycles (half ones count ½), largest_range (Pa), damage (of the observed stretch), life
  /// (s, the stretch repeated until the damage is 1; at most kEndless). SceneError for fewer than two states, unknown
  /// nodes, a bad curve, a stress that reaches the tensile strength.
  Table table(const FatigueCriterion& criterion) const;
  /// A column of such a table at all nodes, by index; zero at those that are not in it. To colour a page:
  ///   run.add(shaft, {"damage", "", fatigue.at_nodes(table, "damage")});
  VectorX at_nodes(const Table& table, const std::string& column) const;
  /// The undeformed mesh (mesh axes) with the fields damage and largest_range (Pa) of such a table.
  void write_vtu(const std::string& path, const Table& table) const;

 private:
  BodyStress stress_;
  std::vector<double> times_;        // s
  std::vector<double> coordinates_;  // of state after state
};

}  // namespace lithe
