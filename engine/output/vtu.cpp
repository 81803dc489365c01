#include "engine/output/vtu.h"

#include <bit>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <span>
#include <string_view>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/output/partial_file.h"

namespace lithe {

namespace {

static_assert(std::endian::native == std::endian::little, "the file says byte_order=\"LittleEndian\"");

struct CellType {
  std::uint8_t vtk_type;
  int node_count;
};

constexpr CellType kVertex{1, 1};
constexpr std::uint8_t kVtkWedge = 13;

const std::map<std::string, CellType, std::less<>>& cell_types() {
  static const std::map<std::string, CellType, std::less<>> types = {
      {"C3D4", {10, 4}},   {"C3D6", {kVtkWedge, 6}}, {"C3D8", {12, 8}},    {"C3D8I", {12, 8}}, {"C3D8R", {12, 8}},
      {"C3D10", {24, 10}}, {"C3D20", {25, 20}},      {"C3D20R", {25, 20}}, {"S3", {5, 3}},     {"B31", {3, 2}}};
  return types;
}

CellType cell_type(const std::string& element_type, const std::string& path) {
  if (const auto found = cell_types().find(element_type); found != cell_types().end()) return found->second;
  std::string known;
  for (const auto& [name, type] : cell_types()) known += (known.empty() ? "" : ", ") + name;
  throw SceneError("element type '" + element_type + "' cannot be written as a VTU cell.", path,
                   "known are " + known + ".");
}

// The arrays of <Cells>: all connectivity in one row, where each cell ends in it, and what each cell is.
struct CellArrays {
  std::vector<std::int64_t> connectivity, offsets;
  std::vector<std::uint8_t> types;

  void add(CellType type, std::span<const int> nodes) {
    static constexpr int kWedgeOrder[] = {0, 2, 1, 3, 5, 4};
    for (std::size_t i = 0; i < nodes.size(); ++i)
      connectivity.push_back(nodes[type.vtk_type == kVtkWedge ? static_cast<std::size_t>(kWedgeOrder[i]) : i]);
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    types.push_back(type.vtk_type);
  }
};

void require_nodes(const VtuCells& cells, const std::vector<int>& nodes, CellType type, Eigen::Index point_count,
                   const std::string& path) {
  if (static_cast<int>(nodes.size()) != type.node_count)
    throw SceneError("a " + cells.element_type + " element has " + std::to_string(nodes.size()) + " nodes.", path,
                     "give " + std::to_string(type.node_count) + " node indices.");
  for (const int node : nodes)
    if (node < 0 || node >= point_count)
      throw SceneError("a " + cells.element_type + " element names point " + std::to_string(node) + ".", path,
                       "indices go from 0 to " + std::to_string(point_count - 1) + ": give indices, not node labels.");
}

CellArrays cell_arrays(const std::vector<VtuCells>& cells, Eigen::Index point_count, const std::string& path) {
  CellArrays arrays;
  for (const auto& block : cells) {
    const CellType type = cell_type(block.element_type, path);
    for (const auto& nodes : block.connectivity) {
      require_nodes(block, nodes, type, point_count, path);
      arrays.add(type, nodes);
    }
  }
  if (arrays.types.empty())
    for (int point = 0; point < point_count; ++point) arrays.add(kVertex, {&point, 1});
  return arrays;
}

std::string base64(std::string_view bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) -> unsigned {
      return i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0;
    };
    const unsigned triple = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (const int shift : {18, 12, 6, 0}) text += kDigits[triple >> shift & 63];
  }
  // The last group says with '=' how many of its three bytes are not there.
  for (std::size_t k = 0; k < (3 - bytes.size() % 3) % 3; ++k) text[text.size() - 1 - k] = '=';
  return text;
}

std::string escaped(const std::string& name) {
  std::string text;
  for (const char c : name) switch (c) {
      case '&':
        text += "&amp;";
        break;
      case '<':
        text += "&lt;";
        break;
      case '>':
        text += "&gt;";
        break;
      case '"':
        text += "&quot;";
        break;
      default:
        text += c;
    }
  return text;
}

