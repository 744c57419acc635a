#include "tilth/derive/relief_pass.h"

#include <utility>

#include "tilth/core/checks.h"
#include "tilth/world/texel_rects.h"

namespace tilth {
namespace {

enum Unit { kHigh, kLow, kSlopes };
constexpr int kRanges = 0;  // the unit of what the other two passes read

TexelRect moved(const TexelRect& rect, Texel by) {
    return {{rect.min.x + by.x, rect.min.z + by.z}, {rect.max.x + by.x, rect.max.z + by.z}};
}

/// What of `changed` lies in `square`, disjoint.
std::vector<TexelRect> changed_within(std::span<const TexelRect> changed, const TexelRect& square) {
    const Texel corner = square.min;
    std::vector<TexelRect> rects;
    for (const TexelRect& rect : changed)
        rects.push_back(moved(intersection(rect, square), {-corner.x, -corner.z}));  // none negative
    rects = disjoint(rects);
    for (TexelRect& rect : rects) rect = moved(rect, corner);
    return rects;
}

std::vector<gl::PassRect> pass_rects(std::span<const TexelRect> texels) {
    std::vector<gl::PassRect> rects;
    for (const TexelRect& rect : texels) rects.push_back({rect.min.x, rect.min.z, rect.max.x, rect.max.z, {}});
    return rects;
}

/// Where `texels` lie in a window of `size` texels; read from a texture whose texel (0, 0) is the map's `origin`.
std::vector<gl::PassRect> fill_rects(std::span<const TexelRect> texels, std::int32_t size, Texel origin, bool read) {
    std::vector<gl::PassRect> rects;
    for (const TexelRect& rect : texels)
        for (const auto& [map, at] : wrapped_parts(rect, size))
            rects.push_back({at.x,
                             at.z,
                             at.x + map.width(),
                             at.z + map.depth(),
                             {map.min.x - origin.x - at.x, map.min.z - origin.z - at.z, read ? 1 : 0, 0}});
    return rects;
}

[[maybe_unused]] bool holds(const TexelRect& outer, const TexelRect& inner) {
    return inner.empty() || intersection(outer, inner) == inner;
}

}  // namespace

ReliefPass::ReliefPass(gl::TexelPass fill, gl::TexelPass pyramid, gl::TexelPass range, double code_quantum_m)
    : fill_(std::move(fill)), pyramid_(std::move(pyramid)), range_(std::move(range)), code_quantum_m_(code_quantum_m) {}

Result<ReliefPass> ReliefPass::create(gl::Device& device, gl::ShaderLibrary& shaders, HeightPrecision precision,
                                      SlopeFormat format, double code_quantum_m) {
    gl::Features features;
    if (precision == HeightPrecision::bits16) features.emplace_back("BITS16", "1");
    if (format == SlopeFormat::rg16f) features.emplace_back("SLOPES_RG16F", "1");
    Result<gl::TexelPass> fill =
        gl::TexelPass::create(device, shaders, "relief fill", "derive/relief_fill.frag", features);
    if (!fill) return fill.error();
    Result<gl::TexelPass> pyramid =
        gl::TexelPass::create(device, shaders, "relief pyramid", "derive/relief_pyramid.frag");
    if (!pyramid) return pyramid.error();
    Result<gl::TexelPass> range = gl::TexelPass::create(device, shaders, "relief range", "derive/relief_range.frag");
    if (!range) return range.error();
    fill->program().sampler("u_high", kHigh);
    fill->program().sampler("u_low", kLow);
    fill->program().sampler("u_slopes", kSlopes);
    pyramid->program().sampler("u_finer", kRanges);
    range->program().sampler("u_pyramid", kRanges);
    return ReliefPass(*std::move(fill), *std::move(pyramid), *std::move(range), code_quantum_m);
}

Result<void> ReliefPass::reload(gl::ShaderLibrary& shaders) {
    for (gl::TexelPass* pass : {&fill_, &pyramid_, &range_})
        if (Result<void> reloaded = shaders.reload(pass->program()); !reloaded) return reloaded;
    return {};
}

void ReliefPass::run(std::span<const TexelRect> changed, const TexelRect& square, std::span<const ReliefSource> sources,
                     ReliefWindow& window, gl::StageStats& derive) {
    TILTH_EXPECTS(square.width() == window.size() && square.depth() == window.size(), "a square of another size");
    const std::vector<TexelRect> texels = changed_within(changed, square);
    if (texels.empty()) return;
    fill(texels, sources, window, derive);
    build_pyramid(texels, window, derive);
    build_range(texels, window, derive);
}

void ReliefPass::fill(std::span<const TexelRect> texels, std::span<const ReliefSource> sources, ReliefWindow& window,
                      gl::StageStats& derive) {
    const gl::Texture2D* const targets[] = {&window.heights(), &window.slopes()};
    gl::Program& program = fill_.program();
    fill_.begin(targets, 0, derive);
    program.set(program.uniform("u_code_quantum_m"), static_cast<float>(code_quantum_m_));
    std::vector<TexelRect> rest(texels.begin(), texels.end());
    for (const ReliefSource& source : sources) {
        TILTH_EXPECTS(holds(source.planes->rect(), source.interior) && holds(source.slopes->rect(), source.interior),
                      "a source without the texels of its interior");
        TILTH_EXPECTS(source.planes->origin() == source.slopes->origin() && source.slopes->format() == window.format(),
                      "slopes and codes of different texels, or slopes stored unlike the window's");
        const std::vector<TexelRect> of_source = taken(rest, source.interior);
        if (of_source.empty()) continue;
        source.planes->high().bind(kHigh);
        source.planes->low().bind(kLow);
        source.slopes->texture().bind(kSlopes);
        fill_.draw(fill_rects(of_source, window.size(), source.planes->origin(), true), derive);
    }
    if (rest.empty()) return;
    for (const int unit : {kHigh, kLow, kSlopes}) window.range().bind(unit);  // not read, but not a target either
    fill_.draw(fill_rects(rest, window.size(), {}, false), derive);
}

void ReliefPass::build_pyramid(std::span<const TexelRect> texels, ReliefWindow& window, gl::StageStats& derive) {
    gl::Texture2D& pyramid = window.pyramid();
    const gl::Texture2D* const targets[] = {&pyramid};
    // A level is drawn from the one before it: without mip filtering only the base level is sampled, so that there is
    // no feedback; the level drawn to stays within the range, without which the framebuffer would be incomplete.
    pyramid.set_filter(gl::Filter::Nearest);
    for (std::int32_t level = 0; level < ReliefWindow::kLevels; ++level) {
        std::vector<TexelRect> nodes;
        for (const TexelRect& rect : texels) nodes.push_back(stale_nodes(rect, level));
        nodes = wrapped_rects(nodes, pyramid.width(level));
        if (level > 0) pyramid.set_level_range(level - 1, level);
        pyramid_.run(targets, level, pass_rects(nodes), derive, [&](gl::Program& program) {
            (level == 0 ? window.heights() : pyramid).bind(kRanges);
            program.set(program.uniform("u_of_heights"), level == 0 ? 1 : 0);
            program.set(program.uniform("u_finer_mask"), 2 * pyramid.width(level) - 1);
        });
    }
    pyramid.set_level_range(0, ReliefWindow::kLevels - 1);
    pyramid.set_filter(gl::Filter::NearestMipNearest);
}

void ReliefPass::build_range(std::span<const TexelRect> texels, ReliefWindow& window, gl::StageStats& derive) {
    constexpr std::int32_t kTop = ReliefWindow::kLevels - 1;
    std::vector<TexelRect> nodes;
    for (const TexelRect& rect : texels) nodes.push_back(expanded(stale_nodes(rect, kTop), 1));
    nodes = wrapped_rects(nodes, window.range().width());
    const gl::Texture2D* const targets[] = {&window.range()};
    range_.run(targets, 0, pass_rects(nodes), derive, [&](gl::Program& program) {
        window.pyramid().bind(kRanges);
        program.set(program.uniform("u_level"), kTop);
        program.set(program.uniform("u_mask"), window.range().width() - 1);
    });
}

}  // namespace tilth
