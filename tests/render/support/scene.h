// A map on the GPU with everything that the renderer asks for, made without the stages before it.
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "support/gl_context.h"
#include "tilth/core/shared_glsl.h"
#include "tilth/gl/state_guard.h"
#include "tilth/ground/height_field.h"
#include "tilth/render/terrain_renderer.h"
#include "tilth/source/ridged_source.h"

namespace tilth::shared {
#include "shared/slope_math.glsl"
}

namespace tilth::test {

/// Heights of a source as codes.
inline HeightField field_of(const HeightSource& source, const HeightCodec& codec,
                            HeightPrecision precision = HeightPrecision::bits32) {
    HeightField field(source.width(), source.depth());
    for (std::int32_t z = 0; z < field.depth(); ++z)
        for (std::int32_t x = 0; x < field.width(); ++x)
            field.set_code({x, z}, codec.code(source.height_m({x, z}), precision));
    return field;
}

/// Mountains of the given size; the lowest post is at 0 m.
struct Mountains {
    HeightCodec codec;
    HeightField field;
};
inline Mountains mountains(std::int32_t size, double relief_m, std::uint64_t seed = 7,
                           HeightPrecision precision = HeightPrecision::bits32) {
    const auto source = make_ridged_source({.seed = seed, .size = size, .relief_m = relief_m});
    const HeightCodec codec = HeightCodec::for_range(source->min_m(), source->max_m());
    return {codec, field_of(*source, codec, precision)};
}

/// Slopes as a texture holds them.
class SlopeTexels {
public:
    explicit SlopeTexels(SlopeFormat format) : format_(format) {}
    void add(float sx, float sz) {
        const float length = std::sqrt(sx * sx + sz * sz);
        for (const float s : {sx, sz}) {
            if (format_ == SlopeFormat::rg8) {
                bytes_.push_back(static_cast<std::uint8_t>(shared::slope_byte(s, length)));
            } else {  // to half, truncated; no denormals
                int exponent = 0;
                const float mantissa = std::frexp(std::abs(s), &exponent);
                const int bits =
                    s == 0 || exponent < -13 ? 0 : ((exponent + 14) << 10) + static_cast<int>(mantissa * 2048) - 1024;
                halves_.push_back(static_cast<std::uint16_t>(bits | (s < 0 ? 0x8000 : 0)));
            }
        }
    }
    [[nodiscard]] const void* data() const {
        return format_ == SlopeFormat::rg8 ? static_cast<const void*>(bytes_.data()) : halves_.data();
    }

private:
    SlopeFormat format_;
    std::vector<std::uint8_t> bytes_;
    std::vector<std::uint16_t> halves_;
};

/// Slopes by central differences on the CPU, level by level, as pool/slope_map.h says.
inline void upload_slopes(SlopeMap& slopes, const HeightField& field, float per_m) {
    for (int level = 0; level < slopes.texture().levels(); ++level) {
        const int width = slopes.padded_width() >> level, depth = slopes.padded_depth() >> level;
        SlopeTexels texels(slopes.format());
        for (int z = 0; z < depth; ++z) {
            for (int x = 0; x < width; ++x) {
                const auto code = [&](int dx, int dz) {
                    return field.code({std::clamp(std::min(x << level, field.width() - 1) + dx, 0, field.width() - 1),
                                       std::clamp(std::min(z << level, field.depth() - 1) + dz, 0, field.depth() - 1)});
                };
                const int px = std::min(x << level, field.width() - 1), pz = std::min(z << level, field.depth() - 1);
                const float sx =
                    shared::slope_along(0, code(-1, 0), code(1, 0), 0, px, field.width() - 1, false, per_m);
                const float sz =
                    shared::slope_along(0, code(0, -1), code(0, 1), 0, pz, field.depth() - 1, false, per_m);
                texels.add(sx, sz);
            }
        }
        slopes.texture().upload(level, slopes.texture().bounds(level), texels.data());
    }
}

struct SceneOptions {
    ClipmapSettings clipmap;
    WorldPos origin;
    double spacing_m = 1;
    double lift_m = 0;  ///< moves the world up
    HeightPrecision precision = HeightPrecision::bits32;
    SlopeFormat slopes = SlopeFormat::rg8;
    bool mirrored = false;
};

/// A field on the GPU and a renderer for it.
class Scene {
public:
    Scene(const HeightField& field, HeightCodec codec, const SceneOptions& options)
        : device_(test::device()),
          guard_(device_),
          shaders_(test::shaders()),
          map_{{options.origin, options.spacing_m, field.width(), field.depth()},
               {codec.middle_m + options.lift_m, codec.quantum_m},
               options.precision,
               options.slopes,
               options.mirrored},
          field_(&field),
          planes_(value(HeightPlanes::create(device_, field.width(), field.depth(), options.precision))),
          slopes_(value(SlopeMap::create(device_, field.width(), field.depth(), options.slopes))),
          bounds_(field),
          renderer_(value(TerrainRenderer::create(device_, shaders_, options.clipmap, map_))) {
        gl::TransferStats transfer;
        planes_.upload(field, field.rect(), transfer);
        upload_slopes(slopes_, field, static_cast<float>(codec.code_quantum_m() / options.spacing_m));
    }

