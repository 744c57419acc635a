#include "tilth/pool/height_planes.h"

#include <utility>
#include <vector>

#include "tilth/core/checks.h"
#include "tilth/pool/gl_rect.h"

namespace tilth {

HeightPlanes::HeightPlanes(std::vector<gl::Texture2D> planes, gl::Framebuffer reader, const PlanesSpec& spec)
    : planes_(std::move(planes)),
      reader_(std::move(reader)),
      origin_(spec.rect.min),
      map_(spec.map),
      precision_(spec.precision) {}

Result<HeightPlanes> HeightPlanes::create(gl::Device& device, const PlanesSpec& spec) {
    std::vector<gl::Texture2D> planes;
    const auto add = [&](const char* name) -> Result<void> {
        Result<gl::Texture2D> plane =
            gl::Texture2D::create(device, text(spec.label, ", ", name, " plane"),
                                  {.format = gl::Format::R16, .width = spec.rect.width(), .height = spec.rect.depth()});
        if (!plane) return plane.error();
        planes.push_back(std::move(*plane));
        return {};
    };
    if (const Result<void> high = add("high"); !high) return high.error();
    if (spec.precision == HeightPrecision::bits32)
        if (const Result<void> low = add("low"); !low) return low.error();
    Result<gl::Framebuffer> reader = gl::Framebuffer::create(device, text("read back of ", spec.label));
    if (!reader) return reader.error();
    HeightPlanes made(std::move(planes), std::move(*reader), spec);
    made.reader_.attach(made.targets());
    if (const Result<void> complete = made.reader_.check(); !complete) return complete.error();
    return made;
}

std::vector<const gl::Texture2D*> HeightPlanes::targets() const {
    std::vector<const gl::Texture2D*> all;
    for (const gl::Texture2D& texture : planes_) all.push_back(&texture);
    return all;
}

void HeightPlanes::clear(TextureFill& fill) {
    for (std::size_t p = 0; p < planes_.size(); ++p) {
        const std::uint32_t bits = p == 0 ? kMidCode >> 16 : kMidCode & 0xffffu;
        fill.run(planes_[p], 0, {.red = (static_cast<float>(bits) + 0.25f) / 65535.0f, .texel = bits});
    }
}

void HeightPlanes::upload(const CodeView& codes, const TexelRect& rect, gl::TransferStats& stats) {
    TILTH_EXPECTS(intersection(rect, this->rect()) == rect, "an upload outside the planes");
    TILTH_EXPECTS(intersection(rect, codes.rect) == rect, "an upload of texels that the view does not cover");
    if (rect.empty()) return;
    std::vector<std::uint16_t> bits(static_cast<std::size_t>(rect.count()));
    for (std::size_t p = 0; p < planes_.size(); ++p) {
        const std::uint32_t shift = p == 0 ? 16 : 0;
        std::uint16_t* out = bits.data();
        for (std::int32_t z = rect.min.z; z < rect.max.z; ++z) {
            const std::uint32_t* row = codes.at({rect.min.x, z});
            for (std::int32_t x = 0; x < rect.width(); ++x) *out++ = static_cast<std::uint16_t>(row[x] >> shift);
        }
        planes_[p].upload(0, gl_rect(rect, origin_), bits.data());
        stats.bytes_up += bits.size() * sizeof(std::uint16_t);
    }
}

void HeightPlanes::read_back(const TexelRect& rect, std::uint32_t* out, std::size_t stride,
                             gl::TransferStats& stats) const {
    TILTH_EXPECTS(intersection(rect, this->rect()) == rect, "a read-back outside the planes");
    if (rect.empty()) return;
    std::vector<std::uint16_t> high(static_cast<std::size_t>(rect.count())), low(high.size(), 0);
    reader_.bind();  // for drawing too: drivers complain of an incomplete one that was left there
    reader_.read(gl_rect(rect, origin_), gl::Format::R16, high.data(), 0);
    if (planes_.size() == 2) reader_.read(gl_rect(rect, origin_), gl::Format::R16, low.data(), 1);
    stats.bytes_down += high.size() * sizeof(std::uint16_t) * planes_.size();
    std::size_t i = 0;
    for (std::int32_t z = 0; z < rect.depth(); ++z, out += stride)
        for (std::int32_t x = 0; x < rect.width(); ++x, ++i) out[x] = std::uint32_t{high[i]} << 16 | low[i];
}

void HeightPlanes::read_back(const TexelRect& rect, HeightField& field, gl::TransferStats& stats) const {
    if (rect.empty()) return;
    TILTH_EXPECTS(intersection(rect, field.rect()) == rect, "a read-back outside the map");
    read_back(rect, field.row(rect.min.z) + rect.min.x, static_cast<std::size_t>(field.width()), stats);
}

std::uint64_t HeightPlanes::bytes() const {
    std::uint64_t sum = 0;
    for (const gl::Texture2D& texture : planes_) sum += texture.bytes();
    return sum;
}

}  // namespace tilth
