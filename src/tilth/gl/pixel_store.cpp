#include "tilth/gl/pixel_store.h"

#include "tilth/gl/api.h"

namespace tilth::gl {

void set_unpack(const Api& gl, int row_texels) {
    gl.PixelStorei(GL_UNPACK_SWAP_BYTES, GL_FALSE);
    gl.PixelStorei(GL_UNPACK_LSB_FIRST, GL_FALSE);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl.PixelStorei(GL_UNPACK_ROW_LENGTH, row_texels);
    gl.PixelStorei(GL_UNPACK_SKIP_ROWS, 0);
    gl.PixelStorei(GL_UNPACK_SKIP_PIXELS, 0);
    gl.PixelStorei(GL_UNPACK_IMAGE_HEIGHT, 0);
    gl.PixelStorei(GL_UNPACK_SKIP_IMAGES, 0);
}

void set_pack(const Api& gl) {
    gl.PixelStorei(GL_PACK_SWAP_BYTES, GL_FALSE);
    gl.PixelStorei(GL_PACK_LSB_FIRST, GL_FALSE);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.PixelStorei(GL_PACK_ROW_LENGTH, 0);
    gl.PixelStorei(GL_PACK_SKIP_ROWS, 0);
    gl.PixelStorei(GL_PACK_SKIP_PIXELS, 0);
    gl.PixelStorei(GL_PACK_IMAGE_HEIGHT, 0);
    gl.PixelStorei(GL_PACK_SKIP_IMAGES, 0);
}

}  // namespace tilth::gl
