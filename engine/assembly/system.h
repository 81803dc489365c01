#pragma once

#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/assembly/batch.h"
#include "engine/contact/contact_places.h"
#include "engine/factor/block_structure.h"
#include "engine/forward/rigid_scene.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/layout.h"
#include "engine/model/state.h"
#include "engine/model/system_graph.h"

namespace lithe {

/// A row that depends on others as drawn.
struct RedundantRow {
  int row;              // number in lambda
  std::string name;     // "'guide' row 2"
  std::string repeats;  // "'pin' row 5"; "other rows" beyond the first hundred; empty: it restrains nothing
};

/// The assembled, unchanging system: layout, batches, sparsity. const, so threads share it; borrows the graph.
class System {
 public:
  const Layout& layout() const { return layout_; }
  const Vector3& gravity() const { return graph_->gravity(); }
  const SystemGraph& graph() const { return *graph_; }
  int rank() const { return layout_.row_count() - static_cast<int>(redundant_.size()); }
  int degrees_of_freedom() const { return layout_.v_count() - rank(); }
  /// As drawn. Where the pose changes which rows repeat others, EquationsOfMotion::redundant_rows() follows.
  const std::vector<RedundantRow>& redundant_rows() const { return redundant_; }
  /// Bodies that follow each other in the graph, with what lies between them alone: threads may share parts. Their
  /// number depends on the scene alone, and so do the bits.
  struct Part {
    int first_q = 0, last_q = 0, first_v = 0, last_v = 0;
    int first_coupling = 0, last_coupling = 0;  // of BlockStructure, of its frames to those after them
    std::vector<int> jacobians;                 // of BlockStructure, on its bodies
  };
  const std::vector<Part>& parts() const { return parts_; }
  /// Whether State::left_out may be this: empty, or as many rows as at the start, in order.
  bool may_leave_out(const std::vector<int>& rows) const;
  /// Rows on velocities alone (rolling), sorted numbers in lambda.
  const std::vector<int>& velocity_rows() const { return velocity_rows_; }

  /// The state as drawn, projected onto the constraints: consistent positions and velocities at t = 0.
  const State& initial_state() const { return initial_; }

  const std::vector<ContactRecord>& contacts() const { return contacts_; }

  /// How explicit integrators find accelerations.
  ForwardMethod forward_method() const { return forward_method_; }

  /// Where the blocks of the equations lie in an evaluator's values.
  const BlockStructure& blocks() const { return blocks_; }
  /// √(g M⁻¹ gᵀ) of each row as drawn, 1 where nothing moves; empty without redundant rows.
  const VectorX& row_scales() const { return row_scales_; }
  /// Place of an angle in State::quarter_turns; -1 if no connector of the system measures it.
  int find_angle(const JointCoordinate& coordinate) const;
  /// Place of the first angle that a connector of the graph measures.
  int first_angle(const Connector& connector) const;

  /// First row and number of rows of a constraint in lambda. Throws SceneError for one of another graph.
  const Layout::RowSlice& rows(const Constraint& constraint) const;

 private:
  friend class Evaluator;
  friend class SystemBuilder;
  System() = default;

  struct Batches {
    std::vector<std::unique_ptr<BodyBatch>> bodies;
    std::vector<std::unique_ptr<ConstraintBatch>> constraints;
    std::vector<std::unique_ptr<ForceBatch>> forces;
  };
  const SystemGraph* graph_ = nullptr;
  Layout layout_;
  BlockStructure blocks_;
  Batches batches_;
  std::vector<Part> parts_;
  struct Place {
    int batch, index;
    int slice;  // index into Layout::bodies(), -1: ground
  };
  std::vector<Place> body_places_;             // of graph bodies, ground first
  std::deque<std::vector<MarkerSlot>> slots_;  // of all connectors, in chunks that do not move
  int marker_count_ = 0, compliant_count_ = 0;
  std::vector<ContactRecord> contacts_;
  std::vector<RedundantRow> redundant_;
  VectorX row_scales_;
  std::vector<int> velocity_rows_;
  struct Angle {
    int A, B;  // places of the markers in the table
    int axis;
    bool to_point;
    Marker of_A, of_B;
  };
  std::vector<Angle> angles_;
  std::vector<int> first_angles_;  // of the graph's constraints, then its forces
  bool reacts_ = false;            // a force element wants the reaction of a joint
  State initial_;
  ForwardMethod forward_method_ = ForwardMethod::constraints;
  int threads_ = 1;
};

struct AssembleOptions {
  enum class Start {
    assemble,  // move bodies onto the constraints
    refuse,    // throw if a row is off by more than 1e-9 as drawn
    as_drawn,  // take whatever is drawn: joints are not initialized, nothing is projected (to look at rows anywhere)
  } start = Start::assemble;
  double position_tolerance = 1e-12;  // of consistent positions, in the units of the rows
  /// Whether explicit integrators may solve rigid trees and planar mechanisms for their free motions alone, where they
  /// are such (System::forward_method() tells); else all scenes are bodies with constraints. Answers agree to round-off
  /// of the accelerations and to the integrator's own error of the motion.
  bool forward_dynamics = true;
  /// That may work on this one scene: they share parts of it, branches of its factor, and branches and islands of rigid
  /// trees. Worth it from some hundred bodies on. The bits do not depend on it. Laws and elements of your own are then
  /// called by several threads at once. Many scenes at once are the business of sweep().
  int threads = 1;
};

/// Freezes the topology; finds redundant rows (named in a warning), consistent initial positions and velocities; logs
/// one line. Throws SceneError: no body, a joint between ground and ground, positions that cannot be assembled.
System assemble(SystemGraph& graph, const AssembleOptions& options = {});

}  // namespace lithe
