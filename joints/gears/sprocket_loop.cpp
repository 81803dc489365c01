#include "joints/gears/sprocket_loop.h"

#include "engine/assembly/batch_of.h"
#include "engine/base/error.h"

namespace lithe {
namespace {

/// Counter-clockwise about z a wheel lies to the left of the chain, which touches it on its right.
int side_of(int sense) {
  if (sense != 1 && sense != -1)
    throw SceneError("sense " + std::to_string(sense) + " of a sprocket", "",
                     "give 1 where the chain runs counter-clockwise about z, -1 where it runs clockwise");
  return -sense;
}

}  // namespace

SprocketRun::SprocketRun(Parameters p)
    : chain_(p.chain), A_(p.teeth_A, chain_, side_of(p.sense_A)), B_(p.teeth_B, chain_, side_of(p.sense_B)) {
  chain_.check();
}

void SprocketRun::evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const {
  ChainSpan::between(A_, B_, chain_, markers, rows).pull(material_, chain_.damping, markers, rows);
}

void SprocketRun::initialize(std::span<const MarkerView> markers) {
  ChainSpan::check(A_, B_, markers);
  material_ = {ChainSpan::between(A_, B_, chain_, markers, {}), chain_};
}

std::vector<DrawnShape> SprocketRun::drawn_shapes(int marker) const {
  return {visual::cylinder(marker == 0 ? A_.radius : B_.radius, 0.5 * chain_.pitch)};
}

void SprocketRun::drawn_line(std::span<const MarkerView> markers, const AngleMemory&, Matrix3X& points) const {
  const ChainSpan span = ChainSpan::between(A_, B_, chain_, markers, {});
  points.resize(3, 2);
  points.col(0) = markers[0].p + A_.radius * in_plane_direction(markers[0], span.normal_A);
  points.col(1) = markers[1].p + B_.radius * in_plane_direction(markers[1], span.normal_B);
}

template std::unique_ptr<ForceBatch> make_force_batch<SprocketRun>();

std::vector<SprocketRun*> add_sprocket_loop(SystemGraph& graph, Located name, const std::vector<SprocketWheel>& wheels,
                                            const ChainDrive& chain) {
  if (wheels.size() < 2)
    throw SceneError("'" + name.text + "' has " + std::to_string(wheels.size()) + " sprockets", "add_sprocket_loop",
                     "give two or more, in the order in which the chain meets them");
  std::vector<SprocketRun*> runs;
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    const SprocketWheel &A = wheels[i], &B = wheels[(i + 1) % wheels.size()];
    Located run = name;
    run.text += " " + std::to_string(i + 1);
    runs.push_back(&graph.add<SprocketRun>(
        run, {A.marker, B.marker},
        {.teeth_A = A.teeth, .teeth_B = B.teeth, .sense_A = A.sense, .sense_B = B.sense, .chain = chain}));
  }
  return runs;
}

}  // namespace lithe
