// What the tests of both rings share: textures of random bits, and reading them by another way than the rings.
#pragma once

#include <chrono>
#include <cstring>
#include <random>
#include <thread>

#include "recording_gl.h"
#include "tilth/transfer/read_back_ring.h"
#include "tilth/transfer/upload_ring.h"

namespace tilth::test {

/// `count` bytes that no transfer may change. Of half floats, NaNs are left out: GL may turn one into another.
inline std::vector<std::byte> random_texels(gl::Format format, std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::byte> bytes(count);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() & 0xff);
    const gl::FormatInfo& info = gl::info_of(format);
    if (info.type != GL_HALF_FLOAT) return bytes;
    for (std::size_t i = 1; i < count; i += 2)  // the high byte: sign, five bits of exponent
        if ((bytes[i] & std::byte{0x7c}) == std::byte{0x7c}) bytes[i] &= std::byte{0xfb};
    return bytes;
}

inline std::size_t texel_bytes(gl::Format format) {
    return static_cast<std::size_t>(gl::info_of(format).transfer_bytes);
}
inline std::size_t bytes_in(const gl::Rect& rect, gl::Format format) {
    return static_cast<std::size_t>(rect.count()) * texel_bytes(format);
}

/// A texture that holds `texels`, written from client memory.
inline gl::Texture2D texture_of(gl::Device& device, gl::Format format, int width, int height,
                                const std::vector<std::byte>& texels) {
    gl::Texture2D texture = value(gl::Texture2D::create(device, "test", {format, width, height}));
    texture.upload(0, texture.bounds(), texels.data());
    return texture;
}

/// Level 0, read through the test's own device: the recording one calls it a violation.
inline std::vector<std::byte> texels_of(const gl::Texture2D& texture) {
    const gl::Api& gl = test::device().gl();
    const gl::FormatInfo& format = gl::info_of(texture.format());
    std::vector<std::byte> texels(bytes_in(texture.bounds(), texture.format()));
    gl.BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    for (GLenum what : {GL_PACK_ROW_LENGTH, GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS, GL_PACK_SWAP_BYTES})
        gl.PixelStorei(what, 0);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, texture.id());
    gl.GetTexImage(GL_TEXTURE_2D, 0, format.layout, format.type, texels.data());
    return texels;
}

/// `rect` of an image of `width` texels a row, rows one behind the other.
inline std::vector<std::byte> cut(const std::vector<std::byte>& image, int width, const gl::Rect& rect,
                                  gl::Format format) {
    std::vector<std::byte> part;
    for (int y = rect.min_y; y < rect.max_y; ++y) {
        const auto at =
            static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y * width + rect.min_x) * texel_bytes(format));
        const auto row = static_cast<std::ptrdiff_t>(static_cast<std::size_t>(rect.width()) * texel_bytes(format));
        part.insert(part.end(), image.begin() + at, image.begin() + at + row);
    }
    return part;
}
inline void paste(std::vector<std::byte>& image, int width, const gl::Rect& rect, gl::Format format,
                  const std::vector<std::byte>& part) {
    const std::size_t row = static_cast<std::size_t>(rect.width()) * texel_bytes(format);
    for (int y = 0; y < rect.height(); ++y)
        std::memcpy(
            image.data() + static_cast<std::size_t>((rect.min_y + y) * width + rect.min_x) * texel_bytes(format),
            part.data() + static_cast<std::size_t>(y) * row, row);
}

/// Tries until it goes well, a few seconds at most: what the frames of a program would do. The last answer.
template <class Try>
auto until(Try attempt) {
    auto answer = attempt();
    for (int i = 0; i < 5000 && !answer; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        answer = attempt();
    }
    return answer;
}

/// Each test ends without a violation of the order of calls.
class TransferTest : public GlTest {
protected:
    /// A new device; everything made from the last one must be gone.
    void make(RecordingGl::Settings settings) {
        finish();
        gl_ = std::make_unique<RecordingGl>(settings);
    }
    void TearDown() override {
        finish();
        GlTest::TearDown();
    }
    [[nodiscard]] RecordingGl& recorder() { return *gl_; }
    [[nodiscard]] gl::Device& device() { return gl_->device(); }

private:
    void finish() {
        if (gl_)
            for (const std::string& violation : gl_->violations) ADD_FAILURE() << violation;
        gl_.reset();
    }
    std::unique_ptr<RecordingGl> gl_;
};

}  // namespace tilth::test
