// Gears, bearings, tyres, oil, ropes, controllers and friction: gradients through what machines are made of.
#include "bodies/integral_state.h"
#include "bodies/point_mass.h"
#include "bodies/rigid_body.h"
#include "integrators/explicit_runge_kutta.h"
#include "integrators/radau.h"
#include "joints/aerodynamics/dynamic_airfoil_strip.h"
#include "joints/bearings/ball_bearing.h"
#include "joints/bearings/journal_bearing.h"
#include "joints/bearings/roller_bearing.h"
#include "joints/control/control_force.h"
#include "joints/coordinate_drive.h"
#include "joints/forces/joint_bristles.h"
#include "joints/forces/joint_friction.h"
#include "joints/forces/pid_controller.h"
#include "joints/forces/point_force.h"
#include "joints/gears/bevel_gear_pair.h"
#include "joints/gears/sprocket_pair.h"
#include "joints/gears/toothed_gear_pair.h"
#include "joints/gears/toothed_rack.h"
#include "joints/hydraulics/hydraulic_cylinder.h"
#include "joints/planar_joint.h"
#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "joints/rope/rope.h"
#include "joints/tyre/tyre.h"
#include "models/read_tir.h"
#include "tests/gradient/gradient_support.h"

namespace lithe::test {
namespace {

using Mode = GradientOptions::Mode;
using Draw = std::function<std::vector<Sensor>(SystemGraph&, const SweepPoint&)>;

ParametricScene machine(const char* name, double duration, double step, Draw draw) {
  return {.name = name, .duration = duration, .draw = std::move(draw), .integrator = exact_alpha(step)};
}
MakeIntegrator machine_radau(double step) {
  return [=] { return std::make_unique<Radau>(Radau::Parameters{.step = step, .newton_tolerance = 1e-13}); };
}

/// A mass on a cylinder between a supply and a tank, its valve half open.
ParametricScene lift() {
  return machine("lift", 0.05, 5e-4, [](SystemGraph& graph, const SweepPoint& p) {
    auto& block = graph.add<RigidBody>("block", {.mass = p["mass"], .position = {0, 0, 0.7}});
    graph.add<PrismaticJoint>("slide", {graph.ground().marker(), block.marker()});
    auto& oil = graph.add<FirstOrderStates>("oil", {.start = HydraulicCylinder::start(p["start"], 1e6)});
    auto& cylinder = graph.add<HydraulicCylinder>(
        "lift", {graph.ground().marker(), block.marker(), oil.point(0)},
        {.bore = p["bore"],
         .rod = 0.05,
         .stroke = 0.5,
         .closed_length = 0.6,
         .cap_dead_volume = 2e-4,
         .rod_dead_volume = 1.5e-4,
         .leakage = p["leakage"],
         .friction = 200,
         .valve = {
             .area = p["area"], .command = constant(0.5), .time_constant = 0.02, .supply = constant(p["supply"])}});
    return std::vector<Sensor>{position(block.marker(), "p"), cylinder.pressures("oil")};
  });
}
const std::vector<DesignParameter> kLift{{"mass", 800},  {"bore", 0.08},    {"leakage", 1e-11},
                                         {"area", 1e-4}, {"supply", 1.2e7}, {"start", 3e6}};

TEST(MachineGradients, OfAHydraulicCylinderAndItsPressures) {
  expect_gradient(lift(), {value_at("oil_cap", 0.05), value_at("oil_rod", 0.03), integral("p_z")}, kLift);
}

/// A wheel with a heavy hub that rolls with a slip angle.
TEST(MachineGradients, OfATyreThatRollsAtAnAngle) {
  const ParametricScene scene = machine("tyre", 0.1, 1e-3, [](SystemGraph& graph, const SweepPoint& p) {
    TyreCoefficients tyre = read_tir(LITHE_EXAMPLE_DATA "/tyres/car.tir");
    tyre.vertical_stiffness *= p["stiffness"];
    tyre.lmuy *= p["grip"];
    const double m = p["mass"], v = p["speed"], radius = tyre.unloaded_radius - 0.015;
    const Matrix3 axle = rotation_about({0, 0, 1}, p["heading"]) * rotation_about({1, 0, 0}, -M_PI / 2);
    auto& wheel = graph.add<RigidBody>("wheel", {.mass = m,
                                                 .inertia = {20, 20, 1.5},
                                                 .position = {0, 0, radius},
                                                 .orientation = axle,
                                                 .velocity = {v, 0, 0},
                                                 .angular_velocity = {0, 0, v / radius}});
    auto& carcass = graph.add<FirstOrderStates>("carcass", {.start = VectorX::Zero(3)});
    auto& contact =
        graph.add<Tyre>("tyre", {graph.ground().marker(), wheel.marker(), carcass.point(0)}, {.coefficients = tyre});
    return std::vector<Sensor>{position(wheel.marker(), "p"), tyre_contact(contact, "tyre")};
  });
  expect_gradient(scene, {value_at("p_y", 0.1), value_at("tyre_Fy", 0.08), integral("tyre_Fz")},
                  {{"stiffness", 1}, {"grip", 1}, {"mass", 400}, {"speed", 12}, {"heading", 0.03}});
}

/// Motions of micrometres: of the runs that are compared Newton leaves 1e-13 m in each step.
constexpr double kOfMicrometres = 1e-7;

/// Two shafts with elastic teeth between them, without backlash, at torques that load one flank. Stiffness has corners
/// over the mesh cycle, so runs that are compared are near.
ParametricScene gears(const char* name, const Vector3& second, const Matrix3& turned,
                      std::function<void(SystemGraph&, const SweepPoint&, Marker, Marker)> mesh) {
  return machine(name, 1e-3, 2e-5, [=](SystemGraph& graph, const SweepPoint& p) {
    auto& pinion = graph.add<RigidBody>(
        "pinion", {.mass = 1, .inertia = {1e-3, 1e-3, p["inertia"]}, .angular_velocity = {0, 0, 1}});
    auto& wheel = graph.add<RigidBody>(
        "wheel", {.mass = 2, .inertia = {4e-3, 4e-3, 4e-3}, .position = second, .orientation = turned});
    auto& shaft = graph.add<RevoluteJoint>("shaft", {graph.ground().marker(), pinion.marker()});
    auto& axle = graph.add<RevoluteJoint>("axle", {graph.ground().marker(second, turned), wheel.marker()});
    graph.add<PointForce>("drive", {pinion.marker()}, {.torque = {0, 0, p["torque"]}});
    mesh(graph, p, pinion.marker(), wheel.marker());
    return std::vector<Sensor>{coordinate(shaft.angle(), "A"), coordinate(axle.angle(), "B")};
  });
}
const std::vector<DesignParameter> kGears{{"inertia", 1e-3}, {"torque", 40}, {"width", 0.03}, {"E", 2.06e11}};
const std::vector<Quantity> kMeshed{value_at("B", 1e-3), value_at("A", 6e-4), integral("B")};

TEST(MachineGradients, OfHelicalGears) {
  const double module = 3e-3;
  const auto design = [=](double width) {
    return GearDesign{.module = module, .teeth_A = 20, .teeth_B = 31, .helix_angle = 0.2, .face_width = width};
  };
  const double apart = GearGeometry(design(0.03)).centre_distance;
  expect_of_near_runs(gears("helical gears", {apart, 0, 0}, Matrix3::Identity(),
                            [=](SystemGraph& graph, const SweepPoint& p, Marker A, Marker B) {
                              graph.add<ToothedGearPair>(
                                  "mesh", {A, B},
                                  {.gears = design(p["width"]), .teeth = {.material = {.youngs_modulus = p["E"]}}});
                            }),
                      kMeshed, kGears, kOfMicrometres);
}

TEST(MachineGradients, OfAToothedBelt) {
  expect_gradient(gears("toothed belt", {0.3, 0, 0}, Matrix3::Identity(),
                        [](SystemGraph& graph, const SweepPoint& p, Marker A, Marker B) {
                          graph.add<SprocketPair>("belt", {A, B},
                                                  {.teeth_A = 17,
                                                   .teeth_B = 38,
                                                   .pitch = 12.7e-3,
                                                   .axial_stiffness = 1e-5 * p["E"],
                                                   .damping = 10,
                                                   .pretension = 1e5 * p["width"],
                                                   .polygon = false});
                        }),
                  kMeshed, kGears);
}

TEST(MachineGradients, OfBevelGears) {
  const Matrix3 across = rotation_about({1, 0, 0}, -M_PI / 2);
  expect_of_near_runs(gears("bevel gears", {0, 0, 0}, across,
                            [](SystemGraph& graph, const SweepPoint& p, Marker A, Marker B) {
                              graph.add<BevelGearPair>("mesh", {A, B},
                                                       {.module = 3e-3,
                                                        .teeth_A = 20,
                                                        .teeth_B = 31,
                                                        .face_width = 0.5 * p["width"],
                                                        .teeth = {.material = {.youngs_modulus = p["E"]}}});
                            }),
                      kMeshed, kGears);
}

TEST(MachineGradients, OfAGearOnARack) {
  const ParametricScene scene = machine("rack", 2e-3, 2e-5, [](SystemGraph& graph, const SweepPoint& p) {
    auto& pinion =
        graph.add<RigidBody>("pinion", {.mass = 1, .inertia = {1e-3, 1e-3, p["inertia"]}, .position = {0, 0.03, 0}});
    auto& rack = graph.add<RigidBody>("rack", {.mass = p["mass"]});
    const Matrix3 along = rotation_about({0, 1, 0}, M_PI / 2);
    auto& shaft = graph.add<RevoluteJoint>("shaft", {graph.ground().marker({0, 0.03, 0}), pinion.marker()});
    graph.add<PrismaticJoint>("slide", {graph.ground().marker({}, along), rack.marker({}, along)});
    graph.add<PointForce>("drive", {pinion.marker()}, {.torque = {0, 0, p["torque"]}});
    graph.add<ToothedRack>("mesh", {pinion.marker(), rack.marker()},
                           {.gears = {.module = 3e-3, .teeth_A = 20, .face_width = 0.03}});
    return std::vector<Sensor>{coordinate(shaft.angle(), "A"), position(rack.marker(), "rack")};
  });
  expect_of_near_runs(scene, {value_at("A", 2e-3), integral("rack_x")},
                      {{"inertia", 1e-3}, {"mass", 4}, {"torque", 40}});
}

/// A shaft that turns in a bearing under its load; all rolling elements carry, by interference.
ParametricScene turning(const char* name,
                        std::function<void(SystemGraph&, const SweepPoint&, Marker, Marker)> bearing) {
  return machine(name, 2e-3, 2e-5, [=](SystemGraph& graph, const SweepPoint& p) {
    auto& shaft = graph.add<RigidBody>(
        "shaft", {.mass = p["mass"], .inertia = {2e-3, 2e-3, 1e-3}, .angular_velocity = {0, 0, 200}});
    bearing(graph, p, shaft.marker(), graph.ground().marker());
    graph.add<PlanarJoint>("plane", {graph.ground().marker(), shaft.marker()});
    graph.add<PointForce>("load", {shaft.marker({0, 0, 0})}, {.force = {p["load"], 100, 0}});
    return std::vector<Sensor>{position(shaft.marker(), "p"), velocity(shaft.marker(), "v")};
  });
}
const std::vector<Quantity> kTurned{value_at("p_x", 2e-3), value_at("p_y", 1e-3), integral("v_x")};
const std::vector<DesignParameter> kTurning{{"mass", 1}, {"load", 300}, {"clearance", -2e-5}, {"diameter", 8e-3}};

TEST(MachineGradients, OfABallBearing) {
  expect_gradient(turning("ball bearing",
                          [](SystemGraph& graph, const SweepPoint& p, Marker inner, Marker outer) {
                            const double D = p["diameter"];
                            graph.add<BallBearing>("bearing", {inner, outer},
                                                   {.balls = 8,
                                                    .ball_diameter = D,
                                                    .pitch_diameter = 33.5e-3,
                                                    .inner_groove_radius = 0.515 * D,
                                                    .outer_groove_radius = 0.525 * D,
                                                    .clearance = p["clearance"]});
                          }),
                  kTurned, kTurning);
}

TEST(MachineGradients, OfARollerBearing) {
  expect_gradient(turning("roller bearing",
                          [](SystemGraph& graph, const SweepPoint& p, Marker inner, Marker outer) {
                            graph.add<RollerBearing>("bearing", {inner, outer},
                                                     {.rollers = 12,
                                                      .roller_diameter = p["diameter"],
                                                      .roller_length = 9e-3,
                                                      .pitch_diameter = 40e-3,
                                                      .clearance = p["clearance"],
                                                      .slices = 3,
                                                      .profile_place = {-4.5e-3, 0, 4.5e-3},
                                                      .profile_drop = {1e-7, 0, 1e-7}});
                          }),
                  kTurned, kTurning);
}

TEST(MachineGradients, OfAJournalBearing) {
  const ParametricScene scene = machine("journal", 0.02, 1e-4, [](SystemGraph& graph, const SweepPoint& p) {
    auto& rotor = graph.add<RigidBody>("rotor", {.mass = p["mass"],
                                                 .inertia = {2e-3, 2e-3, 1e-3},
                                                 .position = {1e-5, -2e-5, 0},
                                                 .angular_velocity = {0, 0, 100}});
    auto& film = graph.add<JournalBearing>(
        "bearing", {rotor.marker(), graph.ground().marker()},
        {.radius = 0.025, .length = 0.02, .clearance = p["clearance"], .viscosity = p["viscosity"]});
    auto& plane = graph.add<PlanarJoint>("plane", {graph.ground().marker(), rotor.marker()});
    graph.add<CoordinateDrive>("drive", {plane.angle()}, {.motion = ramp(0, 100)});
    graph.add<PointForce>("load", {rotor.marker()}, {.force = {0, -p["load"], 0}});
    return std::vector<Sensor>{position(rotor.marker(), "p"), eccentricity(film, "film")};
  });
  expect_gradient(scene, {value_at("p_x", 0.02), value_at("film_eccentricity", 0.01), integral("p_y")},
                  {{"mass", 5}, {"clearance", 5e-5}, {"viscosity", 0.02}, {"load", 200}}, kOfMicrometres);
}

/// A wing that falls, held at its root.
TEST(MachineGradients, OfAnAirfoilStrip) {
  const ParametricScene scene = machine("wing", 0.3, 3e-3, [](SystemGraph& graph, const SweepPoint& p) {
    auto& wing =
        graph.add<RigidBody>("wing", {.mass = p["mass"], .inertia = {0.1, 0.2, 0.25}, .velocity = {8, 0, 0.4}});
    graph.add<AirfoilStrip>(
        "strip", {wing.marker({0.1, 0, 0}, rotation_about({0, 0, 1}, -M_PI / 2))},
        {.width = p["width"], .chord = p["chord"], .twist = p["twist"], .airfoil = linear_airfoil(), .density = 1.2});
    return std::vector<Sensor>{position(wing.marker(), "p")};
  });
  expect_gradient(scene, {value_at("p_z", 0.3), integral("p_x")},
                  {{"mass", 1.5}, {"width", 0.6}, {"chord", 0.25}, {"twist", 0.05}});
}

/// The same in a flow that remembers, on the way into stall.
TEST(MachineGradients, OfADynamicAirfoilStrip) {
  const ParametricScene scene = machine("stalling wing", 0.3, 3e-3, [](SystemGraph& graph, const SweepPoint& p) {
    const AirfoilLaw law = airfoil_table({-3.2, -0.4, -0.25, -0.1, 0, 0.1, 0.2, 0.3, 0.4, 0.6, 1, 1.6, 3.2},
                                         {0, -0.8, -0.9, -0.6, 0, 0.6, 1.1, 1.15, 0.95, 0.9, 0.9, 0.1, 0});
    auto& wing = graph.add<RigidBody>(
        "wing",
        {.mass = p["mass"], .inertia = {0.1, 0.2, 0.25}, .velocity = {8, 0, 0.4}, .angular_velocity = {0, -1, 0}});
    auto& flow = graph.add<FirstOrderStates>("flow", {.start = DynamicAirfoilStrip::start()});
    auto& strip = graph.add<DynamicAirfoilStrip>(
        "strip", {wing.marker({0.1, 0, 0}, rotation_about({0, 0, 1}, -M_PI / 2)), flow.point(0), flow.point(1)},
        {.strip = {.width = 0.6, .chord = p["chord"], .twist = p["twist"], .airfoil = law, .density = 1.2},
         .lags = {.separation = p["lag"]}});
    return std::vector<Sensor>{position(wing.marker(), "p"), strip.flow("flow")};
  });
  expect_gradient(scene, {value_at("p_z", 0.3), integral("flow_lift"), value_at("flow_separation", 0.2)},
                  {{"mass", 1.5}, {"chord", 0.25}, {"twist", 0.15}, {"lag", 3}});
}

/// A hinge that a controller moves; what its filter and its integrator remember are states of the run.
ParametricScene servo(bool diagram, MakeIntegrator method) {
  ParametricScene scene = machine("servo", 0.3, 3e-3, [=](SystemGraph& graph, const SweepPoint& p) {
    const Matrix3 y = rotation_about({1, 0, 0}, -M_PI / 2);
    auto& arm =
        graph.add<RigidBody>("arm", {.mass = p["mass"], .inertia = {0.01, 0.02, 0.02}, .position = {0.3, 0, 0}});
    auto& hinge = graph.add<RevoluteJoint>("hinge", {graph.ground().marker({}, y), arm.marker({-0.3, 0, 0}, y)});
    std::vector<Sensor> sensors{coordinate(hinge.angle(), "angle")};
    if (diagram) {
      ControlDiagram control;
      const ControlSignal error = control.number(p["target"]) - control.value(hinge.angle());
      const ControlSignal effort = control.pid(
          error, {.proportional = p["gain"], .integral = p["integral"], .derivative = 2, .filter = p["filter"]});
      control.push(hinge.angle(), effort);
      auto& states = graph.add<FirstOrderStates>("states", {.start = control.start()});
      auto& force = graph.add<ControlForce>("servo", control.markers(states), {control});
      sensors.push_back(force.sensor(effort, "effort"));
    } else {
      auto& memory = graph.add<IntegralState>("memory");
      graph.add<PidController>(
          "servo", {hinge.angle(), memory.coordinate()},
          {.target = constant(p["target"]), .proportional = p["gain"], .integral = p["integral"], .derivative = 2});
      sensors.push_back(coordinate_rate(memory.coordinate(), "memory"));
    }
    return sensors;
  });
  scene.integrator = std::move(method);
  return scene;
}
const std::vector<DesignParameter> kDiagram{
    {"mass", 1.2}, {"target", 0.4}, {"gain", 30}, {"integral", 40}, {"filter", 60}};
const std::vector<DesignParameter> kPid{{"mass", 1.2}, {"target", 0.4}, {"gain", 30}, {"integral", 40}};

TEST(MachineGradients, OfAControlDiagramAndItsStates) {
  const std::vector<Quantity> end{value_at("angle", 0.3), value_at("effort", 0.2), integral("angle")};
  expect_gradient(servo(true, exact_alpha(3e-3)), end, kDiagram);
}

/// Five masses on slides, each pushed by what all do and by a filter of it: more than one element has room for.
TEST(MachineGradients, OfALargeControlDiagram) {
  const ParametricScene scene = machine("feedback", 0.3, 3e-3, [](SystemGraph& graph, const SweepPoint& p) {
    ControlDiagram control;
    std::vector<JointCoordinate> x;
    ControlSignal sum = control.number(0);
    for (int i = 0; i < 5; ++i) {
      const Vector3 at(0, i, 0);
      auto& mass = graph.add<RigidBody>(
          "mass " + std::to_string(i),
          {.mass = p["mass"] + 0.1 * i, .position = at, .velocity = {0, 0, p["speed"] * (1 - 0.4 * i)}});
      x.push_back(graph.add<PrismaticJoint>("slide " + std::to_string(i), {graph.ground().marker(at), mass.marker()})
                      .displacement());
      sum = sum + control.value(x.back()) * control.rate(x.back());
    }
    for (int i = 0; i < 5; ++i)
      control.push(x[i], control.lag(sum, p["lag"]) - p["gain"] * (control.value(x[i]) + 0.1 * control.rate(x[i])));
    auto& states = graph.add<FirstOrderStates>("states", {.start = control.start()});
    add_control(graph, "feedback", control, states);
    return std::vector<Sensor>{coordinate(x[0], "first"), coordinate(x[4], "last")};
  });
  expect_gradient(scene, {value_at("first", 0.3), integral("last")},
                  {{"mass", 1.2}, {"speed", 1}, {"lag", 0.1}, {"gain", 30}});
}

TEST(MachineGradients, OfAPidControllerAndItsMemory) {
  const std::vector<Quantity> end{value_at("angle", 0.3), value_at("memory", 0.2)};
  expect_gradient(servo(false, exact_alpha(3e-3)), end, kPid);
}

/// A swing about a pin that rubs, through a reversal of its velocity.
template <class AddFriction>
ParametricScene rubbing_swing(const AddFriction& add_friction) {
  return machine("rubbing swing", 0.4, 2e-3, [=](SystemGraph& graph, const SweepPoint& p) {
    const Matrix3 y = rotation_about({1, 0, 0}, -M_PI / 2);
    auto& rod = graph.add<RigidBody>("rod", {.mass = p["mass"],
                                             .inertia = {0.01, 0.01, 0.01},
                                             .position = {0, 0, -0.3},
                                             .velocity = {-0.3 * p["speed"], 0, 0},
                                             .angular_velocity = {0, p["speed"], 0}});
    auto& pin = graph.add<RevoluteJoint>("pin", {graph.ground().marker({}, y), rod.marker({0, 0, 0.3}, y)});
    add_friction(graph, p, pin);
    return std::vector<Sensor>{coordinate(pin.angle(), "angle"), coordinate_rate(pin.angle(), "rate")};
  });
}
const std::vector<DesignParameter> kRubbing{{"mass", 1.1}, {"speed", 1.5}, {"friction", 0.4}};

TEST(MachineGradients, OfFrictionThroughAReversal) {
  const ParametricScene scene = rubbing_swing([](SystemGraph& graph, const SweepPoint& p, RevoluteJoint& pin) {
    graph.add<JointFriction>("rub", {pin.angle()},
                             {.joint = &pin, .coefficient = p["friction"], .creep_speed = 0.02, .radius = 0.02});
  });
  expect_gradient(scene, {value_at("angle", 0.4), integral("angle")}, kRubbing, 1e-8, false);
}

TEST(MachineGradients, OfBristlesThroughAReversal) {
  ParametricScene scene = rubbing_swing([](SystemGraph& graph, const SweepPoint& p, RevoluteJoint& pin) {
    auto& states = graph.add<FirstOrderStates>("bristles", {.start = JointBristles::start(10)});
    add_joint_bristles(
        graph, "rub", {pin.angle()}, states,
        {.joint = &pin, .coefficient = p["friction"], .breakaway_deflection = 1e-3, .load_time = 5e-3, .radius = 0.02});
  });
  expect_of_near_runs(scene, {value_at("angle", 0.4), integral("angle")}, kRubbing, 1e-6, false);
}

/// A mass on a rope of length L, thrown from d: slack, taut for half a period, and slack again,
///   x(T) = 2 L - d - v T + v π sqrt(m L/EA)
/// Where it becomes taut the force bends; nobody tells steps of it, so they resolve it as well as they are short.
TEST(MachineGradients, OfARopeThatGoesTautAndSlack) {
  const double L = 0.5, d = 0.48, EA = 4000, m = 2, v = 1.5, T = 0.08;
  const auto scene = [=](MakeIntegrator method) {
    ParametricScene thrown = machine("rope", T, 1e-3, [=](SystemGraph& graph, const SweepPoint& p) {
      auto& body = graph.add<RigidBody>(
          "mass",
          {.mass = p["mass"], .inertia = {0.01, 0.01, 0.01}, .position = {d, 0, 0}, .velocity = {p["speed"], 0, 0}});
      reeve(graph, "rope", {{graph.ground().marker()}, {body.marker()}},
            {.axial_stiffness = p["stiffness"], .length = p["length"]});
      return std::vector<Sensor>{position(body.marker(), "p")};
    });
    thrown.gravity = {0, 0, 0};
    thrown.integrator = std::move(method);
    return thrown;
  };
  const double touch = M_PI * std::sqrt(m * L / EA);
  Eigen::RowVectorXd expected(4), scales(4);
  scales << EA, m, v, L;
  expected << -v * touch / 2, v * touch / 2, v * touch - v * T, 2 * L + v * touch / 2;
  const auto off = [&](MakeIntegrator method, Mode mode) {
    const Gradient found = gradient(scene(std::move(method)), {value_at("p_x", T)},
                                    {{"stiffness", EA}, {"mass", m}, {"speed", v}, {"length", L}}, {.mode = mode});
    const double error = (found.derivatives.cwiseProduct(scales) - expected).lpNorm<Eigen::Infinity>() /
                         expected.lpNorm<Eigen::Infinity>();
    return error;
  };
  EXPECT_LT(off(exact_alpha(2e-5), Mode::tangent), 1e-3);
  EXPECT_LT(off(machine_radau(5e-5), Mode::tangent), 1e-3);
}

}  // namespace
}  // namespace lithe::test
