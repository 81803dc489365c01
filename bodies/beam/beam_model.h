#pragma once

#include <memory>

#include "bodies/beam/beam.h"
#include "bodies/flexible/drawn_skin.h"
#include "bodies/flexible/reduction.h"

namespace lithe {

/// How a beam of modes is drawn: the surface of its sections, of which each point moves with the nodes beside it.
DrawnSkin drawn_skin(const Beam& beam);

/// A beam about its drawing as a finite-element model: node i of the beam is node i + 1 of the model, with three
/// displacements and three rotations in world axes; K, M (lumped or consistent), Kelvin-Voigt damping and the forces of
/// second order are those of its elements. The graph's gravity and the beam's velocities are not in it.
FiniteElementModel finite_element_model(const Beam& beam);

/// The beam reduced to modes, for FlexibleBody: where it deflects little, in the same place and axes as drawn.
///   SystemGraph drawing;
///   const Beam& blade = drawing.add<Beam>("blade", {...});
///   auto& modal = graph.add<FlexibleBody>("blade", {.basis = make_basis(blade, TangentFrame{{1}}, 6)});
///   modal.node(blade.node_count());  // a marker at its tip, with the node's rotation
/// With Deflection::stiffened the deflections of second order are with it: a bent beam gets shorter, so that tension
/// and spin stiffen it. Throws as make_basis() of a model does; SceneError for Deflection::quadratic, whose energy of
/// fourth order takes solid elements: a beam of such deflections is better left as it is.
std::shared_ptr<const ModalBasis> make_basis(const Beam& beam, const BodyFrame& frame, int mode_count,
                                             const Reduction& reduction = {});

}  // namespace lithe
