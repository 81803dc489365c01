#include "joints/gears/gear_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "joints/gears/bevel_gear_pair.h"
#include "joints/gears/mesh_stiffness.h"
#include "joints/gears/sprocket_pair.h"
#include "joints/gears/toothed_gear_pair.h"
#include "joints/gears/toothed_rack.h"
#include "tests/support/message_of.h"

namespace lithe::test::gear_geometry_test {
namespace {

constexpr double kPi = std::numbers::pi, kDegree = kPi / 180;

GearDesign spur(double teeth_A, double teeth_B) {
  return {.module = 3e-3, .teeth_A = teeth_A, .teeth_B = teeth_B, .face_width = 20e-3};
}

/// r, r_b, r_a, r_f by hand; contact ratio by the textbook's formula with tan of the tips' pressure angles.
TEST(GearGeometry, HasTheRadiiAndTheContactRatioOfAStandardPair) {
  const GearGeometry g(spur(20, 30));
  EXPECT_NEAR(g.A.pitch_radius, 30e-3, 1e-15);
  EXPECT_NEAR(g.A.base_radius, 28.190778623577e-3, 1e-14);
  EXPECT_NEAR(g.A.tip_radius, 33e-3, 1e-15);
  EXPECT_NEAR(g.A.root_radius, 26.25e-3, 1e-15);
  EXPECT_NEAR(g.centre_distance, 75e-3, 1e-15);
  EXPECT_NEAR(g.A.undercut_teeth, 2 / std::pow(std::sin(20 * kDegree), 2), 1e-12);
  EXPECT_NEAR(g.A.tooth_thickness, 0.5 * kPi * 3e-3, 1e-15);
  EXPECT_NEAR(g.backlash, 0, 1e-15);
  const auto tip = [](double z) { return std::tan(std::acos(z * std::cos(20 * kDegree) / (z + 2))); };
  const double expected =
      (20 * (tip(20) - std::tan(20 * kDegree)) + 30 * (tip(30) - std::tan(20 * kDegree))) / (2 * kPi);
  EXPECT_NEAR(g.contact_ratio, expected, 1e-12);
  // Helical: transverse pressure angle and overlap, b sin β/(π m_n).
  GearDesign d = spur(20, 30);
  d.helix_angle = 15 * kDegree;
  const GearGeometry h(d);
  EXPECT_NEAR(h.transverse_pressure_angle, 20.6469 * kDegree, 1e-6);
  EXPECT_NEAR(h.overlap_ratio, 20e-3 * std::sin(15 * kDegree) / (kPi * 3e-3), 1e-12);
  EXPECT_NEAR(std::tan(h.base_helix_angle) / std::cos(h.transverse_pressure_angle), std::tan(15 * kDegree), 1e-12);
}

/// The play between flanks, found from involutes, against the thicknesses of teeth on the working circles, which fill
/// the pitch there but for the backlash: external, helical, shifted, internal; by centre distance and by thinner teeth.
TEST(GearGeometry, HasTheBacklashThatItsTeethLeaveOnTheWorkingCircles) {
  for (const bool ring : {false, true})
    for (const double helix : {0.0, 0.3})
      for (const double more : {0.0, 2e-4})
        for (const double thinner : {0.0, 5e-5}) {
          GearDesign d = spur(24, ring ? -70 : 35);
          d.helix_angle = helix, d.shift_A = 0.3, d.shift_B = ring ? -0.1 : 0.2, d.shortening_B = ring ? 0.35 : 0;
          d.centre_distance = std::abs(GearGeometry(d).centre_distance) + (ring ? -more : more);
          d.backlash = thinner;
          const GearGeometry g(d);
          const double pitch = 2 * kPi * g.A.working_radius / g.A.teeth;
          const double gap = (pitch - g.A.tooth_thickness - g.B.tooth_thickness) * std::cos(g.working_pressure_angle);
          EXPECT_NEAR(g.backlash, gap, 1e-15);
          EXPECT_NEAR(g.A.working_radius + g.B.working_radius, g.centre_distance, 1e-15);
          if (more + thinner > 0) {
            EXPECT_GT(g.backlash, 4e-5);
          }
        }
}

TEST(GearGeometry, SaysWhyGearsAreImpossibleAndWhatToChange) {
  const auto message = [](const GearDesign& d) { return message_of<SceneError>([&] { GearGeometry{d}; }); };
  const auto with = [](GearDesign d, auto change) {
    change(d);
    return d;
  };
  expect_says(message(spur(12, 35)), {"teeth_A is 12", "17.097", "undercuts", "shift_A of at least 0.298"});
  expect_says(message(with(spur(20, 30), [](auto& d) { d.centre_distance = 74.5e-3; })),
              {"74.5", "overlap", "75.0", "apart"});
  expect_says(message(with(spur(20, 30), [](auto& d) { d.centre_distance = 78e-3; })),
              {"contact ratio is 0.7", "teeth"});
  expect_says(message(with(spur(20, 30), [](auto& d) { d.shift_A = 1.9; })), {"A are pointed", "smaller shift_A"});
  expect_says(message(spur(20, -60)), {"tips of B meet the fillets of A", "shortening_B"});
  expect_says(message(with(spur(30, -34), [](auto& d) { d.shortening_B = 0.45; })), {"off the line of action", "ten"});
  expect_says(message(with(spur(20, -27), [](auto&) {})), {"base circle", "shortening_B"});
  expect_says(message(spur(20, -18)), {"does not take in"});
  expect_says(message(with(spur(20, 30), [](auto& d) { d.module = NAN; })), {"module is nan"});
  expect_says(message_of<SceneError>([] { BevelGearPair{{.module = 3e-3, .teeth_A = 16, .teeth_B = 200}}; }),
              {"face_width"});
  expect_says(message_of<SceneError>([] {
                BevelGearPair{{.module = 3e-3, .teeth_A = 16, .teeth_B = 40, .shaft_angle = 2.5, .face_width = 0.01}};
              }),
              {"shaft_angle is 2.5"});
  expect_says(message_of<SceneError>([] { ToothedRack{{.gears = spur(20, 30)}}; }), {"teeth_B", "rack"});
  expect_says(message_of<SceneError>([] { SprocketPair{{.teeth_A = 3, .teeth_B = 20}}; }), {"3 teeth", "five"});
  expect_says(message_of<SceneError>(
                  [] { ToothedGearPair{{.gears = spur(20, 30), .teeth = {.model = ToothStiffness::table}}}; }),
              {"table of stiffness has no values"});
}

/// c' = 14 and c_γ = 20 N/(mm µm) are ISO 6336-1's values for steel spur gears of usual shape; q' by hand for 40/40.
TEST(MeshStiffness, HasThePublishedMagnitude) {
  GearDesign d = spur(40, 40);
  const GearGeometry pair(d);
  const ToothMaterial steel;
  const double q = 0.04723 + (0.15551 + 0.25791) / 40;
  EXPECT_NEAR(iso_single_stiffness(pair, steel), 1e9 * 0.8 * 0.975 / q, 1);
  EXPECT_NEAR(iso_single_stiffness(pair, steel), 14e9, 0.6e9);
  const auto mean = [&](ToothStiffness model) {
    double sum = 0;
    const std::vector<double> k = mesh_stiffness(pair, model, steel);
    for (double each : k) sum += each;
    return sum / static_cast<double>(k.size()) / d.face_width;
  };
  const double c_gamma = iso_single_stiffness(pair, steel) * (0.75 * pair.contact_ratio + 0.25);
  EXPECT_NEAR(mean(ToothStiffness::iso_6336), c_gamma, 0.005 * c_gamma);
  EXPECT_NEAR(c_gamma, 20e9, 1e9);
  // Without ISO's factor of 0.8 for what theory leaves out, c'_th = 1/q' is what Weber and Banaschek's equations give.
  EXPECT_NEAR(tooth_pair_stiffness(pair, steel, 0), 1e9 / q, 0.12e9 / q);
  EXPECT_NEAR(mean(ToothStiffness::weber_banaschek), c_gamma / 0.78, 0.12 * c_gamma);
}

/// One pair in contact, then two: the mesh is softest at the pitch point of a spur pair, and nearly even where the
/// helical overlap is one.
TEST(MeshStiffness, ChangesWithTheNumberOfPairsInContact) {
  const auto ends = [](const GearDesign& d) {
    const std::vector<double> k = mesh_stiffness(GearGeometry(d), ToothStiffness::weber_banaschek, {});
    const auto [least, most] = std::minmax_element(k.begin(), k.end());
    return std::array{*least, *most, k[0], k[k.size() / 2]};
  };
  GearDesign d = spur(24, 35);
  const auto [least, most, pitch_point, between] = ends(d);
  EXPECT_NEAR(pitch_point, least, 0.05 * least);
  EXPECT_GT(between, 1.6 * pitch_point);
  d.face_width = kPi * d.module / std::sin(0.35), d.helix_angle = 0.35;
  const auto [lowest, highest, any, other] = ends(d);
  EXPECT_LT(highest, 1.02 * lowest);
}

}  // namespace
}  // namespace lithe::test::gear_geometry_test
