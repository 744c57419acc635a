// A transfer's whole pixel-store state: nothing of it may be left to what the host did before.
#pragma once

#include "tilth/gl/api_fwd.h"

namespace tilth::gl {

/// Rows of `row_texels` in client memory (0: as wide as the rectangle), no padding, no skipping. Sets every unpack
/// value.
void set_unpack(const Api& gl, int row_texels);

/// Rows one behind the other in client memory. Sets every pack value.
void set_pack(const Api& gl);

}  // namespace tilth::gl
