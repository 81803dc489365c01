#include "tests/support/adams_results.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

#include "tests/support/methods.h"

namespace lithe::test {
namespace {

constexpr std::array kQuantities = {"Pos", "Vel", "Acc", "Quat", "Avel", "Aacc", "Rforce", "Rtorque"};
constexpr std::size_t kQuaternion = 3;
using Bounds = std::array<double, kQuantities.size()>;

const std::map<std::string, Bounds> kBounds = {
    {"Revolute_Case02", {5.1e-6, 5.1e-6, 1.2e-3, 5.1e-7, 5.1e-6, 5.1e-4, 1.2e-3, 1.7e-3}},
    {"Spherical_Case02", {5.1e-6, 5.1e-6, 6.6e-4, 5.1e-7, 5.1e-6, 6e-4, 6.1e-4, 1e-11}},
    {"Prismatic_Case02", {5.1e-5, 5.1e-5, 7.9e-4, 4.8e-7, 1e-11, 1e-11, 7.9e-4, 9.5e-2}},
    {"Cylindrical_Case03", {5.1e-5, 5.1e-5, 6.9e-4, 5.1e-7, 5.1e-6, 6e-4, 6.9e-4, 7.2e-2}},
    {"Universal_Case02", {8.6e-4, 2.7e-3, 1.4e-2, 2.3e-4, 1.1e-3, 2.4e-3, 1.4e-2, 1e-11}},
    {"Distance_Case03", {6.3e-7, 9.8e-7, 1.4e-3, 5e-6, 2.9e-6, 1.3e-3, 1.4e-3, 1e-11}},
    {"TranSpring_Case02", {5.1e-7, 5.2e-7, 5.1e-6, 1e-11, 1e-11, 1e-11, 5.1e-6, 1e-11}},
    {"RotSpring_Case01", {1.4e-6, 1.1e-5, 7.9e-4, 2.4e-7, 5.4e-6, 6.7e-4, 7.9e-4, 1.5e-4}}};

/// The rows of one result file, time first.
std::vector<std::vector<double>> results(const std::string& file, std::size_t columns) {
  std::ifstream in(std::string(LITHE_TEST_DATA) + "/adams/" + file);
  std::string header;
  for (int line = 0; line < 3; ++line) std::getline(in, header);
  std::vector<std::vector<double>> rows;
  for (std::vector<double> row(1 + columns);;) {
    for (double& number : row) in >> number;
    if (!in) return rows;
    rows.push_back(row);
  }
}

}  // namespace

void expect_adams_results(const std::string& name, const Table& table,
                          const std::array<std::vector<AddedColumns>, 8>& columns) {
  const Bounds& bounds = kBounds.at(name);
  ASSERT_EQ(table.row_count(), 501);
  for (std::size_t k = 0; k < kQuantities.size(); ++k) {
    const auto rows = results(name + "_ADAMS_" + kQuantities[k] + ".txt", columns[k].size());
    ASSERT_EQ(rows.size(), 501U) << name << " " << kQuantities[k];
    double difference = 0, size = 0;
    for (int row = 0; row < 501; ++row) {
      const std::vector<double>& theirs = rows[static_cast<std::size_t>(row)];
      ASSERT_NEAR(table.at(row, 0), theirs[0], 1e-9);
      double plus = 0, minus = 0;  // a quaternion and its opposite are one rotation
      for (std::size_t c = 0; c < columns[k].size(); ++c) {
        double ours = 0;
        for (const int column : columns[k][c]) ours += table.at(row, column);
        plus = std::max(plus, std::abs(ours - theirs[1 + c]));
        minus = std::max(minus, std::abs(ours + theirs[1 + c]));
        size = std::max(size, std::abs(theirs[1 + c]));
      }
      difference = std::max(difference, k == kQuaternion ? std::min(plus, minus) : plus);
    }
    const std::string what = name + " " + kQuantities[k];
    expect_below(what + " (of " + std::to_string(size) + ")", difference, bounds[k]);
    if (size > 1e-6) {
      EXPECT_GT(size, 100 * bounds[k]) << what << ": the bound sees a sign";
    }
  }
}

}  // namespace lithe::test
