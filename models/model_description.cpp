#include "models/model_description.h"

#include <cstdio>

#include "engine/base/error.h"

namespace lithe {
namespace {

template <class Named>
int find(const std::vector<Named>& all, const std::string& name, const char* kind, const std::string& path) {
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].name == name) return static_cast<int>(i);
  std::string known;
  for (const Named& one : all) known += (known.empty() ? "" : ", ") + one.name;
  throw SceneError("the model has no " + std::string(kind) + " '" + name + "'.", path, "known are " + known + ".");
}

std::string counted(int count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

std::string to_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace

int ModelDescription::link(const std::string& wanted) const { return find(links, wanted, "link", path); }
int ModelDescription::joint(const std::string& wanted) const { return find(joints, wanted, "joint", path); }

std::vector<int> ModelDescription::welded_to() const {
  std::vector<int> above(links.size(), -1);
  for (const ModelJoint& joint : joints)
    if (joint.type == ModelJoint::Type::fixed) above[joint.child] = joint.parent;
  std::vector<int> result(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    int at = static_cast<int>(i);
    while (above[at] >= 0) at = above[at];
    result[i] = at;
  }
  return result;
}

std::string ModelDescription::sheet() const {
  using enum ModelJoint::Type;
  int kinds[5] = {}, followers = 0;
  for (const ModelJoint& joint : joints) {
    ++kinds[static_cast<int>(joint.type)];
    followers += joint.mimic.has_value();
  }
  const auto of = [&](ModelJoint::Type type) { return kinds[static_cast<int>(type)]; };
  const std::vector<int> welded = welded_to();
  double mass = 0;
  int bodies = 0, massless = 0;
  for (std::size_t i = 0; i < links.size(); ++i) {
    mass += links[i].mass;
    bodies += welded[i] == static_cast<int>(i);
    massless += links[i].mass == 0;
  }
  std::string text = "Model '" + name + "' (" + format + "): " + path + "\n";
  text += "  links   " + counted(static_cast<int>(links.size()), "link", "links") + ", root '" + links[root].name +
          "'; fixed joints make them " + counted(bodies, "body", "bodies") + ", the root's included\n";
  text += "  mass    " + to_text(mass) + " kg, " + counted(massless, "link", "links") + " without\n";
  text += "  joints  " + std::to_string(of(revolute)) + " revolute, " + std::to_string(of(prismatic)) + " prismatic, " +
          std::to_string(of(planar)) + " planar, " + std::to_string(of(floating)) + " floating, " +
          std::to_string(of(fixed)) + " fixed\n";
  const int freedoms = of(revolute) + of(prismatic) + 3 * of(planar) + 6 * of(floating) - followers;
  text += "  freedoms with the root fixed: " + std::to_string(freedoms) + ", " +
          counted(followers, "joint follows", "joints follow") + " another; with the root free: 6 more\n";
  if (notes.empty()) return text + "  all of the file acts\n";
  text += "  does not act:\n";
  for (const ModelNote& note : notes)
    text += "    line " + std::to_string(note.line) +
            (note.count > 1 ? ", " + std::to_string(note.count) + " times" : "") + ": " + note.what + ": " + note.why +
            "\n";
  return text;
}

}  // namespace lithe
