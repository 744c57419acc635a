#include "tilth/derive/slope_pass.h"

#include "tilth/pool/gl_rect.h"

namespace tilth {
namespace {

enum Unit { kHigh, kLow };

}  // namespace

Result<SlopePass> SlopePass::create(gl::Device& device, gl::ShaderLibrary& shaders, HeightPrecision precision,
                                    SlopeFormat format, const SlopeSettings& settings) {
    gl::Features features;
    if (precision == HeightPrecision::bits16) features.emplace_back("BITS16", "1");
    if (format == SlopeFormat::rg16f) features.emplace_back("SLOPES_RG16F", "1");
    Result<gl::TexelPass> pass = gl::TexelPass::create(device, shaders, "slopes", "derive/slopes.frag", features);
    if (!pass) return pass.error();
    pass->program().sampler("u_high", kHigh);
    pass->program().sampler("u_low", kLow);
    return SlopePass(std::move(*pass), settings);
}

void SlopePass::run(std::span<const TexelRect> changed, const HeightPlanes& planes, SlopeMap& slopes,
                    gl::StageStats& derive, gl::StageStats& mips) {
    std::vector<TexelRect> stale;
    for (const TexelRect& rect : changed) stale.push_back(stale_slopes(rect, planes.rect(), settings_.stencil));
    stale = disjoint(stale);
    const gl::Texture2D* const target[] = {&slopes.texture()};
    for (std::int32_t level = 0; level < SlopeMap::kLevels; ++level) {
        std::vector<gl::PassRect> rects;
        for (const TexelRect& posts : stale) {
            const TexelRect texels = mip_texels(posts, level);
            if (!texels.empty()) rects.push_back({texels.min.x, texels.min.z, texels.max.x, texels.max.z, {}});
        }
        pass_.run(target, level, rects, level == 0 ? derive : mips, [&](gl::Program& program) {
            planes.high().bind(kHigh);
            planes.low().bind(kLow);
            program.set(program.uniform("u_last_post"), planes.rect().max.x - 1, planes.rect().max.z - 1);
            program.set(program.uniform("u_level"), level);
            program.set(program.uniform("u_per_m"), static_cast<float>(settings_.code_quantum_m / settings_.spacing_m));
            program.set(program.uniform("u_fourth"), settings_.stencil == SlopeStencil::Fourth ? 1 : 0);
        });
    }
}

}  // namespace tilth
