#pragma once

#include <memory>

namespace lithe {

class BodyBatch;
class ConstraintBatch;
class ForceBatch;

/// All elements of one type (engine/assembly/batch.h), made for a type where it is added to a graph
/// (engine/assembly/batch_of.h); built-in types are instantiated in their own file.
template <class T>
std::unique_ptr<BodyBatch> make_body_batch();
template <class T>
std::unique_ptr<ConstraintBatch> make_constraint_batch();
template <class T>
std::unique_ptr<ForceBatch> make_force_batch();

}  // namespace lithe
