// Every instruction set gives the bits of the definition (reference.h), for every shape, rule and precision.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ground/reference.h"
#include "ground/support.h"
#include "tilth/ground/cpu_executor.h"

namespace tilth {
namespace {

constexpr std::int32_t kWidth = 701, kDepth = 331;  // wider than one kernel call

struct Draw {
    std::mt19937_64 random{20};
    double unit() { return std::uniform_real_distribution<double>(0, 1)(random); }
    std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); }

    StampRecord record(const ShapeLibrary& shapes, const MapGeometry& map) {
        StampRecord record;
        record.map = map.kind;
        record.shape = below(shapes.size());
        record.rule = static_cast<StampRule>(below(5));
        const double radius_texels = 0.3 * std::pow(200 / 0.3, unit() * (below(8) == 0 ? 1.0 : 0.75));
        record.radius = static_cast<std::uint32_t>(radius_texels * 262144);
        const double x = (unit() * 1.2 - 0.1) * kWidth, z = (unit() * 1.2 - 0.1) * kDepth;
        record.centre_x = std::llround((map.grid.origin.x + map.grid.spacing_m * x) * 16777216.0);
        record.centre_z = std::llround((map.grid.origin.z + map.grid.spacing_m * z) * 16777216.0);
        record.amplitude = static_cast<std::uint32_t>(std::exp2(unit() * 32) - 1);
        if (record.rule == StampRule::Smooth) record.amplitude = below(65537);
        record.level = static_cast<std::uint32_t>(random());
        record.rotation = below(4) == 0 ? below(8) << 29 : static_cast<std::uint32_t>(random());
        record.key = static_cast<std::uint32_t>(random());
        record.negative = static_cast<std::uint8_t>(below(2));
        record.mirror = static_cast<std::uint8_t>(below(2));
        return record;
    }
};

class KernelsByPrecision : public testing::TestWithParam<HeightPrecision> {};

TEST_P(KernelsByPrecision, GiveTheBitsAndTheSaturatedCountOfTheDefinition) {
    const MapGeometry map{.kind = MapKind::Detail,
                          .grid = {.origin = {-37.5, 1000.25}, .spacing_m = 0.1 / 3, .width = kWidth, .depth = kDepth},
                          .codec = HeightCodec::detail(),
                          .precision = GetParam()};
    ShapeLibrary shapes;
    const test::UserShapes user(shapes);
    ASSERT_TRUE(shapes.add_image("dot", 1, 1, std::vector<std::uint16_t>{65535}).ok());

    Draw draw;
    const std::uint32_t kept = GetParam() == HeightPrecision::bits16 ? 0xffff0000u : 0xffffffffu;
    HeightField start(kWidth, kDepth);
    for (std::uint32_t& code : start.codes())  // a third of the range in the middle, some at the very ends
        code = (draw.below(50) == 0 ? (draw.below(2) == 0 ? 0u : 0xffffffffu) : 0x55555555u + draw.below(0x55555555u)) &
               kept;

    std::vector<std::uint32_t> expected(start.codes().begin(), start.codes().end());
    std::vector<HeightField> fields(available_cpu_kernels().size(), start);
    std::int64_t done = 0, saturated_texels = 0, by_rule[5] = {};
    while (done < 1100) {
        const StampRecord record = draw.record(shapes, map);
        const reference::Stamp definition(record, map, shapes);
        if (definition.doubtful()) continue;
        ++done;
        const std::int64_t saturated = definition.apply(expected, kWidth, kDepth);
        saturated_texels += saturated;
        ++by_rule[static_cast<int>(record.rule)];
        const PreparedStamp prepared = prepare(record, map, shapes);
        for (std::size_t set = 0; set < fields.size(); ++set) {
            const ApplyResult result = apply_stamp(prepared, fields[set], *available_cpu_kernels()[set]);
            ASSERT_EQ(static_cast<std::int64_t>(result.saturated), saturated)
                << available_cpu_kernels()[set]->name << " stamp " << done << " shape " << record.shape << " rule "
                << static_cast<int>(record.rule) << " radius " << record.radius;
            for (std::size_t i = 0; i < expected.size(); ++i)
                ASSERT_EQ(fields[set].codes()[i], expected[i])
                    << available_cpu_kernels()[set]->name << " stamp " << done << " shape " << record.shape << " rule "
                    << static_cast<int>(record.rule) << " radius " << record.radius << " texel " << i % kWidth << ", "
                    << i / kWidth;
        }
    }
    EXPECT_GT(saturated_texels, 1000);  // the draw did reach the ends of the range
    for (const std::int64_t count : by_rule) EXPECT_GT(count, 100);
}

INSTANTIATE_TEST_SUITE_P(Both, KernelsByPrecision, testing::ValuesIn(test::kBothPrecisions), [](const auto& param) {
    return param.param == HeightPrecision::bits32 ? "bits32" : "bits16";
});

TEST(CpuKernels, TheDefaultIsTheBestAvailable) {
    ASSERT_GE(available_cpu_kernels().size(), 1u);
    EXPECT_EQ(&cpu_kernels(), available_cpu_kernels().back());
    EXPECT_STREQ(available_cpu_kernels().front()->name, "baseline");
}

// The largest radius (8 192 texels) stays within the integers: distances of 24 bits.
TEST(CpuKernels, TheLargestRadiusIsRight) {
    constexpr std::int32_t kSide = 16400;
    const MapGeometry map = test::map_of(kSide);
    const ShapeLibrary shapes;
    for (const std::int32_t z : {5, 2000, 8199, 8200, 16391})
        for (const CpuKernels* kernels : available_cpu_kernels()) {
            const StampRecord record = test::record_at(8200.25, 8199.5, 8191.999, 1u << 30, {0});
            PreparedStamp prepared = prepare(record, map, shapes);
            const reference::Stamp definition(record, map, shapes);
            std::vector<std::uint32_t> codes(kKernelTexels);
            for (std::int32_t x = prepared.rect().min.x; x < prepared.rect().max.x; x += kKernelTexels) {
                codes.assign(kKernelTexels, kMidCode);
                const std::int32_t count = std::min(kKernelTexels, prepared.rect().max.x - x);
                EXPECT_EQ(kernels->apply_row({.stamp = &prepared.params,
                                              .weights = prepared.shape->weights.data(),
                                              .x = x,
                                              .z = z,
                                              .count = count,
                                              .codes = codes.data()}),
                          0u);
                for (std::int32_t i = 0; i < count; ++i)
                    ASSERT_EQ(std::int64_t{codes[static_cast<std::size_t>(i)]} - std::int64_t{kMidCode},
                              definition.change(x + i, z))
                        << kernels->name << " texel " << x + i << ", " << z;
            }
        }
}

}  // namespace
}  // namespace tilth
