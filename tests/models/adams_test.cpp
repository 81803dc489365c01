// What Adams data sets say, element by element, against closed forms and against each other.
#include <cmath>
#include <sstream>

#include "engine/base/rotations.h"
#include "engine/run/simulation.h"
#include "joints/forces/spring_damper.h"
#include "models/draw_model.h"
#include "models/read_model.h"
#include "tests/models/adams_data_set.h"
#include "tests/support/joint_checks.h"
#include "tests/support/methods.h"

namespace lithe::test::adams_test {
namespace {

TEST(AdamsMeasures, AreThoseOfThePosesAndVelocities) {
  const std::string names[] = {"DM(21,11)",    "DX(21,11,11)",    "DY(21,11)",  "DZ(21)",     "VM(21,11)",
                               "VX(21,11,11)", "VY(21,11,11,11)", "VR(21,11)",  "VR(11,21)",  "WM(21)",
                               "WX(21,11)",    "WY(21,11,21)",    "AZ(21,11)",  "AX(21,11)",  "AY(21,11)",
                               "PSI(21,11)",   "THETA(21,11)",    "PHI(21,11)", "YAW(21,11)", "PITCH(21,11)",
                               "ROLL(21,11)",  "ACCZ(20)"};
  std::string text = kBody;
  for (int k = 0; k < static_cast<int>(std::size(names)); ++k)
    text += "VARIABLE/" + std::to_string(k + 1) + ", FUNCTION=" + names[k] + "\n";
  Scene scene(text + "ACCGRAV/KGRAV=-9\n");
  const double d = M_PI / 180;
  const Matrix3 part = rotation_from_euler_313(20 * d, 30 * d, -10 * d),
                I = part * rotation_from_euler_313(5 * d, -8 * d, 12 * d),
                J = rotation_from_euler_313(-10 * d, 15 * d, 6 * d);
  const Vector3 p = Vector3(0.3, 0.1, -0.2) + part * Vector3(0.05, -0.1, 0.15), q(0.1, 0.2, 0.05), r = p - q;
  const Vector3 w = part * Vector3(0.4, 0.5, -0.3),
                v = Vector3(0.3, -0.2, 0.1) + w.cross(part * Vector3(0.05, -0.1, 0.15));
  const Matrix3 R = J.transpose() * I;
  const double expected[] = {r.norm(),
                             r.dot(J.col(0)),
                             r.y(),
                             p.z(),
                             v.norm(),
                             v.dot(J.col(0)),
                             v.dot(J.col(1)),
                             v.dot(r) / r.norm(),
                             v.dot(r) / r.norm(),
                             w.norm(),
                             w.x(),
                             w.dot(I.col(1)),
                             std::atan2(R(1, 0), R(0, 0)),
                             std::atan2(-R(1, 2), R(2, 2)),
                             std::atan2(R(0, 2), R(2, 2)),
                             0,
                             0,
                             0,
                             0,
                             0,
                             0,
                             -9};
  for (int k = 0; k < static_cast<int>(std::size(names)); ++k) {
    if (k >= 15 && k <= 20) continue;
    EXPECT_NEAR(scene.start("VARIABLE/" + std::to_string(k + 1)), expected[k], 1e-14 * 100) << names[k];
  }
  // Angles put together again give the rotation; Adams' pitch is counted the other way round.
  const auto angle = [&](int k) { return scene.start("VARIABLE/" + std::to_string(k)); };
  EXPECT_LT((rotation_from_euler_313(angle(16), angle(17), angle(18)) - R).norm(), 1e-13);
  EXPECT_LT((rotation_from_euler_321(angle(19), -angle(20), angle(21)) - R).norm(), 1e-13);
}

// ---- loads: the same said twice ----

const char* const kGeneral =
    "GFORCE/1, I=21, JFLOAT=12, RM=11\nMARKER/12, PART=1, FLOATING\n"
    ", FX=-100*DX(21,11,11)-3*VX(21,11,11,11)+5\\\n, FY=-200*DY(21,11,11)-4*VY(21,11,11,11)\\\n"
    ", FZ=-300*DZ(21,11,11)-5*VZ(21,11,11,11)\\\n, TX=-10*AX(21,11)-0.3*WX(21,11,11)\\\n"
    ", TY=-20*AY(21,11)-0.4*WY(21,11,11)+2\\\n, TZ=-30*AZ(21,11)-0.5*WZ(21,11,11)\n";

Vector6 acceleration(const std::string& text) { return Scene(kBody + text).acceleration(); }

TEST(AdamsLoads, BushingFieldAndGeneralForceAgree) {
  std::string general = kGeneral;  // the marker stands after its components' first line there
  general = "MARKER/12, PART=1, FLOATING\n" + general.substr(0, general.find("MARKER/12")) +
            general.substr(general.find("\n, FX") + 1);
  const Vector6 force = acceleration(general);
  const Vector6 bushing = acceleration(
      "BUSHING/1, I=21, J=11, K=100,200,300, C=3,4,5, KT=10,20,30, CT=0.3,0.4,0.5\n, FORCE=5,0,0, TORQUE=0,2,0\n");
  EXPECT_GT(force.norm(), 100);
  EXPECT_LT((force - bushing).norm(), 1e-12 * force.norm());
  std::string matrix = "FIELD/1, I=21, J=11, FORCE=5,0,0,0,2,0, KMATRIX=", damping = "\n, CMATRIX=";
  const double k[] = {100, 200, 300, 10, 20, 30}, c[] = {3, 4, 5, 0.3, 0.4, 0.5};
  for (int i = 0; i < 36; ++i) {
    matrix += (i ? "," : "") + std::to_string(i % 7 == 0 ? k[i / 7] : 0.0);
    damping += (i ? "," : "") + std::to_string(i % 7 == 0 ? c[i / 7] : 0.0);
  }
  EXPECT_LT((acceleration(matrix + damping + "\n") - bushing).norm(), 1e-12 * force.norm());
  // Power: what the load gives to I and J together is what its derivatives say; its tangent is that of its load.
  Scene scene(kBody + general);
  check_force(scene.graph, *scene.graph.forces()[0].force, {.conservative = false});
  Scene field(std::string(kBody) + "FIELD/1, I=21, J=11" + matrix.substr(matrix.find(", FORCE")) + damping + "\n");
  check_force(field.graph, *field.graph.forces()[0].force, {.conservative = false});
}

TEST(AdamsLoads, SpringDampersAndSingleForcesAgree) {
  const Vector6 spring = acceleration("SPRINGDAMPER/1, I=21, J=11, TRANSLATION, K=50, C=2, LENGTH=0.4, FORCE=3\n");
  EXPECT_GT(spring.norm(), 1);
  EXPECT_LT(
      (acceleration("SFORCE/1, I=21, J=11, TRANSLATIONAL\n, FUNCTION=-50*(DM(21,11)-0.4)\n, -2*VR(21,11)\n, +3\n") -
       spring)
          .norm(),
      1e-13 * spring.norm());
  // About an axis that both share.
  const std::string hinge =
      "PART/2, MASS=2, CM=20, IP=0.03,0.04,0.05, QG=1,0,0, REULER=0D,0D,30D, WZ=0.7\nMARKER/20, PART=2\nMARKER/21, "
      "PART=2\n"
      "MARKER/11, PART=1, QP=1,0,0\nJOINT/1, REVOLUTE, I=21, J=11\n";
  const Vector6 turned =
      Scene(hinge + "SPRINGDAMPER/1, I=21, J=11, ROTATION, KT=6, CT=0.2, ANGLE=10D, TORQUE=0.5\n").acceleration();
  EXPECT_NEAR(turned[5], (-6 * 20 * M_PI / 180 - 0.2 * 0.7 + 0.5) / 0.05, 1e-11);
  const Vector6 single =
      Scene(hinge + "SFORCE/1, I=21, J=11, ROTATIONAL, FUNCTION=-6*(AZ(21,11)-10D)-0.2*WZ(21,11,11)+0.5\n")
          .acceleration();
  EXPECT_LT((turned - single).norm(), 1e-11);
  // Turns count: a clock spring wound by three turns.
  Scene wound(
      hinge +
      "SFORCE/1, I=21, J=11, ROTATIONAL, FUNCTION=-0.01*AZ(21,11)+0.2\nREQUEST/1, F2=AZ(21,11)\\F3=SFORCE(1,0,8,0)\n");
  const std::vector<double> end = wound.after(5);
  // x'' = (0.2 - 0.01 x) / 0.05 from x = 30 D, x' = 0.7
  const double omega = std::sqrt(0.2), x0 = M_PI / 6 - 20;
  const double x = 20 + x0 * std::cos(5 * omega) + 0.7 / omega * std::sin(5 * omega);
  EXPECT_GT(x, 4 * M_PI);
  EXPECT_NEAR(end[0], x, 1e-7);
  EXPECT_NEAR(end[1], 0.2 - 0.01 * x, 1e-8);
}

TEST(AdamsLoads, ForcesActOnIAndTheirOppositeOnTheOtherPart) {
  // Two free parts, no gravity: neither momentum nor angular momentum changes.
  const std::string other =
      "PART/3, MASS=1.5, CM=30, IP=0.02,0.03,0.04, QG=-0.4,0.6,0.2\nMARKER/30, PART=3\nMARKER/31, PART=3, "
      "QP=0.1,0.2,0.3\n"
      "MARKER/32, PART=3, FLOATING\n";
  for (const std::string load :
       {"VFORCE/1, I=21, JFLOAT=32, RM=31, FX=1\\FY=2+TIME\\FZ=-3*DX(21,31)",
        "VTORQUE/1, I=21, JFLOAT=32, TX=1\\TY=2\\TZ=3", "GFORCE/1, I=21, JFLOAT=32, RM=21, FX=1\\TY=2\\FZ=3",
        "SFORCE/1, I=21, J=31, TRANSLATIONAL, FUNCTION=7", "SFORCE/1, I=21, J=31, ROTATIONAL, FUNCTION=7",
        "BUSHING/1, I=21, J=31, K=100,200,300, KT=1,2,3, C=1,2,3, CT=1,1,1",
        "BEAM/1, I=21, J=31, LENGTH=0.8, AREA=1E-4, IXX=2E-9, IYY=1E-9, IZZ=3E-9, EMODULUS=2E9, GMODULUS=8E8, "
        "CRATIO=0.01"}) {
    Scene scene(kBody + other + load + "\n");
    const System system = assemble(scene.graph);
    const State state = system.initial_state();
    Snapshot now(system, state);
    Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
    double size = 1;
    for (const auto& [id, mass, J] :
         {std::tuple(20, 2.0, Vector3(0.03, 0.04, 0.05)), {30, 1.5, Vector3(0.02, 0.03, 0.04)}}) {
      const MarkerKinematics k = now.marker(scene.drawn.adams_marker(id));
      const Vector6 a = now.acceleration(scene.drawn.adams_marker(id));
      const Matrix3 inertia = k.R * J.asDiagonal() * k.R.transpose();
      force += mass * a.head<3>();
      size += a.norm();
      moment += k.p.cross(mass * a.head<3>()) + inertia * a.tail<3>() + k.w.cross(inertia * k.w);
    }
    EXPECT_LT(force.norm(), 1e-13 * size) << load;
    EXPECT_LT(moment.norm(), 1e-13 * size) << load;
  }
  // ACTIONONLY: along z of J, on I alone.
  Scene thrust(std::string(kBody) +
               "SFORCE/1, I=20, J=21, TRANSLATIONAL, ACTIONONLY, FUNCTION=4\nREQUEST/1, F2=FM(20)\n");
  EXPECT_NEAR(thrust.start("REQUEST/1"), 4, 1e-14);
  const double d = M_PI / 180;
  const Vector3 z =
      rotation_from_euler_313(20 * d, 30 * d, -10 * d) * rotation_from_euler_313(5 * d, -8 * d, 12 * d).col(2);
  EXPECT_LT((thrust.acceleration().head<3>() - 2 * z).norm(), 1e-13);
}

// A cantilever of length L: a force F at its tip bends it by F L³ / 3 E I and turns it by F L² / 2 E I.
TEST(AdamsLoads, ABeamIsACantilever) {
  const double E = 2e11, I = 1e-10, L = 2, F = 1e-3, y = F * L * L * L / (3 * E * I), turn = F * L * L / (2 * E * I);
  std::ostringstream text;
  text.precision(17);
  text << "MARKER/11, PART=1\nPART/2, MASS=1, CM=20, IP=1,1,1, QG=2," << y << ",0, REULER=" << turn
       << ",0,0\nMARKER/20, PART=2\n"
       << "BEAM/1, I=20, J=11, LENGTH=2, AREA=1E-4, IXX=2E-10, IYY=1E-10, IZZ=1E-10, EMODULUS=2E11, GMODULUS=8E10\n"
       << "REQUEST/1, F, I=20, J=11\nREQUEST/2, F2=BEAM(1,1,3,0)\n";
  Scene scene(text.str());
  EXPECT_NEAR(scene.start("REQUEST/1", 2), -F, 1e-9 * F);
  EXPECT_NEAR(scene.start("REQUEST/1", 7), 0, 1e-9 * F * L);
  EXPECT_NEAR(scene.start("REQUEST/2"), F, 1e-9 * F);
}

// ---- units, inertia ----

TEST(AdamsUnits, TheSameInMillimetresGramsAndMilliseconds) {
  const std::string parts =
      "PART/1, GROUND\nMARKER/1, PART=1\nPART/2, MASS=%M, CM=20, IP=%I,%I,%I, QG=%L,0,0, VX=%V, WY=%W\nMARKER/20, "
      "PART=2\n"
      "MARKER/21, PART=2, QP=%L,%L,0\nACCGRAV/KGRAV=%G\n"
      "SPRINGDAMPER/1, I=21, J=1, TRANSLATION, K=%K, C=%C, LENGTH=%L\nSFORCE/2, I=20, J=1, TRANSLATIONAL, "
      "FUNCTION=%F*SIN(%O*TIME)*DM(20,1)\n"
      "BUSHING/3, I=21, J=1, KT=%T,%T,%T, K=%K,0,0\nREQUEST/1, "
      "F2=FX(21,1)\\F3=VX(20)\\F4=ACCX(20)\\F5=TX(21,1)\\F6=WDTY(20)\nEND\n";
  const auto filled = [&](const std::string& units, const std::map<char, double>& values) {
    std::string text = "t\n" + units;
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (parts[i] == '%') {
        std::ostringstream number;
        number.precision(17);
        number << values.at(parts[++i]);
        text += number.str();
      } else {
        text += parts[i];
      }
    return text;
  };
  const std::map<char, double> si = {{'M', 2},  {'I', 0.05}, {'L', 0.4}, {'V', 0.3}, {'W', 2}, {'G', -9.8},
                                     {'K', 30}, {'C', 0.5},  {'F', 6},   {'O', 3},   {'T', 4}};
  // g, mm, ms, kN: a force of 1 kN, 1e-3 of it per N, and so on.
  const std::map<char, double> other = {{'M', 2e3},  {'I', 0.05 * 1e9}, {'L', 400},   {'V', 0.3},
                                        {'W', 2e-3}, {'G', -9.8e-3},    {'K', 30e-6}, {'C', 0.5e-3},
                                        {'F', 6e-6}, {'O', 3e-3},       {'T', 4}};
  const auto run = [&](const std::string& text) {
    const ScratchFolder folder;
    const ModelDescription model = read_model(folder.write("m.adm", text));
    SystemGraph graph{{.gravity = model.gravity}};
    const DrawnModel drawn = draw_model(graph, model);
    const System system = assemble(graph);
    const Method method = runge_kutta8(1e-11);
    Simulation simulation(system, *method);
    State state = system.initial_state();
    simulation.run(state, 1);
    Snapshot now(system, state);
    VectorX all(state.q.size() + 5);
    all.head(state.q.size()) = state.q;
    for (int c = 0; c < 5; ++c) all[state.q.size() + c] = drawn.outputs()[0].value(now, c);
    return all;
  };
  VectorX a = run(filled("UNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\n", si));
  VectorX b = run(filled("UNITS/FORCE=KNEWTON, MASS=GRAM, LENGTH=MILLIMETER, TIME=MILLISECOND\n", other));
  const Eigen::Index n = a.size() - 5;
  b[n] *= 1e3, b[n + 1] *= 1, b[n + 2] *= 1e3, b[n + 3] *= 1, b[n + 4] *= 1e6;  // N, m/s, m/s², N m, rad/s²
  for (Eigen::Index i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-8 * (1 + std::abs(a[i]))) << i;
}

TEST(AdamsParts, InertiaIsAboutImAndProductsAreIntegrals) {
  // Two points of 1 kg at ±(1, 2, 3): Ixy = ∫ xy dm = 4, ...; seen from IM, turned and moved.
  const double d = M_PI / 180;
  const Matrix3 R = rotation_from_euler_313(30 * d, 40 * d, 50 * d);
  const Vector3 o(0.2, -0.4, 0.5);
  Vector6 I = Vector6::Zero();
  Matrix3 about_centre = Matrix3::Zero();
  for (const Vector3& r : {Vector3(1, 2, 3), Vector3(-1, -2, -3), Vector3(2, -1, 0), Vector3(-2, 1, 0)}) {
    const Vector3 x = R.transpose() * (r - o);
    I += (Vector6() << x.y() * x.y() + x.z() * x.z(), x.x() * x.x() + x.z() * x.z(), x.x() * x.x() + x.y() * x.y(),
          x.x() * x.y(), x.x() * x.z(), x.y() * x.z())
             .finished();
    about_centre += r.squaredNorm() * Matrix3::Identity() - r * r.transpose();
  }
  std::ostringstream text;
  text.precision(17);
  text << "PART/2, MASS=4, CM=20, IM=21, IP=" << I[0];
  for (int i = 1; i < 6; ++i) text << "," << I[i];
  text << "\nMARKER/20, PART=2\nMARKER/21, PART=2, QP=0.2,-0.4,0.5, REULER=30D,40D,50D\n";
  EXPECT_LT((Scene(text.str()).model.links[1].inertia - about_centre).norm(), 1e-12);
}

TEST(AdamsParts, MarkersByPoints) {
  Scene scene(
      "PART/2, MASS=1, CM=20, IP=1,1,1, QG=1,0,0, ZG=1,1,0, XG=1,0,1\nMARKER/20, PART=2\n"
      "MARKER/21, PART=2, QP=0,0,1, ZP=1,0,1, XP=0,1,1\n");
  Matrix3 part, marker;
  part << 0, 0, -1 * -1, 0, 0, 0, 0, 0, 0;  // z along y, x along z: y along x
  part.col(2) = Vector3::UnitY(), part.col(0) = Vector3::UnitZ(), part.col(1) = Vector3::UnitX();
  marker.col(2) = Vector3::UnitX(), marker.col(0) = Vector3::UnitY(), marker.col(1) = Vector3::UnitZ();
  const System system = assemble(scene.graph);
  const State state = system.initial_state();
  Snapshot now(system, state);
  EXPECT_LT((now.marker(scene.drawn.adams_marker(20)).R - part).norm(), 1e-14);
  EXPECT_LT((now.marker(scene.drawn.adams_marker(21)).R - part * marker).norm(), 1e-14);
}

// ---- joints, motions, couplings ----

TEST(AdamsJoints, LeaveTheFreedomsThatAdamsSays) {
  const std::string body =
      "PART/2, MASS=2, CM=20, IP=0.03,0.04,0.05\nMARKER/20, PART=2\nMARKER/21, PART=2\nMARKER/11, PART=1\n"
      "MARKER/22, PART=2, REULER=0D,90D,0D\nMARKER/23, PART=2, REULER=0D,180D,0D\n";
  const std::pair<const char*, int> all[] = {{"JOINT/1, REVOLUTE, I=21, J=11", 1},
                                             {"JOINT/1, TRANSLATIONAL, I=21, J=11", 1},
                                             {"JOINT/1, CYLINDRICAL, I=21, J=11", 2},
                                             {"JOINT/1, SPHERICAL, I=21, J=11", 3},
                                             {"JOINT/1, FIXED, I=21, J=11", 0},
                                             {"JOINT/1, PLANAR, I=21, J=11", 3},
                                             {"JOINT/1, HOOKE, I=21, J=11", 2},
                                             {"JOINT/1, UNIVERSAL, I=22, J=11", 2},
                                             {"JOINT/1, CONVEL, I=23, J=11", 2},
                                             {"JOINT/1, SCREW, I=21, J=11, PITCH=0.1", 1},
                                             {"JPRIM/1, ATPOINT, I=21, J=11", 3},
                                             {"JPRIM/1, INLINE, I=21, J=11", 4},
                                             {"JPRIM/1, INPLANE, I=21, J=11", 5},
                                             {"JPRIM/1, ORIENTATION, I=21, J=11", 3},
                                             {"JPRIM/1, PARALLEL_AXES, I=21, J=11", 4},
                                             {"JPRIM/1, PERPENDICULAR, I=22, J=11", 5},
                                             {"GCON/1, FUNCTION=DX(21,11)-0.1*AZ(21,11)", 5}};
  for (const auto& [joint, freedoms] : all) {
    Scene scene(body + joint + "\n");
    EXPECT_EQ(assemble(scene.graph).degrees_of_freedom(), freedoms) << joint;
  }
}

// Constant velocity: bent shafts turn at one speed; in Adams z of both markers points away from the joint.
TEST(AdamsJoints, ConvelTurnsBothShaftsAlike) {
  Scene scene(
      "PART/2, MASS=1, CM=20, IP=0.1,0.1,0.1\nMARKER/20, PART=2, QP=0,0,-1\nMARKER/21, PART=2, REULER=0D,180D,0D\n"
      "MARKER/22, PART=2, QP=0,0,-1\nMARKER/12, PART=1, QP=0,0,-1\n"
      "PART/3, MASS=1, CM=30, IP=0.1,0.1,0.1, REULER=0D,30D,0D\nMARKER/30, PART=3, QP=0,0,1\nMARKER/31, PART=3\n"
      "MARKER/32, PART=3, QP=0,0,1\nMARKER/13, PART=1, QP=0,-0.5,0.8660254037844386, REULER=0D,30D,0D\n"
      "MARKER/33, PART=3\n"
      "JOINT/1, REVOLUTE, I=22, J=12\nJOINT/2, REVOLUTE, I=32, J=13\nJOINT/3, CONVEL, I=21, J=31\n"
      "SFORCE/1, I=22, J=12, ROTATIONAL, FUNCTION=1\nREQUEST/1, F2=AZ(22,12)\\F3=AZ(32,13)\n");
  EXPECT_EQ(assemble(scene.graph).degrees_of_freedom(), 1);
  const std::vector<double> turns = scene.after(2);
  EXPECT_NEAR(turns[0], 0.5 * 1 / 0.2 * 4, 1e-7);  // both shafts' inertia
  EXPECT_NEAR(turns[1], turns[0], 1e-8);
}

TEST(AdamsJoints, AMotionFollowsItsFunctionAndAVelocityItsIntegral) {
  const std::string slide =
      "PART/2, MASS=2, CM=20, IP=1,1,1\nMARKER/20, PART=2\nMARKER/21, PART=2\nMARKER/11, PART=1\n"
      "JOINT/1, TRANSLATIONAL, I=21, J=11\nREQUEST/1, F2=DZ(21,11,11)\\F3=VZ(21,11,11)\\F4=MOTION(1,0,4,0)\n";
  const double u = 1.3 / 2;
  for (const char* motion : {"MOTION/1, JOINT=1, TRANSLATION, FUNCTION=STEP5(TIME, 0, 0, 2, 3)",
                             "MOTION/1, I=21, J=11, Z, FUNCTION=STEP5(TIME, 0, 0, 2, 3)",
                             "MOTION/1, JOINT=1, VELOCITY, FUNCTION=3*30/2*(TIME/2)**2*(1-TIME/2)**2"}) {
    const std::vector<double> end = Scene(slide + motion + "\n").after(1.3);
    const double x = end[0], v = end[1], force = end[2];
    EXPECT_NEAR(x, 3 * u * u * u * (10 - 15 * u + 6 * u * u), 2e-8) << motion;
    EXPECT_NEAR(v, 1.5 * 30 * u * u * (1 - u) * (1 - u), 1e-8) << motion;
    EXPECT_NEAR(force, 2 * 0.75 * 60 * u * (1 - u) * (1 - 2 * u), 1e-7) << motion;
  }
}

TEST(AdamsJoints, GearsAndCouplersTieAngles) {
  const std::string gears =
      "PART/2, MASS=1, CM=20, IP=1,1,0.2\nMARKER/20, PART=2\nMARKER/11, PART=1\n"
      "PART/3, MASS=1, CM=30, IP=1,1,0.5, QG=0.5,0,0\nMARKER/30, PART=3\nMARKER/13, PART=1, QP=0.5,0,0\n"
      "JOINT/1, REVOLUTE, I=20, J=11\nJOINT/2, REVOLUTE, I=13, J=30\n"  // the second counted the other way round
      "MARKER/15, PART=1, QP=0.2,0,0, REULER=0D,-90D,0D\n"              // 0.2 and 0.3, z along y
      "SFORCE/1, I=20, J=11, ROTATIONAL, FUNCTION=2\n"
      "REQUEST/1, F2=WDTZ(20)\\F3=WDTZ(30)\n";
  // r2 w2 = -r1 w1:  I1 a1 + I2 (r1/r2)² a1 = 2
  const double first = 2 / (0.2 + 0.5 * 4.0 / 9);
  for (const char* tie : {"GEAR/1, JOINTS=1,2, CV=15", "COUPLER/1, JOINTS=1,2, SCALES=2,-3"}) {
    Scene scene(gears + tie + "\n");
    EXPECT_NEAR(scene.start("REQUEST/1", 0), first, 1e-12) << tie;
    EXPECT_NEAR(scene.start("REQUEST/1", 1), -first * 2 / 3, 1e-12) << tie;
  }
  // A slide and a wheel: 1 * angle - 4 * displacement = 0.
  Scene rack(
      "PART/2, MASS=1, CM=20, IP=1,1,0.2\nMARKER/20, PART=2\nMARKER/11, PART=1\nPART/3, MASS=3, CM=30, IP=1,1,1\n"
      "MARKER/30, PART=3\nMARKER/13, PART=1\nJOINT/1, CYLINDRICAL, I=20, J=11\nJPRIM/1, INPLANE, I=20, J=11\n"
      "JOINT/2, TRANSLATIONAL, I=30, J=13\nCOUPLER/1, JOINTS=1,2, TYPE=R:T, SCALES=-4\n"
      "SFORCE/1, I=20, J=11, ROTATIONAL, FUNCTION=2\nREQUEST/1, F2=WDTZ(20)\\F3=ACCZ(30)\n");
  const double a = 2 / (0.2 + 3.0 / 16);
  EXPECT_NEAR(rack.start("REQUEST/1", 0), a, 1e-12);
  EXPECT_NEAR(rack.start("REQUEST/1", 1), a / 4, 1e-12);
}

// The pinion rolls on the side on which the rack is drawn: at the pitch point both have one velocity. Rack along z,
// pinion about x: on the side of -y of the pinion (which is -y here) a falling rack turns it by +v/r about x ...
TEST(AdamsJoints, ARackTurnsItsPinionAsItRolls) {
  for (const double side : {-0.1, 0.1, 0.0}) {
    std::ostringstream text;
    text << "PART/2, MASS=1, CM=20, IP=0.04,0.04,0.02\nMARKER/20, PART=2, REULER=90D,90D,-90D\n"
         << "MARKER/11, PART=1, REULER=90D,90D,-90D\n"
         << "PART/3, MASS=3, CM=30, IP=1,1,1\nMARKER/30, PART=3, QP=0," << side << ",0, REULER=0D,180D,0D\n"
         << "MARKER/13, PART=1, QP=0," << side << ",0, REULER=0D,180D,0D\n"
         << "JOINT/1, REVOLUTE, I=20, J=11\nJOINT/2, TRANSLATIONAL, I=30, J=13\n"
         << "JOINT/3, RACKPIN, I=20, J=30, PD=0.2\nACCGRAV/KGRAV=-10\nREQUEST/1, F2=WDTX(20)\\F3=ACCZ(30)\n";
    Scene scene(text.str());
    const double fall = -10 * 3 / (3 + 0.02 / 0.01);
    EXPECT_NEAR(scene.start("REQUEST/1", 1), fall, 1e-12);
    // ω x r at the pitch point (0, side, 0): its z is ω side
    EXPECT_NEAR(scene.start("REQUEST/1", 0), fall / (side == 0 ? -0.1 : side), 1e-11) << side;
    EXPECT_NE(scene.model.sheet().find("RACKPIN"), std::string::npos);
  }
}

// A wheel that rolls along x by a GCON: turns count, and its rows are the derivatives of its function.
TEST(AdamsJoints, AConstraintByAFunctionHoldsOverTurns) {
  Scene scene(
      "PART/2, MASS=1, CM=20, IP=1,1,0.01\nMARKER/20, PART=2\nMARKER/11, PART=1\nJOINT/1, PLANAR, I=20, J=11\n"
      "GCON/1, FUNCTION=DX(20,11,11)+0.1*AZ(20,11)\nGCON/2, FUNCTION=DY(20,11,11)-0.01*SIN(3*DX(20,11))-0.02*TIME**2\n"
      "ACCGRAV/IGRAV=2\nREQUEST/1, F2=DX(20,11)\\F3=AZ(20,11)\\F4=DY(20,11)-0.01*SIN(3*DX(20,11))-0.02*TIME**2\n");
  check_joint(scene.graph, *scene.graph.find<Constraint>("GCON/1"), {.rank = 1, .tolerance = 1e-7});
  check_joint(scene.graph, *scene.graph.find<Constraint>("GCON/2"), {.rank = 1, .tolerance = 1e-7});
  const std::vector<double> end = scene.after(3);
  EXPECT_GT(end[0], 2.0);  // three turns and more
  EXPECT_NEAR(end[0] + 0.1 * end[1], 0, 1e-9);
  EXPECT_NEAR(end[2], 0, 1e-9);
}

TEST(AdamsSettings, AreTaken) {
  const ModelDescription model =
      Scene(std::string(kBody) +
            "ACCGRAV/IGRAV=1, JGRAV=2, KGRAV=-3\nINTEGRATOR/GSTIFF, SI2, ERROR=1.0E-4, HMAX=0.01\n"
            "SIMULATE/TRANSIENT, END=3, STEPS=60\n")
          .model;
  EXPECT_EQ(model.gravity, Vector3(1, 2, -3));
  EXPECT_DOUBLE_EQ(model.tolerance.value(), 1e-4);
  EXPECT_DOUBLE_EQ(model.duration.value(), 3);
  EXPECT_DOUBLE_EQ(model.every.value(), 0.05);
  EXPECT_NE(model.sheet().find("the method of INTEGRATOR"), std::string::npos);
}

}  // namespace
}  // namespace lithe::test::adams_test
