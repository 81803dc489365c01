#pragma once

#include <vector>

#include "engine/model/contact_element.h"
#include "engine/model/layout.h"

namespace lithe {

/// A contact element as an assembled system knows it.
struct ContactRecord {
  const ContactElement* element;
  int number;                   // of the graph's contact elements
  int energy;                   // index into Workspace::force_energy
  std::vector<Marker> markers;  // one a collider
  std::vector<int> places;      // of these in the marker table
  std::vector<int> bodies;      // index into Layout::bodies(); -1: ground
};

/// Where the colliders are, and their bodies' slices, for one evaluator.
class ContactPlaces final : public ContactPoses {
 public:
  /// All of them are borrowed: the table of markers, and the bodies' states by layout.
  ContactPlaces(const ContactRecord& record, const Layout& layout, const std::vector<MarkerKinematics>& markers,
                const std::vector<BodyState>& bodies)
      : record_(record), layout_(layout), markers_(markers), bodies_(bodies) {}

  const MarkerKinematics& collider(int i) const override { return markers_[record_.places[i]]; }
  void node(int i, int marker, MarkerKinematics& out) const override {
    record_.markers[i].body->marker_kinematics(bodies_[record_.bodies[i]], marker, Level::velocity, out);
  }
  std::span<const double> deformation(int i) const override {
    if (record_.bodies[i] < 0) return {};
    const Coordinates c = record_.markers[i].body->coordinates();
    return {bodies_[record_.bodies[i]].q + 7 * c.frames, static_cast<std::size_t>(c.linear)};
  }
  /// Null: ground.
  const Layout::BodySlice* slice(int i) const {
    return record_.bodies[i] < 0 ? nullptr : &layout_.bodies()[record_.bodies[i]];
  }
  const ContactRecord& record() const { return record_; }

 private:
  const ContactRecord& record_;
  const Layout& layout_;
  const std::vector<MarkerKinematics>& markers_;
  const std::vector<BodyState>& bodies_;
};

}  // namespace lithe
