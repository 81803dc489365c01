#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/assembly/system.h"

namespace lithe {

class PlanarStandIn;

struct SimplificationOptions {
  bool weld = true;  // rigid bodies that fixed joints tie become one
  bool hold = true;  // rigid bodies that fixed joints tie to ground become ground
  /// Rigid bodies that joints alone hold in a plane keep three coordinates, and rows that say nothing there go. Not in
  /// a mechanism with friction that asks for reactions, nor in a rigid tree that is not all in one plane normal to a
  /// world axis: explicit integrators have a faster way (ForwardMethod::tree).
  bool planar = true;
};

/// A scene with fewer bodies, coordinates and rows, and the same motion. Elements that stay are shared with the scene
/// as drawn, which owns them and must outlive this; what has vanished is found by expand().
///   Simplification simple{graph};
///   const System system = assemble(simple.graph());
///   State state = simple.start(), full;
///   ...                                          // integrate
///   simple.expand(state, full);                  // for sensors: Snapshot{simple.whole(), full}
/// A fixed joint whose reaction a force element asks for stays, as does one that does not close as drawn. Find
/// equilibria and linearize with the whole scene: bodies in planes leave the stiffness of loaded joints out of Newton's
/// matrix.
class Simplification {
 public:
  /// Assembles the whole. Throws SceneError as assemble() does.
  explicit Simplification(SystemGraph& whole, SimplificationOptions options = {});

  SystemGraph& graph() { return *graph_; }
  const System& whole() const { return whole_; }
  /// Whether anything has gone: else graph() has the bodies and rows of the whole.
  bool smaller() const { return smaller_; }

  /// The smaller system's state where the whole starts.
  State start() const { return reduce(whole_.initial_state()); }
  /// Coordinates, velocities, accelerations and turns of the whole. Where rows have gone, without lambda:
  /// Snapshot::found_multipliers() finds it. Throws SceneError for a state of another system, as does reduce().
  void expand(const State& small, State& whole) const;
  /// The other way, from a state that meets the constraints of the whole.
  State reduce(const State& whole) const;

  /// What was done, a line each: "'bracket' and 'motor' are one body with 'arm': welded by 'bolt'." Also logged.
  std::string report() const;

 private:
  friend class Simplifier;
  struct Piece {  // a rigid body of the whole, in a stand-in
    int q, v;
    Vector3 at;      // in the axes of the stand-in's frame
    Vector4 turned;  // its axes to those
  };
  struct Moved {
    int q, v;                     // of the stand-in
    const PlanarStandIn* planar;  // null: it has a frame
    Vector4 reference;            // of a planar one, at θ = 0
    std::vector<Piece> pieces;
  };
  struct Copied {  // a slice that both have
    int whole, small, count;
  };
  struct Motion;
  Motion motion(const Moved& moved, const State& small) const;

  System whole_;
  std::unique_ptr<SystemGraph> graph_;
  std::vector<std::string> report_;
  bool smaller_ = false;
  int q_count_ = 0, v_count_ = 0, angle_count_ = 0;  // of the smaller one
  VectorX still_;                                    // coordinates of the whole at its start
  std::vector<Moved> moved_;
  std::vector<Copied> q_, v_, angles_;
  std::vector<int> rows_;  // of the whole, by row of the smaller one
};

}  // namespace lithe
