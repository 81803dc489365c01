#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/assembly/workspace.h"
#include "engine/model/batch_factories.h"
#include "engine/model/body.h"
#include "engine/model/constraint.h"
#include "engine/model/element_error.h"
#include "engine/model/force_element.h"
#include "engine/model/rigid_rows.h"

namespace lithe {

/// Where a body's blocks lie.
struct BodyRecord {
  int q, v, frame, linear;  // frame, linear: indices into BlockStructure, -1: none; the first frame
  int frames;               // how many
  std::vector<BodyTangent::PairPlace> pairs;
  std::vector<std::pair<int, int>> markers;  // (marker of the body, place in the table): those that connectors use
  std::vector<std::pair<int, int>> loaded;   // of these, those that force elements use
};

/// All elements of one type: those of one part of the scene (System::parts()) lie together, those between parts last.
class Batch {
 public:
  virtual ~Batch() = default;
  BatchRange part(std::size_t i) const { return {i == 0 ? 0 : ends_[i - 1], ends_[i]}; }
  /// Where each part ends, then those between parts.
  void set_ends(std::vector<int> ends) { ends_ = std::move(ends); }

 private:
  std::vector<int> ends_;
};

/// All bodies of one type; the loop knows the type, so its calls are inlined.
class BodyBatch : public Batch {
 public:
  /// Caches of all bodies of the batch, contiguous.
  class Caches {
   public:
    virtual ~Caches() = default;
    virtual BodyCache& at(int i) = 0;
  };
  virtual void add(const Body& body, BodyRecord record) = 0;
  virtual std::unique_ptr<Caches> make_caches() const = 0;
  /// Bodies to `level`, and their markers to `markers`: all of them, or those alone that force elements use.
  virtual void evaluate(Workspace&, Caches&, BatchRange, Level level, Level markers) const = 0;
  virtual void evaluate_loaded(Workspace&, Caches&, BatchRange, Level level) const = 0;
  virtual void add_residual(Workspace&, Caches&, BatchRange, const double* v_dot, double* r) const = 0;
  /// Writes the bodies' own blocks of S. `increment`: of the chart in which S is to act, or null.
  virtual void write_tangent(Workspace&, Caches&, BatchRange, const BlockStructure&, const double* v_dot,
                             const TangentWeights&, const double* increment) const = 0;
};

struct ConnectorRecord {
  int first_row, rows;  // rows vertex index in BlockStructure::rows
  int energy = -1;      // force elements: index into Workspace::force_energy
  int first_angle = 0;  // of the connector's measured angles, in Workspace::quarter_turns
  int marker_count = 0, slot_count = 0;
  const MarkerSlot* slots = nullptr;  // the system's; those of the markers in their order first
  bool rigid = false;                 // a joint of RigidRows between plain frames, or one and ground
  int ab = -1, ba = -1;               // of such: values of the blocks of S between their frames, if they have any
};

/// All constraints of one type.
class ConstraintBatch : public Batch {
 public:
  virtual void add(const Constraint& constraint, ConnectorRecord record) = 0;
  /// Null unless the type says that its rows are such.
  virtual const RigidRows* rigid_rows() const = 0;
  virtual void evaluate(Workspace&, BatchRange, const BlockStructure&, Level) const = 0;
  /// Adds weight · ∂(Gᵀ lambda)/∂q to the bodies' blocks: the stiffness of loaded joints.
  virtual void add_stiffness(Workspace&, BatchRange, const BlockStructure&, double weight,
                             const double* lambda) const = 0;
};

/// The joint whose reaction a force element wants.
struct ReactionRecord {
  const Constraint* joint = nullptr;  // null: none
  ConnectorRecord record;             // of the joint
  int coupling = -1;                  // index into BlockStructure::row_couplings
};

/// All force elements of one type.
class ForceBatch : public Batch {
 public:
  virtual void add(const ForceElement& force, ConnectorRecord record, ReactionRecord reaction) = 0;
  virtual void evaluate(Workspace&, BatchRange, const BlockStructure&) const = 0;
  /// Adds the derivatives of loads by positions and velocities, and of the directions of loaded rows, as weighted.
  virtual void add_tangent(Workspace&, BatchRange, const BlockStructure&, const TangentWeights&) const = 0;
  /// Whether threads may share its elements; else they all count as between parts.
  virtual bool shares() const { return true; }
  /// Tensions that joints' reactions make (friction), for these multipliers.
  virtual void react(Workspace&, const BlockStructure&, const double* lambda) const = 0;
  /// Their derivatives by the multipliers; the diagonals of the rows' compliance are there.
  virtual void write_reaction_tangent(Workspace&, const BlockStructure&, const double* lambda) const = 0;
};

}  // namespace lithe
