// Names a stretch of GL commands in captures and GPU timelines.
#pragma once

#include "tilth/gl/device.h"

namespace tilth::gl {

/// Pushes a debug group and pops it on scope exit. Free without GL_KHR_debug.
class DebugGroup {
public:
    DebugGroup(const Device& device, const char* name);
    ~DebugGroup();
    DebugGroup(const DebugGroup&) = delete;
    DebugGroup& operator=(const DebugGroup&) = delete;

private:
    const Device& device_;
};

}  // namespace tilth::gl
