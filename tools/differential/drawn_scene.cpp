#include "tools/differential/drawn_scene.h"

#include <algorithm>
#include <numeric>

#include "tools/differential/drawing.h"

namespace lithe::differential {

const Place& Drawing::any_place() { return dice.one_of(dice.chance(0.2) ? ground : dice.one_of(scene.bodies).places); }

std::vector<int> Drawing::rigid_bodies() const {
  std::vector<int> out;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (scene.bodies[i].rigid) out.push_back(static_cast<int>(i));
  return out;
}

DrawnScene draw_scene(std::uint32_t seed) {
  Drawing drawing(seed);
  Dice& dice = drawing.dice;
  DrawnScene& scene = drawing.scene;
  scene.seed = seed;
  scene.units = {.length = dice.magnitude(0.01, 30), .mass = dice.magnitude(0.01, 1000)};
  constexpr double kGravity = 9.81;  // m/s²
  scene.units.time = std::sqrt(scene.units.length / kGravity);
  scene.duration = dice.number(1, 3) * scene.units.time;
  drawing.planar = dice.chance(0.25);
  if (drawing.planar && dice.chance(0.5)) drawing.plane = dice.rotation();
  scene.impacts = dice.chance(0.12);
  const bool contact = scene.impacts || dice.chance(0.15), deformable = dice.chance(0.4);
  const double weight = dice.chance(0.2) ? 0 : kGravity;
  scene.gravity =
      contact || dice.chance(0.5)
          ? Vector3(0, 0, -kGravity)
          : Vector3(weight * (drawing.planar ? Vector3(drawing.plane.col(1)) : Vector3(dice.vector().normalized())));
  if (dice.chance(0.5)) {
    drawing.drift = dice.vector(scene.units.speed());
    drawing.spin = (drawing.planar ? Vector3(dice.number() * drawing.plane.col(2)) : dice.vector()) / scene.units.time;
  }
  for (int i = 0; i < 2; ++i) {
    const Vector3 point = drawing.shift(1);
    drawing.ground.push_back(
        {-1, point, [point](SystemGraph& graph, const Matrix3& axes) { return graph.ground().marker(point, axes); }});
  }
  const int bodies = 1 + dice.pick(6);
  for (int i = 0; i < bodies; ++i) {
    BodyKind kind = BodyKind::rigid;
    if (!drawing.planar && dice.chance(0.08)) kind = BodyKind::point;
    if (!drawing.planar && deformable && dice.chance(0.4))
      kind = dice.chance(0.65) ? BodyKind::flexible : dice.chance(0.6) ? BodyKind::beam : BodyKind::cable;
    const bool free = dice.chance(contact ? 0.4 : 0.1);
    if (free) {
      draw_body(drawing, kind, drawing.shift(2));
      continue;
    }
    const bool from_ground = scene.bodies.empty() || dice.chance(0.25);
    if (from_ground) {
      grow(drawing, kind, dice.one_of(drawing.ground), true);
    } else {
      const DrawnBody parent = dice.one_of(scene.bodies);
      grow(drawing, kind, dice.one_of(parent.places), parent.axes);
    }
  }
  if (!drawing.planar && dice.chance(0.25)) draw_group(drawing);
  if (dice.chance(0.3)) close_loop(drawing);
  if (dice.chance(0.1)) close_loop(drawing);
  for (int i = dice.pick(4); i > 0; --i) draw_force(drawing);
  if (contact) draw_contact(drawing);
  return scene;
}

std::vector<int> order_of(const DrawnScene& scene, std::uint32_t seed) {
  std::vector<int> left(scene.elements.size()), out;
  std::iota(left.begin(), left.end(), 0);
  if (seed == 0) return left;
  Dice dice(seed);
  for (int i = static_cast<int>(left.size()); i > 1; --i) std::swap(left.begin()[i - 1], left.begin()[dice.pick(i)]);
  while (!left.empty()) {
    const auto next = std::find_if(left.begin(), left.end(), [&](int i) {
      const std::vector<int>& needs = scene.elements.begin()[i].needs;
      return std::all_of(needs.begin(), needs.end(),
                         [&](int needed) { return std::find(out.begin(), out.end(), needed) != out.end(); });
    });
    out.push_back(*next);
    left.erase(next);
  }
  return out;
}

DrawnScene without(const DrawnScene& scene, const std::vector<int>& left_out) {
  DrawnScene out = scene;
  out.elements.clear(), out.bodies.clear(), out.joints.clear();
  std::vector<int> place(scene.elements.size(), -1);
  for (std::size_t i = 0; i < scene.elements.size(); ++i) {
    DrawnElement element = scene.elements[i];
    bool stays = std::find(left_out.begin(), left_out.end(), static_cast<int>(i)) == left_out.end();
    for (int& needed : element.needs) {
      needed = place.begin()[needed];
      stays = stays && needed >= 0;
    }
    if (!stays) continue;
    place[i] = static_cast<int>(out.elements.size());
    if (std::find(scene.joints.begin(), scene.joints.end(), element.name) != scene.joints.end())
      out.joints.push_back(element.name);
    out.elements.push_back(std::move(element));
  }
  for (DrawnBody body : scene.bodies) {
    body.element = place.begin()[body.element];
    if (body.element >= 0) out.bodies.push_back(std::move(body));
  }
  return out;
}

std::string text_of(const DrawnScene& scene) {
  std::string out = "scene " + std::to_string(scene.seed) + ": size " + std::to_string(scene.units.length) +
                    " m, mass " + std::to_string(scene.units.mass) + " kg, " + std::to_string(scene.duration) + " s\n";
  for (const DrawnElement& element : scene.elements) {
    out += "  " + element.name;
    const char* before = " on ";
    for (int needed : element.needs) {
      out += before + ("'" + scene.elements.begin()[needed].name + "'");
      before = ", ";
    }
    out += "\n";
  }
  return out;
}

}  // namespace lithe::differential
