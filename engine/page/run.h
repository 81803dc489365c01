#pragma once

#include <memory>
#include <source_location>
#include <string>
#include <vector>

#include "engine/model/appearance.h"
#include "engine/observe/event.h"
#include "engine/observe/observer.h"
#include "engine/observe/sensors.h"

namespace lithe {

struct RunRecord;

/// What a Run records in addition to the motion of all bodies and its sensors.
struct RunOptions {
  std::string name = "run";  // of the variant, as the page shows it
  bool coordinates = true;   // q and v of each body as charts
  bool reactions = true;     // of joints and force elements
  bool residuals = true;     // |g| and |G v + ∂g/∂t|, of each joint and the largest
  bool energies = true;      // of each body and the sums
  bool contacts = true;      // points and forces
  bool stress = true;        // of flexible bodies that can recover it
  int detailed = 100;        // bodies and connectors, in the order drawn, that have charts; those beyond only move
};

/// A quantity at the nodes of a body that stays the same over a run, such as the damage of a FatigueRecorder.
struct MeshField {
  std::string name{};
  std::string unit{};  // empty: none
  VectorX values{};    // one a node, by index
};

/// How Run::follow() shows a run while it goes on.
struct FollowOptions {
  int port = 0;       // of 127.0.0.1; 0: any that is free
  double speed = 0;   // simulated seconds a second, while somebody looks; 0: as fast as possible. The page changes it
  double wait = 0;    // s, at the first state, for a browser to open the page
  double ramp = 0.5;  // s of the run in which an input between samples `linear` or `smooth` gets to what the page asks
  std::size_t kept = 256'000'000;  // bytes of states for the page; beyond them every second one is left out there
};

/// A recorded simulation for viewing: as one page (write_page, engine/page/page.h), or from a file by
/// `lithe view`.
///   Run run{system, {position(tip, "tip")}, {.name = "flexible"}};
///   simulation.observe(run, every(0.02));
///   simulation.run(state, 10);
///   write_page(run, "pendulum.html");
/// The motion of flexible bodies is kept as modal coordinates, that of bodies with full nodal coordinates as the points
/// of their surface. Position sensors of markers give traces. It needs the system until its first state, and the
/// scene's bodies as long as it receives states; afterwards it is independent.
class Run final : public Observer {
 public:
  explicit Run(const System& system, std::vector<Sensor> sensors = {}, RunOptions options = {},
               std::source_location where = std::source_location::current());
  Run(const System&& system, std::vector<Sensor> sensors = {}, RunOptions options = {}) = delete;
  Run(Run&& other) noexcept;
  Run& operator=(Run&& other) noexcept;
  ~Run() override;

  /// A shape to draw on a body, in the axes of its frame (a rigid body's at its centre of mass). Bodies without any
  /// are drawn by their mesh, the shapes of their contacts, or sticks between their markers. Throws SceneError after
  /// the first state, and for a body of another scene.
  void draw(const Body& body, DrawnShape shape);
  /// Writes the run into an HDF5 file as it comes, instead of keeping it: the file holds every observed state,
  /// even if the run is killed at any moment (engine/output/hdf5_series.h). Throws SceneError after the first state,
  /// FileError if it cannot be written.
  void stream(const std::string& path);
  /// Shows the run in a browser while it goes on: at the address that it returns and prints, on this machine alone.
  /// The page pauses the run, goes from state to state, ends it (simulation.stopped_by() names the page) and sets
  /// inputs of the scene, all at the states that this run observes: results are, bit for bit, those of the run that
  /// nobody looks at, unless an input is moved. A run that is paused goes on when all browsers have left for five
  /// seconds. Called again it returns the address. See docs/page.md. Throws SceneError after the first state and for
  /// options out of range, FileError for a port that cannot be had.
  std::string follow(const FollowOptions& options = {}, std::source_location where = std::source_location::current());
  /// `lithe view --follow` sets this variable of the environment to a port: then every run is followed, in real time,
  /// from when a browser is there.
  static constexpr const char* kFollowVariable = "LITHE_FOLLOW";
  /// The events of the run: run.add(simulation.events()), once, after the run.
  void add(const std::vector<EventRecord>& events);
  /// A colour that the page offers for the mesh of a body, beside displacement and stress: run.add(shaft, {"damage",
  /// "", values}), after the run. Throws SceneError before the first state, for a body that draws no mesh, fewer values
  /// than nodes, and one that is not finite.
  void add(const Body& body, const MeshField& field);

  /// Throws SimulationError, the state not kept, for a value that is not finite; SceneError for the state of
  /// another system.
  void observe(Snapshot& snapshot) override;

  int frame_count() const;
  const std::string& name() const;

  /// What a chart of the page shows, one number a state ("t": the times). Throws SceneError that lists the known names.
  std::vector<double> channel(const Located& name) const;

  /// A file that stream() wrote, of a run that ended or was killed. Throws FileError for a file that is not a run file,
  /// is truncated, or has another version of the format. A name given replaces the one in the file.
  static Run read(const std::string& path, const std::string& name = "");

  /// For write_page: what was recorded; read back if it went to a file.
  std::shared_ptr<const RunRecord> record() const;

 private:
  struct Parts;
  void follow_as_asked(const std::string& port);
  explicit Run(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace lithe
