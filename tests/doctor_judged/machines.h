#pragma once

#include "joints/gear_pair.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/doctor_judged/judged_scene.h"

/// Machines that sound scenes share with those that have an error.
namespace lithe::test {

inline const Vector3 kA{0, 0, 0.2}, kB{0.5, 0, 0.4}, kD{0.6, 0, 0};

/// Crank, coupler and rocker in the plane y = 0; the coupler's pin on the rocker is at `rocker_end` of the rocker and
/// has its axis along `axis`.
inline std::vector<Sensor> draw_four_bar(SystemGraph& graph, const Vector3& axis = kAcross,
                                         const Vector3& rocker_end = kB) {
  auto& crank = add_rod(graph, "crank", kO, kA);
  auto& coupler = add_rod(graph, "coupler", kA, kB);
  auto& rocker = add_rod(graph, "rocker", kD, kB);
  tie<RevoluteJoint>(graph, "pin O", graph.ground(), crank, kO);
  tie<RevoluteJoint>(graph, "pin A", crank, coupler, kA);
  graph.add<RevoluteJoint>(
      "pin B", {coupler.marker_at_world(kB, axes_of(axis)), rocker.marker_at_world(rocker_end, axes_of(axis))});
  tie<RevoluteJoint>(graph, "pin D", graph.ground(), rocker, kD);
  return {position(coupler.marker(), "coupler")};
}

struct SliderCrank {
  RevoluteJoint& main;
  RigidBody& piston;
};
/// In the plane y = 0, the crank's end at `end`, the piston at `slide`.
inline SliderCrank add_slider_crank(SystemGraph& graph, const Vector3& end, const Vector3& slide) {
  auto& crank = add_rod(graph, "crank", kO, end);
  auto& rod = add_rod(graph, "rod", end, slide);
  auto& piston = graph.add<RigidBody>("piston", {.inertia = {1e-3, 1e-3, 1e-3}, .position = slide});
  auto& main = tie<RevoluteJoint>(graph, "main bearing", graph.ground(), crank, kO);
  tie<RevoluteJoint>(graph, "big end", crank, rod, end);
  tie<RevoluteJoint>(graph, "small end", rod, piston, slide);
  tie<PrismaticJoint>(graph, "bore", graph.ground(), piston, slide, kAlong);
  return {main, piston};
}

struct Parallelogram {
  RevoluteJoint &left, &right;  // feet
  RigidBody& bar;
};
/// Feet at the origin and D, cranks along `crank`.
inline Parallelogram add_parallelogram(SystemGraph& graph, const Vector3& D, const Vector3& crank) {
  auto& left = add_rod(graph, "left crank", kO, crank);
  auto& right = add_rod(graph, "right crank", D, D + crank);
  auto& bar = add_rod(graph, "bar", crank, D + crank);
  auto& left_foot = tie<RevoluteJoint>(graph, "left foot", graph.ground(), left, kO);
  auto& right_foot = tie<RevoluteJoint>(graph, "right foot", graph.ground(), right, D);
  tie<RevoluteJoint>(graph, "left pin", left, bar, crank);
  tie<RevoluteJoint>(graph, "right pin", right, bar, D + crank);
  return {left_foot, right_foot, bar};
}

struct MeshedShafts {
  RevoluteJoint &input, &output;
};
inline MeshedShafts add_meshed_shafts(SystemGraph& graph) {
  const Vector3 centre{0.1, 0, 0};
  auto& first = graph.add<RigidBody>("input", {.inertia = {1e-3, 1e-3, 2e-3}});
  auto& second = graph.add<RigidBody>("output", {.inertia = {1e-3, 1e-3, 2e-3}, .position = centre});
  auto& input = tie<RevoluteJoint>(graph, "input shaft", graph.ground(), first, kO, kUp);
  auto& output = tie<RevoluteJoint>(graph, "output shaft", graph.ground(), second, centre, kUp);
  graph.add<GearPair>("mesh", {first.marker(), second.marker()}, {.radius_A = 0.05, .radius_B = 0.05});
  return {input, output};
}

/// A hand on an arm that is turned by `yaw`, at a wrist whose axes on the arm are turned by `pitch`.
inline RigidBody& add_hand(SystemGraph& graph, const Matrix3& yaw, const Matrix3& pitch, const Matrix3& orientation) {
  auto& arm = graph.add<RigidBody>("arm", {.inertia = {1e-2, 1e-2, 1e-2}, .orientation = yaw});
  auto& hand = graph.add<RigidBody>(
      "hand",
      {.mass = 0.3, .inertia = {1e-3, 1e-3, 1e-3}, .position = yaw * Vector3(0.2, 0, 0), .orientation = orientation});
  graph.add<RevoluteJoint>("shoulder", {graph.ground().marker(kO, yaw), arm.marker()});
  graph.add<RevoluteJoint>("wrist", {arm.marker({0.2, 0, 0}, pitch), hand.marker()});
  return hand;
}

struct DoorHinges {
  RevoluteJoint &lower, &upper;
};
inline DoorHinges add_door(SystemGraph& graph) {
  auto& door = graph.add<RigidBody>("door", {.mass = 25, .inertia = {8, 9, 1.4}, .position = {0.4, 0, 1}});
  auto& lower = tie<RevoluteJoint>(graph, "lower hinge", graph.ground(), door, {0, 0, 0.3}, kUp);
  auto& upper = tie<RevoluteJoint>(graph, "upper hinge", graph.ground(), door, {0, 0, 1.7}, kUp);
  return {lower, upper};
}

}  // namespace lithe::test
