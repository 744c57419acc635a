#include "tilth/pool/relief_window.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace tilth {
namespace {

/// Every byte of every level becomes `byte`.
void fill(gl::Texture2D& texture, std::byte byte) {
    constexpr int kRows = 16;
    const int bytes = gl::info_of(texture.format()).transfer_bytes;
    const std::vector<std::byte> strip(static_cast<std::size_t>(texture.width() * kRows * bytes), byte);
    for (int level = 0; level < texture.levels(); ++level) {
        const gl::Rect whole = texture.bounds(level);
        for (int row = 0; row < whole.max_y; row += kRows)
            texture.upload(level, {0, row, whole.max_x, std::min(row + kRows, whole.max_y)}, strip.data());
    }
}

Result<void> check_drawable(gl::Device& device, std::span<const gl::Texture2D* const> targets) {
    Result<gl::Framebuffer> framebuffer = gl::Framebuffer::create(device, "relief window");
    if (!framebuffer) return framebuffer.error();
    framebuffer->attach(targets);
    return framebuffer->check();
}

}  // namespace

ReliefWindow::ReliefWindow(gl::Texture2D heights, gl::Texture2D slopes, gl::Texture2D pyramid, gl::Texture2D range,
                           SlopeFormat format)
    : heights_(std::move(heights)),
      slopes_(std::move(slopes)),
      pyramid_(std::move(pyramid)),
      range_(std::move(range)),
      format_(format) {}

Result<ReliefWindow> ReliefWindow::create(gl::Device& device, std::int32_t size, SlopeFormat format) {
    if (size < kLeastSize || size > kMostSize || !std::has_single_bit(static_cast<std::uint32_t>(size)))
        return Error{ErrorCode::InvalidArgument,
                     text("relief window: size is ", size, ", allowed are powers of two of ", kLeastSize, " to ",
                          kMostSize, " texels")};
    const auto square = [&](std::string_view label, gl::Format stored, std::int32_t side, std::int32_t levels,
                            gl::Filter filter) {
        return gl::Texture2D::create(device, label,
                                     {.format = stored,
                                      .width = side,
                                      .height = side,
                                      .levels = levels,
                                      .filter = filter,
                                      .wrap = gl::Wrap::Repeat});
    };
    Result<gl::Texture2D> heights = square("relief heights", gl::Format::R32F, size, 1, gl::Filter::Linear);
    if (!heights) return heights.error();
    const bool bytes = format == SlopeFormat::rg8;
    Result<gl::Texture2D> slopes =
        square("relief slopes", bytes ? gl::Format::Rg8 : gl::Format::Rg16F, size, 1, gl::Filter::Linear);
    if (!slopes) return slopes.error();
    Result<gl::Texture2D> pyramid =
        square("relief pyramid", gl::Format::Rg32F, size / 2, kLevels, gl::Filter::NearestMipNearest);
    if (!pyramid) return pyramid.error();
    Result<gl::Texture2D> range = square("relief range", gl::Format::Rg32F, size / kTopCells, 1, gl::Filter::Linear);
    if (!range) return range.error();

    const gl::Texture2D* const filled[] = {&*heights, &*slopes};
    if (const Result<void> drawable = check_drawable(device, filled); !drawable) return drawable.error();
    const gl::Texture2D* const ranges[] = {&*pyramid};
    if (const Result<void> drawable = check_drawable(device, ranges); !drawable) return drawable.error();

    fill(*heights, std::byte{0});
    fill(*slopes, bytes ? std::byte{128} : std::byte{0});  // flat
    fill(*pyramid, std::byte{0});
    fill(*range, std::byte{0});
    return ReliefWindow(*std::move(heights), *std::move(slopes), *std::move(pyramid), *std::move(range), format);
}

}  // namespace tilth
