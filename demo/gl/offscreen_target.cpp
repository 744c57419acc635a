#include "demo/gl/offscreen_target.h"

#include <algorithm>

#include "tilth/gl/api.h"

namespace tilth::demo {

namespace {

/// GL's first row is the bottom one; pictures start at the top.
template <class T>
void flip_rows(std::vector<T>& texels, std::size_t row) {
    const std::size_t rows = texels.size() / row;
    for (std::size_t y = 0; y < rows / 2; ++y)
        std::swap_ranges(texels.begin() + std::ptrdiff_t(y * row), texels.begin() + std::ptrdiff_t((y + 1) * row),
                         texels.begin() + std::ptrdiff_t((rows - 1 - y) * row));
}

}  // namespace

OffscreenTarget::OffscreenTarget(gl::Device& device, gl::Texture2D colour, gl::Texture2D depth,
                                 gl::Framebuffer framebuffer)
    : device_(&device),
      width_(colour.width()),
      height_(colour.height()),
      colour_(std::move(colour)),
      depth_(std::move(depth)),
      framebuffer_(std::move(framebuffer)) {}

Result<OffscreenTarget> OffscreenTarget::create(gl::Device& device, int width, int height) {
    auto colour =
        gl::Texture2D::create(device, "demo.colour", {.format = gl::Format::Rgba8, .width = width, .height = height});
    if (!colour) return colour.error();
    auto depth =
        gl::Texture2D::create(device, "demo.depth", {.format = gl::Format::Depth32F, .width = width, .height = height});
    if (!depth) return depth.error();
    auto framebuffer = gl::Framebuffer::create(device, "demo.target");
    if (!framebuffer) return framebuffer.error();
    const gl::Texture2D* const colours[] = {&*colour};
    framebuffer->attach(colours, 0, &*depth);
    if (const auto complete = framebuffer->check(); !complete) return complete.error();
    return OffscreenTarget(device, std::move(*colour), std::move(*depth), std::move(*framebuffer));
}

void OffscreenTarget::begin(const Vec3f& clear) {
    const gl::Api& api = device_->gl();
    framebuffer_.bind();
    api.Viewport(0, 0, width_, height_);
    api.Disable(GL_SCISSOR_TEST);
    api.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    api.DepthMask(GL_TRUE);
    api.ClearColor(clear.x, clear.y, clear.z, 1.0f);
    api.ClearDepth(1.0);
    api.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void OffscreenTarget::finish() { device_->gl().Finish(); }

std::vector<std::uint8_t> OffscreenTarget::read_rgb8() const {
    const std::size_t pixels = std::size_t(width_) * std::size_t(height_);
    std::vector<std::uint8_t> rgba(pixels * 4), rgb(pixels * 3);
    framebuffer_.read(colour_.bounds(), colour_.format(), rgba.data());
    for (std::size_t i = 0; i < pixels; ++i) std::copy_n(&rgba[i * 4], 3, &rgb[i * 3]);
    flip_rows(rgb, std::size_t(width_) * 3);
    return rgb;
}

std::vector<float> OffscreenTarget::read_depth() const {
    std::vector<float> depth(std::size_t(width_) * std::size_t(height_));
    depth_.read(0, depth.data());
    flip_rows(depth, std::size_t(width_));
    return depth;
}

}  // namespace tilth::demo
