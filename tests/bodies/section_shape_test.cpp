#include "bodies/beam/section_shape.h"

#include <gtest/gtest.h>

#include "engine/base/error.h"
#include "tests/support/methods.h"

/// Stresses of sections against what they add up to, against equilibrium inside, and against closed forms.
namespace lithe::test::section_shape_test {
namespace {

const Vector6 kResultants = (Vector6() << 700, -300, 500, 40, -60, 90).finished();

/// Resultants of the stresses, by midpoints of a fine grid.
Vector6 sum(const SectionShape& shape, double width, double height, int cells) {
  Vector6 total = Vector6::Zero();
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j < cells; ++j) {
      const double y = width * ((i + 0.5) / cells - 0.5), z = height * ((j + 0.5) / cells - 0.5);
      if (!shape.contains(y, z)) continue;
      const SectionStress s = shape.stress(kResultants, y, z);
      total += (Vector6() << s.normal, s.shear_2, s.shear_3, y * s.shear_3 - z * s.shear_2, z * s.normal, -y * s.normal)
                   .finished() *
               width * height / (cells * cells);
    }
  return total;
}

double off(const Vector6& found) { return (found - kResultants).cwiseQuotient(kResultants).cwiseAbs().maxCoeff(); }

TEST(SectionShape, StressesAddUpToTheResultants) {
  const double flat = off(sum(SectionShape::rectangle(0.06, 0.02), 0.06, 0.02, 90));
  expect_below("flat rectangle", flat, 2e-3);
  expect_below("high rectangle", off(sum(SectionShape::rectangle(0.02, 0.05), 0.02, 0.05, 90)), 2e-3);
  expect_below("ellipse", off(sum(SectionShape::ellipse(0.03, 0.02), 0.06, 0.04, 500)), 2e-3);
  expect_below("circle", off(sum(SectionShape::circle(0.03), 0.06, 0.06, 500)), 2e-3);
  expect_below("tube", off(sum(SectionShape::tube(0.02, 0.03), 0.06, 0.06, 500)), 5e-3);
}

/// Without end effects  ∂σ11/∂x1 + ∂σ12/∂x2 + ∂σ13/∂x3 = 0, where the moments grow by the shear forces:
/// dm_2/dx1 = n_3, dm_3/dx1 = -n_2. And nothing acts on the rim.
TEST(SectionShape, StressesAreInEquilibrium) {
  const SectionShape shapes[] = {SectionShape::rectangle(0.06, 0.02), SectionShape::ellipse(0.03, 0.02),
                                 SectionShape::tube(0.01, 0.03)};
  for (const SectionShape& shape : shapes)
    for (const auto& [y, z] : {std::pair(0.012, 0.004), {-0.015, 0.007}, {0.011, -0.0065}}) {
      const double h = 1e-5;
      Vector6 growth = Vector6::Zero();
      growth[4] = kResultants[2], growth[5] = -kResultants[1];
      const double along = shape.stress(growth, y, z).normal;
      const auto at = [&](double dy, double dz) { return shape.stress(kResultants, y + dy, z + dz); };
      const double across = (at(h, 0).shear_2 - at(-h, 0).shear_2 + at(0, h).shear_3 - at(0, -h).shear_3) / (2 * h);
      EXPECT_GT(std::abs(along), 1e6);
      expect_below("sources", std::abs(along + across) / std::abs(along), 1e-4);
    }
  for (const double angle : {0.3, 1.9, 4.1}) {
    const double c = std::cos(angle), s = std::sin(angle);
    const SectionStress in = SectionShape::tube(0.01, 0.03).stress(kResultants, 0.01 * c, 0.01 * s);
    const SectionStress out = SectionShape::tube(0.01, 0.03).stress(kResultants, 0.03 * c, 0.03 * s);
    const SectionStress rim = SectionShape::ellipse(0.03, 0.02).stress(kResultants, 0.03 * c, 0.02 * s);
    const double size = std::hypot(out.shear_2, out.shear_3);
    expect_below("inner rim", std::abs(c * in.shear_2 + s * in.shear_3) / size, 1e-8);
    expect_below("outer rim", std::abs(c * out.shear_2 + s * out.shear_3) / size, 1e-8);
    expect_below("ellipse's rim", std::abs(c / 0.03 * rim.shear_2 + s / 0.02 * rim.shear_3) * 0.02 / size, 1e-8);
  }
}

TEST(SectionShape, AgreesWithClosedForms) {
  const auto torsion = [](double moment) { return Vector6(moment * Vector6::Unit(3)); };
  // Largest torsional stress of rectangles, T/(k b h²), h the shorter edge: Timoshenko & Goodier, table in art. 109.
  for (const auto& [ratio, k] : {std::pair(1.0, 0.208), {1.5, 0.231}, {2.0, 0.246}, {3.0, 0.267}, {10.0, 0.312}}) {
    const double h = 0.01, b = ratio * h, exact = 5 / (k * b * h * h);
    EXPECT_NEAR(std::abs(SectionShape::rectangle(b, h).stress(torsion(5), 0, h / 2).shear_2) / exact, 1, 4e-3);
    EXPECT_NEAR(std::abs(SectionShape::rectangle(h, b).stress(torsion(5), h / 2, 0).shear_3) / exact, 1, 4e-3);
  }
  // An I 200 x 100 mm, web 6 mm, flanges 10 mm: bending by 10 kN m, shear of 50 kN in the web.
  const SectionShape beam = SectionShape::i_beam({.height = 0.2, .width = 0.1, .web = 0.006, .flange = 0.01});
  const double I2 = (0.1 * std::pow(0.2, 3) - 0.094 * std::pow(0.18, 3)) / 12;
  Vector6 load = Vector6::Zero();
  load[2] = 5e4, load[4] = 1e4;
  EXPECT_NEAR(beam.stress(load, 0.05, 0.1).normal / (1e4 * 0.1 / I2), 1, 1e-12);
  const double Q = 0.1 * 0.01 * 0.095 + 0.006 * 0.09 * 0.045;
  EXPECT_NEAR(beam.stress(load, 0, 0).shear_3 / (5e4 * Q / (I2 * 0.006)), 1, 1e-12);
  const Vector6 whole = sum(beam, 0.1, 0.2, 1000);
  EXPECT_NEAR(whole[2] / kResultants[2], 1, 0.06);  // what the flanges carry across is left out
  EXPECT_NEAR(whole[4] / kResultants[4], 1, 5e-3);
  const double web = std::sqrt(3) * 5e4 * Q / (I2 * 0.006);  // more than the flanges, and than where they meet it
  EXPECT_GE(beam.largest_von_mises(load), (1 - 1e-12) * web);
  EXPECT_LT(beam.largest_von_mises(load), 1.1 * web);
}

TEST(SectionShape, GivesTheSectionOfABeam) {
  const Material steel{2.1e11, 0.3, 7850};
  EXPECT_EQ(SectionShape::tube(0.02, 0.03).section(steel).stiffness, BeamSection::tube(0.02, 0.03, steel).stiffness);
  EXPECT_THROW(SectionShape::tube(0.02, 0.03).stress(kResultants, 0, 0.01), SceneError);
  EXPECT_THROW(SectionShape::rectangle(0.02, 0), SceneError);
}

}  // namespace
}  // namespace lithe::test::section_shape_test
