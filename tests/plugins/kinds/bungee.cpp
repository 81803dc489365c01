#include "engine/plugin.h"

using namespace lithe;

/// A rope that pulls when it is stretched, σ = k (l - l₀) + c l̇ for l > l₀, V = ½ k (l - l₀)², and the drag of the air
/// on its second end, f = -b v.
class Bungee final : public Force</*markers=*/2, /*rows=*/1> {
 public:
  struct Parameters {
    double stiffness = 100, damping = 0;  // k, N/m; c, N s/m
    double natural_length = 1;            // l₀, m
    double drag = 0;                      // b, N s/m
    bool slack = true;                    // false: it pushes too
  };
  static constexpr Field<Parameters> kParameters[] = {{"stiffness", &Parameters::stiffness},
                                                      {"damping", &Parameters::damping},
                                                      {"natural_length", &Parameters::natural_length},
                                                      {"drag", &Parameters::drag},
                                                      {"slack", &Parameters::slack}};
  explicit Bungee(Parameters parameters) : parameters_(parameters) {
    require::not_negative(parameters_.stiffness, "stiffness");
  }

  void evaluate(double, std::span<const MarkerView> markers, ForceRows& rows) const override {
    const auto &A = markers[0], &B = markers[1];
    const auto& p = parameters_;
    const Vector3 d = B.p - A.p;
    const double length = d.norm(), stretch = length - p.natural_length;
    const Vector3 n = d / length;
    const bool taut = !p.slack || stretch > 0;
    const double k = taut ? p.stiffness : 0, c = taut ? p.damping : 0;
    rows.add({force(-n), force(n)}, k * stretch + c * n.dot(B.v - A.v), k, c, 0.5 * k * stretch * stretch);
    rows.add_load(B, force(-p.drag * B.v));
  }

 private:
  const Parameters parameters_;
};

LITHE_EXPORT_FORCE(Bungee, "bungee")
