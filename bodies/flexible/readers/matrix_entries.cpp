#include "bodies/flexible/readers/matrix_entries.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/error.h"

namespace lithe {
namespace {

std::string at(Eigen::Index row, Eigen::Index column) {
  return "row " + std::to_string(row + 1) + ", column " + std::to_string(column + 1);
}

}  // namespace

void MatrixEntries::add_line(TextFile& file) {
  const auto& words = file.words();
  if (words.size() != 3)
    file.fail("a line of " + std::to_string(words.size()) + " words, where row, column and value should stand.",
              "export the matrix again; the file may be cut.");
  const int row = file.integer(words[0], "row"), column = file.integer(words[1], "column");
  const double value = file.number(words[2], "matrix entry");
  for (int index : {row, column})
    if (index < 1 || index > size_)
      file.fail("row or column " + std::to_string(index) + " of a matrix of " + std::to_string(size_) + " rows.",
                "rows count from 1; check that all files are of the same export.");
  entries_.emplace_back(row - 1, column - 1, value);
}

SparseMatrix MatrixEntries::assembled(const std::string& path, bool lower) const {
  auto entries = entries_;
  if (lower)
    for (auto& e : entries) e = {std::max(e.row(), e.col()), std::min(e.row(), e.col()), e.value()};
  SparseMatrix A(size_, size_);
  A.setFromTriplets(entries.begin(), entries.end());
  if (A.nonZeros() == static_cast<Eigen::Index>(entries.size())) return A;

  // Fewer entries than lines: some were summed. Find one for the message.
  const auto place = [](const auto& e) { return std::pair(e.col(), e.row()); };
  std::sort(entries.begin(), entries.end(), [&](const auto& a, const auto& b) { return place(a) < place(b); });
  const auto twice = std::adjacent_find(entries.begin(), entries.end(),
                                        [&](const auto& a, const auto& b) { return place(a) == place(b); });
  throw FileError("the entry at " + at(twice->row(), twice->col()) +
                      (lower ? " is given twice, or in both triangles." : " is given twice."),
                  path, "give each entry once" + std::string(lower ? ", of one triangle only." : "."));
}

SparseMatrix MatrixEntries::symmetric(const std::string& path) const {
  SparseMatrix lower = assembled(path, true);
  lower.prune([](Eigen::Index row, Eigen::Index column, double value) { return row == column || value != 0; });
  return lower.selfadjointView<Eigen::Lower>();
}

SparseMatrix MatrixEntries::general(const std::string& path) const {
  const SparseMatrix A = assembled(path, false);
  const SparseMatrix transposed = A.transpose();
  const SparseMatrix difference = A - transposed;
  double scale = 0, worst = 0;
  Eigen::Index row = 0, column = 0;
  for (int j = 0; j < size_; ++j) {
    for (SparseMatrix::InnerIterator e(A, j); e; ++e) scale = std::max(scale, std::abs(e.value()));
    for (SparseMatrix::InnerIterator e(difference, j); e; ++e)
      if (std::abs(e.value()) > worst) worst = std::abs(e.value()), row = e.row(), column = j;
  }
  if (worst > 1e-10 * scale)
    throw FileError("the matrix is not symmetric: at " + at(row, column) + " it differs from its transpose by " +
                        std::to_string(worst / scale) + " of its largest entry.",
                    path, "give a symmetric matrix; contact, follower loads and damping do not belong in it.");
  return 0.5 * (A + transposed);
}

SparseMatrix MatrixEntries::one_triangle_or_both(const std::string& path) const {
  std::vector<std::pair<int, int>> places;
  places.reserve(entries_.size());
  for (const auto& e : entries_) places.emplace_back(std::max(e.row(), e.col()), std::min(e.row(), e.col()));
  std::sort(places.begin(), places.end());
  const bool once = std::adjacent_find(places.begin(), places.end()) == places.end();
  return once ? symmetric(path) : general(path);
}

}  // namespace lithe
