#pragma once

#include <string>
#include <vector>

#include "bodies/flexible/finite_element_model.h"
#include "bodies/flexible/readers/text_file.h"

namespace lithe {

/// The entries of one symmetric matrix as a file lists them: `row column value`, counted from 1, one triangle.
class MatrixEntries {
 public:
  explicit MatrixEntries(int size) : size_(size) {}
  /// The current line of the file; FileError for anything but three numbers within the size.
  void add_line(TextFile& file);
  /// An entry that the reader has checked; row and column count from 0.
  void add(int row, int column, double value) { entries_.emplace_back(row, column, value); }
  int size() const { return size_; }
  int count() const { return static_cast<int>(entries_.size()); }

  /// Both triangles from one. FileError if an entry appears twice (or in both triangles).
  SparseMatrix symmetric(const std::string& path) const;
  /// As listed. FileError if an entry appears twice or the matrix is not symmetric to 1e-10 of its largest entry.
  SparseMatrix general(const std::string& path) const;
  /// Whichever of the two it is: symmetric() if no entry has a partner across the diagonal, general() otherwise. Of use
  /// where one triangle is given in an order of rows that is not ours, so that it is spread over both.
  SparseMatrix one_triangle_or_both(const std::string& path) const;

 private:
  SparseMatrix assembled(const std::string& path, bool lower) const;

  int size_;
  std::vector<Eigen::Triplet<double>> entries_;
};

}  // namespace lithe
