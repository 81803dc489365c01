#pragma once

#include <functional>
#include <initializer_list>

#include "engine/assembly/evaluator.h"
#include "engine/motion/integrator.h"

/// Classical scenes, assembled and ready to move.
namespace lithe::test {

/// A graph, its system, its equations and a state: stays where it is made.
class Scene {
 public:
  Scene(const Vector3& gravity, const std::function<void(SystemGraph&)>& draw);
  ~Scene();
  Scene(const Scene&) = delete;

  /// The state as drawn, until `integrator` moves it to time t; it is started when time has not moved yet.
  void run(Integrator& integrator, double t);

  double energy();
  /// Largest |g|, or |ġ| at Level::velocity.
  double violation(Level level);
  Vector3 position(int body) const;

  SystemGraph graph;
  System system;
  Evaluator equations;
  State state;

 private:
  bool started_ = false;
};

/// Point masses of 1 kg, each 1 m from the one before (the first from the origin) at the given angles from the downward
/// vertical, in the plane z = 0; at rest; gravity along -y.
Scene mass_chain(std::initializer_list<double> angles);

/// Box links of 0.25 m, straight along +x from the origin, gravity along -z. Spherical joints, the whole turning about
/// z at 1 rad/s; or revolute ones with axes (0, 1, 0) and (0, 1, 1) in turn, at rest.
Scene box_chain(int links, bool revolute);

/// Far end of link `i` (1, 2, …) of box_chain; the origin for 0.
Vector3 link_end(const Scene& chain, int i);

/// Symmetric top on a fixed point, its axis y starting horizontal, centre of mass at `length` along it.
Scene heavy_top(double mass, double length, double across, double axial, const Vector3& omega);

/// A free body without gravity.
Scene free_body(const Vector3& inertia, const Vector3& omega);

}  // namespace lithe::test
