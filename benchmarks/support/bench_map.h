// A flat map on the GPU and on the CPU, and stamps for it.
#pragma once

#include <optional>
#include <vector>

#include "support/bench_device.h"
#include "tilth/core/hash.h"
#include "tilth/deform/deformer.h"
#include "tilth/derive/slope_pass.h"
#include "tilth/ground/cpu_executor.h"
#include "tilth/ground/random_stamps.h"

namespace tilth::bench {

enum class Column { Gpu, Cpu };

/// A map of `posts` x `posts` at 1 m with both executors' data. Deform, then slopes of what changed: what a frame does.
class BenchMap {
public:
    explicit BenchMap(std::int32_t posts, HeightPrecision precision = HeightPrecision::bits32)
        : map{.kind = MapKind::Coarse,
              .grid = {.spacing_m = 1, .width = posts, .depth = posts},
              .codec = HeightCodec::for_range(0, 100),
              .precision = precision},
          field(posts, posts),
          planes(value(HeightPlanes::create(device(), posts, posts, precision))),
          slopes(value(SlopeMap::create(device(), posts, posts, SlopeFormat::rg8))),
          deformer(value(Deformer::create(device(), shaders()))),
          slope_pass(value(SlopePass::create(device(), shaders(), precision, SlopeFormat::rg8, slope_settings()))) {
        planes.upload(field, field.rect(), transfer);
    }

    /// A stamp of `radius` texels at (x, z) posts; a quantum of the high plane high, so that 10^6 of them fit the
    /// range.
    [[nodiscard]] PreparedStamp stamp(double radius, double x, double z,
                                      BuiltinProfile profile = BuiltinProfile::Gaussian,
                                      StampRule rule = StampRule::Add, bool negative = false) const {
        const StampRecord record{.centre_x = static_cast<std::int64_t>(x * 16777216),
                                 .centre_z = static_cast<std::int64_t>(z * 16777216),
                                 .shape = static_cast<std::uint32_t>(profile),
                                 .radius = static_cast<std::uint32_t>(radius * 262144),
                                 .amplitude = 65536,
                                 .level = kMidCode,
                                 .key = 1,
                                 .rule = rule,
                                 .negative = negative ? std::uint8_t{1} : std::uint8_t{0}};
        return prepare(record, map, shapes);
    }

    /// Applies `stamps` by one executor, and their slopes if asked.
    void apply(Column column, std::span<const PreparedStamp> stamps, bool with_slopes = true) {
        std::vector<TexelRect> changed;
        if (column == Column::Gpu) {
            std::vector<DeformStamp> list;
            for (const PreparedStamp& prepared : stamps) {
                list.push_back({.prepared = prepared});
                changed.push_back(prepared.rect());
            }
            check(deformer.apply(list, planes, deform));
            if (with_slopes) slope_pass.run(changed, planes, slopes, derive, mips);
            return;
        }
        for (const PreparedStamp& prepared : stamps) changed.push_back(apply_stamp(prepared, field).rect);
        for (const TexelRect& rect : disjoint(changed)) planes.upload(field, rect, transfer);
        if (with_slopes) upload_slopes(changed, field, slope_settings(), slopes, derive, mips, transfer);
    }

    /// XXH3-64 of the codes that the column's executor left.
    [[nodiscard]] std::uint64_t hash(Column column) {
        if (column == Column::Gpu) {
            HeightField read(field.width(), field.depth());
            planes.read_back(planes.rect(), read, transfer);
            return hash_bytes(std::as_bytes(read.codes()));
        }
        return hash_bytes(std::as_bytes(static_cast<const HeightField&>(field).codes()));
    }

    [[nodiscard]] SlopeSettings slope_settings() const {
        return {SlopeStencil::Central, map.codec.code_quantum_m(), map.grid.spacing_m};
    }

    ShapeLibrary shapes;
    MapGeometry map;
    HeightField field;
    HeightPlanes planes;
    SlopeMap slopes;
    Deformer deformer;
    SlopePass slope_pass;
    gl::TransferStats transfer;
    gl::StageStats deform, derive, mips;
};

}  // namespace tilth::bench
