// Tyre property files: what is read, converted and refused.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "joints/tyre/magic_formula.h"
#include "models/read_tir.h"
#include "tests/models/scratch_folder.h"
#include "tests/support/message_of.h"

namespace lithe::test::tir_test {
namespace {

std::string car() {
  std::ifstream file(LITHE_EXAMPLE_DATA "/tyres/car.tir");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}
std::string with(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}
TyreCoefficients read(const std::string& text) { return read_tir(ScratchFolder().write("tyre.tir", text)); }
std::string refused(const std::string& text) {
  return message_of<FileError>([&] { read(text); });
}

TEST(Tir, ReadsACarTyre) {
  const TyreCoefficients c = read(car());
  EXPECT_FALSE(c.before_60);
  EXPECT_EQ(c.unloaded_radius, 0.313);
  EXPECT_EQ(c.fnomin, 4000);
  EXPECT_EQ(c.longvl, 16.67);  // before a comment
  EXPECT_EQ(c.pkx1, 21.51);
  EXPECT_EQ(c.rvy6, -10.71);
  EXPECT_EQ(c.ssz4, -0.238);
  EXPECT_EQ(c.lkx, 1);  // not in the file
  EXPECT_EQ(c.lmuv, 0);
}

TEST(Tir, ConvertsUnits) {
  std::string text = car();
  for (const auto& [from, to] : {std::pair("'meter'", "'mm'"), {"'newton'", "'kN'"}, {"'radian'", "\"deg\""}})
    text = with(text, from, to);
  text = with(text, "TIME                    = 'second'", "TIME = 'millisecond'   ! comment");
  const TyreCoefficients c = read(text), si = read(car());
  EXPECT_DOUBLE_EQ(c.unloaded_radius, 1e-3 * si.unloaded_radius);
  EXPECT_DOUBLE_EQ(c.fnomin, 1e3 * si.fnomin);
  EXPECT_DOUBLE_EQ(c.longvl, si.longvl);
  EXPECT_DOUBLE_EQ(c.vertical_stiffness, 1e6 * si.vertical_stiffness);
  EXPECT_DOUBLE_EQ(c.vertical_damping, 1e3 * si.vertical_damping);
  EXPECT_DOUBLE_EQ(c.inflpres, 1e9 * si.inflpres);
  EXPECT_DOUBLE_EQ(c.cammax, si.cammax * std::numbers::pi / 180);
  EXPECT_EQ(c.pdy3, si.pdy3);
  EXPECT_DOUBLE_EQ(read(with(car(), "[UNITS]", "[UNITS]\nPRESSURE = 'bar'")).nompres, 1e5 * si.nompres);
}

TEST(Tir, KnowsTheFormulaBeforeVersion6) {
  const std::string old = with(with(car(), "= 61", "= 6"), "PHY2 ", "PHY3 = 0.031\nPHY2 ");
  EXPECT_TRUE(read(old).before_60);
  // Version 5.2 shifts the side force by camber alone: F_y(α, γ) = F_y(α + PHY3 γ, 0) + S_V(γ), friction alike.
  TyreCoefficients c = read(old);
  c.pdy3 = c.pky3 = c.pey4 = c.pvy3 = c.pvy4 = 0;
  c.rvy3 = 0;
  const MagicFormula formula(c);
  const double shifted = std::atan(std::tan(0.03) + 0.031 * std::sin(0.1));
  EXPECT_NEAR(formula.at({.alpha = 0.03, .camber = 0.1, .load = 4000, .speed = 20}).Fy,
              formula.at({.alpha = shifted, .load = 4000, .speed = 20}).Fy, 1e-9 * 4000);
}

TEST(Tir, SaysWhatHasNoEffect) {
  read(with(car(), "[SCALING", "Q_FCX = 0.1\nBOTTOM_STIFF = 0\n[SCALING"));  // in a range's section
  read(with(car(), "PFZ1 ", "Q_FCX = 0.1\nQ_CAM = 0\nPFZ1 "));
  expect_says(log::last_warning(), {"tyre.tir", "Q_FCX"});
  EXPECT_EQ(log::last_warning().find("Q_CAM"), std::string::npos);
}

TEST(Tir, RefusesBrokenFiles) {
  expect_says(message_of<FileError>([] { read_tir("no_such.tir"); }), {"no_such.tir", "path"});
  expect_says(refused(""), {"[MODEL]", "complete"});
  expect_says(refused(with(car(), "[LATERAL_COEFFICIENTS]", "[SOMETHING]")), {"[LATERAL_COEFFICIENTS]"});
  expect_says(refused(with(car(), "PKX1 ", "PKX9 ")), {"[LONGITUDINAL_COEFFICIENTS]", "no PKX1", "tyre.tir:5"});
  expect_says(refused(with(car(), "= 61", "= 21")), {"FITTYP is 21", "61", "tyre.tir:11"});
  expect_says(refused(with(car(), "0.313", "0.313x")), {"UNLOADED_RADIUS", "0.313x", "tyre.tir:16"});
  expect_says(refused(with(car(), "0.313", "nan")), {"finite"});
  expect_says(refused(with(car(), "0.313", "")), {"UNLOADED_RADIUS", "finite"});
  expect_says(refused(with(car(), "'meter'", "'furlong'")), {"furlong", "LENGTH", "inch", "tyre.tir:5"});
  expect_says(refused(with(car(), "[MODEL]", "[MODEL")), {"bracket", "tyre.tir:10"});
  expect_says(refused(with(car(), "FNOMIN ", "FNOMIN = 4000\nFNOMIN ")), {"FNOMIN", "twice"});
  expect_says(refused(with(car(), "[STRUCTURAL]", "[VERTICAL]")), {"[VERTICAL]", "twice"});
  expect_says(refused(with(car(), "FNOMIN ", "rubbish\nFNOMIN ")), {"rubbish", "NAME = value"});
  expect_says(refused("A = 1\n" + car()), {"before any section", "tyre.tir:1"});
}

}  // namespace
}  // namespace lithe::test::tir_test