constexpr const char* type_name(double) { return "Float64"; }
constexpr const char* type_name(std::int64_t) { return "Int64"; }
constexpr const char* type_name(std::uint8_t) { return "UInt8"; }

// An array is its size in bytes as UInt64 and its values, encoded together.
template <class T>
void write_array(std::ostream& out, const std::string& name, Eigen::Index components, const T* values,
                 std::size_t count) {
  const std::uint64_t size = count * sizeof(T);
  std::string bytes(reinterpret_cast<const char*>(&size), sizeof(size));
  bytes.append(reinterpret_cast<const char*>(values), size);
  out << "<DataArray type=\"" << type_name(T{}) << "\" Name=\"" << escaped(name) << "\" NumberOfComponents=\""
      << components << "\" format=\"binary\">" << base64(bytes) << "</DataArray>\n";
}

}  // namespace

void write_vtu(const std::string& path, const Matrix3X& points, const std::vector<VtuCells>& cells,
               const std::vector<VtuField>& fields) try {
  for (const auto& field : fields)
    if (field.values.cols() != points.cols() || field.values.rows() == 0)
      throw SceneError("field '" + field.name + "' is " + std::to_string(field.values.rows()) + " x " +
                           std::to_string(field.values.cols()) + ".",
                       path, "give components x points, here with " + std::to_string(points.cols()) + " columns.");
  const CellArrays arrays = cell_arrays(cells, points.cols(), path);

  PartialFile file(path);
  std::ostream& out = file.stream();
  out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
         "header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\""
      << points.cols() << "\" NumberOfCells=\"" << arrays.types.size() << "\">\n<Points>\n";
  // Eigen's columns are points, so memory already lies as VTK reads it: x, y, z of the first point, then the next.
  write_array(out, "Points", 3, points.data(), static_cast<std::size_t>(points.size()));
  out << "</Points>\n<Cells>\n";
  write_array(out, "connectivity", 1, arrays.connectivity.data(), arrays.connectivity.size());
  write_array(out, "offsets", 1, arrays.offsets.data(), arrays.offsets.size());
  write_array(out, "types", 1, arrays.types.data(), arrays.types.size());
  out << "</Cells>\n<PointData>\n";
  for (const auto& field : fields)
    write_array(out, field.name, field.values.rows(), field.values.data(),
                static_cast<std::size_t>(field.values.size()));
  out << "</PointData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  file.commit();
} catch (...) {
  rethrow_as_error("writing the file", path, "see what it says; an older file of that name is unharmed");
}

void PvdSeries::add(double time, const Matrix3X& points, const std::vector<VtuCells>& cells,
                    const std::vector<VtuField>& fields) {
  if (!times_.empty() && !(time > times_.back()))
    throw SceneError(
        "a frame at t = " + std::to_string(time) + " s follows one at t = " + std::to_string(times_.back()) + " s.",
        path_ + ".pvd", "add frames in the order of time, each time once.");
  write_vtu(frame_path(frame_count()), points, cells, fields);
  times_.push_back(time);
  write_index();
}

std::string PvdSeries::frame_path(int frame) const {
  char number[16];
  std::snprintf(number, sizeof(number), "_%04d.vtu", frame);
  return path_ + number;
}

void PvdSeries::write_index() const {
  PartialFile file(path_ + ".pvd");
  std::ostream& out = file.stream();
  out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
         "byte_order=\"LittleEndian\">\n<Collection>\n";
  for (int frame = 0; frame < frame_count(); ++frame) {
    std::string time;
    append_number(time, times_[static_cast<std::size_t>(frame)]);
    // Names without their folder: the series can be moved as a whole.
    const std::string name = std::filesystem::path(frame_path(frame)).filename().string();
    out << "<DataSet timestep=\"" << time << "\" part=\"0\" file=\"" << escaped(name) << "\"/>\n";
  }
  out << "</Collection>\n</VTKFile>\n";
  file.commit();
}

}  // namespace lithe
