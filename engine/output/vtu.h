#pragma once

#include <string>
#include <vector>

#include "engine/base/math.h"

namespace lithe {

/// Elements of one type, in CalculiX/Abaqus naming and node order: C3D4, C3D6, C3D8 (I, R), C3D10, C3D20 (R), S3, B31.
///
/// Node orders against VTK's: C3D4, C3D8, C3D10 and C3D20 agree (C3D20: corners, bottom edges, top edges, vertical
/// edges, as in VTK_QUADRATIC_HEXAHEDRON). C3D6 does not: the first triangle of VTK_WEDGE looks outwards, so nodes 2
/// and 3, 5 and 6 are exchanged on writing.
struct VtuCells {
  std::string element_type;
  std::vector<std::vector<int>> connectivity;  // column of `points`, from 0, for each node of each element
};

/// A value at each point. Three components are a vector, six a symmetric tensor in VTK's order xx, yy, zz, xy, yz, xz.
struct VtuField {
  std::string name;
  MatrixX values;  // components x points
};

/// Writes one picture of a mesh for ParaView: VTK's XML unstructured grid, base64 inside.
/// `points` is 3 x n, metres, world axes. Without cells each point becomes a vertex, so that it can still be seen.
/// Throws SceneError for an unknown element type, a wrong node count or index, a field that does not fit the points;
/// FileError if the file cannot be written. The file appears under its name only when complete.
void write_vtu(const std::string& path, const Matrix3X& points, const std::vector<VtuCells>& cells,
               const std::vector<VtuField>& fields);

/// An animation for ParaView: frames name_0000.vtu, name_0001.vtu … and name.pvd, which lists their times. The .pvd is
/// rewritten after each frame, so a killed run leaves a series that opens.
class PvdSeries {
 public:
  explicit PvdSeries(std::string path_without_extension) : path_(std::move(path_without_extension)) {}

  /// Writes the next frame; `time` in seconds must increase, or SceneError is thrown. The rest as in write_vtu().
  void add(double time, const Matrix3X& points, const std::vector<VtuCells>& cells,
           const std::vector<VtuField>& fields);
  int frame_count() const { return static_cast<int>(times_.size()); }

 private:
  std::string frame_path(int frame) const;
  void write_index() const;

  std::string path_;
  std::vector<double> times_;
};

}  // namespace lithe
