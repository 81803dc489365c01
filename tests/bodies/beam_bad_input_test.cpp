#include <gtest/gtest.h>

#include <limits>

#include "bodies/beam/beam.h"
#include "engine/base/rotations.h"

/// What a wrong drawing of a beam is told: which station, and what to give.
namespace lithe::test::beam_bad_input_test {
namespace {

const Material kSteel{2.1e11, 0.3, 7850};
const BeamSection kBar = BeamSection::rectangle(0.04, 0.02, kSteel);
const BeamAxis kLine = BeamAxis::straight({0, 0, 0}, {2, 0, 0});
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Each of `words` stands in the message, the name of the beam and the line of the scene too.
void expect_refused(Beam::Parameters p, const std::vector<std::string>& words) {
  SystemGraph graph;
  try {
    graph.add<Beam>("mast", std::move(p));
  } catch (const SceneError& error) {
    const std::string message = error.what();
    for (const std::string& word : words) EXPECT_NE(message.find(word), std::string::npos) << message << " / " << word;
    EXPECT_NE(message.find("mast"), std::string::npos) << message;
    EXPECT_NE(message.find("beam_bad_input_test.cpp"), std::string::npos) << message;
    EXPECT_FALSE(error.fix().empty());
    return;
  }
  ADD_FAILURE() << "accepted; wanted: " << words.front();
}

TEST(BeamBadInput, Sections) {
  const auto with = [](auto&& spoil) {
    BeamSection bad = kBar;
    spoil(bad);
    return Beam::Parameters{.axis = kLine, .sections = {{0, kBar}, {1, bad}, {2, kBar}}};
  };
  expect_refused(with([](auto& s) { s.stiffness(5, 5) = -3; }), {"section 1 (at 1.0", "bending about 3", "above zero"});
  expect_refused(with([](auto& s) { s.stiffness(1, 1) = 0; }), {"section 1 (at 1.0", "shear along 2"});
  expect_refused(with([](auto& s) { s.stiffness(3, 4) = s.stiffness(4, 3) = 1e9; }),
                 {"section 1 (at 1.0", "not positive definite", "couplings smaller"});
  expect_refused(with([](auto& s) { s.stiffness(3, 4) = 1; }), {"section 1 (at 1.0", "not symmetric"});
  expect_refused(with([](auto& s) { s.stiffness(2, 2) = kNan; }), {"section 1 (at 1.0", "stiffness"});
  expect_refused(with([](auto& s) { s.mass(0, 0) = s.mass(1, 1) = s.mass(2, 2) = -1; }),
                 {"mass per length of section 1 (at 1.0"});
  expect_refused(with([](auto& s) { s.mass(3, 3) = -1; }), {"rotary inertia of section 1 (at 1.0"});
  expect_refused(with([](auto& s) { s.damping[4] = -1e-3; }), {"damping time (bending about 2) of section 1 (at 1.0"});
  expect_refused({.axis = kLine}, {"it has no section", ".sections"});
}

TEST(BeamBadInput, Stations) {
  expect_refused({.axis = kLine, .sections = {{0, kBar}, {1.5, kBar}, {1, kBar}}},
                 {"section 2 (at 1.0", "does not lie behind", "from the start to the end"});
  expect_refused({.axis = kLine, .sections = {{0, kBar}, {0, kBar}}}, {"section 1 (at 0.0", "does not lie behind"});
  expect_refused({.axis = kLine, .sections = {{kNan, kBar}}}, {"the place of section 0"});
  expect_refused({.axis = kLine, .sections = {{0, kBar}}, .stations = {0.5, 2.1}},
                 {"the station at 2.1", "beyond its ends", "from 0 to 2.0"});
  expect_refused({.axis = kLine, .sections = {{0, kBar}}, .stations = {kNan}}, {"the station at nan"});
}

TEST(BeamBadInput, Axis) {
  expect_refused({.sections = {{0, kBar}}}, {"length"});
  expect_refused({.axis = {.length = 1}, .sections = {{0, kBar}}}, {"no curve", "BeamAxis::straight"});
  expect_refused({.axis = {.length = 3, .pose = kLine.pose}, .sections = {{0, kBar}}, .elements = 0}, {"0 elements"});
  // A length that is not the curve's, an axis 1 that points back, axes that are no rotation.
  expect_refused({.axis = {.length = 1,
                           .pose =
                               [](double s) {
                                 return FramePose{{2 * s, 0, 0}, Matrix3::Identity()};
                               }},
                  .sections = {{0, kBar}}},
                 {"element 0, from 0.0", "its length is"});
  expect_refused({.axis = {.length = 1,
                           .pose =
                               [](double s) {
                                 return FramePose{{-s, 0, 0}, Matrix3::Identity()};
                               }},
                  .sections = {{0, kBar}}},
                 {"element 0, from 0.0", "axis 1"});
  expect_refused({.axis = {.length = 1,
                           .pose =
                               [](double s) {
                                 return FramePose{{s, 0, 0}, Matrix3(2 * Matrix3::Identity())};
                               }},
                  .sections = {{0, kBar}}},
                 {"axes at 0.0"});
}

TEST(BeamBadInput, TooFewElementsForTheCurvature) {
  const BeamAxis ring = BeamAxis::curved({}, {0, 0, 2 * M_PI}, 1);
  expect_refused({.axis = ring, .sections = {{0, kBar}}, .elements = 3},
                 {"element 0, from 0.0", "120.0", "take more elements"});
  SystemGraph graph;
  EXPECT_NO_THROW(graph.add<Beam>("ring", {.axis = ring, .sections = {{0, kBar}}, .elements = 5}));
}

/// What the corner of a bent beam does (its stiffness, where its shear centre is) the drawing does not say.
TEST(BeamBadInput, AKink) {
  for (const double place : {0.3, 0.37, 0.5}) {
    const auto bent = [place](double turn) {
      return BeamAxis{
          .length = 1, .pose = [=](double s) {
            const Matrix3 axes = rotation_about({0, 0, 1}, s < place ? 0 : turn);
            const Vector3 corner(place, 0, 0);
            return FramePose{s < place ? Vector3(s, 0, 0) : Vector3(corner + (s - place) * axes.col(0)), axes};
          }};
    };
    const Beam::Parameters p{.axis = bent(0.6), .sections = {{0, kBar}}, .elements = 20};
    expect_refused(p, {"kink of 34.377", "at " + std::to_string(place).substr(0, 4), "two beams", "FixedJoint"});
    SystemGraph graph;  // an arc that turns as much, and a corner that is hardly one
    EXPECT_NO_THROW(graph.add<Beam>("straight", {.axis = bent(1e-3), .sections = {{0, kBar}}}));
    EXPECT_NO_THROW(graph.add<Beam>(
        "arc", {.axis = BeamAxis::curved({}, {0.6, 0.3, 0.6}, 1), .sections = {{0, kBar}}, .elements = 1}));
  }
}

}  // namespace
}  // namespace lithe::test::beam_bad_input_test
