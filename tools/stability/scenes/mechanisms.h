#pragma once

#include <string>
#include <vector>

#include "joints/prismatic_joint.h"
#include "joints/revolute_joint.h"
#include "tools/scenes/parts.h"
#include "tools/stability/bench.h"

/// Mechanisms of the rigid benchmarks, with hinges in space as an engineer draws them: their rows are redundant.
namespace lithe::lab {

using scenes::axes_with_z;
using scenes::Part;
using scenes::rod;

/// R12: planar four-bar of 3-D hinges, 20 rows of rank 17. Bodies: crank O-A, coupler A-B, rocker D-B.
class FourBar : public Bench {
 public:
  FourBar()
      : Bench({0, -9.81, 0}, [](SystemGraph& graph) {
          const Vector3 O(0, 0, 0), D(1.4, 0, 0), A(0, 0.5, 0), v_A(-3, 0, 0);
          const Vector3 B(1.109610152249955961, 0.9569084262998764912, 0);
          const Vector3 v_B(-2.666762317410566574, -0.8092735752498505519, 0);
          const Part crank = rod(graph, "crank", O, A, 0.5, 0, O, v_A);
          const Part coupler = rod(graph, "coupler", A, B, 1.2, 0, v_A, v_B);
          const Part rocker = rod(graph, "rocker", D, B, 1.0, 0, O, v_B);
          graph.add<RevoluteJoint>("O", {graph.ground().marker(O), crank.at(O)});
          graph.add<RevoluteJoint>("A", {crank.at(A), coupler.at(A)});
          graph.add<RevoluteJoint>("B", {coupler.at(B), rocker.at(B)});
          graph.add<RevoluteJoint>("D", {graph.ground().marker(D), rocker.at(D)});
        }) {}
  Vector3 B() const { return 2 * state.q.segment<3>(14) - Vector3(1.4, 0, 0); }
  /// B at 5 s: rigid/R12_redundant_four_bar/reference.csv.
  static Vector3 B_after_5_s() { return {7.152166022556951663e-1, 7.287466625472567294e-1, 0}; }
};

/// R04: Bricard's closed 6R loop, 30 rows of rank 29 all along. Bodies: rods P1P2 ... P5P6.
class Bricard : public Bench {
 public:
  Bricard()
      : Bench({0, -9.81, 0}, [](SystemGraph& graph) {
          const Vector3 P[] = {{0, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, -1, 1}, {0, -1, 1}, {0, 0, 1}};
          const Vector3 axis[] = {Vector3::UnitY(), Vector3::UnitZ(), Vector3::UnitX(),
                                  Vector3::UnitY(), Vector3::UnitZ(), Vector3::UnitX()};
          std::vector<Part> rods;
          for (int i = 0; i < 5; ++i)
            rods.push_back(rod(graph, "rod " + std::to_string(i + 1), P[i], P[i + 1], 1, 0.1));
          for (int i = 0; i < 6; ++i) {
            const Matrix3 axes = axes_with_z(axis[i]);
            const Marker before = i > 0 ? rods[i - 1].at(P[i], axes) : graph.ground().marker(P[i], axes);
            const Marker after = i < 5 ? rods[i].at(P[i], axes) : graph.ground().marker(P[i], axes);
            graph.add<RevoluteJoint>("hinge " + std::to_string(i + 1), {before, after});
          }
        }) {}
  /// The end of the second rod: from its middle half a metre along its x axis.
  Vector3 P3() const { return state.q.segment<3>(7) + 0.5 * rotation_matrix(Vector4(state.q.segment<4>(10))).col(0); }
  /// P3 at 10 s: rigid/R04_bricard/reference.csv.
  static Vector3 P3_after_10_s() { return {9.99730987303835361e-1, -9.9999996382581724e-1, -2.68976512249304587e-4}; }
};

/// R11: planar slider-crank through its dead centres. Bodies: crank, rod, slider on the x axis.
class SliderCrank : public Bench {
 public:
  struct Variant {
    double crank, rod, crank_mass, rod_mass, slider_mass;  // m, kg
    double angle, speed;                                   // rad, rad/s
  };
  static constexpr Variant kA{0.15, 0.30, 0.36, 0.151104, 0.075552, 0, 15};
  static constexpr Variant kB{1, 1, 1, 1, 1, M_PI / 4, 5};

  explicit SliderCrank(const Variant& of)
      : Bench({0, -9.81, 0},
              [&](SystemGraph& graph) {
                const double sine = of.crank * std::sin(of.angle), cosine = of.crank * std::cos(of.angle);
                // Equal links: the branch on which the slider goes through the crank's axis.
                const bool equal = of.rod == of.crank;
                const double along = equal ? cosine : std::sqrt(of.rod * of.rod - sine * sine), x = cosine + along;
                const double speed = -of.speed * sine * (equal ? 2 : 1 + cosine / along);
                const Vector3 O(0, 0, 0), pin(cosine, sine, 0), end(x, 0, 0);
                const Vector3 v_pin = of.speed * Vector3(-sine, cosine, 0), v_end(speed, 0, 0);
                const Part crank = scenes::rod(graph, "crank", O, pin, of.crank_mass, 0, O, v_pin);
                const Part link = scenes::rod(graph, "rod", pin, end, of.rod_mass, 0, v_pin, v_end);
                const Part slider(graph, "slider", of.slider_mass, {1, 1, 1}, end, Matrix3::Identity(), v_end);
                const Matrix3 along_x = axes_with_z({1, 0, 0}, {0, 1, 0});
                graph.add<RevoluteJoint>("main bearing", {graph.ground().marker(), crank.at(O)});
                graph.add<RevoluteJoint>("crank pin", {crank.at(pin), link.at(pin)});
                graph.add<RevoluteJoint>("wrist pin", {link.at(end), slider.at(end)});
                graph.add<PrismaticJoint>("guide", {graph.ground().marker(O, along_x), slider.at(end, along_x)});
              }),
        variant_(of) {}

  /// How far the slider is from where the crank's angle wants it on the branch of the start, m.
  double branch_error() const {
    const Vector3 pin = 2 * state.q.head<3>();
    const double along =
        variant_.rod == variant_.crank ? pin.x() : std::sqrt(variant_.rod * variant_.rod - pin.y() * pin.y());
    return std::abs(state.q[14] - pin.x() - along);
  }

 private:
  Variant variant_;
};

}  // namespace lithe::lab
