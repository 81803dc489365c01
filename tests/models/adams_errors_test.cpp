// What is wrong in an Adams data set is refused with its line and the fix.
#include <gtest/gtest.h>

#include <tuple>

#include "tests/models/refusal.h"

namespace lithe::test::adams_errors_test {
namespace {

TEST(AdamsErrors, NameTheLineAndTheFix) {
  const std::string units = "t\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER, TIME=SECOND\n",
                    ground = "PART/1, GROUND\nMARKER/1, PART=1\n",    // lines 3, 4
      body = "PART/2, MASS=1, CM=20, IP=1,1,1\nMARKER/20, PART=2\n",  // lines 5, 6
      all = units + ground + body;
  EXPECT_EQ(refusal("bad.adm", all + "END\n"), "");
  const std::tuple<std::string, const char*, int> bad[] = {
      {"", "ends without END", 1},
      {"t\n", "ends without END", 1},
      {all, "ends without END", 6},
      {"t\n" + ground + "END\n", "has no UNITS", 1},
      {"t\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=METER\n" + ground + "END\n", "has no TIME", 2},
      {"t\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=FURLONG, TIME=SECOND\nEND\n", "unknown LENGTH FURLONG", 2},
      {"t\nUNITS/SYSTEM=IPS\n" + ground + "END\n", "which is not read", 2},
      {units + body + "END\n", "no PART is GROUND", 1},
      {"t\n, MASS=1\nEND\n", "continues a statement", 2},
      {all + "BANANA/3, I=1\nEND\n", "'BANANA' is no statement", 7},
      {all + "JOINT/1, REVOLUTE, I=20, J=1, COLOUR=2\nEND\n", "no argument COLOUR", 7},
      {all + "JOINT/1, I=20, J=1\nEND\n", "has no kind", 7},
      {all + "JOINT/1, REVOLUTE, SPHERICAL, I=20, J=1\nEND\n", "is REVOLUTE and SPHERICAL", 7},
      {all + "JOINT/1, REVOLUTE, I=20\nEND\n", "has no J", 7},
      {all + "JOINT/1, REVOLUTE, I=20, J=99\nEND\n", "MARKER/99", 7},
      {all + "JOINT/1, REVOLUTE, I=20, J=1, I=20\nEND\n", "has I twice", 7},
      {all + "JOINT/1, REVOLUTE, I=20, J=x\nEND\n", "where a number should be", 7},
      {all + "MARKER/21, PART=2\nJOINT/1, REVOLUTE, I=20, J=21\nEND\n", "two markers of one part", 8},
      {all + "JOINT/0, REVOLUTE, I=20, J=1\nEND\n", "no whole number above zero", 7},
      {all + "JOINT, REVOLUTE, I=20, J=1\nEND\n", "has no identifier", 7},
      {all + "MARKER/20, PART=2\nEND\n", "there are two MARKER/20", 7},
      {all + "MARKER/21, PART=7\nEND\n", "PART/7", 7},
      {all + "MARKER/21, FLEX_BODY=1\nEND\n", "not read", 7},
      {all + "FLEX_BODY/1\nEND\n", "not read", 7},
      {all + "MARKER/21, PART=2, QP=1,2\nEND\n", "QP with 2 numbers", 7},
      {all + "MARKER/21, PART=2, QP=1,2,nan\nEND\n", "where a number should be", 7},
      {all + "MARKER/21, PART=2, QP=1,2,1E999\nEND\n", "where a number should be", 7},
      {all + "MARKER/21, PART=2, REULER=1,2,3, ZP=1,0,0\nEND\n", "REULER and points", 7},
      {all + "MARKER/21, PART=2, ZP=0,0,0\nEND\n", "in its own origin", 7},
      {all + "MARKER/21, PART=2, ZP=1,0,0, XP=2,0,0\nEND\n", "give no axes", 7},
      {all + "PART/3, MASS=1, IP=1,1,1\nEND\n", "has no CM", 7},
      {all + "PART/3, CM=20, IP=1,1,1\nEND\n", "no mass", 7},
      {all + "PART/3, MASS=-1, CM=20, IP=1,1,1\nEND\n", "no mass", 7},
      {all + "PART/3, MASS=1, CM=20, IP=1,1,1\nEND\n", "on another part", 7},
      {all + "PART/3, MASS=1, CM=30, IP=1,1,5\nMARKER/30, PART=3\nEND\n", "impossible inertia", 7},
      {all + "PART/3, MASS=1, CM=30, IP=1,1,-1\nMARKER/30, PART=3\nEND\n", "impossible inertia", 7},
      {all + "PART/3, MASS=1, CM=30\nMARKER/30, PART=3\nEND\n", "has no IP", 7},
      {all + "PART/3, GROUND\nEND\n", "as another part is", 7},
      {all + "VARIABLE/1, FUNCTION=1+\nEND\n", "it ends where a number", 7},
      {all + "VARIABLE/1, FUNCTION=(1+2\nEND\n", "it ends where ')'", 7},
      {all + "VARIABLE/1, FUNCTION=1 2\nEND\n", "does not belong here", 7},
      {all + "VARIABLE/1, FUNCTION=SINE(1)\nEND\n", "'SINE' is no function", 7},
      {all + "VARIABLE/1, FUNCTION=STEP(1,2,3)\nEND\n", "STEP has 3 arguments", 7},
      {all + "VARIABLE/1, FUNCTION=DX(77)\nEND\n", "MARKER/77", 7},
      {all + "VARIABLE/1, FUNCTION=DX(1.5)\nEND\n", "'.' stands where ')' should", 7},
      {all + "VARIABLE/1, FUNCTION=VARVAL(1)\nEND\n", "reads itself", 7},
      {all + "VARIABLE/1, FUNCTION=VARVAL(2)\nVARIABLE/2, FUNCTION=VARVAL(1)\nEND\n", "reads itself", 7},
      {all + "VARIABLE/1, FUNCTION=VARVAL(5)\nEND\n", "VARIABLE/5", 7},
      {all + "VARIABLE/1, FUNCTION=AKISPL(1,0,5)\nEND\n", "SPLINE/5", 7},
      {all + "VARIABLE/1, FUNCTION=USER(1,2)\nEND\n", "user routine", 7},
      {all + "VARIABLE/1, FUNCTION=JOINT(4,0,2,0)\nEND\n", "JOINT/4", 7},
      {all + "VARIABLE/1, FUNCTION=" + std::string(300, '(') + "1" + std::string(300, ')') + "\nEND\n", "nested deeper",
       7},
      {all + "VARIABLE/1, FUNCTION=" + std::string(3000, '-') + "1\nEND\n", "nested deeper", 7},
      {all + "SPLINE/1, X=1,2,3,4, Y=1,2,3\nEND\n", "4 X and 3 Y", 7},
      {all + "SPLINE/1, X=1,2,2,4, Y=1,2,3,4\nEND\n", "do not rise", 7},
      {all + "SPLINE/1, X=1,2,3, Y=1,2,3\nEND\n", "X with 3 numbers", 7},
      {all + "SFORCE/1, I=20, J=1, TRANSLATIONAL, FUNCTION=FX(20,1)\nEND\n", "depends on a load", 7},
      {all + "SFORCE/1, I=20, J=1, TRANSLATIONAL\nEND\n", "has no FUNCTION", 7},
      {all + "GCON/1, FUNCTION=VX(20,1)\nEND\n", "depends on a velocity", 7},
      {all + "GCON/1, FUNCTION=TIME\nEND\n", "reads no marker", 7},
      {all + "MOTION/1, JOINT=3, FUNCTION=TIME\nEND\n", "JOINT/3", 7},
      {all + "JOINT/1, SPHERICAL, I=20, J=1\nMOTION/1, JOINT=1, FUNCTION=TIME\nEND\n", "no rotation or translation", 8},
      {all + "JOINT/1, SCREW, I=20, J=1\nEND\n", "has no PITCH", 7},
      {all + "COUPLER/1, JOINTS=1,2, SCALES=1,2\nEND\n", "JOINT/1", 7},
      {all + "GEAR/1, JOINTS=1,2, CV=1\nEND\n", "JOINT/1", 7},
      {all + "BEAM/1, I=20, J=1, LENGTH=0\nEND\n", "LENGTH", 7},
      {all + "BUSHING/1, I=20, J=1, K=1,2,3, KT=x,1,1\nEND\n", "where a number should be", 7},
      {all + "FIELD/1, I=20, J=1, KMATRIX=1,2,3\nEND\n", "KMATRIX with 3", 7},
      {all + "SIMULATE/TRANSIENT, END=0\nEND\n", "ends at the time 0", 7},
      {all + std::string("PART/3\0, MASS", 13) + "=1\nEND\n", "zero byte", 7}};
  for (const auto& [text, words, line] : bad) {
    const std::string told = refusal("bad.adm", text);
    EXPECT_NE(told.find(words), std::string::npos) << "wanted: " << words << "\n" << told << text;
    EXPECT_NE(told.find("bad.adm:" + std::to_string(line)), std::string::npos) << line << "\n" << told << text;
  }
  // A file cut anywhere is refused, or is whole.
  for (std::size_t cut = 0; cut < all.size(); cut += 7) EXPECT_NE(refusal("bad.adm", all.substr(0, cut)), "") << cut;
  EXPECT_NE(refusal("bad.adm", all.substr(0, 30)).find("bad.adm:"), std::string::npos);
  EXPECT_THROW(read_model("/no/such/folder/model.adm"), FileError);
  EXPECT_THROW(read_model("/dev/zero.adm"), FileError);
}

}  // namespace
}  // namespace lithe::test::adams_errors_test
