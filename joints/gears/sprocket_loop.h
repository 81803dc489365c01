#pragma once

#include "engine/assembly/batch.h"
#include "engine/model/appearance.h"
#include "engine/model/system_graph.h"
#include "joints/gears/chain_span.h"

namespace lithe {

/// One straight part of a chain or toothed belt from sprocket A to sprocket B, as SprocketPair has two; where both
/// sprockets turn alike along the outer tangent, otherwise crossed. add_sprocket_loop() draws them.
class SprocketRun final : public Force</*markers=*/2, /*rows=*/1>, public DrawableConnector {
 public:
  struct Parameters {
    int teeth_A = 0, teeth_B = 0;  // z
    int sense_A = 1, sense_B = 1;  // as SprocketWheel::sense
    ChainDrive chain{};
  };
  /// Throws SceneError as SprocketPair does, and for a sense that is not 1 or -1.
  explicit SprocketRun(Parameters parameters);

  std::vector<MeasuredAngle> angles() const override { return ChainSpan::bearings(); }
  bool depends_on_time() const override { return false; }
  void evaluate(double time, std::span<const MarkerView> markers, ForceRows& rows) const override;
  void initialize(std::span<const MarkerView> markers) override;
  std::vector<DrawnShape> drawn_shapes(int marker) const override;
  void drawn_line(std::span<const MarkerView> markers, const AngleMemory& memory, Matrix3X& points) const override;

 private:
  const ChainDrive chain_;
  const Sprocket A_, B_;
  ChainMaterial material_;
};

extern template std::unique_ptr<ForceBatch> make_force_batch<SprocketRun>();

/// A sprocket of a loop.
struct SprocketWheel {
  Marker marker;  // at its centre; z: its axis
  int teeth = 0;  // z
  int sense = 1;  // 1: on its way through the wheels as listed the chain runs counter-clockwise about z; -1: clockwise,
                  // of a wheel that it passes with its back
};

/// A closed chain or toothed belt around two or more sprockets on about parallel z axes, each straight part an element
/// "<name> 1", … from wheel to wheel. Material passes the sprockets with their teeth; each straight part has a tension
/// of its own. Around two it is SprocketPair. Limits as there.
///   add_sprocket_loop(graph, "cam drive", {{crank.marker(), 21}, {inlet.marker(), 42}, {idler.marker(), 19, -1}},
///                     {.pitch = 9.525e-3, .axial_stiffness = 1e6, .pretension = 100});
/// Throws SceneError for fewer than two sprockets, and as SprocketRun does.
std::vector<SprocketRun*> add_sprocket_loop(SystemGraph& graph, Located name, const std::vector<SprocketWheel>& wheels,
                                            const ChainDrive& chain);

}  // namespace lithe
