#include <filesystem>
#include <fstream>

#include "engine/analysis/state_space.h"
#include "engine/base/number_text.h"
#include "engine/output/csv.h"
#include "engine/output/hdf5_file.h"
#include "engine/output/partial_file.h"

namespace lithe {
namespace {

struct Named {
  std::string name;
  const MatrixX* matrix;
  const std::vector<std::string>* columns;  // null: states
  bool sparse;
};

std::vector<Named> matrices(const StateSpace& s) {
  const auto& d = s.descriptor;
  return {{"A", &s.A, nullptr, false},
          {"B", &s.B, &s.inputs, false},
          {"C", &s.C, nullptr, false},
          {"D", &s.D, &s.inputs, false},
          {"B_rate", &s.B_rate, &s.inputs, false},
          {"B_acceleration", &s.B_acceleration, &s.inputs, false},
          {"D_rate", &s.D_rate, &s.inputs, false},
          {"D_acceleration", &s.D_acceleration, &s.inputs, false},
          {"descriptor_E", &d.E, &d.states, true},
          {"descriptor_A", &d.A, &d.states, true},
          {"descriptor_B", &d.B, &s.inputs, true},
          {"descriptor_C", &d.C, &d.states, true},
          {"descriptor_D", &d.D, &s.inputs, true}};
}

}  // namespace

void write_csv(const StateSpace& system, const std::string& path) {
  for (const Named& m : matrices(system)) {
    Table table;
    for (Eigen::Index j = 0; j < m.matrix->cols(); ++j)
      table.columns.push_back(m.columns ? (*m.columns)[static_cast<std::size_t>(j)] : "x" + std::to_string(j + 1));
    if (table.columns.empty()) continue;
    for (Eigen::Index i = 0; i < m.matrix->rows(); ++i)
      for (Eigen::Index j = 0; j < m.matrix->cols(); ++j) table.values.push_back((*m.matrix)(i, j));
    write_csv(table, path + "_" + m.name + ".csv");
  }
}

void write_hdf5(const StateSpace& system, const std::string& path) {
  Hdf5Writer file(path);
  file.attribute("/", "kind", "lithe state space");
  for (const Named& m : matrices(system)) {
    std::string name = "/" + m.name;
    if (m.sparse) name.replace(0, std::string("/descriptor_").size(), "/descriptor/");
    file.write(name, *m.matrix);
  }
  file.write("/inputs", system.inputs);
  file.write("/input_units", system.input_units);
  file.write("/outputs", system.outputs);
  file.write("/output_units", system.output_units);
  file.write("/descriptor/states", system.descriptor.states);
  file.commit();
}

void write_matrix_market(const StateSpace& system, const std::string& path) {
  for (const Named& m : matrices(system)) {
    const MatrixX& matrix = *m.matrix;
    std::string text = std::string("%%MatrixMarket matrix ") + (m.sparse ? "coordinate" : "array") + " real general\n";
    text += std::to_string(matrix.rows()) + " " + std::to_string(matrix.cols());
    text += m.sparse ? " " + std::to_string((matrix.array() != 0).count()) + "\n" : "\n";
    for (Eigen::Index j = 0; j < matrix.cols(); ++j)
      for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
        if (m.sparse && matrix(i, j) == 0) continue;
        if (m.sparse) text += std::to_string(i + 1) + " " + std::to_string(j + 1) + " ";
        append_number(text, matrix(i, j));
        text += "\n";
      }
    PartialFile file(path + "_" + m.name + ".mtx");
    file.stream() << text;
    file.commit();
  }
}

}  // namespace lithe
