#include "engine/model/rigid_frame_body.h"

namespace lithe {

RigidFrameBody::~RigidFrameBody() = default;

}  // namespace lithe
