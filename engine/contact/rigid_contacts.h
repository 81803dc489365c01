#pragma once

#include <vector>

#include "engine/cones/cone_problem.h"
#include "engine/contact/contact_event.h"
#include "engine/contact/contact_forces.h"
#include "engine/contact/joint_surfaces.h"
#include "engine/factor/block_structure.h"
#include "engine/model/rigid_frame_body.h"
#include "engine/model/state.h"

namespace lithe {

class EquationsOfMotion;

/// The contacts of rigid surfaces as integrators see them, at the state evaluated last by the equations of motion.
class RigidContacts {
 public:
  /// What they act in: all of it is borrowed and outlives them.
  struct Scene {
    EquationsOfMotion& equations;
    const BlockStructure& blocks;
    const std::vector<double>& values;  // of its blocks
    const std::vector<ContactRecord>& records;
    ContactForces& contacts;
    std::vector<int> loaded;  // bodies that force elements act on, by layout
    double gravity;           // m/s²
    std::unique_ptr<JointSurfaces> joints;
  };
  explicit RigidContacts(Scene scene);

  struct Point {
    RigidContact law;
    double gap;
    Vector3 before;   // velocity in the point's frame at `v`, m/s
    int first, rows;  // rows of the problem
    int pair;         // into pairs()
    double turning;   // bounds how fast the turning of bodies changes that velocity, m/s²
  };
  /// Two colliders with points.
  struct Pair {
    int element, a, b;
    auto operator<=>(const Pair&) const = default;
  };
  /// Finds all points that surfaces moving with v may close within `horizon` seconds either way, at the state evaluated
  /// last.
  void find(ConstVectorRef v, double horizon);
  bool empty() const { return points_.empty(); }
  /// All velocities, rising, of the bodies that joints or springs tie to that of a marker; of ground: none.
  const std::vector<int>& tied_velocities(const Marker& marker) const;
  /// Joints whose friction is found beside contacts; null: there are none.
  JointSurfaces* joints() const { return scene_.joints.get(); }
  /// Whether some collider moves so far in half of find()'s horizon that, looked at in the middle of a step of that
  /// length, it may have passed another.
  bool fast() const { return fast_; }
  /// The step that no surface passes through another in: `step`, or a shorter one in whose middle those that meet at v
  /// are not deeper in each other than half their thickness. At the start of the step, evaluated last; find() is to
  /// follow.
  double step_without_passing(ConstVectorRef v, double step);
  const std::vector<Point>& points() const { return points_; }
  const std::vector<Pair>& pairs() const { return pairs_; }

  /// The problem of impulses at these points (engine/cones/cone_problem.h), but for `free`, with Y = S⁻¹ Hᵀ of the
  /// last factor.
  ConeProblem& form();
  /// As formed last, to be given another `free` or friction.
  ConeProblem& problem() { return problem_; }
  /// u = H v of all points.
  void velocity(ConstVectorRef v, VectorRef u) const;
  /// f += Hᵀ r, the generalized impulses.
  void add_impulses(ConstVectorRef r, VectorRef f) const;
  /// dv += Σ weight_i Y_i r_i, a weight for each point (null: 1).
  void add_response(ConstVectorRef r, const VectorX* weights, VectorRef dv) const;
  /// Whether a group has a body that deforms.
  bool deforms(int group) const { return components_[used_[group]].deforms; }
  /// Whether joints and drives hold what a point is on, so that no impulse along its normal moves it.
  bool is_held(int point) const;
  /// Throws SimulationError that names the contact, the bodies and what holds them. The equations are left at `start`,
  /// at rest.
  [[noreturn]] void refuse_held(int point, const State& start, double speed);
  /// a·b of a group's velocities.
  double dot(int group, ConstVectorRef a, ConstVectorRef b) const;
  /// Of the last step, over `h`, where it was of these points: impulses r, from which a solver may start, and by how
  /// much u of a velocity that stays grows from the middle of a step to its end, since bodies turn: u' - H v' = h/2 Ḣ
  /// v'.
  void recall(const ContactMemory& memory, double h, VectorRef r, VectorRef growth) const;
  /// How fast each point slid at the last step's start and end, m/s; NaN where it was not of these points.
  void recall_slip(const ContactMemory& memory, VectorRef at_start, VectorRef at_end) const;
  /// What the points did, mean forces over h, the velocity that it left them, and how they slid.
  void remember(ConstVectorRef r, ConstVectorRef v, double h, ConstVectorRef slip_at_start, ConstVectorRef slip_at_end,
                ContactMemory& memory) const;

  /// What happened since find(); whoever reports it takes it out.
  struct Happening {
    double time;  // since the step's start, s
    int element;
    ContactEvent event;
  };
  std::vector<Happening>& happenings() { return happenings_; }
  /// Whether the pairs of an element are of rigid surfaces and reported as events.
  bool located(int element) const { return located_[element]; }

 private:
  void find_reach(const ContactRecord& record, ConstVectorRef v, double horizon);
  const ContactTrace* find_trace(const ContactMemory& memory, const ContactRows::Row& row) const;
  void group_bodies();
  int frames_under(const ContactRecord& record, int collider) const;
  void add_groups();
  void respond_alone(const ContactRows::Row& row, const ContactRows::Side& side, ConeProblem::Side& to);
  void respond_together();
  double mobility_alone(const ContactRows::Side& side, int rows) const;

  const Scene scene_;
  // Bodies that joints or springs tie are one component.
  struct Component {
    std::vector<int> bodies, velocities;  // velocities: of the whole system, in order
    bool alone = false;                   // one rigid body that nothing ties
    bool deforms = false;                 // one of them has more freedoms than a rigid body
    int values = 0;                       // then: of its block of S in Workspace::values
    RigidInertia inertia{};               // and that inverted
    int group = -1;                       // in the problem
  };
  std::vector<Component> components_;
  std::vector<int> component_;  // of each body
  std::vector<int> place_;      // of each velocity in its component
  std::vector<int> used_;       // components of the groups
  struct Column {
    int point, side, row;
  };
  std::vector<std::vector<Column>> columns_;  // by group
  VectorX rv_, rl_;
  std::vector<ContactPoint> found_;
  std::vector<std::vector<double>> reach_, half_thickness_;  // by collider
  bool fast_ = false;
  ContactRows rows_;
  std::vector<Point> points_;
  std::vector<Pair> pairs_;
  std::vector<char> located_;  // by element
  std::vector<Happening> happenings_;
  ConeProblem problem_;
  std::vector<std::vector<int>> diagonals_;  // in Workspace::values, of each linear block with a pattern
  std::vector<std::vector<int>> frames_;     // how many carry a collider; 0: that of its marker alone
};

}  // namespace lithe
