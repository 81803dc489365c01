#pragma once

#include <memory>

#include "bodies/flexible/modal_basis.h"
#include "engine/model/deformable_body.h"

namespace lithe {

/// Part of an eigenmode basis, the modes that a fidelity names. A mode that is left out moves no more by itself; with a
/// deflection of second order it still follows the square of those that stay, as a field.
struct SelectedBasis {
  std::shared_ptr<const ModalBasis> basis;
  MatrixX fields;  // of the selected basis, by those of the whole: columns of [B, Ψ] = those of the whole times this
};
/// Throws SceneError for a basis that is not of eigenmodes, a mode or a deflection that it does not have.
SelectedBasis selected(const ModalBasis& whole, const Fidelity& fidelity);

/// Integrals of the displacement fields that are the columns of the old ones times T.
InertiaIntegrals transformed(const InertiaIntegrals& all, const MatrixX& T);

}  // namespace lithe
