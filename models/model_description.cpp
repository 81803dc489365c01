#include "models/model_description.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "engine/base/error.h"

namespace lithe {
namespace {

template <class Named>
int find(const std::vector<Named>& all, const std::string& name, const char* kind, const std::string& path) {
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].name == name) return static_cast<int>(i);
  std::string known;
  for (std::size_t i = 0; i < all.size() && i < 40; ++i) known += (known.empty() ? "" : ", ") + all[i].name;
  if (all.size() > 40) known += " and " + std::to_string(all.size() - 40) + " more";
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

std::string kind_of(const ModelJoint& joint) {
  constexpr const char* kNames[] = {"fixed", "revolute", "prismatic", "planar", "floating", "spherical", "universal"};
  return joint.type == ModelJoint::Type::other ? joint.kind : kNames[static_cast<int>(joint.type)];
}

}  // namespace

int ModelDescription::link(const std::string& wanted) const { return find(links, wanted, "link", path); }
int ModelDescription::joint(const std::string& wanted) const { return find(joints, wanted, "joint", path); }

std::vector<int> ModelDescription::welded_to() const {
  std::vector<int> above(links.size(), -1);
  for (const ModelJoint& joint : joints)
    if (joint.type == ModelJoint::Type::fixed && !joint.closes_loop) above[joint.child] = joint.parent;
  std::vector<int> result(links.size());
  for (std::size_t i = 0; i < links.size(); ++i) {
    int at = static_cast<int>(i);
    while (above[at] >= 0) at = above[at];
    result[i] = at;
  }
  return result;
}

std::string ModelDescription::sheet() const {
  const std::vector<int> welded = welded_to();
  double mass = 0;
  int bodies = 0, massless = 0, followers = 0, loops = 0;
  for (std::size_t i = 0; i < links.size(); ++i) {
    mass += links[i].mass;
    bodies += welded[i] == static_cast<int>(i);
    massless += links[i].mass == 0;
  }
  std::map<std::string, int> kinds;
  std::vector<std::string> order = {"revolute", "prismatic", "spherical", "universal", "planar", "floating"};
  int freedoms = 0;
  for (const ModelJoint& joint : joints) {
    const std::string kind = kind_of(joint);
    if (++kinds[kind] == 1 && joint.type == ModelJoint::Type::other) order.push_back(kind);
    followers += joint.mimic.has_value();
    loops += joint.closes_loop;
    constexpr int kFreedoms[] = {0, 1, 1, 3, 6, 3, 2, 0};
    if (!joint.closes_loop) freedoms += kFreedoms[static_cast<int>(joint.type)];
  }
  std::string text = "Model '" + name + "' (" + format + "): " + path + "\n";
  text += "  links   " + counted(static_cast<int>(links.size()), "link", "links") + ", root '" + links[root].name +
          "'; fixed joints make them " + counted(bodies, "body", "bodies") + ", the root's included\n";
  text += "  mass    " + to_text(mass) + " kg, " + counted(massless, "link", "links") + " without\n";
  text += "  joints  ";
  order.push_back("fixed");
  std::string list;
  for (const std::string& kind : order)
    if (kinds[kind] > 0) list += (list.empty() ? "" : ", ") + std::to_string(kinds[kind]) + " " + kind;
  text += (list.empty() ? "none" : list) + "\n";
  if (!adams) {
    text += "  freedoms with the root fixed: " + std::to_string(freedoms - followers) + ", " +
            counted(followers, "joint follows", "joints follow") + " another";
    if (loops > 0) text += ", less what " + counted(loops, "closed loop takes", "closed loops take");
    text += root_is_world ? "\n" : "; with the root free: 6 more\n";
  }
  text += "  gravity " + to_text(gravity.x()) + " " + to_text(gravity.y()) + " " + to_text(gravity.z()) + " m/s2";
  if (tolerance) text += ", tolerance " + to_text(*tolerance);
  if (duration) text += ", " + to_text(*duration) + " s";
  text += "\n";
  if (adams)
    text += "  units   " + to_text(adams->units.mass) + " kg, " + to_text(adams->units.length) + " m, " +
            to_text(adams->units.time) + " s, " + to_text(adams->units.force) + " N; " +
            counted(static_cast<int>(adams->requests.size()), "request", "requests") + "\n";
  if (notes.empty()) return text + "  all of the file acts\n";
  text += "  does not act:\n";
  for (const ModelNote& note : notes)
    text += "    line " + std::to_string(note.line) +
            (note.count > 1 ? ", " + std::to_string(note.count) + " times" : "") + ": " + note.what + ": " + note.why +
            "\n";
  return text;
}

std::string ModelDescription::table() const {
  std::size_t width = 4;
  for (const ModelLink& link : links) width = std::max(width, link.name.size());
  for (const ModelJoint& joint : joints) width = std::max(width, joint.name.size());
  width = std::min<std::size_t>(width, 40);
  const auto padded = [&](std::string word, std::size_t to) {
    word.resize(std::max(word.size(), to), ' ');
    return word + "  ";
  };
  const std::vector<int> welded = welded_to();
  std::string text = padded("link", width) + "mass, kg   centre of mass in its frame, m\n";
  for (std::size_t i = 0; i < links.size(); ++i) {
    const ModelLink& link = links[i];
    text += padded(link.name, width) + padded(to_text(link.mass), 9);
    const Vector3& c = link.inertial.position;
    if (link.mass > 0) text += to_text(c.x()) + " " + to_text(c.y()) + " " + to_text(c.z());
    if (static_cast<int>(i) == root)
      text += "root";
    else if (welded[i] != static_cast<int>(i))
      text += "  fixed to " + links[static_cast<std::size_t>(welded[i])].name;
    text += "\n";
  }
  text += padded("joint", width) + padded("kind", 16) + "links\n";
  for (const ModelJoint& joint : joints) {
    text += padded(joint.name, width) + padded(kind_of(joint), 16) +
            links[static_cast<std::size_t>(joint.parent)].name + " - " +
            links[static_cast<std::size_t>(joint.child)].name;
    if (joint.mimic) text += ", follows " + joints[static_cast<std::size_t>(joint.mimic->leader)].name;
    if (joint.closes_loop) text += ", closes a loop";
    text += "\n";
  }
  return text;
}

}  // namespace lithe
