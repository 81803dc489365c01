// The function language of Adams, by its definitions.
#include <cmath>
#include <sstream>

#include "bodies/rigid_body.h"
#include "engine/run/simulation.h"
#include "joints/forces/spring_damper.h"
#include "models/adams/adams_scene.h"
#include "tests/models/adams_data_set.h"
#include "tests/support/joint_checks.h"

namespace lithe::test::adams_test {
namespace {

TEST(AdamsFunctions, AreThoseOfTheirDefinitions) {
  const double d = M_PI / 180;
  const std::pair<const char*, double> all[] = {
      {"1+2*3-4/8", 6.5},
      {"-2**2", -4},
      {"2**3**2", 512},
      {"2**-1", 0.5},
      {"-3*-2", 6},
      {"(1.5E1+.5)*2.", 31},
      {"90D", M_PI / 2},
      {"sin(30D)+Cos(60d)", 1},
      {"RTOD*DTOR*PI", M_PI},
      {"IF(-1: 1, 2, 3)", 1},
      {"IF(0: 1, 2, 3)", 2},
      {"IF(1: 1, 2, 1/0)", INFINITY},
      {"IF(-1: 1, 2, 1/0)", 1},
      {"STEP(1.25, 1, 10, 2, 20)", 10 + 10 * 0.0625 * 2.5},
      {"STEP(0, 1, 10, 2, 20)", 10},
      {"STEP5(1.5, 1, 10, 2, 20)", 15},
      {"STEP5(1.25, 1, 0, 2, 1)", std::pow(0.25, 3) * (10 - 15 * 0.25 + 6 * 0.0625)},
      {"HAVSIN(1.25, 1, 0, 2, 1)", 0.5 + 0.5 * std::sin(M_PI * 0.25 - M_PI / 2)},
      {"IMPACT(0.9, -2, 1, 100, 1.5, 4, 0.2)", 100 * std::pow(0.1, 1.5) + 2 * 4 * 0.5},
      {"IMPACT(1.1, -2, 1, 100, 1.5, 4, 0.2)", 0},
      {"IMPACT(0.99, 5, 1, 1, 1.5, 400, 0.01)", 0},
      {"BISTOP(2.1, 3, 1, 2, 100, 1.5, 4, 0.2)", -(100 * std::pow(0.1, 1.5) + 3 * 4 * 0.5)},
      {"BISTOP(0.9, -2, 1, 2, 100, 1.5, 4, 0.2)", 100 * std::pow(0.1, 1.5) + 2 * 4 * 0.5},
      {"BISTOP(1.5, 9, 1, 2, 100, 1.5, 4, 0.2)", 0},
      {"POLY(3, 1, 1, 2, 3)", 1 + 2 * 2 + 3 * 4},
      {"SHF(2, 0.5, 3, 4, 0.1, 7)", 3 * std::sin(4 * 1.5 - 0.1) + 7},
      {"FORSIN(2, 0.5, 3, 1, 2, 4)", 1 + 2 * std::sin(4.5) + 4 * std::sin(9)},
      {"FORCOS(2, 0.5, 3, 1, 2, 4)", 1 + 2 * std::cos(4.5) + 4 * std::cos(9)},
      {"CHEBY(2, 0.5, 1, 2, 3, 4)", 1 + 2 * 1.5 + 3 * (2 * 1.5 * 1.5 - 1) + 4 * (4 * std::pow(1.5, 3) - 3 * 1.5)},
      {"MOD(-7, 3)+10*SIGN(2, -1)+100*DIM(5, 3)+1000*MAX(1, 2)+MIN(1, 2)", -1 - 20 + 200 + 2000 + 1},
      {"AINT(-1.7)+10*ANINT(-1.7)", -1 - 20},
      {"SQRT(16)+ABS(-3)+EXP(0)+LOG(1)+LOG10(1000)", 11},
      {"ATAN2(1, -1)+ATAN(1)+ASIN(1)+ACOS(1)", 0.75 * M_PI + M_PI / 4 + M_PI / 2},
      {"SINH(1)**2-COSH(1)**2+TANH(0)+TAN(0)", -1},
      {"0.0**2+(-2)**3+4**0.5", -6},
      {"TIME", 0},
      {"VARVAL(2)*VARVAL(2)", 49}};
  for (const auto& [function, expected] : all) {
    const double found = value(function, "VARIABLE/2, FUNCTION=3+4\n");
    if (std::isinf(expected))
      EXPECT_EQ(found, expected) << function;
    else
      EXPECT_NEAR(found, expected, 1e-13 * (1 + std::abs(expected))) << function;
  }
  EXPECT_NEAR(value("45D"), 45 * d, 1e-15);
}

// Text of a tree is that of another tree with the same values, and stays what it is.
TEST(AdamsFunctions, AreReadAgainFromTheirText) {
  SystemGraph graph;
  const AdamsScene scene(graph, {}, {});
  const auto again = [&](const std::string& text) { return adams_text(scene.function(text)); };
  for (const char* text : {"1-2*3-4/8", "(1-2)*-3", "-2**2", "(-2)**2", "2**3**2", "(2**3)**2", "1-(2-3)", "8/2/2",
                           "8/(2/2)", "8/2*3", "2*(8/3)", "-(1+2)*3", "1--2", "IF(TIME-1: 1, 2*TIME, -3)",
                           "STEP(TIME, 0, 0, 1, 5)**2", "1.5E-9*TIME", "POLY(3, 1, 1, -2, 3)-MAX(1, 2)"}) {
    EXPECT_EQ(value(again(text)), value(text)) << text << " is " << again(text);
    EXPECT_EQ(again(again(text)), again(text));
  }
  EXPECT_EQ(again("VX(3,4)-DM(5)*WZ(6,7,8)/YAW(1,2)+ORIENT(27,3,1,2)"),
            "VX(3, 4, 0, 0)-DM(5, 0)*WZ(6, 7, 8)/YAW(1, 2)+ORIENT(27, 3, 1, 2)");
  EXPECT_THROW(scene.function("VARVAL(1)"), SceneError);
  EXPECT_THROW(scene.function("AKISPL(TIME, 0, 1)"), SceneError);
  EXPECT_THROW(scene.function("SINE(1)"), SceneError);
  EXPECT_THROW(adams_text(scene.function("FX(1,2)")), SceneError);
}

// In a scene of one's own: a spring and damper of Adams beside ours, and markers that were not given.
TEST(AdamsFunctions, ActInASceneOfOnesOwn) {
  const auto motion = [](bool by_function) {
    SystemGraph graph;
    auto& bob = graph.add<RigidBody>("bob", {.mass = 2, .inertia = {1, 1, 1}, .position = {0.3, 0, -1}});
    if (by_function) {
      AdamsScene adams(graph, {.length = 1e-3}, {{1, graph.ground().marker()}, {2, bob.marker({0, 0, 0.1})}});
      adams.add("force", AdamsModel::Load{.kind = AdamsModel::Load::Kind::along_line,
                                          .i = 2,
                                          .j = 1,
                                          .functions = {{adams.function("-0.1*(DM(2,1)-700)-0.02*VR(2,1)")}}});
      EXPECT_THROW(adams.add("lost", AdamsModel::Constraint{adams.function("DX(2,9)")}), SceneError);
    } else {
      graph.add<SpringDamper>("force", {graph.ground().marker(), bob.marker({0, 0, 0.1})},
                              {.stiffness = 100, .damping = 20, .natural_length = 0.7});
    }
    const System system = assemble(graph);
    State state = system.initial_state();
    const auto method = runge_kutta(1e-10);
    Simulation{system, *method}.run(state, 1);
    return state.q;
  };
  EXPECT_LT((motion(true) - motion(false)).lpNorm<Eigen::Infinity>(), 1e-8);
}

// A parabola is what Akima's curve and its ends reproduce, a cubic what a not-a-knot spline does. Adams says of the
// ends: a parabola through the last three points, or with LINEAR_EXTRAPOLATE a line through the last two.
TEST(AdamsFunctions, SplinesAreExactWhereTheirKindIsAndGoOnBeyondTheirEnds) {
  const auto table = [](auto&& f, const std::string& more) {
    std::ostringstream text;
    text.precision(17);
    text << "SPLINE/1" << more << ", X=-1,0,1,2,3,4\n, Y=";
    for (int x = -1; x <= 4; ++x) text << (x > -1 ? ", " : "") << f(static_cast<double>(x));
    text << "\n";
    return text.str();
  };
  const auto parabola = [](double x) { return 1 + 2 * x - 0.5 * x * x; };
  const auto cubic = [](double x) { return 1 + 2 * x - 0.5 * x * x + 0.3 * x * x * x; };
  for (const double x : {-0.7, 0.25, 1.5, 3.99, -3.0, 6.0}) {
    const std::string at = std::to_string(x);
    EXPECT_NEAR(value("AKISPL(" + at + ", 0, 1)", table(parabola, "")), parabola(x), 1e-12) << x;
    EXPECT_NEAR(value("AKISPL(" + at + ", 0, 1, 1)", table(parabola, "")), 2 - x, 1e-12) << x;
    EXPECT_NEAR(value("CUBSPL(" + at + ", 0, 1, 2)", table(parabola, "")), -1, 1e-11) << x;
    if (x > -1 && x < 4) {
      EXPECT_NEAR(value("CUBSPL(" + at + ", 0, 1)", table(cubic, "")), cubic(x), 1e-12) << x;
    }
  }
  const std::string line = table(parabola, ", LINEAR_EXTRAPOLATE");
  EXPECT_NEAR(value("AKISPL(6, 0, 1)", line), parabola(4) + 2 * (parabola(4) - parabola(3)), 1e-12);
  EXPECT_NEAR(value("CUBSPL(-2, 0, 1)", line), parabola(-1) - (parabola(0) - parabola(-1)), 1e-12);
  // A step in the slope stays local with Akima: three equal slopes on either side leave straight lines there.
  const auto bend = [](double x) { return x < 2 ? 0 : x - 2; };
  EXPECT_NEAR(value("AKISPL(0.5, 0, 1)", table(bend, "")), 0, 1e-14);
}

}  // namespace
}  // namespace lithe::test::adams_test
