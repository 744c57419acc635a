// The name of the GL function table without a GL header, for headers that only pass it on.
#pragma once

struct GladGLContext;

namespace tilth::gl {
using Api = ::GladGLContext;
}
