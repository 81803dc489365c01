#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/math.h"
#include "engine/model/appearance.h"
#include "engine/observe/event.h"
#include "engine/page/page.h"

namespace lithe {

/// A run as it is kept, in memory or a file: JSON as tools/viewer/README.md describes a run, but with arrays by name,
///   {"set": name, "as": type}: a matrix that stays the same, column by column;
///   {"row": first, "width": n, "as": type}: a part of every row;
/// and the mesh of a body without modes with "nodal": the displaced points, to which shapes are fitted on writing.
struct RunRecord {
  static constexpr int kVersion = 1;
  std::string name;
  std::string scene;
  std::map<std::string, MatrixX> sets;
  int width = 1;                 // of a row
  std::vector<double> rows;      // row[0]: time, s
  std::vector<double> contacts;  // kContactWidth a point: number of the row, connector, point (m), force (N)
  std::vector<EventRecord> events;
  static constexpr int kContactWidth = 8, kMostColumns = 100'000'000;

  int row_count() const { return static_cast<int>(rows.size() / static_cast<std::size_t>(width)); }
};

/// Describes a scene once, and fills rows of its states.
class SceneRecorder {
 public:
  struct Drawn {
    const Body* body;
    DrawnShape shape;
  };
  /// Fills the record's scene, sets and width. `now` is the first state.
  SceneRecorder(Snapshot& now, const std::vector<Sensor>& sensors, const RunOptions& options,
                const std::vector<Drawn>& drawn, RunRecord& record);
  ~SceneRecorder();
  /// Throws SimulationError for a value that is not finite.
  void fill(Snapshot& now, int number, VectorX& row, std::vector<double>& contacts);
  /// Number of a body, and its mesh. SceneError for one that draws none.
  std::pair<int, const DrawnMesh&> mesh_of(const Body& body) const;

 private:
  std::unique_ptr<struct ScenePlan> plan_;
};

/// A field at the points of the mesh of body number `body`, into the scene and the sets.
struct PlacedField {
  int body;
  std::string name, unit;
  MatrixX values;  // 1 x points
};
void add_field(RunRecord& record, const PlacedField& field);

/// The default drawing of a body: sticks to its markers (body axes, m), else the box of its inertia, no
/// larger than fits a scene of that extent (m).
std::vector<DrawnShape> inferred_shapes(const Body& body, const std::vector<Vector3>& markers, double extent);

/// The HDF5 file of a run: engine/page/run_file.cpp.
class RunFile {
 public:
  /// Writes scene and sets; rows may follow.
  RunFile(const std::string& path, const RunRecord& record);
  ~RunFile();
  void append(const VectorX& row, const std::vector<double>& contacts);
  void append(const std::vector<EventRecord>& events);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};
RunRecord read_run_file(const std::string& path);
/// Throws SceneError for a channel that the run does not have.
std::vector<double> channel_of(const RunRecord& record, const Located& name);

/// Rotation and translation that move `from` onto `to` best (least squares; Horn 1987): to ≈ R from + t.
struct BestFit {
  Matrix3 rotation;
  Vector3 translation;
};
BestFit best_fit(const Matrix3X& from, const Matrix3X& to);

/// Displacements (a column a frame) as combinations of few shapes: every entry is met to `tolerance`.
struct FittedShapes {
  MatrixX shapes;       // rows x k
  MatrixX coordinates;  // k x frames
};
FittedShapes fit_shapes(const MatrixX& displacements, double tolerance);

/// Runs as one page. A live one has one run, which goes on (LiveRun): its arrays tell which part of a row they are of
/// (tools/viewer/README.md), and nothing is left out or rounded by the motion so far. `where`: for errors.
enum class PageKind { finished, live };
std::string page_text(const std::vector<const RunRecord*>& runs, const PageOptions& options, const std::string& where,
                      PageKind kind = PageKind::finished);

/// The whole page around the data: tools/viewer/dist/viewer.html, as it was when the library was built.
std::string_view viewer_template();

/// zlib's deflate of bytes, as base64.
std::string packed_text(const std::string& bytes);

}  // namespace lithe
