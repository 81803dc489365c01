#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "bodies/flexible/readers/read_flexible_body.h"
#include "bodies/flexible/reduction.h"
#include "engine/output/vtu.h"
#include "tools/lithe/commands.h"

namespace lithe::command {
namespace fs = std::filesystem;
namespace {

struct InspectOptions {
  std::string path, units, out;
  std::vector<double> material;  // E, nu, density
  int modes = 6;
};

/// The elements that VTU knows; others are left to the dots of their nodes.
std::vector<VtuCells> pictured(const std::vector<ElementBlock>& blocks) {
  std::vector<VtuCells> cells;
  for (const ElementBlock& block : blocks)
    if (block.type.rfind("C3D", 0) == 0 && block.type.rfind("C3D15", 0) != 0)
      cells.push_back({block.type, block.nodes});
  return cells;
}

/// DIR/mesh.vtu, and DIR/NAME.pvd: one frame a mode, at its number as time, the largest displacement a tenth of the
/// body's size, with the displacement as field.
void write_pictures(const InspectOptions& options, const FlexibleBodyFile& body) {
  auto basis = body.basis;
  if (!basis)
    basis = make_basis(*body.model, MeanAxisFrame{}, std::clamp(options.modes, 0, body.model->dof_count() - 6));
  const Matrix3X& nodes = basis->nodes;
  const auto cells = pictured(basis->elements);
  fs::create_directories(options.out);
  write_vtu((fs::path(options.out) / "mesh.vtu").string(), nodes, cells, {});
  const double size = (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
  PvdSeries series((fs::path(options.out) / fs::path(options.path).stem()).string());
  for (int k = 0; k < std::min<int>(options.modes, basis->mode_count()); ++k) {
    Matrix3X shape(3, nodes.cols());
    for (Eigen::Index i = 0; i < nodes.cols(); ++i) shape.col(i) = basis->modes.col(k).segment<3>(3 * i);
    const double largest = shape.colwise().norm().maxCoeff();
    if (largest > 0) shape *= 0.1 * size / largest;
    series.add(k + 1, nodes + shape, cells, {{"displacement", shape}});
  }
  std::printf("mesh and %d mode(s) written to %s\n", series.frame_count(), options.out.c_str());
}

int inspect(const InspectOptions& options) {
  ImportOptions import{.units = options.units};
  if (!options.material.empty()) import.materials[""] = {options.material[0], options.material[1], options.material[2]};
  const FlexibleBodyFile body = read_flexible_body(options.path, import);
  std::printf("%s", body.sheet().c_str());
  if (!options.out.empty()) write_pictures(options, body);
  return 0;
}

}  // namespace

void add_body(CLI::App& app, int& exit_code) {
  CLI::App* body = app.add_subcommand("body", "Flexible bodies from finite-element codes.");
  body->require_subcommand(1);
  CLI::App* command = body->add_subcommand("inspect", "Read a body, prove it and print what was understood.");
  auto options = std::make_shared<InspectOptions>();
  command->add_option("path", options->path, "any file of the body: deck, matrix, mesh, SID")->required();
  command->add_option("--units", options->units, "m-kg-s (SI), mm-t-s, mm-kg-ms, ...; asked for where needed");
  command->add_option("--material", options->material, "E nu density, for a mesh without matrices")->expected(3);
  command->add_option("--modes", options->modes, "modes to write")->check(CLI::Range(0, 1000))->capture_default_str();
  command->add_option("--out", options->out, "folder for mesh.vtu and the modes, for ParaView");
  command->callback([options, &exit_code] { exit_code = inspect(*options); });
}

}  // namespace lithe::command
