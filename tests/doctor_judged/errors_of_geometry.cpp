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
#include "tests/doctor_judged/machines.h"
#include "tests/doctor_judged/seeded_errors.h"

namespace lithe::test {
namespace {

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
           const auto [left, right, bar] = add_parallelogram(graph, {0.4, 0, 0}, {0, 0, 0.2});
           graph.add<CoordinateDrive>("left motor", {left.angle()}, {.motion = smooth_step(0, 1, 0, 1)});
           graph.add<CoordinateDrive>("right motor", {right.angle()}, {.motion = smooth_step(0, 1.2, 0, 1)});
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
           const auto [one, two] = add_meshed_shafts(graph);
           graph.add<CoordinateCoupling>("belt", {one.angle(), two.angle()}, {.factors = {1, -1}});
           graph.add<CoordinateMotor>("motor", {one.angle()}, {[](double, double, double w) { return 1 - w; }});
           return {coordinate(one.angle(), "input")};
         }}},
       {Cause::locked},
       {{"mesh", "belt"}}},
      {{{.name = "a parallelogram is drawn flat, where it can fold",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           return {position(add_parallelogram(graph, {1, 0, 0}, {0.3, 0, 0}).bar.marker(), "bar")};
         }}},
       {Cause::singular_position},
       {{"foot", "pin", "crank", "bar"}}},
      {{{.name = "the hand is turned by its Euler angles in the wrong order",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           const Matrix3 yaw = rotation_about(kUp, 0.5), pitch = rotation_about(kAcross, 0.7);
           return {position(add_hand(graph, yaw, pitch, pitch * yaw).marker(), "hand")};
         }}},
       {Cause::open_joint},
       {{"wrist"}}},
      {{{.name = "the reaction of one of a door's two hinges is read off",
         .draw = [](SystemGraph& graph) -> std::vector<Sensor> {
           return {reaction(add_door(graph).upper, 1, kWorldAxes, "load of the screws")};
         }}},
       {Cause::redundant_rows},
       {{"lower hinge", "upper hinge"}}},
  };
}

}  // namespace lithe::test
