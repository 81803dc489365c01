#pragma once

#include <algorithm>
#include <cassert>
#include <span>
#include <vector>

#include "engine/model/constraint.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/marker.h"

namespace lithe {

/// A force law changes its form where a coordinate passes a value, such as a stop that is reached or left. Simulation
/// ends a step there.
struct CoordinateSwitch {
  JointCoordinate coordinate;
  double value;  // m or rad
};

/// The action of a force element on its markers at one state: loads (wrenches given directly) and compliant rows, which
/// act like the rows of a joint with a multiplier that is a function of the row's own length and speed:
///   length' = Σ W·V,   generalized force = -Σ Jᵀ W σ(length, length').
/// Rows keep stiff springs out of the bodies' blocks: Newton solves them as constraints with compliance.
class ForceRows : public AngleMemory, public ActingMarkers {
 public:
  explicit ForceRows(int markers) : markers_(markers) {
    for (int m = 0; m < std::min(markers_, kMaxMarkers); ++m) load_[m] = {Vector3::Zero(), Vector3::Zero()};
  }

  void add_load(const MarkerView& marker, const Wrench& w) {
    load_[marker.index].force += w.force;
    load_[marker.index].torque += w.torque;
    loaded_ = true;
  }
  /// Row with tension σ and its derivatives ∂σ/∂length, ∂σ/∂length'; energy: stored potential, joules.
  void add(std::initializer_list<Wrench> wrenches, double tension, double stiffness, double damping, double energy) {
    assert(static_cast<int>(wrenches.size()) == markers_ && count_ < kMaxRows);
    int m = 0;
    for (const Wrench& w : wrenches) wrench_[count_][m++] = w;
    tension_[count_] = tension, stiffness_[count_] = stiffness, damping_[count_] = damping;
    energy_ += energy;
    ++count_;
  }
  void add_energy(double energy) { energy_ += energy; }
  /// Opens a row whose wrenches, one for each marker that it acts on, are all to be filled; and ends it.
  Wrench* open() { return wrench_[count_]; }
  void finish(double tension, double stiffness, double damping) {
    tension_[count_] = tension, stiffness_[count_] = stiffness, damping_[count_] = damping;
    ++count_;
  }

  /// Reaction of the joint named by ForceElement::reaction_of() on the body of its second marker: force and moment
  /// about that marker's point, world axes.
  const Wrench& reaction() const { return reaction_; }
  /// Time stepping finds the friction itself (FrictionByImpulses).
  bool friction_left_out() const { return friction_left_out_; }
  /// The last row's tension also depends on that reaction: its derivatives ∂σ/∂force, ∂σ/∂moment.
  void depends_on_reaction(const Wrench& by) { by_reaction_[count_ - 1] = by; }

  // The engine's side.
  void leave_out_friction(bool left_out) { friction_left_out_ = left_out; }
  void set_reaction(const Wrench& reaction) {
    reaction_ = reaction;
    for (Wrench& w : by_reaction_) w = {Vector3::Zero(), Vector3::Zero()};
  }
  const Wrench& by_reaction(int row) const { return by_reaction_[row]; }
  int count() const { return count_; }
  /// It acts by loads too, though they may be zero here.
  bool loaded() const { return loaded_; }
  /// None of an element on more than kMaxMarkers markers: it acts by rows.
  const Wrench& load(int marker) const { return load_[marker < kMaxMarkers ? marker : 0]; }
  const Wrench& wrench(int row, int marker) const { return wrench_of(wrench_[row], marker); }
  double tension(int row) const { return tension_[row]; }
  double stiffness(int row) const { return stiffness_[row]; }
  double damping(int row) const { return damping_[row]; }
  double energy() const { return energy_; }

 private:
  int markers_, count_ = 0;
  bool loaded_ = false, friction_left_out_ = false;
  double energy_ = 0;
  Wrench load_[kMaxMarkers];
  Wrench wrench_[kMaxRows][kMaxMarkers];
  double tension_[kMaxRows], stiffness_[kMaxRows], damping_[kMaxRows];
  Wrench reaction_, by_reaction_[kMaxRows];
};

/// Wrenches at markers, and their potential if they have one.
class ForceElement : public Connector {
 public:
  virtual int row_count() const = 0;  // compliant rows
  virtual void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const = 0;
  /// The joint whose reaction this element needs (friction); null: none. Such an element acts by rows, not by loads.
  virtual const Constraint* reaction_of() const { return nullptr; }
  virtual std::vector<CoordinateSwitch> switches() const { return {}; }
  /// Whether its force may change while the bodies rest. Where nothing does, a scene at rest sleeps
  /// (engine/run/sleeping_integrator.h); a law of position and velocity alone says so.
  virtual bool depends_on_time() const { return true; }
};

/// A force element with its numbers of markers and compliant rows known to the compiler.
template <int Markers, int Rows>
class Force : public ForceElement {
 public:
  static constexpr int kMarkers = Markers, kRows = Rows;
  int marker_count() const final { return Markers; }
  int row_count() const final { return Rows; }
};

}  // namespace lithe
