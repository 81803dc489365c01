#pragma once

#include <string>
#include <vector>

#include "engine/base/math.h"
#include "engine/model/body.h"

namespace lithe {

/// The slices of q, v and lambda of each body and constraint.
class Layout {
 public:
  /// A body, or one frame of a body that has several: those follow each other, its linear coordinates come after them.
  struct BodySlice {
    const Body* body;
    int q, v;  // first index
    bool frame;
    int linear;        // number of linear coordinates
    std::string name;  // "link"; "blade frame 3", counted from 0
    int part = 0;      // which of the body's frames; their number: its linear coordinates
  };
  struct RowSlice {
    std::string name;  // of the constraint
    int first, count;
  };

  void add_body(const Body& body);
  /// Where only the coordinates are known: within a plug-in. `body` is null then.
  void add_body(std::string name, const Coordinates& coordinates, const Body* body = nullptr);
  void add_rows(std::string name, int count);

  int q_count() const { return q_count_; }
  int v_count() const { return v_count_; }
  int row_count() const { return row_count_; }
  const std::vector<BodySlice>& bodies() const { return bodies_; }
  const std::vector<RowSlice>& rows() const { return rows_; }
  /// Of all bodies, in their order.
  std::vector<std::string> body_names() const;
  /// The first of the body's slices.
  const BodySlice& slice(const Body& body) const;
  /// The linear coordinates of the body that a slice belongs to.
  struct LinearSlice {
    int q, v, size;
  };
  LinearSlice linear_slice(const BodySlice& of) const;

  /// out = q ⊕ d: positions move by d, quaternions turn by d (body axes), linear coordinates move. out may be q.
  void retract(ConstVectorRef q, ConstVectorRef d, VectorRef out) const;
  /// The same of the bodies from `first` to before `last`.
  void retract(int first, int last, ConstVectorRef q, ConstVectorRef d, VectorRef out) const;
  /// d_dot of the chart q_n ⊕ d along velocities v: Jr⁻¹(psi) omega for rotations, v elsewhere.
  void chart_rates(ConstVectorRef d, ConstVectorRef v, VectorRef d_dot) const;
  /// d with q_to = q_from ⊕ d.
  void difference(ConstVectorRef q_from, ConstVectorRef q_to, VectorRef d) const;
  /// Magnitudes by which an error in the chart is judged, length v_count: |p|, 1 for rotations, |eta|.
  void magnitudes(ConstVectorRef q, VectorRef out) const;

  /// "link: omega_y", "hub: p_z", "link: eta_3" for a velocity index; "pin row 2" for a row.
  std::string velocity_name(int index) const;
  std::string row_name(int index) const;

 private:
  std::vector<BodySlice> bodies_;
  std::vector<RowSlice> rows_;
  int q_count_ = 0, v_count_ = 0, row_count_ = 0;
};

}  // namespace lithe
