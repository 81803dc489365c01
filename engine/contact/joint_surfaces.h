#pragma once

#include <functional>
#include <vector>

#include "engine/factor/block_structure.h"
#include "engine/model/constraint.h"
#include "engine/model/friction_by_impulses.h"
#include "engine/model/marker_motions.h"

namespace lithe {

/// The joints of a scene whose friction time-stepping methods find, as they see them, at the state that the equations
/// of motion evaluated last.
class JointSurfaces {
 public:
  struct Surface {
    const FrictionByImpulses* friction;
    const Constraint* joint;
    std::vector<Marker> markers, joint_markers;
    const double* joint_turns;  // quarter turns of the joint's angles; null: it measures none
    int joint_row;              // first of the joint, in lambda
    int row;                    // first of the friction, among compliant rows
    int first, count;           // directions
    int kept;                   // velocities that keep the friction of the last step; -1: none
  };
  /// What they act in: borrowed.
  struct Scene {
    const BlockStructure& blocks;
    const std::vector<double>& values;                         // of its blocks
    int constraint_rows, compliant_rows;                       // in all
    const double& time;                                        // s
    std::function<MarkerKinematics(const Marker&)> motion_of;  // at Level::velocity
    bool& left_out;                                            // what tells the force elements so
  };
  JointSurfaces(Scene scene, std::vector<Surface> surfaces);
  virtual ~JointSurfaces() = default;

  const std::vector<Surface>& surfaces() const { return surfaces_; }
  int directions() const { return directions_; }
  /// Leaves the friction out of the equations until the next recall of contacts: it is found here. What is set-valued
  /// is kept in velocities, which whoever finds it takes out.
  void leave_out() { scene_.left_out = true; }
  /// D, a column a direction: s = Dᵀ v, and a friction F adds D F to the generalized forces. Of the state evaluated
  /// last, for what follows.
  void find_directions();
  /// s = Dᵀ v of all directions, m/s.
  void speeds(ConstVectorRef v, VectorX& s) const;
  /// f += D e of one direction of a surface.
  void add_direction(int surface, int direction, VectorRef f) const;
  /// f += D p.
  void add_impulses(const VectorX& p, VectorRef f) const;
  /// From here on slid() counts.
  void start();
  /// How far all surfaces have slid since start(), along their directions, m.
  void slid(VectorX& way);
  /// P_i R of a surface by the multipliers of its joint: a matrix for each, 3 x the joint's rows from joint_row on.
  void find_presses(const Surface& surface, std::vector<Matrix3X>& by_lambda);
  /// Multipliers, a column each, become those of least norm with the same forces where rows repeat others.
  virtual void felt(MatrixRef lambda) = 0;

 private:
  const Scene scene_;
  const std::vector<Surface> surfaces_;
  /// One velocity that slides a surface, and by how much along each direction.
  struct Entry {
    int velocity;
    int value;  // of the first direction, among those of the blocks; others follow
    Vector3 by;
  };

  int directions_ = 0;
  std::vector<std::vector<Entry>> D_;                // of each surface
  std::vector<std::vector<MarkerKinematics>> from_;  // of each surface's markers
  MarkerMotions motions_, joint_motions_;            // of one surface
  std::vector<MarkerView> from_views_;               // likewise
};

}  // namespace lithe
