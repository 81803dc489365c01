#include "engine/cones/dense_cones.h"

namespace lithe {

DenseCones::DenseCones(const ConeProblem& problem) : problem_rows(problem.rows) {
  const MatrixX all = problem.delassus();
  std::vector<double> scales;
  const auto add_rows = [&](int first, int count) {
    // One scale for all rows of a disc: it has to stay a disc.
    double largest = 0;
    for (int i = first; i < first + count; ++i) largest = std::max(largest, all(i, i));
    for (int i = first; i < first + count; ++i) {
      rows.push_back(i);
      scales.push_back(largest > 0 ? 1 / std::sqrt(largest) : 1);
    }
    return scales.back();
  };
  for (const auto& contact : problem.contacts) {
    if (!(all(contact.row, contact.row) > 0)) continue;  // nothing moves along the normal
    const int normal = static_cast<int>(rows.size());
    normals.push_back(normal);
    const double scale_normal = add_rows(contact.row, 1);
    const auto add_disc = [&](int offset, int count, double limit) {
      if (!(limit > 0)) return;
      const int first = static_cast<int>(rows.size());
      const double scale_disc = add_rows(contact.row + offset, count);
      // Each row is scaled to a unit diagonal, so the limit of a disc is multiplied by the ratio of the two scales.
      discs.push_back({normal, first, count, limit * scale_normal / scale_disc});
    };
    add_disc(1, 2, contact.friction);
    if (contact.rows == 6) {
      add_disc(3, 2, contact.rolling);
      add_disc(5, 1, contact.spinning);
    }
  }
  scale = Eigen::Map<VectorX>(scales.data(), static_cast<Eigen::Index>(scales.size()));
  W = all(rows, rows);
  W.array().colwise() *= scale.array();
  W.array().rowwise() *= scale.transpose().array();
  free = problem.free(rows).cwiseProduct(scale);
}

VectorX DenseCones::scaled(const VectorX& r) const { return r(rows).cwiseQuotient(scale); }

void DenseCones::unscale(const VectorX& x, VectorX& r) const {
  r.setZero(problem_rows);
  for (std::size_t i = 0; i < rows.size(); ++i) r[rows[i]] = scale[i] * x[i];
}

}  // namespace lithe
