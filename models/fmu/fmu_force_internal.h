#pragma once

#include <memory>
#include <optional>

#include "engine/assembly/batch.h"
#include "engine/model/coupled_markers.h"
#include "engine/model/event_memory.h"
#include "engine/model/force_element.h"
#include "engine/model/joint_coordinate.h"
#include "engine/model/motion_law.h"
#include "models/fmu/exchange_equations_internal.h"

namespace lithe {

/// What the numbers of an FMU for model exchange are in a scene: inputs read coordinates and functions of time, outputs
/// push coordinates. Markers: those of the coordinates, two each, then the points of the FirstOrderStates.
struct FmuWires {
  struct In {
    int place;       // in u
    int coordinate;  // -1: the law
    bool rate;       // of the coordinate
    MotionLaw law;
  };
  struct Out {
    int place;  // in y
    int coordinate;
    double by_value = 0, by_rate = 0;  // ∂y by its own coordinate, at the start
  };
  /// What one element acts on where the FMU has more markers or outputs than one element may: at most kMaxMarkers
  /// markers by at most kMaxRows rows.
  struct Part {
    std::vector<int> outputs{};      // places among `outputs`
    std::vector<int> coordinates{};  // that these push
    int first_state = 0, states = 0;
  };
  CoordinateSet coordinates;
  std::vector<In> inputs;
  std::vector<Out> outputs;
  int points = 1;

  int marker_count() const { return 2 * coordinates.count() + points; }
  /// Empty: one element has room for all.
  std::vector<Part> parts(int states) const;
  void read(double time, std::span<const MarkerView> markers, const AngleMemory& memory, VectorX& z, VectorX& u) const;
  /// `rates`: ż, then y. What an output owes to its own coordinate at the start is a compliant row, which Newton's
  /// matrix has for flexible bodies too; the rest of it a load.
  void act(std::span<const MarkerView> markers, const VectorX& rates, int states, ForceRows& rows) const;
  /// All by rows, those of a part.
  void act(const Part& part, std::span<const MarkerView> markers, const VectorX& rates, int states,
           ForceRows& rows) const;
};

/// Such an FMU as a force element: the derivatives of its states are forces on the points, its outputs forces and
/// torques on coordinates, a row each. One with many markers is several elements, each of which reads all markers and
/// acts on a part of them; the first has the equations.
class FmuForce final : public ForceElement, public EventMemory, public CoupledMarkers {
 public:
  struct Parameters {
    std::unique_ptr<ExchangeEquations> equations{};  // null: those of `first`
    const FmuForce* first = nullptr;
    FmuWires wires;
    std::optional<FmuWires::Part> part{};  // none: it acts on all
  };
  explicit FmuForce(Parameters parameters) : p_(std::move(parameters)) {}

  ExchangeEquations& equations() const { return p_.first ? p_.first->equations() : *p_.equations; }
  const FmuWires& wires() const { return p_.wires; }
  bool is_whole() const { return !p_.part; }
  bool is_first() const { return !p_.first; }
  int marker_count() const override { return p_.wires.marker_count(); }
  int row_count() const override {
    return static_cast<int>(is_whole() ? p_.wires.outputs.size() : p_.part->outputs.size()) +
           (is_whole() ? 0 : p_.part->states);
  }
  std::vector<MeasuredAngle> angles() const override { return p_.wires.coordinates.angles(); }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  void set_as_drawn(bool drawn) const override;

 private:
  const Parameters p_;
};

/// Its tangent is that of the FMU's equations made linear, which costs the FMU one Jacobian and no differences over
/// the motions of markers.
template <>
std::unique_ptr<ForceBatch> make_force_batch<FmuForce>();

}  // namespace lithe
