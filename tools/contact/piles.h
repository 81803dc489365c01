#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/assembly/system.h"
#include "engine/motion/make_integrator.h"

/// Scenes of many contacts, as every engine gets them, and what is measured of a run.
namespace lithe::contact_bench {

constexpr double kGravity = 9.81, kFriction = 0.5;  // no restitution
constexpr double kCube = 1, kRadius = 0.1;          // edge; of the spheres, m

/// Equal bodies that fall: cubes on one another onto a plane, or spheres into an open box of five planes.
struct Pile {
  std::string name;
  double end;  // s
  bool cubes;
  double wall;                 // half width of the box, m
  std::vector<Vector3> start;  // centres, m
  std::vector<double> mass;    // kg
  double inertia(std::size_t i) const { return mass[i] * (cubes ? kCube * kCube / 6 : 0.4 * kRadius * kRadius); }
  int count() const { return static_cast<int>(start.size()); }
};

/// Unit cubes of 1 kg with gaps of 5 cm, the top one of `top_mass`.
Pile stack(const std::string& name, int count, double top_mass, double end);
/// Spheres of 1 kg on a lattice whose places err by a twentieth of the radius.
Pile spheres(int count, double end);

/// World axes.
struct Motion {
  Vector3 position, velocity, spin;
  Matrix3 axes;
};
using Motions = std::vector<Motion>;

/// J, heights from z = 0.
double energy(const Pile& pile, const Motions& motions);
/// Deepest overlap, m: of spheres exact, of cubes by their separating axes.
double overlap(const Pile& pile, const Motions& motions);
/// Bodies whose centre is outside the box or below the floor.
int tunnelled(const Pile& pile, const Motions& motions);

/// What moves a pile by steps of one length.
class Stepper {
 public:
  virtual ~Stepper() = default;
  virtual void step() = 0;  // throws std::runtime_error if it fails
  virtual void read(Motions& motions) const = 0;
  /// Mean of the contact solver's iterations a step; 0: not known.
  virtual double iterations() const { return 0; }
};

/// Bullet as its users write it, without the engine. `direct`: Dantzig's solver, else sweeps of sequential impulses.
std::unique_ptr<Stepper> plain_bullet(const Pile& pile, double step, int sweeps, bool direct);

/// The engine, by an integrator of this step.
std::unique_ptr<Stepper> lithe_stepper(const Pile& pile, double step, const MakeIntegratorBy<const System&>& make);

/// The pile as a graph: RigidBody "body 0" ... and one Contact, "pile".
void draw(SystemGraph& graph, const Pile& pile);

}  // namespace lithe::contact_bench
