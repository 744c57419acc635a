#include "tilth/gl/debug_group.h"

#include "tilth/gl/api.h"

namespace tilth::gl {

DebugGroup::DebugGroup(const Device& device, const char* name) : device_(device) {
    if (device_.capabilities().debug) device_.gl().PushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, -1, name);
}

DebugGroup::~DebugGroup() {
    if (device_.capabilities().debug) device_.gl().PopDebugGroup();
}

}  // namespace tilth::gl
