#pragma once

#include "engine/base/math.h"
#include "engine/model/contact_memory.h"

namespace lithe {

using ContactKey = decltype(contact_key(0, ContactPoint()));

/// What contacts remember from step to step, as numbers that steps depend on: of compliant points the places in touch,
/// the bristles and the speed of the impact, of rigid ones the velocity that the last step left and how they slid.
/// Slips that are not known are left out.
VectorX contact_numbers(const ContactMemory& memory);
/// The same points with other numbers.
void set_contact_numbers(ConstVectorRef numbers, ContactMemory& memory);
/// The first of the three numbers of a rigid point's velocity; -1: it does not act.
Eigen::Index velocity_number(const ContactMemory& memory, const ContactKey& key);
/// Whether the same points act; of rigid ones, whether the same stick and slide.
bool same_contact_set(const ContactMemory& a, const ContactMemory& b);

}  // namespace lithe
