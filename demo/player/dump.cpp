#include "demo/player/dump.h"

#include <algorithm>
#include <vector>

#include "demo/player/region.h"
#include "tilth/core/shared_glsl.h"
#include "tilth/io/height_writer.h"

namespace tilth::shared {
#include "shared/slope_math.glsl"
}

namespace tilth::demo {

namespace {

constexpr std::int64_t kMaxDumpTexels = 1LL << 28;

std::uint32_t code_at(const Ground& ground, MapKind map, Texel t) {
    return map == MapKind::Coarse ? ground.coarse_code(t) : ground.detail().code(t);
}

template <class Get>
auto gathered(const TexelRect& rect, int channels, const Get& get) {
    std::vector<std::decay_t<decltype(get(Texel{}, 0))>> values;
    values.reserve(std::size_t(rect.count()) * std::size_t(channels));
    for (std::int32_t z = rect.min.z; z < rect.max.z; ++z)
        for (std::int32_t x = rect.min.x; x < rect.max.x; ++x)
            for (int c = 0; c < channels; ++c) values.push_back(get(Texel{x, z}, c));
    return values;
}

}  // namespace

std::array<double, 2> slope_at(const Ground& ground, MapKind map, Texel t) {
    const MapGeometry& geometry = ground.map(map);
    const Texel last{geometry.grid.width - 1, geometry.grid.depth - 1};
    const auto code = [&](std::int32_t x, std::int32_t z) {
        return code_at(ground, map, {std::clamp(x, 0, last.x), std::clamp(z, 0, last.z)});
    };
    const float per_m = float(geometry.codec.code_quantum_m() / geometry.grid.spacing_m);
    return {shared::slope_along(0, code(t.x - 1, t.z), code(t.x + 1, t.z), 0, t.x, last.x, false, per_m),
            shared::slope_along(0, code(t.x, t.z - 1), code(t.x, t.z + 1), 0, t.z, last.z, false, per_m)};
}

Result<void> write_dump(const Ground& ground, const DumpStep& step, const std::string& path) {
    const MapGeometry& geometry = ground.map(step.map);
    const TexelRect rect = texels_in(geometry.grid, step.region);
    if (rect.empty()) return Error{ErrorCode::InvalidArgument, "region: no texel of the map lies in it"};
    if (rect.count() > kMaxDumpTexels)
        return Error{ErrorCode::InvalidArgument,
                     text("region: holds ", rect.count(), " texels; allowed: at most ", kMaxDumpTexels)};

    const int channels = step.what == DumpWhat::Slope ? 2 : 1;
    const auto value = [&](Texel t, int channel) -> double {
        if (step.what == DumpWhat::Slope) return slope_at(ground, step.map, t)[std::size_t(channel)];
        const std::uint32_t code = code_at(ground, step.map, t);
        return step.what == DumpWhat::Code ? double(code) : geometry.codec.height_m(code);
    };
    if (path.ends_with(".csv")) {
        const io::CsvFrame frame{geometry.grid.world(rect.min), geometry.grid.spacing_m};
        return io::write_csv(path, frame, gathered(rect, channels, value), rect.width(), rect.depth(), channels);
    }
    if (step.what == DumpWhat::Code) {
        const auto code = [&](Texel t, int) { return code_at(ground, step.map, t); };
        return io::write_codes(path, gathered(rect, 1, code), rect.width(), rect.depth());
    }
    const auto rounded = [&](Texel t, int channel) { return float(value(t, channel)); };
    return io::write_floats(path, gathered(rect, channels, rounded), rect.width(), rect.depth(), channels);
}

}  // namespace tilth::demo
