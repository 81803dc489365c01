#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/model/motion_law.h"
#include "engine/motion/integrator.h"
#include "engine/observe/sensors.h"
#include "engine/output/table.h"
#include "tools/certify/elastic_part.h"

namespace lithe::certify {

/// A scene on which what solve() states is held against what is so. Watched quantities are small in number and named;
/// instants are evenly spaced, the first at t = 0.
struct Scene {
  std::string name, shows;  // a line
  double duration = 1;      // s
  int samples = 50;         // instants after t = 0
  Vector3 gravity{0, 0, -9.81};
  /// Adds bodies, joints and forces, elastic parts by `parts`, and returns what is watched.
  std::function<std::vector<Sensor>(SystemGraph&, ElasticParts&)> draw;
  /// Columns t and those of the sensors, at the instants: of nonlinear finite elements; empty: as references/NAME.csv,
  /// made by reference.cpp.
  std::function<Table()> known{};
  bool linear_reference = false;  // of a body that no bricks make: of many more modes instead
  int beam_elements = 0;          // its elastic parts are beams: of the finer of two references; 0: it has none
  bool is_long = false;           // about a hundred swings: what choosing costs beside the run is counted
  bool seen = true;               // of the half that factors of caution are set on, else of that they are judged on
};

/// All of them, in order; by turns of the half that is seen and of the other.
std::vector<Scene> scenes();
/// Throws SceneError listing the known ones.
Scene find_scene(const std::string& name);

/// What is known of the scene: `known`, or references/NAME.csv. Throws FileError for a reference not made yet.
Table reference_of(const Scene& scene);

struct Sampled;
/// As scenes are run for their references: nonlinear finite elements, exact beams, or many more modes. `finer`: of two.
Sampled run_for_reference(const Scene& scene, Integrator& integrator, bool finer);

/// Samples of a run: columns t and those of the sensors.
struct Sampled {
  Table table;
  std::vector<Sensor> watched;
  int coordinates = 0;  // velocities of the system
  double cpu = 0;       // s, of assembling and stepping
};
/// Draws a scene and runs it.
Sampled run(const Scene& scene, ElasticParts& parts, Integrator& integrator);

/// Largest deviation of each watched quantity (Euclidean norm of its columns) over the instants, as a part of its
/// largest change in `reference`.
std::vector<double> deviations(const std::vector<Sensor>& watched, const Table& table, const Table& reference);

// Groups of scenes, a file each.
void add_pendulums(std::vector<Scene>& scenes);
void add_mechanisms(std::vector<Scene>& scenes);
void add_robots(std::vector<Scene>& scenes);
void add_flights(std::vector<Scene>& scenes);
void add_structures(std::vector<Scene>& scenes);
void add_beams(std::vector<Scene>& scenes);
void add_contacts(std::vector<Scene>& scenes);
void add_long_runs(std::vector<Scene>& scenes);
void add_large_and_weak(std::vector<Scene>& scenes);

// ---- what several of them need ----

/// From rest to a constant rate between t = 0 and `time`, with continuous acceleration; rad/s or m/s.
MotionLaw run_up(double rate, double time);
/// sin² between two times, 0 elsewhere: 1 at the middle.
double pulse(double time, double begin, double end);
/// Place of a marker in the axes of another, m.
Sensor relative_position(Marker marker, Marker seen_from, const std::string& name);
/// How far a marker lies off the straight line between two others, in the axes of the first, m.
Sensor deflection_between(Marker middle, Marker first, Marker last, const std::string& name);
/// Direction of a marker's x axis, world axes.
Sensor pointing(Marker marker, const std::string& name);

}  // namespace lithe::certify
