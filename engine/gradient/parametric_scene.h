#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/motion/make_integrator.h"
#include "engine/observe/event.h"
#include "engine/observe/sensors.h"
#include "engine/study/sweep.h"

namespace lithe {

/// An event of a parametric scene: where a column of its sensors passes a level, the state changes and the method
/// starts anew.
struct ParametricEvent {
  std::string name;
  Located column;
  double level = 0;
  Event::Direction direction = Event::Direction::both;
  /// Of the state at the event; it may depend on the parameters. Positions and velocities are moved onto the joints
  /// afterwards. Smooth, of small changes of the state.
  std::function<void(State&, const SweepPoint&)> change = {};
};

/// A scene as a function of named parameters: it is drawn afresh for every set of values, into a graph of its own.
/// Whatever the drawing makes of `point["mass"]` is a parameter: inertias, places of markers, laws of forces and
/// motions, initial states, sections, the modulus of a finite-element model before its reduction. The parameters may
/// not change which elements there are.
struct ParametricScene {
  std::string name;
  double duration = 1;           // s, from t = 0
  Vector3 gravity{0, 0, -9.81};  // m/s², world axes
  /// Adds bodies, joints and forces and says which quantities may be wanted.
  std::function<std::vector<Sensor>(SystemGraph&, const SweepPoint&)> draw;
  MakeIntegrator integrator;     // not needed for what is wanted at rest
  bool forward_dynamics = true;  // AssembleOptions: explicit methods have an adjoint where it is off
  std::vector<ParametricEvent> events = {};
};

/// A named number and its value here. Derivatives compare drawings at value ± step and ± 2 step.
struct DesignParameter {
  std::string name;
  double value = 0;
  double step = 0;  // 0: a thousandth of |value|; 1e-3 where that is zero
};

/// One drawing of a parametric scene, assembled.
class Drawing {
 public:
  /// Throws SceneError: nothing to draw, nothing wanted, whatever drawing and assembling throw, with the values.
  Drawing(const ParametricScene& scene, const std::vector<DesignParameter>& parameters);
  Drawing(const Drawing&) = delete;
  Drawing& operator=(const Drawing&) = delete;

  const System& system() const { return *system_; }
  /// A column of a sensor: which sensor, and where in it. Throws SceneError that lists the known ones.
  struct Place {
    int sensor, column;
  };
  Place find(const Located& column) const;
  /// The values that it is drawn with.
  SweepPoint point() const { return SweepPoint(values_, 0); }
  const Sensor& sensor(int number) const { return sensors_[static_cast<std::size_t>(number)]; }

 private:
  Table values_;
  SystemGraph graph_;
  std::vector<Sensor> sensors_;
  std::unique_ptr<const System> system_;
};

/// The scene as drawn, not assembled.
void draw_only(const ParametricScene& scene, const std::vector<DesignParameter>& parameters,
               const std::function<void(const SystemGraph&)>& look);

/// The same parameters with offsets in steps: the k-th by `steps` times its own.
std::vector<DesignParameter> moved_parameter(std::vector<DesignParameter> parameters, int k, double steps);
/// Fills in the steps. Throws SceneError for no parameter, one without name, twice named, or values not finite.
std::vector<DesignParameter> checked_parameters(std::vector<DesignParameter> parameters);

}  // namespace lithe
