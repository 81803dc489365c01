#pragma once

#include <vector>

#include "engine/base/math.h"
#include "engine/contact/contact_places.h"

namespace lithe {

/// A frame of a collider's body that has several.
inline const Layout::BodySlice& frame_slice(const ContactPlaces& places, int collider, int frame) {
  const Layout::BodySlice* own = places.slice(collider);
  return *(own - own->part + frame);
}

/// Rotation whose columns are a contact's axes: the normal and two across, the same for the same normal.
Matrix3 contact_frame(const Vector3& normal);

/// About the axes of a contact's frame (normal first) as rows have it: rolling about the two across, then spinning; and
/// back.
inline Vector3 to_moment_rows(const Vector3& about) { return {about[1], about[2], about[0]}; }
inline Vector3 from_moment_rows(const Vector3& rows) { return {rows[2], rows[0], rows[1]}; }

/// Contact points as rows: u = H v, the velocity of B relative to A in the point's frame; three rows a point, or six
/// with the angular velocity (roll, roll, spin). A generalized force is Hᵀ f, f the load on B in that frame.
class ContactRows {
 public:
  struct Side {
    int collider = -1;
    int body = -1;      // index into Layout::bodies(), -1: ground
    int velocity = -1;  // first velocity of the columns; -1: none
    int frames = 0;     // six columns each, of one body and side by side
    int count = 0;      // columns in all: frames, then linear coordinates
    int H = 0;          // in values(): rows x count, column-major
  };
  struct Row {
    int element;         // ContactRecord::number
    ContactPoint point;  // its position where the loads act
    Matrix3 frame;
    int first, rows;
    Side sides[2];  // A, B
  };

  void clear();
  /// Adds a point of the element at `places`, whose bodies and markers have been evaluated.
  void add(const ContactPlaces& places, const ContactPoint& point, int rows);
  const std::vector<Row>& points() const { return points_; }
  int row_count() const { return count_; }
  const double* values(const Side& side) const { return values_.data() + side.H; }

  /// Of one point: u = H v, `rows` long.
  void velocity(const Row& row, const double* v, double* u) const;
  /// p += Hᵀ f.
  void add_force(const Row& row, const double* f, double* p) const;
  /// Columns that belong to these velocities become zero: what is held does not move.
  void release(const std::vector<int>& velocities);

 private:
  void add_side(const ContactPlaces& places, const ContactSide& at, const MarkerKinematics* nodes, double sign,
                Row& row, Side& side);

  std::vector<Row> points_;
  std::vector<double> values_;
  int count_ = 0;
  MarkerKinematics nodes_[2][3];  // of the point that is added: A, B
};

}  // namespace lithe
