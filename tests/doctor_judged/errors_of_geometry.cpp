#include "bodies/beam/beam.h"
#include "bodies/beam/beam_model.h"
#include "bodies/flexible/flexible_body.h"
#include "engine/observe/sensors.h"
#include "joints/coordinate_coupling.h"
#include "joints/coordinate_drive.h"
#include "joints/fixed_joint.h"
#include "joints/forces/coordinate_motor.h"
#include "joints/forces/coordinate_stop.h"
#include "joints/gear_pair.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tests/doctor_judged/seeded_errors.h"

namespace lithe::test {
namespace {

const Vector3 kO{0, 0, 0}, kA{0, 0, 0.2}, kB{0.5, 0, 0.4}, kD{0.6, 0, 0};

/// Crank, coupler and rocker in the plane y = 0; the coupler's pin on the rocker is at `rocker_end` of the rocker and
/// has its axis along `axis`.
std::vector<Sensor> draw_four_bar(SystemGraph& graph, const Vector3& axis, const Vector3& rocker_end) {
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

std::shared_ptr<const ModalBasis> beam_basis(const BodyFrame& frame, int modes) {
  SystemGraph drawing;
  const Beam& beam = drawing.add<Beam>("beam", {.axis = BeamAxis::straight(kO, kAlong, kAcross),
                                                .sections = {{0, BeamSection::circle(0.01, {7e10, 0.3, 2700})}},
                                                .elements = 10});
  return make_basis(beam, frame, modes);
}

}  // namespace

std::vector<SeededError> errors_of_geometry() {
  return {
      {{{.name = "the axis of a four-bar's pin is tilted by 15 degrees",
         .draw =
             [](SystemGraph& graph) {
               return draw_four_bar(graph, {0.259, 0.966, 0}, kB);
             }}},
       {Cause::locked},
       {{"pin B"}}},
      {{{.name = "the rocker's pin is 20 mm off",
         .draw = [](SystemGraph& graph) { return draw_four_bar(graph, kAcross, kB + Vector3(0.02, 0, 0)); }}},
       {Cause::open_joint},
       {{"pin B"}}},
      {{{.name = "the connecting rod is pinned to the ground instead of the crank",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           const Vector3 end{0, 0, 0.1}, slide{0.3, 0, 0};
           auto& crank = add_rod(graph, "crank", kO, end);
           auto& rod = add_rod(graph, "rod", end, slide);
           auto& slider = graph.add<RigidBody>("slider", {.inertia = {1e-3, 1e-3, 1e-3}, .position = slide});
           auto& main = tie<RevoluteJoint>(graph, "main bearing", graph.ground(), crank, kO);
           tie<RevoluteJoint>(graph, "big end", graph.ground(), rod, end);
           tie<RevoluteJoint>(graph, "small end", rod, slider, slide);
           tie<PrismaticJoint>(graph, "guide", graph.ground(), slider, slide, kAlong);
           graph.add<CoordinateMotor>("motor", {main.angle()}, {[](double, double, double w) { return 2 - w; }});
           return {position(slider.marker(), "slider")};
         }}},
       {Cause::locked},
       {{"rod", "slider", "big end"}}},
      {{{.name = "the payload is never welded to the boom",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& boom = add_rod(graph, "boom", kO, {2, 0, 0}, 20);
           auto& payload = graph.add<RigidBody>("payload", {.mass = 50, .position = {2, 0, 0}});
           tie<RevoluteJoint>(graph, "foot", graph.ground(), boom, kO);
           return {height(payload.marker(), "payload")};
         }}},
       {Cause::free_body},
       {{"payload"}}},
      {{{.name = "both cranks of a parallelogram are driven, one at another speed",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           const Vector3 D{0.4, 0, 0}, A{0, 0, 0.2}, B{0.4, 0, 0.2};
           auto& left = add_rod(graph, "left crank", kO, A);
           auto& right = add_rod(graph, "right crank", D, B);
           auto& bar = add_rod(graph, "bar", A, B);
           auto& first = tie<RevoluteJoint>(graph, "left foot", graph.ground(), left, kO);
           auto& second = tie<RevoluteJoint>(graph, "right foot", graph.ground(), right, D);
           tie<RevoluteJoint>(graph, "left pin", left, bar, A);
           tie<RevoluteJoint>(graph, "right pin", right, bar, B);
           graph.add<CoordinateDrive>("left motor", {first.angle()}, {.motion = smooth_step(0, 1, 0, 1)});
           graph.add<CoordinateDrive>("right motor", {second.angle()}, {.motion = smooth_step(0, 1.2, 0, 1)});
           return {position(bar.marker(), "bar")};
         }}},
       {Cause::incompatible_drive},
       {{"motor"}}},
      {{{.name = "a drive pushes the table 50 mm into its end stop",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& table = graph.add<RigidBody>("table", {.mass = 8, .inertia = {0.1, 0.1, 0.1}});
           auto& slide = tie<PrismaticJoint>(graph, "slide", graph.ground(), table, kO, kAlong);
           graph.add<CoordinateDrive>("ball screw", {slide.displacement()}, {.motion = smooth_step(0, 0.35, 0, 0.8)});
           graph.add<CoordinateStop>("end stop", {slide.displacement()},
                                     {.lower = -0.3, .upper = 0.3, .stiffness = 1e8});
           return {position(table.marker(), "table")};
         }}},
       {},
       {{"end stop"}, {"drive", "ball screw"}}},
      {{{.name = "a cantilever with one mode, which bends across its load",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           SystemGraph drawing;
           const Beam& beam =
               drawing.add<Beam>("beam", {.axis = BeamAxis::straight(kO, kAlong, kAcross),
                                          .sections = {{0, BeamSection::rectangle(0.004, 0.02, {7e10, 0.3, 2700})}},
                                          .elements = 10});
           auto& boom = graph.add<FlexibleBody>("boom", {.basis = make_basis(beam, TangentFrame{{1}}, 12),
                                                         .mode_count = 1,
                                                         .damping = {.modal_ratios = {0.05}}});
           graph.add<FixedJoint>("clamp", {graph.ground().marker(), boom.node(1)});
           auto& load =
               graph.add<RigidBody>("load", {.mass = 0.5, .inertia = {1e-4, 1e-4, 1e-4}, .position = {1, 0, 0}});
           graph.add<FixedJoint>("hook", {boom.node(11), load.marker()});
           return {height(load.marker(), "load")};
         }}},
       {},
       {{"boom"}, {"mode"}}},
      {{{.name = "a beam of free-free modes is clamped at both ends: its few modes are all taken",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& beam = graph.add<FlexibleBody>("beam", {.basis = beam_basis(MeanAxisFrame{}, 4)});
           graph.add<FixedJoint>("left clamp", {graph.ground().marker(), beam.node(1)});
           graph.add<FixedJoint>("right clamp", {graph.ground().marker({1, 0, 0}), beam.node(11)});
           return {height(beam.node(6), "middle")};
         }}},
       {Cause::locked},
       {{"beam", "clamp"}}},
      {{{.name = "gears turn against each other, and the belt beside them does not",
         .gravity = {0, 0, 0},
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           const Vector3 centre{0.1, 0, 0};
           auto& first = graph.add<RigidBody>("input", {.inertia = {1e-3, 1e-3, 2e-3}});
           auto& second = graph.add<RigidBody>("output", {.inertia = {1e-3, 1e-3, 2e-3}, .position = centre});
           auto& one = tie<RevoluteJoint>(graph, "input shaft", graph.ground(), first, kO, kUp);
           auto& two = tie<RevoluteJoint>(graph, "output shaft", graph.ground(), second, centre, kUp);
           graph.add<GearPair>("mesh", {first.marker(), second.marker()}, {.radius_A = 0.05, .radius_B = 0.05});
           graph.add<CoordinateCoupling>("belt", {one.angle(), two.angle()}, {.factors = {1, -1}});
           graph.add<CoordinateMotor>("motor", {one.angle()}, {[](double, double, double w) { return 1 - w; }});
           return {coordinate(one.angle(), "input")};
         }}},
       {Cause::locked},
       {{"mesh", "belt"}}},
      {{{.name = "a parallelogram is drawn flat, where it can fold",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           const Vector3 D{1, 0, 0}, A{0.3, 0, 0}, B{1.3, 0, 0};
           auto& left = add_rod(graph, "left crank", kO, A);
           auto& right = add_rod(graph, "right crank", D, B);
           auto& bar = add_rod(graph, "bar", A, B);
           tie<RevoluteJoint>(graph, "left foot", graph.ground(), left, kO);
           tie<RevoluteJoint>(graph, "right foot", graph.ground(), right, D);
           tie<RevoluteJoint>(graph, "left pin", left, bar, A);
           tie<RevoluteJoint>(graph, "right pin", right, bar, B);
           return {position(bar.marker(), "bar")};
         }}},
       {Cause::singular_position},
       {{"foot", "pin", "crank", "bar"}}},
      {{{.name = "the hand is turned by its Euler angles in the wrong order",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           const Matrix3 yaw = rotation_about(kUp, 0.5), pitch = rotation_about(kAcross, 0.7);
           auto& arm = graph.add<RigidBody>("arm", {.inertia = {1e-2, 1e-2, 1e-2}, .orientation = yaw});
           auto& hand = graph.add<RigidBody>("hand", {.mass = 0.3,
                                                      .inertia = {1e-3, 1e-3, 1e-3},
                                                      .position = yaw * Vector3(0.2, 0, 0),
                                                      .orientation = pitch * yaw});
           graph.add<RevoluteJoint>("shoulder", {graph.ground().marker(kO, yaw), arm.marker()});
           graph.add<RevoluteJoint>("wrist", {arm.marker({0.2, 0, 0}, pitch), hand.marker()});
           return {position(hand.marker(), "hand")};
         }}},
       {Cause::open_joint},
       {{"wrist"}}},
      {{{.name = "the reaction of one of a door's two hinges is read off",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           auto& door = graph.add<RigidBody>("door", {.mass = 25, .inertia = {8, 9, 1.4}, .position = {0.4, 0, 1}});
           tie<RevoluteJoint>(graph, "lower hinge", graph.ground(), door, {0, 0, 0.3}, kUp);
           auto& upper = tie<RevoluteJoint>(graph, "upper hinge", graph.ground(), door, {0, 0, 1.7}, kUp);
           return {reaction(upper, 1, kWorldAxes, "load of the screws")};
         }}},
       {Cause::redundant_rows},
       {{"lower hinge", "upper hinge"}}},
  };
}

}  // namespace lithe::test
