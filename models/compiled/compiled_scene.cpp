#include "models/compiled/compiled_scene.h"

#include <cctype>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "engine/base/error.h"
#include "engine/base/number_text.h"
#include "engine/model/input.h"
#include "models/compiled/tape_internal.h"
#include "models/compiled/texts_internal.h"
#include "models/compiled/tree_equations_internal.h"

namespace lithe {
namespace fs = std::filesystem;
namespace {

/// Without what a text has for this repository alone.
std::string carried(const char* text) {
  std::istringstream lines(text);
  std::string all;
  for (std::string line; std::getline(lines, line);)
    if (line != "#pragma once" && !line.starts_with("#include \"models/")) all += line + "\n";
  return all.substr(all.find_first_not_of('\n'));
}

std::string quoted(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') text += '\\';
    text += c == '\n' ? ' ' : c;
  }
  return text + "\"";
}

template <class Item, class Text>
std::string table(const std::string& type, const std::string& name, const std::vector<Item>& items, Text&& text) {
  std::string all =
      "  static constexpr std::array<" + type + ", " + std::to_string(items.size()) + "> " + name + " = {";
  for (std::size_t i = 0; i < items.size(); ++i) all += (i > 0 ? ", " : "") + text(items[i]);
  return all + "};\n";
}

struct Tables {
  std::vector<int> position_of;             // of each velocity; -1: in a quaternion
  std::vector<std::array<int, 2>> turning;  // first of a quaternion, and of its turning
};

Tables tables(const CompiledTree& tree) {
  Tables all{std::vector<int>(tree.velocity_names.size(), -1), {}};
  for (const auto& link : tree.links) {
    using Motion = CompiledTree::Motion;
    const bool free = link.motion == Motion::free;
    if (link.motion == Motion::turn || link.motion == Motion::slide) all.position_of[link.v] = link.q;
    for (int k = 0; free && k < 3; ++k) all.position_of[link.v + k] = link.q + k;
    if (free || link.motion == Motion::ball) all.turning.push_back({link.q + 3 * free, link.v + 3 * free});
  }
  return all;
}

CompiledTape::Text equations(const CompiledTree& tree) {
  CompiledTape tape;
  const auto variables = [&tape](const char* name, int count) {
    std::vector<CompiledNumber> all;
    for (int i = 0; i < count; ++i) all.push_back(tape.variable(name + ("[" + std::to_string(i) + "]")));
    return all;
  };
  const auto q = variables("q", tree.position_count()), v = variables("v", tree.velocity_count()),
             u = variables("u", tree.input_count());
  const auto v_dot = CompiledEquations<CompiledNumber>(tree).accelerations(q, v, u);
  std::vector<CompiledTape::Output> outputs;
  for (std::size_t i = 0; i < v_dot.size(); ++i) outputs.push_back({"a[" + std::to_string(i) + "]", v_dot[i]});
  return tape.write(outputs, "    ");
}

void require_name(const std::string& name) {
  bool plain = !name.empty() && !std::isdigit(static_cast<unsigned char>(name[0]));
  for (const char c : name) plain = plain && (std::isalnum(static_cast<unsigned char>(c)) || c == '_');
  if (!plain) throw SceneError("'" + name + "' is no name of C++", "lithe compile", "take letters, digits and _");
}

}  // namespace

