#pragma once

#include <map>
#include <memory>
#include <vector>

#include "bodies/beam/beam.h"
#include "bodies/flexible/flexible_body.h"
#include "engine/model/deformable_body.h"

namespace lithe {

/// A beam in as much detail as a scene needs, from one drawing: rigid, some modes, modes with the deflections of second
/// order, or the Beam itself with any number of elements. As drawn it is the Beam; solve() chooses (engine/study/
/// solve.h), or set_fidelity():
///   {}                                                       rigid
///   {.modes = {0, 1}, .deflection = Deflection::stiffened}   two modes, of the mesh as drawn
///   {.deflection = Deflection::exact, .elements = 40}        geometrically exact
///   auto& blade = graph.add<SlenderBody>("blade", {.beam = {.axis = line, .sections = {{0, s}}, .elements = 16}});
///   graph.add<FixedJoint>("root", {hub.marker(), blade.marker(0)});
///   solve(graph, 20, {want(position(blade.marker(blade.length())), percent(1))});
/// Modes are those of the beam clamped at `held`, and its frame is tangent there; deflections of second order are
/// relative to that frame: it must be where the body is held.
class SlenderBody final : public DeformableBody, public DrawableBody {
 public:
  struct Parameters {
    Beam::Parameters beam{};  // its `stations` are where markers may be, beside the ends
    double held = 0;          // arc length, m: an end or a station
    int mode_count = 12;      // candidates
  };
  struct Cache : BodyCache {
    explicit Cache(const SlenderBody& body) : inner(body.model().make_cache()) {}
    std::unique_ptr<BodyCache> inner;
  };

  /// Throws SceneError as Beam does, for `held` where no node is, and for fewer than one candidate.
  explicit SlenderBody(Parameters parameters);

  /// In the section at an end or a station, by its arc length (m); marker axes to section axes. SceneError elsewhere.
  Marker marker(double arc, const Matrix3& orientation = Matrix3::Identity());
  /// In the section of the end or station at `point` (world axes, as drawn, m); marker axes to world axes. SceneError
  /// where there is none within 1e-6 of the length.
  Marker marker_at_world(const Point& point, const Matrix3& orientation = Matrix3::Identity());

  double length() const { return parameters_.beam.axis.length; }  // m
  const Parameters& parameters() const { return parameters_; }
  /// The present model: one of the two is null.
  const Beam* beam() const { return beam_.get(); }
  const FlexibleBody* flexible() const { return flexible_.get(); }

  VectorX candidate_stiffness() const override { return modal().candidate_stiffness(); }
  VectorX candidate_damping() const override { return modal().candidate_damping(); }
  VectorX candidate_reach() const override { return modal().candidate_reach(); }
  /// Empty for the exact beam: it leaves no mode out.
  VectorX candidate_forces(const BodyState&, const double* v_dot, std::span<const MarkerLoad> loads,
                           const Vector3& gravity) const override;
  Deflection finest_deflection() const override { return Deflection::stiffened; }
  int element_count(int asked) const override;
  const Fidelity& fidelity() const override { return fidelity_; }
  void set_fidelity(Fidelity fidelity) override;
  Marker body_frame() override;

  /// Of the present model, as all that follows.
  Coordinates coordinates() const override { return model().coordinates(); }
  std::unique_ptr<BodyCache> make_cache() const override { return std::make_unique<Cache>(*this); }
  void initial_state(VectorRef q, VectorRef v) const override { model().initial_state(q, v); }
  void evaluate(const BodyState&, Level) const override;
  void add_residual(const BodyState&, const double* v_dot, const Vector3& gravity, double* r) const override;
  void add_tangent(const BodyState&, const double* v_dot, const Vector3& gravity, const TangentWeights&,
                   BodyTangent&) const override;
  void marker_kinematics(const BodyState&, int marker, Level, MarkerKinematics&) const override;
  BodyEnergy energy(const BodyState&, const Vector3& gravity) const override;

  DrawnMesh drawn_mesh(bool with_stress) const override { return drawable().drawn_mesh(with_stress); }
  void drawn_points(const BodyState&, const DrawnMesh& mesh, Matrix3X& points) const override;
  std::vector<std::pair<int, double>> nodes_of_marker(int marker) const override {
    return drawable().nodes_of_marker(marker);
  }

 private:
  struct Place {
    bool on_frame;  // else in the section at `arc`
    double arc;
    Matrix3 axes;  // to section axes
  };
  const Body& model() const;
  const DrawableBody& drawable() const;
  /// With all candidates: what is asked of them at any fidelity.
  const FlexibleBody& modal() const;
  /// 0: as drawn.
  Beam::Parameters mesh(int elements) const;
  std::shared_ptr<const ModalBasis> basis_of(int elements) const;
  std::unique_ptr<FlexibleBody> reduced(int elements) const;
  void put(const Place& place);
  Marker add(const Place& place);

  const Parameters parameters_;
  std::vector<Place> places_;
  Fidelity fidelity_;
  std::unique_ptr<Beam> beam_;
  std::unique_ptr<FlexibleBody> flexible_;
  Marker body_frame_;                                               // once asked for
  mutable std::map<int, std::shared_ptr<const ModalBasis>> bases_;  // by elements, once asked for
  mutable std::unique_ptr<FlexibleBody> candidates_;                // likewise
};

extern template std::unique_ptr<BodyBatch> make_body_batch<SlenderBody>();

}  // namespace lithe
