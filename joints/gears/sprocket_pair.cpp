#include "joints/gears/sprocket_pair.h"

#include <numbers>

#include "engine/assembly/batch_of.h"

namespace lithe {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr int kArcPoints = 12;

}  // namespace

SprocketPair::SprocketPair(Parameters p)
    : parameters_(p),
      chain_{p.pitch, p.axial_stiffness, p.damping, p.pretension, p.slack, p.polygon},
      radius_A_(Sprocket(p.teeth_A, chain_, 1).radius),
      radius_B_(Sprocket(p.teeth_B, chain_, 1).radius) {
  chain_.check();
}

ChainSpan SprocketPair::span(int side, std::span<const MarkerView> markers, const AngleMemory& memory) const {
  return ChainSpan::between({parameters_.teeth_A, chain_, side}, {parameters_.teeth_B, chain_, side}, chain_, markers,
                            memory);
}

void SprocketPair::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  for (int i = 0; i < 2; ++i) span(1 - 2 * i, markers, rows).pull(material_[i], chain_.damping, markers, rows);
}

void SprocketPair::initialize(std::span<const MarkerView> m) {
  ChainSpan::check({parameters_.teeth_A, chain_, 1}, {parameters_.teeth_B, chain_, 1}, m);
  for (int i = 0; i < 2; ++i) material_[i] = {span(1 - 2 * i, m, {}), chain_};
}

std::vector<DrawnShape> SprocketPair::drawn_shapes(int marker) const {
  return {visual::cylinder(marker == 0 ? radius_A_ : radius_B_, 0.5 * parameters_.pitch)};
}

void SprocketPair::drawn_line(std::span<const MarkerView> markers, const AngleMemory&, Matrix3X& points) const {
  const auto &A = markers[0], &B = markers[1];
  const ChainSpan left = span(1, markers, {}), right = span(-1, markers, {});
  points.resize(3, 2 * kArcPoints + 1);
  for (int i = 0; i < kArcPoints; ++i) {
    const double x = static_cast<double>(i) / (kArcPoints - 1);
    points.col(i) =
        A.p + radius_A_ * in_plane_direction(A, right.normal_A + (left.normal_A - kTurn - right.normal_A) * x);
    points.col(kArcPoints + i) =
        B.p + radius_B_ * in_plane_direction(B, left.normal_B + (right.normal_B - kTurn - left.normal_B) * x);
  }
  points.col(2 * kArcPoints) = points.col(0);
}

template std::unique_ptr<ForceBatch> make_force_batch<SprocketPair>();

}  // namespace lithe
