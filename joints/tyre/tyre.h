#pragma once

#include <memory>

#include "engine/assembly/batch.h"
#include "engine/model/force_element.h"
#include "engine/observe/sensors.h"
#include "joints/tyre/magic_formula.h"
#include "joints/tyre/tyre_road.h"

namespace lithe {

/// A tyre on a road: Magic Formula forces (MagicFormula) of slips that build up as the tyre rolls. Markers: the road
/// (z up, or a TyreRoad in its axes), the wheel's centre on the body that spins (z: the axle, to the left of the way
/// forward), and a point of FirstOrderStates that holds the deflections u, v of the carcass along the road, m.
///   auto& carcass = graph.add<FirstOrderStates>("carcass", {.start = VectorX::Zero(3)});
///   graph.add<Tyre>("tyre", {road.marker(), wheel.marker(), carcass.point(0)}, {.coefficients = read_tir("car.tir")});
/// With n the road's normal below the wheel, a the axle, x = a × n / |a × n|, y = n × x, γ the camber, sin γ = a·n:
///   R_l = n·(p_B - P) / cos γ,  ρ = R_Ω - R_l          loaded radius, in the wheel's plane; the road's plane holds P
///   R_Ω = R_0 (q_re0 + q_v1 (R_0 Ω / V_0)²)
///   F_z cos γ = (1 + q_v2 |Ω| R_0 / V_0) F_z0 (1 + p_fz1 dp) (q_fz1 ρ/R_0 + q_fz2 ρ²/R_0²) + c ρ̇ >= 0
///   R_e = R_Ω - F_z0/c_z (D atan(B F_z/F_z0) + F F_z/F_z0)      effective rolling radius: breff, dreff, freff
///   V_sx = V_x - Ω R_e,  V_sy = y·(velocity of the wheel's point at the contact)
///   u̇ = -V_sx - |V_x| u / σ_κ,  v̇ = -V_sy - |V_x| v / σ_α,  κ' = u / σ_κ,  tan α' = -v / σ_α
/// (Pacejka 2012, sections 4.3, 7.2 and 9.3.) Relaxation lengths σ = K / C by the stiffnesses of slip and carcass, or
/// by ptx, pty; 0.1 R_0 at least. A wheel at rest hangs on its carcass, so it stands on a slope without creep; below
/// vxlow a damper acts on its slip and u, v stay within |κ'|, |tan α'| of about 1 while it slides. Its radial spring
/// has a potential on a plane and on terrain. Without load there is no force and u, v follow the slip within 0.1 R_0.
/// Limits: one contact; no turn slip; no load transfer within the contact by F_x and F_y (q_Fcx, q_Fcy), no rim; the
/// damping grows with ρ up to a twentieth of the nominal deflection. A wheel that lies flat does not touch.
class Tyre final : public Force</*markers=*/3, /*rows=*/1> {
 public:
  struct Parameters {
    TyreCoefficients coefficients{};
    std::shared_ptr<const TyreRoad> road{};  // null: the plane z = 0 of the road's marker
    double pressure = 0;                     // Pa; 0: that of the coefficients
    bool mirrored = false;                   // a tyre measured for the other side of the car
    double low_speed_damping = 0.1;          // at rest, of critical for the nominal load on its carcass
  };
  /// Throws SceneError as MagicFormula does, without vertical stiffness or relaxation, and for negative values.
  explicit Tyre(Parameters parameters);

  /// Of one state; forces and moments on the wheel at the contact, along x, y and n.
  struct Contact {
    Vector3 point, normal, forward;             // world axes
    double deflection = 0;                      // ρ; negative: in the air
    double load = 0;                            // F_z, N
    double radius = 0;                          // R_e
    double camber = 0;                          // γ
    double kappa = 0, alpha = 0;                // κ', α'
    double speed = 0, spin = 0;                 // V_x, Ω
    double slip_x = 0, slip_y = 0;              // V_sx, V_sy
    double relaxation_x = 0, relaxation_y = 0;  // σ_κ, σ_α
    double u_dot = 0, v_dot = 0;
    MagicFormula::Reaction reaction{};
  };
  Contact contact(std::span<const MarkerView> markers) const;
  const MagicFormula& formula() const { return formula_; }

  // Not a Force<3, 1>: the tangent takes loads of an element with rows by velocity too only where the compiler does not
  // know of the rows.
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  /// Refuses a wheel that is drawn flat on the road.
  void initialize(std::span<const MarkerView> markers) override;

 private:
  struct Radial;
  Radial radial(double deflection) const;
  Contact contact(std::span<const MarkerView> markers, Radial& row, double& deflection_rate) const;
  void roll(std::span<const MarkerView> markers, Contact& c) const;

  const Parameters p_;
  const MagicFormula formula_;
  double by_pressure_ = 0;  // dp_i
  double linear_ = 0;       // q_fz1
  double sag_ = 0;          // F_z0 / c_z, m
};

/// Columns kappa, alpha (rad), camber (rad), deflection (m), Fx, Fy, Fz (N), Mx, My, Mz (N m) of Tyre::Contact, and the
/// power on road and wheel (W; negative: what the tyre and its contact dissipate or store).
Sensor tyre_contact(const Tyre& tyre, Located name = "");

extern template std::unique_ptr<ForceBatch> make_force_batch<Tyre>();

}  // namespace lithe
