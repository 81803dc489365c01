// The Magic Formula against a second implementation, written apart from the published equations (Pacejka 2012,
// 4.E1 to 4.E78), and against what its curves are built to have.
#include <gtest/gtest.h>

#include <numbers>

#include "engine/base/error.h"
#include "joints/tyre/magic_formula.h"
#include "models/read_tir.h"
#include "tests/support/message_of.h"
#include "tests/support/methods.h"
#include "tests/support/motion.h"

namespace lithe::test::tyre_formula_test {
namespace {

using Slip = MagicFormula::Slip;
using std::numbers::pi;

TyreCoefficients car() { return read_tir(LITHE_EXAMPLE_DATA "/tyres/car.tir"); }

/// A tyre none of whose coefficients is zero: the car's, each moved a little.
TyreCoefficients any_tyre(unsigned seed) {
  TyreCoefficients c = car();
  RandomNumbers random(seed);
  for (double* x = &c.lfzo; x <= &c.ssz4; ++x) *x = *x * (1 + random.number(0.1)) + random.number(0.02);
  c.qsy7 = 0.9, c.lmuv = 0.2;
  return c;
}

double peak(double x, double B, double C, double D, double E) {
  if (E > 1) E = 1;
  return D * sin(C * atan(B * x - E * (B * x - atan(B * x))));
}
double hill(double x, double B, double C, double E) {
  if (E > 1) E = 1;
  return cos(C * atan(B * x - E * (B * x - atan(B * x))));
}
int sgn(double x) { return x < 0 ? -1 : 1; }

struct Side {
  double F_y0, mu, B, S_H, S_V, K;
};

Side side(const TyreCoefficients& c, double dfz, double dpi, double Fz, double alpha, double gamma, double mu_scale) {
  const double Fz0 = c.fnomin * c.lfzo, late = 10 * mu_scale / (1 + (10 - 1) * mu_scale);
  const double K = c.pky1 * Fz0 * (1 + c.ppy1 * dpi) * (1 - c.pky3 * fabs(gamma)) *  // (4.E25)
                   sin(c.pky4 * atan((Fz / Fz0) / ((c.pky2 + c.pky5 * pow(gamma, 2)) * (1 + c.ppy2 * dpi)))) * c.lky;
  const double S_Vg = Fz * (c.pvy3 + c.pvy4 * dfz) * gamma * c.lkyc * late;              // (4.E28)
  const double S_V = Fz * (c.pvy1 + c.pvy2 * dfz) * c.lvy * late + S_Vg;                 // (4.E29)
  const double K_g = Fz * (c.pky6 + c.pky7 * dfz) * (1 + c.ppy5 * dpi) * c.lkyc;         // (4.E30)
  const double S_H = (c.phy1 + c.phy2 * dfz) * c.lhy + (K_g * gamma - S_Vg) / K;         // (4.E27)
  const double a = alpha + S_H, C = c.pcy1 * c.lcy;                                      // (4.E20, 4.E21)
  const double mu = (c.pdy1 + c.pdy2 * dfz) * (1 + c.ppy3 * dpi + c.ppy4 * dpi * dpi) *  // (4.E23)
                    (1 - c.pdy3 * pow(gamma, 2)) * mu_scale;
  const double E = (c.pey1 + c.pey2 * dfz) * (1 + c.pey5 * pow(gamma, 2) - (c.pey3 + c.pey4 * gamma) * sgn(a)) * c.ley;
  const double B = K / (C * mu * Fz);
  return {peak(a, B, C, mu * Fz, E) + S_V, mu, B, S_H, S_V, K};
}

/// Forces by the book, forward, above low speeds, within all ranges.
MagicFormula::Reaction by_the_book(const TyreCoefficients& c, const Slip& s) {
  const double Fz = s.load, kappa = s.kappa, alpha = tan(s.alpha), gamma = sin(s.camber), R0 = c.unloaded_radius;
  const double Fz0 = c.fnomin * c.lfzo, dfz = (Fz - Fz0) / Fz0, dpi = (s.pressure - c.nompres) / c.nompres;
  const double V_s = s.speed * sqrt(kappa * kappa + alpha * alpha), slow = 1 + c.lmuv * V_s / c.longvl;
  const double mu_x = c.lmux / slow, mu_y = c.lmuy / slow;
  // Longitudinal
  const double k = kappa + (c.phx1 + c.phx2 * dfz) * c.lhx, C_x = c.pcx1 * c.lcx;
  const double D_x =
      Fz * (c.pdx1 + c.pdx2 * dfz) * (1 + c.ppx3 * dpi + c.ppx4 * dpi * dpi) * (1 - c.pdx3 * gamma * gamma) * mu_x;
  const double K_x = Fz * (c.pkx1 + c.pkx2 * dfz) * exp(c.pkx3 * dfz) * (1 + c.ppx1 * dpi + c.ppx2 * dpi * dpi) * c.lkx;
  const double E_x = (c.pex1 + c.pex2 * dfz + c.pex3 * dfz * dfz) * (1 - c.pex4 * sgn(k)) * c.lex;
  const double F_x0 =
      peak(k, K_x / (C_x * D_x), C_x, D_x, E_x) + Fz * (c.pvx1 + c.pvx2 * dfz) * c.lvx * 10 * mu_x / (1 + 9 * mu_x);
  // Combined
  const Side y = side(c, dfz, dpi, Fz, alpha, gamma, mu_y);
  const double B_xa = (c.rbx1 + c.rbx3 * gamma * gamma) * cos(atan(c.rbx2 * kappa)) * c.lxal;
  const double E_xa = c.rex1 + c.rex2 * dfz;
  const double F_x = F_x0 * hill(alpha + c.rhx1, B_xa, c.rcx1, E_xa) / hill(c.rhx1, B_xa, c.rcx1, E_xa);
  const double B_yk = (c.rby1 + c.rby4 * gamma * gamma) * cos(atan(c.rby2 * (alpha - c.rby3))) * c.lyka;
  const double E_yk = c.rey1 + c.rey2 * dfz, S_Hyk = c.rhy1 + c.rhy2 * dfz;
  const double G_yk = hill(kappa + S_Hyk, B_yk, c.rcy1, E_yk) / hill(S_Hyk, B_yk, c.rcy1, E_yk);
  const double D_Vyk = y.mu * Fz * (c.rvy1 + c.rvy2 * dfz + c.rvy3 * gamma) * cos(atan(c.rvy4 * alpha));
  const double F_y = G_yk * y.F_y0 + D_Vyk * sin(c.rvy5 * atan(c.rvy6 * kappa)) * c.lvyka;
  // Overturning and rolling
  const double M_x = Fz * R0 * c.lmx *
                     (c.qsx1 * c.lvmx - c.qsx2 * gamma * (1 + c.ppmx1 * dpi) + c.qsx3 * F_y / c.fnomin +
                      c.qsx4 * cos(c.qsx5 * atan(pow(c.qsx6 * Fz / c.fnomin, 2))) *
                          sin(c.qsx7 * gamma + c.qsx8 * atan(c.qsx9 * F_y / c.fnomin)) +
                      c.qsx10 * atan(c.qsx11 * Fz / c.fnomin) * gamma);
  const double M_y = -Fz * R0 * c.lmy *
                     (c.qsy1 + c.qsy2 * F_x / c.fnomin + c.qsy3 * s.speed / c.longvl +
                      c.qsy4 * pow(s.speed / c.longvl, 4) + (c.qsy5 + c.qsy6 * Fz / c.fnomin) * gamma * gamma) *
                     pow(Fz / c.fnomin, c.qsy7) * pow(s.pressure / c.nompres, c.qsy8);
  // Aligning
  const double a_t = alpha + c.qhz1 + c.qhz2 * dfz + (c.qhz3 + c.qhz4 * dfz) * gamma, a_r = alpha + y.S_H + y.S_V / y.K;
  const double a_t_eq = sqrt(a_t * a_t + pow(K_x / y.K * kappa, 2)) * sgn(a_t);
  const double a_r_eq = sqrt(a_r * a_r + pow(K_x / y.K * kappa, 2)) * sgn(a_r);
  const double B_t =
      (c.qbz1 + c.qbz2 * dfz + c.qbz3 * dfz * dfz) * (1 + c.qbz4 * gamma + c.qbz5 * fabs(gamma)) * c.lky / mu_y;
  const double D_t0 = Fz * (R0 / Fz0) * (c.qdz1 + c.qdz2 * dfz) * (1 - c.ppz1 * dpi) * c.ltr;
  const double D_t = D_t0 * (1 + c.qdz3 * gamma + c.qdz4 * gamma * gamma);
  const double E_t = (c.qez1 + c.qez2 * dfz + c.qez3 * dfz * dfz) *
                     (1 + (c.qez4 + c.qez5 * gamma) * (2 / pi) * atan(B_t * c.qcz1 * a_t));
  const double t = D_t * hill(a_t_eq, B_t, c.qcz1, E_t) * cos(s.alpha);
  const double F_y_upright = G_yk * side(c, dfz, dpi, Fz, alpha, 0, mu_y).F_y0;
  const double D_r =
      Fz * R0 * mu_y * cos(s.alpha) *
      ((c.qdz6 + c.qdz7 * dfz) * c.lres +
       ((c.qdz8 + c.qdz9 * dfz) * (1 + c.ppz2 * dpi) + (c.qdz10 + c.qdz11 * dfz) * fabs(gamma)) * gamma * c.lkzc);
  const double B_r = c.qbz9 * c.lky / mu_y + c.qbz10 * y.B * c.pcy1 * c.lcy;
  const double arm = R0 * (c.ssz1 + c.ssz2 * F_y / Fz0 + (c.ssz3 + c.ssz4 * dfz) * gamma) * c.ls;
  return {F_x, F_y, M_x, M_y, -t * F_y_upright + D_r * cos(atan(B_r * a_r_eq)) + arm * F_x};
}

TEST(MagicFormula, EqualsTheBookAtAnySlip) {
  double worst = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const TyreCoefficients c = any_tyre(seed);
    const MagicFormula formula(c);
    RandomNumbers random(100 + seed);
    for (int k = 0; k < 25; ++k) {
      const Slip s{.kappa = random.number(0.9),
                   .alpha = random.number(0.6),
                   .camber = random.number(0.2),
                   .load = 4500 + random.number(4000),
                   .speed = 20 + random.number(15),
                   .pressure = 2.2e5 + random.number(6e4)};
      const auto a = formula.at(s), b = by_the_book(c, s);
      for (const auto& [x, y] : {std::pair(a.Fx, b.Fx), std::pair(a.Fy, b.Fy), std::pair(a.Mx, b.Mx),
                                 std::pair(a.My, b.My), std::pair(a.Mz, b.Mz)})
        worst = std::max(worst, std::abs(x - y) / s.load);
    }
  }
  expect_below("forces against the book, of the load", worst, 1e-12);
}

/// Offsets of ply and cone left out: the curve is odd, its slope at zero K, its peak D.
TyreCoefficients symmetric() {
  TyreCoefficients c = car();
  for (double* x : {&c.phx1, &c.phx2, &c.phy1, &c.phy2, &c.pvy1, &c.pvy2, &c.pey3, &c.rhx1, &c.rhy1, &c.rby3, &c.rvy1,
                    &c.rvy2, &c.qhz1, &c.qhz2, &c.qdz6, &c.qdz7, &c.qez4, &c.ssz1})
    *x = 0;
  return c;
}

TEST(MagicFormula, HasSlopePeakAndSymmetryOfItsCoefficients) {
  const TyreCoefficients c = symmetric();
  const MagicFormula formula(c);
  for (const double load : {1000.0, 4000.0, 7000.0}) {
    const auto Fx = [&](double kappa) { return formula.at({.kappa = kappa, .load = load, .speed = 20}).Fx; };
    const auto Fy = [&](double alpha) { return formula.at({.alpha = alpha, .load = load, .speed = 20}).Fy; };
    const auto [K_x, K_y] = formula.stiffness(load);
    EXPECT_NEAR(derivative(Fx, 1e-4) / K_x, 1, 1e-9);
    EXPECT_NEAR(derivative(Fy, 1e-4) / K_y, 1, 1e-9);
    EXPECT_LT(K_y, 0);
    EXPECT_GT(K_x, 0);
    double most_x = 0, most_y = 0;
    for (double s = 0; s < 1; s += 1e-4) {
      most_x = std::max(most_x, Fx(s)), most_y = std::max(most_y, -Fy(s));
      ASSERT_EQ(Fx(-s), -Fx(s));
      ASSERT_EQ(Fy(-s), -Fy(s));
    }
    const double df = load / c.fnomin - 1;
    EXPECT_NEAR(most_x / (load * (c.pdx1 + c.pdx2 * df)), 1, 1e-6);
    EXPECT_NEAR(most_y / (load * std::abs(c.pdy1 + c.pdy2 * df)), 1, 1e-6);
    // The road turns the wheel back out of its slip, and braking takes from the side force.
    EXPECT_GT(formula.at({.alpha = 0.03, .load = load, .speed = 20}).Mz, 0);
    EXPECT_LT(formula.at({.alpha = 0.03, .load = load, .speed = -20}).Mz, 0);
    EXPECT_LT(std::abs(formula.at({.kappa = -0.2, .alpha = 0.05, .load = load, .speed = 20}).Fy),
              0.6 * std::abs(Fy(0.05)));
    EXPECT_LT(formula.at({.load = load, .speed = 20}).My, 0);
    EXPECT_GT(formula.at({.load = load, .speed = -20}).My, 0);
    EXPECT_EQ(formula.at({.load = load, .speed = 0}).My, 0);
  }
  EXPECT_EQ(formula.at({.kappa = 0.1, .load = 0, .speed = 20}).Fx, 0);
  EXPECT_EQ(formula.at({.kappa = 0.1, .load = -5, .speed = 20}).Fx, 0);
  EXPECT_EQ(formula.at({.kappa = 2, .load = 4000, .speed = 20}).Fx,
            formula.at({.kappa = c.kpumax, .load = 4000, .speed = 20}).Fx);
}

TEST(MagicFormula, RefusesWhatGivesNoForce) {
  const auto refusal = [](double TyreCoefficients::*which, double value) {
    TyreCoefficients c = car();
    c.*which = value;
    return message_of<SceneError>([&] { MagicFormula{c}; });
  };
  EXPECT_NE(refusal(&TyreCoefficients::fnomin, 0).find("fnomin"), std::string::npos);
  EXPECT_NE(refusal(&TyreCoefficients::pcx1, -1).find("pcx1"), std::string::npos);
  EXPECT_NE(refusal(&TyreCoefficients::pky1, 0).find("pky1"), std::string::npos);
  EXPECT_NE(refusal(&TyreCoefficients::qdz4, NAN).find("finite"), std::string::npos);
  EXPECT_NE(refusal(&TyreCoefficients::inflpres, -1).find("pressure"), std::string::npos);
}

}  // namespace
}  // namespace lithe::test::tyre_formula_test
