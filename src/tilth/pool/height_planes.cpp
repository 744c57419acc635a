#include "tilth/pool/height_planes.h"

#include <utility>
#include <vector>

#include "tilth/core/checks.h"
#include "tilth/pool/gl_rect.h"

namespace tilth {
namespace {

Result<gl::Texture2D> plane(gl::Device& device, std::string_view label, std::int32_t width, std::int32_t depth) {
    return gl::Texture2D::create(device, label, {.format = gl::Format::R16, .width = width, .height = depth});
}

}  // namespace

HeightPlanes::HeightPlanes(std::vector<gl::Texture2D> planes, gl::Framebuffer reader, HeightPrecision precision)
    : planes_(std::move(planes)), reader_(std::move(reader)), precision_(precision) {}

Result<HeightPlanes> HeightPlanes::create(gl::Device& device, std::int32_t width, std::int32_t depth,
                                          HeightPrecision precision) {
    std::vector<gl::Texture2D> planes;
    Result<gl::Texture2D> high = plane(device, "coarse heights, high plane", width, depth);
    if (!high) return high.error();
    planes.push_back(std::move(*high));
    if (precision == HeightPrecision::bits32) {
        Result<gl::Texture2D> low = plane(device, "coarse heights, low plane", width, depth);
        if (!low) return low.error();
        planes.push_back(std::move(*low));
    }
    Result<gl::Framebuffer> reader = gl::Framebuffer::create(device, "read back of coarse heights");
    if (!reader) return reader.error();
    HeightPlanes made(std::move(planes), std::move(*reader), precision);
    made.reader_.attach(made.targets());
    if (const Result<void> complete = made.reader_.check(); !complete) return complete.error();
    return made;
}

std::vector<const gl::Texture2D*> HeightPlanes::targets() const {
    std::vector<const gl::Texture2D*> all;
    for (const gl::Texture2D& texture : planes_) all.push_back(&texture);
    return all;
}

void HeightPlanes::upload(const HeightField& field, const TexelRect& rect, gl::TransferStats& stats) {
    TILTH_EXPECTS(intersection(rect, this->rect()) == rect, "an upload outside the map");
    if (rect.empty()) return;
    std::vector<std::uint16_t> bits(static_cast<std::size_t>(rect.count()));
    for (std::size_t p = 0; p < planes_.size(); ++p) {
        const std::uint32_t shift = p == 0 ? 16 : 0;
        std::uint16_t* out = bits.data();
        for (std::int32_t z = rect.min.z; z < rect.max.z; ++z) {
            const std::uint32_t* codes = field.row(z) + rect.min.x;
            for (std::int32_t x = 0; x < rect.width(); ++x) *out++ = static_cast<std::uint16_t>(codes[x] >> shift);
        }
        planes_[p].upload(0, gl_rect(rect), bits.data());
        stats.bytes_up += bits.size() * sizeof(std::uint16_t);
    }
}

void HeightPlanes::read_back(const TexelRect& rect, HeightField& field, gl::TransferStats& stats) const {
    TILTH_EXPECTS(intersection(rect, this->rect()) == rect, "a read-back outside the map");
    if (rect.empty()) return;
    std::vector<std::uint16_t> high(static_cast<std::size_t>(rect.count())), low(high.size(), 0);
    reader_.read(gl_rect(rect), gl::Format::R16, high.data(), 0);
    if (planes_.size() == 2) reader_.read(gl_rect(rect), gl::Format::R16, low.data(), 1);
    stats.bytes_down += high.size() * sizeof(std::uint16_t) * planes_.size();
    std::size_t i = 0;
    for (std::int32_t z = rect.min.z; z < rect.max.z; ++z) {
        std::uint32_t* codes = field.row(z) + rect.min.x;
        for (std::int32_t x = 0; x < rect.width(); ++x, ++i) codes[x] = std::uint32_t{high[i]} << 16 | low[i];
    }
}

std::uint64_t HeightPlanes::bytes() const {
    std::uint64_t sum = 0;
    for (const gl::Texture2D& texture : planes_) sum += texture.bytes();
    return sum;
}

}  // namespace tilth