    Result<void> draw(const View& view, const Shading& shading = {}, const BrushCursor* cursor = nullptr,
                      const DetailView* detail = nullptr) {
        return renderer_.draw(view, shading, cursor, planes_, slopes_, bounds_, stats_, detail);
    }
    /// Clears `target` (depth too) and draws; the picture.
    std::vector<std::uint8_t> picture(const Target& target, View view, const Shading& shading = {},
                                      const BrushCursor* cursor = nullptr, Vec3f clear = {1, 0, 1},
                                      const DetailView* detail = nullptr) {
        view.width = target.width(), view.height = target.height();
        target.clear(clear.x, clear.y, clear.z, view.depth == DepthConvention::Reversed ? 0.0f : 1.0f);
        const Result<void> drawn = draw(view, shading, cursor, detail);
        EXPECT_TRUE(drawn) << (drawn ? "" : drawn.error().message);
        return target.pixels();
    }

    /// Height of the contract surface, metres; (x, z) in posts, inside the map.
    [[nodiscard]] double height_m(double x, double z) const {
        const auto cell = [](double p, std::int32_t size) { return std::min(static_cast<std::int32_t>(p), size - 2); };
        const std::int32_t i = cell(x, field_->width()), j = cell(z, field_->depth());
        const auto h = [&](std::int32_t a, std::int32_t b) {
            return map_.codec.height_m(field_->code({i + a, j + b}));
        };
        const double u = x - i, v = z - j;
        return u >= v ? h(0, 0) + u * (h(1, 0) - h(0, 0)) + v * (h(1, 1) - h(1, 0))
                      : h(0, 0) + v * (h(0, 1) - h(0, 0)) + u * (h(1, 1) - h(0, 1));
    }
    /// A view from `above_m` over the ground at (x, z) posts.
    [[nodiscard]] View view_from(double x, double z, double above_m, Vec3d forward) const {
        View view;
        view.eye = {map_.grid.origin.x + x * map_.grid.spacing_m, height_m(x, z) + above_m,
                    map_.grid.origin.z + z * map_.grid.spacing_m};
        view.forward = forward;
        return view;
    }

    [[nodiscard]] TerrainRenderer& renderer() { return renderer_; }
    [[nodiscard]] const MapInfo& map() const { return map_; }
    [[nodiscard]] const HeightField& field() const { return *field_; }
    [[nodiscard]] gl::StageStats& stats() { return stats_; }

private:
    gl::Device& device_;
    gl::StateGuard guard_;  // tests draw one scene after another
    gl::ShaderLibrary shaders_;
    MapInfo map_;
    const HeightField* field_;
    HeightPlanes planes_;
    SlopeMap slopes_;
    HeightBounds bounds_;
    TerrainRenderer renderer_;
    gl::StageStats stats_;
};

inline bool is_magenta(const std::uint8_t* rgba) { return rgba[0] == 255 && rgba[1] == 0 && rgba[2] == 255; }

/// Where TILTH_RENDER_PICTURES points to, as binary PPM; nothing without it.
inline void keep_picture(const std::string& name, const std::vector<std::uint8_t>& rgba, int width, int height) {
    const char* folder = std::getenv("TILTH_RENDER_PICTURES");
    if (folder == nullptr) return;
    std::FILE* file = std::fopen((std::string(folder) + "/" + name + ".ppm").c_str(), "wb");
    if (file == nullptr) return;
    std::fprintf(file, "P6\n%d %d\n255\n", width, height);
    for (int y = height - 1; y >= 0; --y)
        for (int x = 0; x < width; ++x) std::fwrite(&rgba[static_cast<std::size_t>(y * width + x) * 4], 1, 3, file);
    std::fclose(file);
}

}  // namespace tilth::test
