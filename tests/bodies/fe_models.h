#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "bodies/flexible/finite_element_model.h"
#include "bodies/flexible/readers/calculix.h"
#include "bodies/flexible/readers/matrix_market.h"
#include "engine/base/error.h"

/// The finite-element models of examples/data/pendulum and what tests ask of them.
namespace lithe::test {

inline std::string pendulum_path(const std::string& body, const std::string& file) {
  return std::string(LITHE_EXAMPLE_DATA) + "/pendulum/" + body + "/" + file;
}

inline FiniteElementModel pendulum(const std::string& body) {
  const auto path = [&](const char* file) { return pendulum_path(body, file); };
  return read_matrix_market(path("K.mtx"), path("M.mtx"), path("nodes.csv"), path("node_sets.csv"),
                            path("elements.csv"));
}

inline FiniteElementModel pendulum_from_calculix(const std::string& body) {
  return read_calculix(pendulum_path(body, "calculix/matrices"));
}

/// Columns of a CSV file by name; empty cells are left out.
inline std::map<std::string, std::vector<double>> csv_columns(const std::string& path) {
  std::ifstream stream(path);
  EXPECT_TRUE(stream) << path;
  std::string line, cell;
  std::vector<std::string> names;
  std::getline(stream, line);
  for (std::istringstream header(line); std::getline(header, cell, ',');) names.push_back(cell);
  std::map<std::string, std::vector<double>> columns;
  while (std::getline(stream, line)) {
    std::istringstream row(line);
    for (size_t k = 0; std::getline(row, cell, ','); ++k)
      if (!cell.empty()) columns[names.at(k)].push_back(std::stod(cell));
  }
  return columns;
}

inline double largest(const SparseMatrix& A) { return A.nonZeros() == 0 ? 0.0 : A.coeffs().abs().maxCoeff(); }

inline double difference(const SparseMatrix& A, const SparseMatrix& B) {
  const SparseMatrix D = A - B;
  return largest(D) / largest(B);
}

/// The call throws this kind of error, and the message mentions all of these.
template <typename Kind>
void expect_error(const std::function<void()>& call, const std::vector<std::string>& mentions) {
  try {
    call();
  } catch (const Kind& error) {
    for (const std::string& text : mentions)
      EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << "no '" << text << "' in:\n" << error.what();
    EXPECT_FALSE(error.fix().empty());
    EXPECT_FALSE(error.where().empty());
    return;
  } catch (const std::exception& other) {
    FAIL() << "another kind of error: " << other.what();
  }
  FAIL() << "no error was thrown";
}

}  // namespace lithe::test
