#include "joints/tyre/magic_formula.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/base/checks.h"

namespace lithe {

namespace {

double squared(double x) { return x * x; }
double sign(double x) { return x < 0 ? -1 : 1; }
/// Of a curve's argument: 1 beyond E would turn it back.
double bent(double B, double E, double x) {
  const double Bx = B * x, e = std::min(E, 1.0);
  return std::atan(Bx - e * (Bx - std::atan(Bx)));
}
double sine(double B, double C, double D, double E, double x) { return D * std::sin(C * bent(B, E, x)); }
double cosine(double B, double C, double E, double x) { return std::cos(C * bent(B, E, x)); }
/// Away from zero, where formulas divide by it.
double divisor(double x, double least) { return std::abs(x) < least ? std::copysign(least, x) : x; }

}  // namespace

struct MagicFormula::Point {
  double load, camber;                   // F_z, γ* = sin γ
  double nominal, by_load, by_pressure;  // F'_z0, df_z, dp_i
  double K_x, K_y, K_y_camber;           // K_xκ, K_yα, K_yγ0
};

MagicFormula::MagicFormula(const TyreCoefficients& coefficients) : c_(coefficients) {
  const TyreCoefficients& c = c_;
  for (const auto& [value, name] :
       {std::pair(c.fnomin, "fnomin"), std::pair(c.unloaded_radius, "unloaded_radius"), std::pair(c.longvl, "longvl"),
        std::pair(c.vxlow, "vxlow"), std::pair(c.lfzo, "lfzo"), std::pair(c.lmux, "lmux"), std::pair(c.lmuy, "lmuy"),
        std::pair(c.lcx, "lcx"), std::pair(c.lcy, "lcy"), std::pair(c.pcx1, "pcx1"), std::pair(c.pcy1, "pcy1"),
        std::pair(c.pkx1, "pkx1"), std::pair(c.fzmax, "fzmax")})
    if (!(value > 0))
      throw SceneError(std::string(name) + " of the tyre is " + std::to_string(value), "",
                       "give a positive number; read_tir() reads all coefficients of a .tir file");
  for (const auto& [value, name] :
       {std::pair(c.pdx1, "pdx1"), std::pair(c.pdy1, "pdy1"), std::pair(c.pky1, "pky1"), std::pair(c.pky2, "pky2")})
    if (value == 0 || !std::isfinite(value))
      throw SceneError(std::string(name) + " of the tyre is " + std::to_string(value), "",
                       "give the coefficient of friction or slip stiffness: without it there is no force");
  for (const double pressure : {c.inflpres, c.nompres}) require::not_negative(pressure, "pressure of the tyre");
  // One force holds nearly all coefficients: none of them is NaN.
  const Reaction probe = at({.kappa = 0.01, .alpha = 0.01, .camber = 0.01, .load = c.fnomin, .speed = c.longvl});
  for (const double value : {probe.Fx, probe.Fy, probe.Mx, probe.My, probe.Mz})
    if (!std::isfinite(value))
      throw SceneError("a force of the tyre at its nominal load is not finite", "",
                       "give finite coefficients, of the tyre's own size");
}

double MagicFormula::direction(double speed) const {
  return std::abs(speed) < c_.vxlow ? std::sin(0.5 * std::numbers::pi * speed / c_.vxlow) : sign(speed);
}

MagicFormula::Point MagicFormula::point(double load, double camber, double pressure) const {
  const TyreCoefficients& c = c_;
  Point p{};
  p.load = std::min(load, c.fzmax);
  p.camber = std::sin(std::clamp(camber, c.cammin, c.cammax));
  p.nominal = c.fnomin * c.lfzo;
  p.by_load = (p.load - p.nominal) / p.nominal;
  if (c.nompres > 0) {
    const double p_i = pressure > 0 ? pressure : c.inflpres > 0 ? c.inflpres : c.nompres;
    p.by_pressure = (p_i - c.nompres) / c.nompres;
  }
  const double df = p.by_load, dp = p.by_pressure, g = p.camber;
  p.K_x = p.load * (c.pkx1 + c.pkx2 * df) * std::exp(c.pkx3 * df) * (1 + c.ppx1 * dp + c.ppx2 * dp * dp) * c.lkx;
  p.K_y = c.pky1 * p.nominal * (1 + c.ppy1 * dp) * (1 - c.pky3 * std::abs(g)) *
          std::sin(c.pky4 * std::atan(p.load / p.nominal / ((c.pky2 + c.pky5 * g * g) * (1 + c.ppy2 * dp)))) * c.lky;
  p.K_y_camber = p.load * (c.pky6 + c.pky7 * df) * (1 + c.ppy5 * dp) * c.lkyc;
  return p;
}

MagicFormula::Stiffness MagicFormula::stiffness(double load, double camber, double pressure) const {
  if (!(load > 0)) return {0, 0};
  const Point p = point(load, camber, pressure);
  return {p.K_x, p.K_y};
}

MagicFormula::Reaction MagicFormula::at(const Slip& slip) const {
  if (!(slip.load > 0)) return {};
  const TyreCoefficients& c = c_;
  const Point p = point(slip.load, slip.camber, slip.pressure);
  const double Fz = p.load, df = p.by_load, dp = p.by_pressure, g = p.camber, least = 1e-9 * Fz;
  const double R0 = c.unloaded_radius, travel = direction(slip.speed);
  const double kappa = std::clamp(slip.kappa, c.kpumin, c.kpumax);
  const double alpha = std::tan(std::clamp(slip.alpha, c.alpmin, c.alpmax)), cos_alpha = 1 / std::hypot(1, alpha);

  // Friction falls with the speed of slip (4.E7, 4.E8).
  const double fall = 1 + c.lmuv * std::abs(slip.speed) * std::hypot(kappa, alpha) / c.longvl;
  const double mu_scale_x = c.lmux / fall, mu_scale_y = c.lmuy / fall;
  const auto shift_scale = [](double scale) { return 10 * scale / (1 + 9 * scale); };

  // Longitudinal force, pure slip (4.E9 to 4.E18).
  const double kappa_x = kappa + (c.phx1 + c.phx2 * df) * c.lhx;
  const double C_x = c.pcx1 * c.lcx;
  const double D_x =
      (c.pdx1 + c.pdx2 * df) * (1 + c.ppx3 * dp + c.ppx4 * dp * dp) * (1 - c.pdx3 * g * g) * mu_scale_x * Fz;
  const double E_x = (c.pex1 + c.pex2 * df + c.pex3 * df * df) * (1 - c.pex4 * sign(kappa_x)) * c.lex;
  const double S_Vx = Fz * (c.pvx1 + c.pvx2 * df) * std::abs(travel) * c.lvx * shift_scale(mu_scale_x);
  const double Fx0 = sine(p.K_x / divisor(C_x * D_x, least), C_x, D_x, E_x, kappa_x) + S_Vx;

  // Lateral force, pure slip (4.E19 to 4.E30); of a camber, since the aligning moment takes it without.
  const double C_y = c.pcy1 * c.lcy, K_y = divisor(p.K_y, least);
  const double mu_0 = (c.pdy1 + c.pdy2 * df) * (1 + c.ppy3 * dp + c.ppy4 * dp * dp) * mu_scale_y;
  struct Lateral {
    double force, B, mu, S_H, S_V;
  };
  const auto lateral = [&](const Point& at) {
    const double y = at.camber, K = divisor(at.K_y, least), mu = mu_0 * (1 - c.pdy3 * y * y), D = mu * Fz;
    const double S_V_camber = Fz * (c.pvy3 + c.pvy4 * df) * y * c.lkyc * shift_scale(mu_scale_y);
    const double S_V = Fz * (c.pvy1 + c.pvy2 * df) * c.lvy * shift_scale(mu_scale_y) + S_V_camber;
    const double S_H =
        (c.phy1 + c.phy2 * df) * c.lhy + (c.before_60 ? c.phy3 * y * c.lkyc : (at.K_y_camber * y - S_V_camber) / K);
    const double x = alpha + S_H, B = at.K_y / divisor(C_y * D, least);
    const double E = (c.pey1 + c.pey2 * df) * (1 + c.pey5 * y * y - (c.pey3 + c.pey4 * y) * sign(x)) * c.ley;
    return Lateral{sine(B, C_y, D, E, x) + S_V, B, mu, S_H, S_V};
  };
  const Lateral y = lateral(p);

  // Combined slip (4.E50 to 4.E67): each force falls with the other slip.
  const auto weight = [](double B, double C, double E, double x, double shift) {
    return cosine(B, C, E, x + shift) / cosine(B, C, E, shift);
  };
  const double B_xa = (c.rbx1 + c.rbx3 * g * g) * std::cos(std::atan(c.rbx2 * kappa)) * c.lxal;
  const double Fx = Fx0 * weight(B_xa, c.rcx1, c.rex1 + c.rex2 * df, alpha, c.rhx1);
  const double B_yk = (c.rby1 + c.rby4 * g * g) * std::cos(std::atan(c.rby2 * (alpha - c.rby3))) * c.lyka;
  const double G_yk = weight(B_yk, c.rcy1, c.rey1 + c.rey2 * df, kappa, c.rhy1 + c.rhy2 * df);
  const double S_Vyk = y.mu * Fz * (c.rvy1 + c.rvy2 * df + c.rvy3 * g) * std::cos(std::atan(c.rvy4 * alpha)) *
                       std::sin(c.rvy5 * std::atan(c.rvy6 * kappa)) * c.lvyka;
  const double Fy = G_yk * y.force + S_Vyk;

  // Overturning moment (4.E69) and rolling resistance (4.E70).
  const double by_nominal = Fz / c.fnomin, fy = Fy / c.fnomin;
  const double Mx = R0 * Fz * c.lmx *
                    (c.qsx1 * c.lvmx - c.qsx2 * g * (1 + c.ppmx1 * dp) + c.qsx3 * fy +
                     c.qsx4 * std::cos(c.qsx5 * std::atan(squared(c.qsx6 * by_nominal))) *
                         std::sin(c.qsx7 * g + c.qsx8 * std::atan(c.qsx9 * fy)) +
                     c.qsx10 * std::atan(c.qsx11 * by_nominal) * g);
  const double pace = std::abs(slip.speed) / c.longvl;
  const double My = -Fz * R0 * c.lmy * travel *
                    (c.qsy1 + c.qsy2 * Fx / c.fnomin + c.qsy3 * pace + c.qsy4 * squared(squared(pace)) +
                     (c.qsy5 + c.qsy6 * by_nominal) * g * g) *
                    std::pow(by_nominal, c.qsy7) * std::pow(1 + dp, c.qsy8);

  // Aligning moment (4.E31 to 4.E49, 4.E71 to 4.E78): trail times side force, residual moment, arm of Fx.
  const auto equivalent = [&](double x) { return std::hypot(x, p.K_x / K_y * kappa) * sign(x); };
  const double stiffness_scale = c.lky / mu_scale_y;
  const double alpha_t = alpha + c.qhz1 + c.qhz2 * df + (c.qhz3 + c.qhz4 * df) * g;
  const double B_t =
      (c.qbz1 + c.qbz2 * df + c.qbz3 * df * df) * (1 + c.qbz4 * g + c.qbz5 * std::abs(g)) * stiffness_scale;
  const double D_t =
      Fz * R0 / p.nominal * (c.qdz1 + c.qdz2 * df) * (1 - c.ppz1 * dp) * c.ltr * (1 + c.qdz3 * g + c.qdz4 * g * g);
  const double E_t = (c.qez1 + c.qez2 * df + c.qez3 * df * df) *
                     (1 + (c.qez4 + c.qez5 * g) * 2 / std::numbers::pi * std::atan(B_t * c.qcz1 * alpha_t));
  const double trail = D_t * cosine(B_t, c.qcz1, E_t, equivalent(alpha_t)) * cos_alpha * travel;
  double side = Fy - S_Vyk;
  if (!c.before_60) side = G_yk * lateral(point(slip.load, 0, slip.pressure)).force;
  const double alpha_r = alpha + y.S_H + y.S_V / K_y;
  const double B_r = c.qbz9 * stiffness_scale + c.qbz10 * y.B * C_y;
  const double D_r =
      Fz * R0 * mu_scale_y * cos_alpha * travel *
      ((c.qdz6 + c.qdz7 * df) * c.lres +
       ((c.qdz8 + c.qdz9 * df) * (1 + c.ppz2 * dp) + (c.qdz10 + c.qdz11 * df) * std::abs(g)) * g * c.lkzc);
  const double arm = R0 * (c.ssz1 + c.ssz2 * Fy / p.nominal + (c.ssz3 + c.ssz4 * df) * g) * c.ls;
  const double Mz = -trail * side + D_r * std::cos(std::atan(B_r * equivalent(alpha_r))) + arm * Fx;
  return {Fx, Fy, Mx, My, Mz};
}

}  // namespace lithe
