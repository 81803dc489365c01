#pragma once

#include <limits>

namespace lithe {

/// What describes a tyre, named as in the .tir files of MF-Tyre (models/read_tir.h), SI units and radians. What is not
/// given is 0, of scaling factors 1, of ranges without end.
struct TyreCoefficients {
  /// Of FITTYP 6 (MF-Tyre 5.2): horizontal shift by camber PHY3, and the trail times a side force with camber. False:
  /// 60, 61, 62.
  bool before_60 = false;

  // [MODEL], [DIMENSION], [OPERATING_CONDITIONS], [INERTIA]
  double longvl = 16.7;  // V_0, m/s
  double vxlow = 1;      // below it: low speed, m/s
  double unloaded_radius = 0;
  double inflpres = 0, nompres = 0;  // p, p_0, Pa; 0: without effect of pressure

  // [VERTICAL]
  double fnomin = 0;              // F_z0, N
  double vertical_stiffness = 0;  // c_z at F_z0, N/m, where q_fz1 is 0
  double vertical_damping = 0;    // N s/m
  double breff = 0, dreff = 0, freff = 0;
  double q_re0 = 1, q_v1 = 0, q_v2 = 0, q_fz1 = 0, q_fz2 = 0, pfz1 = 0;

  // [STRUCTURAL]: of the carcass at F_z0, N/m; 0: relaxation lengths by ptx1 … pty2
  double longitudinal_stiffness = 0, lateral_stiffness = 0;
  double pcfx1 = 0, pcfx2 = 0, pcfx3 = 0, pcfy1 = 0, pcfy2 = 0, pcfy3 = 0;
  double ptx1 = 0, ptx2 = 0, ptx3 = 0, pty1 = 0, pty2 = 0;

  // Ranges: what is beyond them acts as at their end.
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  double fzmax = kNone;  // N
  double kpumin = -1.5, kpumax = 1.5, alpmin = -1.5, alpmax = 1.5, cammin = -kNone, cammax = kNone;

  // [SCALING_COEFFICIENTS]
  double lfzo = 1, lcx = 1, lmux = 1, lex = 1, lkx = 1, lhx = 1, lvx = 1, lcy = 1, lmuy = 1, ley = 1, lky = 1, lhy = 1,
         lvy = 1, ltr = 1, lres = 1, lxal = 1, lyka = 1, lvyka = 1, ls = 1, lkyc = 1, lkzc = 1, lvmx = 1, lmx = 1,
         lmy = 1, lmuv = 0, lsgkp = 1, lsgal = 1;

  // [LONGITUDINAL_COEFFICIENTS]
  double pcx1 = 0, pdx1 = 0, pdx2 = 0, pdx3 = 0, pex1 = 0, pex2 = 0, pex3 = 0, pex4 = 0, pkx1 = 0, pkx2 = 0, pkx3 = 0,
         phx1 = 0, phx2 = 0, pvx1 = 0, pvx2 = 0, ppx1 = 0, ppx2 = 0, ppx3 = 0, ppx4 = 0, rbx1 = 0, rbx2 = 0, rbx3 = 0,
         rcx1 = 0, rex1 = 0, rex2 = 0, rhx1 = 0;

  // [OVERTURNING_COEFFICIENTS]
  double qsx1 = 0, qsx2 = 0, qsx3 = 0, qsx4 = 0, qsx5 = 0, qsx6 = 0, qsx7 = 0, qsx8 = 0, qsx9 = 0, qsx10 = 0, qsx11 = 0,
         ppmx1 = 0;

  // [LATERAL_COEFFICIENTS]
  double pcy1 = 0, pdy1 = 0, pdy2 = 0, pdy3 = 0, pey1 = 0, pey2 = 0, pey3 = 0, pey4 = 0, pey5 = 0, pky1 = 0, pky2 = 0,
         pky3 = 0, pky4 = 2, pky5 = 0, pky6 = 0, pky7 = 0, phy1 = 0, phy2 = 0, phy3 = 0, pvy1 = 0, pvy2 = 0, pvy3 = 0,
         pvy4 = 0, ppy1 = 0, ppy2 = 0, ppy3 = 0, ppy4 = 0, ppy5 = 0, rby1 = 0, rby2 = 0, rby3 = 0, rby4 = 0, rcy1 = 0,
         rey1 = 0, rey2 = 0, rhy1 = 0, rhy2 = 0, rvy1 = 0, rvy2 = 0, rvy3 = 0, rvy4 = 0, rvy5 = 0, rvy6 = 0;

  // [ROLLING_COEFFICIENTS]
  double qsy1 = 0, qsy2 = 0, qsy3 = 0, qsy4 = 0, qsy5 = 0, qsy6 = 0, qsy7 = 0, qsy8 = 0;

  // [ALIGNING_COEFFICIENTS]
  double qbz1 = 0, qbz2 = 0, qbz3 = 0, qbz4 = 0, qbz5 = 0, qbz9 = 0, qbz10 = 0, qcz1 = 0, qdz1 = 0, qdz2 = 0, qdz3 = 0,
         qdz4 = 0, qdz6 = 0, qdz7 = 0, qdz8 = 0, qdz9 = 0, qdz10 = 0, qdz11 = 0, qez1 = 0, qez2 = 0, qez3 = 0, qez4 = 0,
         qez5 = 0, qhz1 = 0, qhz2 = 0, qhz3 = 0, qhz4 = 0, ppz1 = 0, ppz2 = 0, ssz1 = 0, ssz2 = 0, ssz3 = 0, ssz4 = 0;
};

}  // namespace lithe