CompiledScene CompiledScene::of(const System& system, const std::string& name, const Options& options) {
  require_name(name);
  if (!(options.right_angles_within >= 0 && options.right_angles_within <= 1e-3))
    throw SceneError("the angle within which axes are parallel is not between 0 and 1e-3 rad", "lithe compile",
                     "give what the file rounds by, as 1e-5 for 1.5708");
  const CompiledTree tree = CompiledTree::of(system, options.right_angles_within);
  if (tree.velocity_count() == 0)
    throw SceneError("nothing moves in the scene", "lithe compile", "draw a body that is not welded to ground");
  const CompiledTape::Text code = equations(tree);
  const auto [position_of, turning] = tables(tree);

  std::vector<std::string> inputs = tree.velocity_names;
  std::vector<double> start(inputs.size(), 0);
  for (const Input* input : tree.inputs) {
    inputs.push_back(input->name());
    start.push_back(input->value(0));
  }
  const std::vector<double> q(tree.q.begin(), tree.q.end()), v(tree.v.begin(), tree.v.end());
  const auto integer = [](const char* what, int value) {
    return "  static constexpr int " + std::string(what) + " = " + std::to_string(value) + ";\n";
  };
  const auto pair = [](const std::array<int, 2>& at) {
    return "std::array<int, 2>{" + std::to_string(at[0]) + ", " + std::to_string(at[1]) + "}";
  };
  const auto count = [](int i) { return std::to_string(i); };

  CompiledScene scene{.name = name, .products = code.products, .sums = code.sums};
  scene.header =
      "// " + name + ".h: the accelerations of one scene, written by `lithe compile`; edit the scene instead.\n" +
      "// " + std::to_string(code.products) + " products, " + std::to_string(code.sums) + " sums, " +
      std::to_string(code.divisions) + " divisions, " + std::to_string(code.sines) +
      " sines with cosines.\n#pragma once\n\n#ifndef LITHE_COMPILED_RUNTIME\n#define LITHE_COMPILED_RUNTIME\n" +
      carried(kCompiledRuntime) + "#endif\n\n" +
      "/// SI units. Positions q: angles and displacements of joints as the scene's joints count them, quaternions\n"
      "/// (w, x, y, z), places of free bodies. Velocities v: their rates; of a ball and a free body ω in the outer\n"
      "/// body's axes. Inputs u: an effort on each velocity (N m, N), then the scene's inputs.\n"
      "struct " +
      name + " {\n  static constexpr const char* kName = " + quoted(name) + ";\n" +
      integer("kPositions", tree.position_count()) + integer("kVelocities", tree.velocity_count()) +
      integer("kInputs", tree.input_count()) + table("const char*", "kPositionNames", tree.position_names, quoted) +
      table("const char*", "kVelocityNames", tree.velocity_names, quoted) +
      table("const char*", "kInputNames", inputs, quoted) + table("double", "kStartPositions", q, number_text) +
      table("double", "kStartVelocities", v, number_text) + table("double", "kStartInputs", start, number_text) +
      "  /// Of each velocity, the position whose rate it is; -1: it turns a quaternion.\n" +
      table("int", "kPositionOf", position_of, count) + "  /// First of a quaternion in q, and of its turning in v.\n" +
      table("std::array<int, 2>", "kQuaternions", turning, pair) +
      "\n  /// a = v̇. The arrays may not overlap.\n"
      "  template <class S>\n"
      "  static void accelerations([[maybe_unused]] const S* q, [[maybe_unused]] const S* v, const S* u, S* a) {\n"
      "    using namespace lithe_compiled;\n" +
      code.code + "  }\n};\n";
  scene.program = "// " + name + ".cpp: a program around " + name + ".h, written by `lithe compile`:\n" +
                  "//   c++ -std=c++17 -O3 -march=native -ffp-contract=off " + name + ".cpp -o " + name + " && ./" +
                  name + "\n#include \"" + name + ".h\"\n\n" + carried(kCompiledProgram) +
                  "\nint main(int count, char** words) { return lithe_compiled::program<" + name +
                  ">(count, words); }\n";
  return scene;
}

void CompiledScene::write(const std::string& folder) const {
  std::error_code failed;  // told by the file that cannot be written
  fs::create_directories(folder, failed);
  for (const auto& [suffix, text] : {std::pair{".h", &header}, {".cpp", &program}}) {
    const std::string path = (fs::path(folder) / (name + suffix)).string();
    std::ofstream file(path);
    file << *text;
    file.close();
    if (!file) throw FileError("cannot be written", path, "name a folder that can be, by -o");
  }
}

}  // namespace lithe
