#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "engine/contact/contact_rows.h"
#include "engine/model/body.h"
#include "engine/model/contact_memory.h"

namespace lithe {

/// The contact elements of one evaluator: finds their points at a state, lets compliant ones push, and knows their
/// stiffness. Rigid ones act by what State::contacts says they did.
class ContactForces {
 public:
  /// Borrows the records, the table of markers and the velocities.
  ContactForces(const std::vector<ContactRecord>& records, const Layout& layout,
                const std::vector<MarkerKinematics>& markers, const VectorX& velocity, std::vector<BodyState> bodies);

  /// What was in touch at the last accepted state: the compliant laws' memory, the rigid laws' loads.
  void recall(const ContactMemory& memory) { memory_ = memory; }
  /// Points and loads at the state evaluated (markers at Level::velocity): load += Hᵀ f, and energies.
  void evaluate(VectorX& load, VectorX& energies);
  /// The memory that the state evaluated last leaves, of compliant contacts; others keep theirs.
  void track(ContactMemory& memory);
  bool remembers() const { return remembers_; }
  bool any_compliant() const { return any_compliant_; }
  bool any_rigid() const { return any_rigid_; }
  /// Columns of modes that are held.
  void release(const std::vector<int>& velocities) { rows_.release(velocities); }

  // ---- what sensors and integrators ask of the state evaluated last ----
  /// Compliant contacts as evaluated, rigid ones as remembered; on_A and on_B are not filled.
  ContactMemory report() const;
  /// Of an element, W: its loads times the velocities of its points.
  double power(int element) const;
  /// Points of an element with gaps below reach[a] + reach[b].
  void find(int element, std::span<const double> reach, std::vector<ContactPoint>& points) {
    detectors_[element]->find(places_[element], reach, points);
  }
  double gap(int element, int a, int b, double reach) {
    return detectors_[element]->gap(places_[element], a, b, reach);
  }
  double extent(int element, int collider) const { return detectors_[element]->extent(collider); }
  double half_thickness(int element, int collider) const { return detectors_[element]->half_thickness(collider); }
  const std::vector<ContactPlaces>& places() const { return places_; }
  /// A material point of a side: where `on`, in the side's axes, is now; and back.
  Vector3 place_of(int element, const ContactSide& side, const Vector3& on) const;
  Vector3 on_side(int element, const ContactSide& side, const Vector3& p) const;

  // ---- stiffness: K = Hᵀ D H', D = -(w_q ∂f/∂x + w_v ∂f/∂u) a block for each point ----
  /// Of the points evaluated last; H' = H with columns of rotations as the chart of `increment` has them.
  void form(const TangentWeights& weights, const VectorX* increment);
  const ContactRows& rows() const { return rows_; }
  int stiff_rows() const { return rows_.row_count(); }
  const std::vector<double>& right() const { return right_; }  // values of H', as rows() has those of H
  /// Blocks ∂f/∂x and ∂f/∂u of each point, one after another, by differences of its law.
  const std::vector<double>& by_position() const { return by_position_; }
  const std::vector<double>& by_velocity() const { return by_velocity_; }

 private:
  struct Acting {
    ContactMotion motion;
    ContactLoad load;
  };
  const ContactTrace* find_trace(int element, const ContactPoint& point) const;
  bool was_inside(int element, const ContactPoint& point) const;
  double speed_of_meeting(int element, const ContactPoint& point, double now) const;
  ContactMotion motion_of(const ContactRows& rows, const ContactRows::Row& row) const;

  const std::vector<ContactRecord>& records_;
  const std::vector<BodyState> bodies_;
  const VectorX& velocity_;
  std::vector<ContactPlaces> places_;
  std::vector<std::unique_ptr<ContactDetector>> detectors_;
  std::vector<double> no_reach_;
  std::vector<ContactPoint> points_;
  ContactRows rows_;  // of compliant points, and of rigid ones that have acted
  std::vector<Acting> acting_;
  ContactMemory memory_;
  ContactRows tracked_;  // of track(), as the next
  ContactMemory next_;
  bool remembers_ = false, any_compliant_ = false, any_rigid_ = false;
  std::vector<double> right_, by_position_, by_velocity_;
};

}  // namespace lithe
