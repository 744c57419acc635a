// PRIVATE: the GL function table and constants. Included by .cpp files only, never by a public header.
//
// The table is glad2's "mx" struct: `api.BindTexture(GL_TEXTURE_2D, id)`. It is a member of `Device`, so two contexts
// with different drivers work in one process and no global GL symbol exists.
#pragma once

#include <glad/gl.h>

#include "tilth/gl/api_fwd.h"
