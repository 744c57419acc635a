#include "tilth/derive/slope_pass.h"

#include <algorithm>
#include <utility>

#include "tilth/core/checks.h"
#include "tilth/pool/gl_rect.h"
#include "tilth/pool/shelves.h"

namespace tilth {
namespace {

enum Unit { kHigh, kLow };

constexpr std::int32_t kLeastScratch = 256;  // texels a side, so that small stamps do not grow it step by step
constexpr std::int32_t kScratchAlign = 4;    // software GL shades blocks of 4 x 4 texels

TexelRect moved(const TexelRect& rect, Texel origin) {
    return {{rect.min.x - origin.x, rect.min.z - origin.z}, {rect.max.x - origin.x, rect.max.z - origin.z}};
}

}  // namespace

SlopePass::SlopePass(gl::Device& device, gl::TexelPass pass, gl::TextureCopy copy, SlopeFormat format,
                     const SlopeSettings& settings)
    : device_(&device), pass_(std::move(pass)), copy_(std::move(copy)), format_(format), settings_(settings) {}

Result<SlopePass> SlopePass::create(gl::Device& device, gl::ShaderLibrary& shaders, HeightPrecision precision,
                                    SlopeFormat format, const SlopeSettings& settings) {
    gl::Features features;
    if (precision == HeightPrecision::bits16) features.emplace_back("BITS16", "1");
    if (format == SlopeFormat::rg16f) features.emplace_back("SLOPES_RG16F", "1");
    Result<gl::TexelPass> pass = gl::TexelPass::create(device, shaders, "slopes", "derive/slopes.frag", features);
    if (!pass) return pass.error();
    pass->program().sampler("u_high", kHigh);
    pass->program().sampler("u_low", kLow);
    Result<gl::TextureCopy> copy = gl::TextureCopy::create(device);
    if (!copy) return copy.error();
    return SlopePass(device, std::move(*pass), std::move(*copy), format, settings);
}

void SlopePass::set_up(const TexelRect& map, std::int32_t level) {
    gl::Program& program = pass_.program();
    program.set(program.uniform("u_first_texel"), map.min.x, map.min.z);
    program.set(program.uniform("u_last_texel"), map.max.x - 1, map.max.z - 1);
    program.set(program.uniform("u_level"), level);
    program.set(program.uniform("u_per_m"), static_cast<float>(settings_.code_quantum_m / settings_.spacing_m));
    program.set(program.uniform("u_fourth"), settings_.stencil == SlopeStencil::Fourth ? 1 : 0);
}

void SlopePass::read_from(const HeightPlanes& planes) {
    gl::Program& program = pass_.program();
    planes.high().bind(kHigh);
    planes.low().bind(kLow);
    const TexelRect held = planes.held();
    program.set(program.uniform("u_origin"), planes.origin().x, planes.origin().z);
    program.set(program.uniform("u_first_held"), held.min.x, held.min.z);
    program.set(program.uniform("u_last_held"), held.max.x - 1, held.max.z - 1);
}

std::vector<TexelRect> SlopePass::stale(const SlopeTarget& target) const {
    TILTH_EXPECTS(target.planes->rect() == target.slopes->rect(), "slopes and codes of different texels");
    std::vector<TexelRect> rects;
    for (const TexelRect& rect : target.changed)
        rects.push_back(stale_slopes(rect, target.planes->held(), target.planes->map(), settings_.stencil));
    return disjoint(rects);
}

void SlopePass::run(std::span<const TexelRect> changed, const HeightPlanes& planes, SlopeMap& slopes,
                    gl::StageStats& derive, gl::StageStats& mips) {
    const std::vector<TexelRect> texels_of_map = stale({&planes, &slopes, changed});
    const gl::Texture2D* const target[] = {&slopes.texture()};
    for (std::int32_t level = 0; level < slopes.levels(); ++level) {
        std::vector<gl::PassRect> rects;
        for (const TexelRect& rect : texels_of_map) {
            const TexelRect texels = mip_texels(moved(rect, slopes.origin()), level);
            if (!texels.empty()) rects.push_back({texels.min.x, texels.min.z, texels.max.x, texels.max.z, {}});
        }
        pass_.run(target, level, rects, level == 0 ? derive : mips, [&](gl::Program&) {
            set_up(planes.map(), level);
            read_from(planes);
        });
    }
}

bool SlopePass::reserve_scratch(std::int32_t width, std::int32_t depth) {
    if (scratch_ && scratch_->width() >= width && scratch_->height() >= depth) return true;
    width = std::max({width, kLeastScratch, scratch_ ? scratch_->width() : 0});
    depth = std::max({depth, kLeastScratch, scratch_ ? scratch_->height() : 0});
    scratch_.reset();
    Result<gl::Texture2D> made = gl::Texture2D::create(
        *device_, "slope scratch",
        {.format = format_ == SlopeFormat::rg8 ? gl::Format::Rg8 : gl::Format::Rg16F, .width = width, .height = depth});
    if (!made) return false;
    scratch_ = std::move(*made);
    return true;
}

void SlopePass::run(std::span<const SlopeTarget> tiles, gl::StageStats& derive) {
    struct Part {
        std::size_t tile = 0;
        TexelRect texels;  // of the tile's texture
        Shelves::Spot spot;
    };
    std::vector<Part> parts;
    std::size_t touched = 0;
    std::int32_t side = kLeastScratch;
    for (const SlopeTarget& tile : tiles)
        side = std::max({side, tile.slopes->rect().width(), tile.slopes->rect().depth()});
    Shelves shelves(side, side, kScratchAlign);
    for (std::size_t t = 0; t < tiles.size(); ++t) {
        TILTH_EXPECTS(tiles[t].slopes->levels() == 1, "tiles have one level of slopes");
        const std::size_t before = parts.size();
        for (const TexelRect& rect : stale(tiles[t]))
            parts.push_back({t, moved(rect, tiles[t].slopes->origin()), shelves.add(rect.width(), rect.depth())});
        touched += parts.size() > before;
    }
    if (parts.empty()) return;
    const bool alone = touched == 1;
    if (alone || !reserve_scratch(shelves.width(), shelves.depth())) {
        if (!alone) ++derive.fallbacks;
        for (const SlopeTarget& tile : tiles) run(tile.changed, *tile.planes, *tile.slopes, derive, derive);
        return;
    }
    const gl::Texture2D* const target[] = {&*scratch_};
    std::vector<gl::PassRect> rects;
    std::vector<gl::CopyRect> copies;
    for (std::size_t first = 0; first < parts.size();) {
        std::size_t end = first;
        while (end < parts.size() && parts[end].spot.pass == parts[first].spot.pass) ++end;
        // Calls `done` with the rectangles of each tile that has parts in this pass.
        const auto each_tile = [&](const auto& done) {
            for (std::size_t i = first; i < end;) {
                const std::size_t tile = parts[i].tile;
                rects.clear();
                copies.clear();
                for (; i < end && parts[i].tile == tile; ++i) {
                    const auto& [t, to, spot] = parts[i];
                    const std::int32_t max_x = spot.x + to.width(), max_z = spot.z + to.depth();
                    rects.push_back({spot.x, spot.z, max_x, max_z, {to.min.x - spot.x, to.min.z - spot.z, 0, 0}});
                    copies.push_back({{spot.x, spot.z, max_x, max_z}, to.min.x, to.min.z});
                }
                done(tiles[tile]);
            }
        };
        pass_.begin(target, 0, derive);
        set_up(tiles.front().planes->map(), 0);
        each_tile([&](const SlopeTarget& tile) {
            read_from(*tile.planes);
            pass_.draw(rects, derive);
        });
        each_tile([&](const SlopeTarget& tile) { copy_.run(*scratch_, tile.slopes->texture(), copies); });
        first = end;
    }
}

}  // namespace tilth
