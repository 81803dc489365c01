#pragma once

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "bodies/flexible/elements/meshes.h"
#include "bodies/flexible/flexible_body.h"
#include "engine/base/rotations.h"
#include "engine/observe/observer.h"
#include "joints/revolute_joint.h"
#include "tests/engine/output/output_scratch_folder.h"
#include "tests/support/json_file.h"

/// Pages read back as a viewer reads them, and a scene to show.
namespace lithe::test::page {

using Json = nlohmann::json;

/// The two data elements of a page: JSON, and the bytes of its arrays.
struct Page {
  Json scene;
  std::string bytes;

  explicit Page(const std::string& path) {
    const std::string html = file_text(path);
    const auto element = [&](const std::string& opening) {
      const std::size_t from = html.find(opening) + opening.size();
      return html.substr(from, html.find("</script>", from) - from);
    };
    scene = parse_json(element("<script type=\"application/json\" id=\"lithe-scene\">"));
    const std::string packed = from_base64(element("<script type=\"text/plain\" id=\"lithe-data\">"));
    for (uLongf size = 1 << 20;; size *= 2) {
      bytes.resize(size);
      const int result = uncompress(reinterpret_cast<Bytef*>(bytes.data()), &size,
                                    reinterpret_cast<const Bytef*>(packed.data()), packed.size());
      if (result == Z_BUF_ERROR) continue;
      EXPECT_EQ(result, Z_OK);
      bytes.resize(size);
      return;
    }
  }
  static std::string from_base64(const std::string& text) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    unsigned bits = 0, count = 0;
    for (char c : text) {
      const std::size_t digit = digits.find(c);
      if (digit == std::string::npos) continue;
      bits = bits << 6 | static_cast<unsigned>(digit);
      if ((count += 6) >= 8) out += static_cast<char>(bits >> (count -= 8) & 255);
    }
    return out;
  }
  template <class Stored>
  VectorX values(const Json& reference) const {
    const auto at = reference.at("at").get<std::size_t>(), n = reference.at("n").get<std::size_t>();
    EXPECT_EQ(at % 8, 0u);
    EXPECT_LE(at + n * sizeof(Stored), bytes.size());
    std::vector<Stored> stored(n);
    std::memcpy(stored.data(), bytes.data() + at, n * sizeof(Stored));
    VectorX values(static_cast<Eigen::Index>(n));
    for (std::size_t i = 0; i < n; ++i) values[static_cast<Eigen::Index>(i)] = static_cast<double>(stored[i]);
    if (reference.contains("scale")) {  // one for each column
      const auto scale = reference.at("scale").get<std::vector<double>>();
      const auto rows = values.size() / static_cast<Eigen::Index>(scale.size());
      for (Eigen::Index i = 0; i < values.size(); ++i) values[i] *= scale[static_cast<std::size_t>(i / rows)];
    }
    return values;
  }
  /// `rows` numbers of frame after frame, point after point.
  MatrixX array(const Json& reference, Eigen::Index rows) const {
    const std::string type = reference.at("type");
    const VectorX all = type == "f64"   ? values<double>(reference)
                        : type == "f32" ? values<float>(reference)
                        : type == "u32" ? values<std::uint32_t>(reference)
                        : type == "u16" ? values<std::uint16_t>(reference)
                                        : values<std::int16_t>(reference);
    return all.reshaped(rows, rows > 0 ? all.size() / rows : 0);
  }
  const Json& body(const std::string& name, std::size_t run = 0) const {
    for (const Json& body : scene.at("runs").at(run).at("bodies"))
      if (body.at("name") == name) return body;
    throw std::out_of_range(name);
  }
  const Json& connector(const std::string& name) const {
    for (const Json& connector : scene.at("runs").at(0).at("connectors"))
      if (connector.at("name") == name) return connector;
    throw std::out_of_range(name);
  }
  VectorX channel(const std::string& name, std::size_t run = 0) const {
    for (const Json& channel : scene.at("runs").at(run).at("channels"))
      if (channel.at("name") == name) return array(channel.at("values"), 1).transpose();
    throw std::out_of_range(name);
  }
  /// Points of a body's mesh in world axes, 3 x n, as the viewer places them.
  Matrix3X mesh_points(const Json& body, Eigen::Index frame) const {
    const Json& mesh = body.at("mesh");
    const auto modes = static_cast<Eigen::Index>(mesh.at("modes").size());
    MatrixX points = array(mesh.at("points"), 3);
    const Eigen::Index numbers = points.size();
    const VectorX eta = modes > 0 ? VectorX(array(mesh.at("coordinates"), modes).col(frame)) : VectorX();
    VectorX moved = points.reshaped();
    if (modes > 0) moved += array(mesh.at("shapes"), numbers) * eta;
    if (mesh.at("pairs").is_object()) {
      const MatrixX ij = array(mesh.at("pairs").at("ij"), 2), shapes = array(mesh.at("pairs").at("shapes"), numbers);
      for (Eigen::Index p = 0; p < ij.cols(); ++p)
        moved += eta[static_cast<Eigen::Index>(ij(0, p))] * eta[static_cast<Eigen::Index>(ij(1, p))] * shapes.col(p);
    }
    const Vector3 at = array(body.at("position"), 3).col(frame);
    const Vector4 turned = array(body.at("rotation"), 4).col(frame);
    return (rotation_matrix(turned) * moved.reshaped(3, points.cols())).colwise() + at;
  }
};

/// Keeps the states that a run is told of.
class States final : public Observer {
 public:
  void observe(Snapshot& now) override { all.push_back(now.state()); }
  std::vector<State> all;
};

/// A slender rod that hangs from a hinge and bends far.
struct RodScene {
  SystemGraph graph;
  FlexibleBody* rod;
  RevoluteJoint* pin;
  Marker tip;

  explicit RodScene(Deflection deflection, int modes = 6) {
    const FiniteElementModel model =
        brick_mesh({.size = {0.5, 0.01, 0.01}, .divisions = {6, 1, 1}, .type = "C3D20", .material = {2e8, 0.3, 1000}});
    const std::vector<int>& root = model.node_set("x_min");
    rod = &graph.add<FlexibleBody>(
        "rod", {.basis = make_basis(model, HingeFrame{{root[0], root[1]}}, modes, {.deflection = deflection}),
                .position = {0.1, 0.2, 0.3},
                .orientation = rotation_about({1, 2, 3}, 0.4)});
    const Matrix3 turned = rod->parameters().orientation;
    const Marker held = rod->average({root[0], root[1]}, hinge_axes(model, root));
    Vector3 middle = Vector3::Zero();
    for (int i : {0, 1}) middle += model.nodes.col(model.node_index(root[static_cast<std::size_t>(i)])) / 2;
    pin = &graph.add<RevoluteJoint>(
        "pin",
        {graph.ground().marker(Vector3(0.1, 0.2, 0.3) + turned * middle, turned * hinge_axes(model, root)), held});
    tip = rod->node(model.node_set("x_max").front());
  }
  static Matrix3 hinge_axes(const FiniteElementModel& model, const std::vector<int>& root) {
    const Vector3 along = model.nodes.col(model.node_index(root[1])) - model.nodes.col(model.node_index(root[0]));
    return axes_along(along);
  }
};

/// What is wrong, by the error that `fault` throws.
template <class Fault>
std::string told(Fault&& fault) {
  try {
    fault();
  } catch (const Error& error) {
    EXPECT_FALSE(error.where().empty()) << error.what();
    EXPECT_FALSE(error.fix().empty()) << error.what();
    return error.problem();
  }
  return "nothing";
}

}  // namespace lithe::test::page
