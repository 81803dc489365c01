#include "engine/integrator.h"

#include <cstdio>

namespace lithe {

std::string step_text(double h) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g s", h);
  return text;
}

double error_ratio(ConstVectorRef error, ConstVectorRef magnitudes, const Tolerance& tolerance) {
  double sum = 0;
  for (Eigen::Index i = 0; i < error.size(); ++i) {
    const double ratio = error[i] / (tolerance.absolute + tolerance.relative * magnitudes[i]);
    sum += ratio * ratio;
  }
  return error.size() > 0 ? std::sqrt(sum / static_cast<double>(error.size())) : 0;
}

}  // namespace lithe
