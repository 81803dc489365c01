#include "tools/certify/elastic_part.h"

#include <Eigen/Geometry>

#include <algorithm>

#include "bodies/flexible/elements/solid_element.h"
#include "engine/assembly/batch_of.h"
#include "joints/fixed_joint.h"
#include "joints/revolute_joint.h"
#include "joints/spherical_joint.h"
#include "plugins/inertial_body/inertial_body.h"

namespace lithe::certify {
namespace {

std::shared_ptr<const BrickMesh> bricks_of(const FiniteElementModel& model) {
  auto mesh = std::make_shared<BrickMesh>();
  mesh->name = model.name;
  mesh->node_ids = model.node_ids;
  mesh->nodes = model.nodes;
  for (const ElementBlock& block : model.elements)
    for (const auto& nodes : block.nodes) {
      if (block.type != "C3D8I" && block.type != "C3D8")
        throw SceneError("its elements are " + block.type, "solid '" + model.name + "'", "make it of C3D8I or C3D8");
      mesh->type = block.type == "C3D8" ? BrickType::plain : BrickType::incompatible_modes;
      std::array<int, 8> brick;
      std::copy(nodes.begin(), nodes.end(), brick.begin());
      mesh->elements.push_back(brick);
      mesh->element_ids.push_back(mesh->element_count() + 1);
      mesh->material = {block.material.young, block.material.poisson, block.material.density};
    }
  return mesh;
}

bool on_a_line(const ElasticPart& part, const std::vector<int>& ids) {
  const Vector3 first = part.place(ids.front()), along = part.place(ids.back()) - first;
  for (int id : ids)
    if (along.cross(part.place(id) - first).norm() > 1e-9 * along.squaredNorm()) return false;
  return true;
}

}  // namespace

SolidModel bar(const Vector3& size, const std::array<int, 3>& divisions, const Material& material) {
  const BrickMesh mesh = brick_block(size, divisions, {material.young, material.poisson, material.density});
  auto model = std::make_shared<FiniteElementModel>();
  model->name = "bar";
  model->node_ids = mesh.node_ids;
  model->nodes = mesh.nodes;
  model->node_sets = mesh.node_sets;
  ElementBlock block{.type = "C3D8I", .nodes = {}, .material = material};
  for (const auto& nodes : mesh.elements) block.nodes.emplace_back(nodes.begin(), nodes.end());
  model->elements.push_back(std::move(block));
  assemble_matrices(*model);
  return model;
}

std::vector<int> nodes_where(const FiniteElementModel& model, const std::function<bool(const Vector3&)>& chosen) {
  std::vector<int> ids;
  for (int i = 0; i < model.node_count(); ++i)
    if (chosen(model.nodes.col(i))) ids.push_back(model.node_ids[static_cast<size_t>(i)]);
  return ids;
}

int node_at(const FiniteElementModel& model, const Vector3& point) {
  Eigen::Index nearest = 0;
  (model.nodes.colwise() - point).colwise().squaredNorm().minCoeff(&nearest);
  return model.node_ids[static_cast<size_t>(nearest)];
}

Marker ElasticPart::average(const std::vector<int>& ids, const Matrix3& axes) {
  const Matrix3 in_mesh = parameters_.orientation.transpose() * axes;
  return modes_ ? modes_->average(ids, in_mesh) : bricks_->average(ids, in_mesh);
}

double ElasticPart::mass() const { return modes_ ? modes_->mass() : bricks_->mass(); }

Marker ElasticPart::node(int id) { return modes_ ? modes_->node(id) : bricks_->node(id); }

Vector3 ElasticPart::place(int id) const {
  return parameters_.position + parameters_.orientation * solid().nodes.col(solid().node_index(id));
}

Vector3 ElasticPart::middle(const std::vector<int>& ids) const {
  Vector3 sum = Vector3::Zero();
  for (int id : ids) sum += place(id);
  return sum / static_cast<double>(ids.size());
}

const ElasticParts::Bases& ElasticParts::reduced(const std::string& name, const ElasticPartParameters& p) {
  const auto [at, is_new] = bases_.try_emplace(name);
  if (is_new) {
    std::vector<WeightedNodes> loaded;
    for (const auto& ids : p.loaded) loaded.push_back({ids});
    at->second.quadratic =
        make_basis(*p.solid, p.frame, p.eigenmodes + more_eigenmodes, {.loaded = loaded, .deflection = p.finest});
    at->second.stiffened = at->second.linear = at->second.quadratic;
    if (p.finest == Deflection::linear) return at->second;
    auto copy = std::make_shared<ModalBasis>(*at->second.quadratic);
    auto without_quartic = std::make_shared<QuadraticDeflection>(*copy->deflection);
    without_quartic->quartic.resize(0, 0);
    copy->deflection = without_quartic;
    at->second.stiffened = copy;
    copy = std::make_shared<ModalBasis>(*copy);
    copy->deflection = nullptr;
    at->second.linear = copy;
  }
  return at->second;
}

ElasticPart ElasticParts::add(SystemGraph& graph, const std::string& name, ElasticPartParameters p) {
  if (kind_ == Kind::bricks) {
    auto& body = graph.add<InertialBody>(name, {.mesh = bricks_of(*p.solid),
                                                .stiffness_damping = p.stiffness_damping,
                                                .position = p.position,
                                                .orientation = p.orientation,
                                                .velocity = p.velocity,
                                                .angular_velocity = p.angular_velocity});
    return {nullptr, &body, std::move(p)};
  }
  const Bases& bases = reduced(name, p);
  const auto& basis = deflection == Deflection::linear      ? bases.linear
                      : deflection == Deflection::stiffened ? bases.stiffened
                                                            : bases.quadratic;
  auto& body = graph.add<FlexibleBody>(name, {.basis = basis,
                                              .mode_count = std::min(mode_count, basis->mode_count()),
                                              .damping = {.stiffness_proportional = p.stiffness_damping},
                                              .position = p.position,
                                              .orientation = p.orientation,
                                              .velocity = p.velocity,
                                              .angular_velocity = p.angular_velocity});
  return {&body, nullptr, std::move(p)};
}

SlenderBody& ElasticParts::add_beam(SystemGraph& graph, const std::string& name, SlenderBody::Parameters p) {
  auto& body = graph.add<SlenderBody>(name, std::move(p));
  if (kind_ == Kind::bricks || deflection == Deflection::exact) {
    body.set_fidelity({.deflection = Deflection::exact, .elements = elements});
    return body;
  }
  if (deflection == Deflection::quadratic && mode_count == FlexibleBody::kAll) return body;  // as drawn
  Fidelity fidelity{.deflection = std::min(deflection, body.finest_deflection())};
  const int candidates = static_cast<int>(body.candidate_stiffness().size());
  for (int k = 0; k < (mode_count == FlexibleBody::kAll ? candidates : std::min(mode_count, candidates)); ++k)
    fidelity.modes.push_back(k);
  if (fidelity.modes.empty()) fidelity.deflection = Deflection::linear;
  body.set_fidelity(fidelity);
  return body;
}

Places on(Ground& ground) {
  return [&ground](const Vector3& place, const Matrix3& axes) { return ground.marker(place, axes); };
}

Places on(RigidBody& body) {
  return [&body](const Vector3& place, const Matrix3& axes) {
    const auto& p = body.parameters();
    const Matrix3 to_body = p.orientation.transpose();
    return body.marker(to_body * (place - p.position), to_body * axes);
  };
}

Matrix3 axes_along(const Vector3& direction) {
  return Eigen::Quaterniond::FromTwoVectors(Vector3::UnitZ(), direction).toRotationMatrix();
}

void hold(SystemGraph& graph, const std::string& name, const Places& holder, ElasticPart& part,
          const std::vector<int>& ids) {
  if (part.is_bricks()) {
    for (int id : ids)
      graph.add<SphericalJoint>(name + "_" + std::to_string(id),
                                {holder(part.place(id), Matrix3::Identity()), part.node(id)});
  } else if (on_a_line(part, ids)) {
    const Matrix3 axes = axes_along(part.place(ids.back()) - part.place(ids.front()));
    graph.add<RevoluteJoint>(name, {holder(part.middle(ids), axes), part.average(ids, axes)});
  } else {
    graph.add<FixedJoint>(name, {holder(part.middle(ids), Matrix3::Identity()), part.average(ids)});
  }
}

}  // namespace lithe::certify
