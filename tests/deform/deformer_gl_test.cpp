// The GPU executor leaves the bits that the CPU executor leaves, on both contexts and in both precisions.
#include "tilth/deform/deformer.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/gl_context.h"
#include "support/random_world.h"
#include "support/route_and_precision.h"
#include "tilth/gl/state_guard.h"
#include "tilth/ground/cpu_executor.h"
#include "tilth/ground/stamp_range.h"

namespace tilth {
namespace {

constexpr std::int32_t kPosts = 257;

/// A world twice: on the CPU, and in height planes with a deformer.
struct Twin {
    Twin(gl::Device& gl_device, HeightPrecision precision)
        : device(gl_device),
          ground(test::small_world(kPosts, precision)),
          shaders(test::shaders(gl_device)),
          planes(test::value(HeightPlanes::create(gl_device, kPosts, kPosts, precision))),
          deformer(test::value(Deformer::create(gl_device, shaders))) {
        planes.upload(ground->coarse(), planes.rect(), transfer);
    }

    /// Applies `records` to both; every stamp's saturated texels are counted when `count` is set.
    void apply(std::span<const StampRecord> records, bool count = false) {
        std::vector<DeformStamp> stamps;
        for (const StampRecord& record : records) {
            stamps.push_back({prepare(record, ground->map(MapKind::Coarse), ground->shapes()), count});
            cpu += ground->apply(record);
        }
        const Result<void> applied = deformer.apply(stamps, planes, gpu);
        ASSERT_TRUE(applied) << applied.error().message;
    }

    /// Texels in which the two differ.
    std::int64_t differences() {
        HeightField read(kPosts, kPosts, 0x12345678);
        planes.read_back(planes.rect(), read, transfer);
        std::int64_t count = 0;
        for (std::size_t i = 0; i < read.codes().size(); ++i) count += read.codes()[i] != ground->coarse().codes()[i];
        return count;
    }

    gl::Device& device;
    gl::StateGuard guard{device};
    std::unique_ptr<Ground> ground;
    gl::ShaderLibrary shaders;
    HeightPlanes planes;
    Deformer deformer;
    gl::TransferStats transfer;
    gl::StageStats gpu;
    ApplyResult cpu;
};

class DeformerTest : public test::GlRouteTest<test::RouteAndPrecision> {
protected:
    static Twin twin() { return {test::device(GetParam().route), GetParam().precision}; }
};

TEST_P(DeformerTest, TenThousandRandomStampsOfEveryKindGiveTheCpusBits) {
    Twin world = twin();
    std::vector<StampRecord> records = test::random_records(*world.ground, 1, 9000, 6);
    const std::vector<StampRecord> larger = test::random_records(*world.ground, 2, 1000, 60);
    records.insert(records.end(), larger.begin(), larger.end());
    SplitMix64 random{5};
    for (std::size_t i = 0; i < records.size(); i += 2) {  // every second stamp lies across an edge of the map
        StampRecord& record = records[i];
        const auto edge = static_cast<std::int64_t>(random.next() % 2) * (kPosts - 1) * (std::int64_t{1} << 24);
        const auto radius = static_cast<std::int64_t>(record.radius) << 6;  // 2^-18 texel to 2^-24 m, posts of 1 m
        (random.next() % 2 == 0 ? record.centre_x : record.centre_z) =
            edge + static_cast<std::int64_t>(random.between(-0.6, 0.6) * static_cast<double>(radius));
    }
    std::size_t next = 0;
    while (next < records.size()) {  // frames of one to many stamps
        const std::size_t frame = std::min(records.size() - next, static_cast<std::size_t>(1 + random.next() % 200));
        world.apply(std::span(records).subspan(next, frame));
        next += frame;
        if (random.next() % 8 == 0) {
            ASSERT_EQ(world.differences(), 0) << "after " << next << " stamps";
        }
    }
    EXPECT_EQ(world.differences(), 0);

    std::int64_t crossing = 0;
    for (const StampRecord& record : records) {
        const PreparedStamp stamp = prepare(record, world.ground->map(MapKind::Coarse), world.ground->shapes());
        const TexelRect r = stamp.rect();
        crossing += !r.empty() && (r.min.x == 0 || r.min.z == 0 || r.max.x == kPosts || r.max.z == kPosts);
    }
    EXPECT_GT(crossing, 4500) << "about half of the stamps must cross the map's edges";
}

TEST_P(DeformerTest, SaturatedTexelsAreCountedLikeOnTheCpu) {
    Twin world = twin();
    std::vector<StampRecord> records =
        test::random_records(*world.ground, 7, 120, 30, {StampRule::Add, StampRule::Set, StampRule::Max});
    for (StampRecord& record : records) {  // towards both ends of the range
        record.amplitude = 0xf0000000u;
        record.level = record.sequence % 2 == 0 ? 0x01000000u : 0xfe000000u;
    }
    world.apply(records, true);
    world.deformer.finish(world.gpu);
    EXPECT_EQ(world.differences(), 0);
    EXPECT_GT(world.cpu.saturated, 1000u);
    EXPECT_EQ(world.gpu.saturated, world.cpu.saturated);
}

TEST_P(DeformerTest, ManyStampsOfAFrameShareOnePass) {
    Twin world = twin();
    const std::vector<StampRecord> records =
        test::random_records(*world.ground, 9, 500, 8, {StampRule::Add, StampRule::Min, StampRule::Set});
    world.apply(records);
    EXPECT_EQ(world.gpu.passes, 1u);
    EXPECT_EQ(world.differences(), 0);
}

TEST_P(DeformerTest, NothingOutsideTheStampsRectangleIsWritten) {
    Twin world = twin();
    std::vector<StampRecord> one;
    TexelRect rect;
    for (const StampRecord& record : test::random_records(*world.ground, 21, 50, 9, {StampRule::Smooth})) {
        rect = prepare(record, world.ground->map(MapKind::Coarse), world.ground->shapes()).rect();
        one = {record};
        if (!rect.empty()) break;
    }
    ASSERT_GT(rect.count(), 0);
    world.apply(one);
    EXPECT_EQ(world.gpu.texels, static_cast<std::uint64_t>(rect.count()));
    world.apply({});
    EXPECT_EQ(world.gpu.texels, static_cast<std::uint64_t>(rect.count()));
    EXPECT_EQ(world.differences(), 0);
}

TEST_P(DeformerTest, BoundsFromStampRangeHoldAndTellWhenCountingIsNeeded) {
    Twin world = twin();
    std::vector<StampRecord> records = test::random_records(*world.ground, 31, 300, 20);
    for (std::size_t i = 0; i < records.size(); i += 3)
        if (records[i].rule != StampRule::Smooth) records[i].amplitude = 0x40000000u;
    for (const StampRecord& record : records) {
        const PreparedStamp stamp = prepare(record, world.ground->map(MapKind::Coarse), world.ground->shapes());
        if (stamp.rect().empty()) continue;
        const TexelRect around = intersection(expanded(stamp.rect(), 1), world.ground->coarse().rect());
        const auto extremes = [&] {
            std::pair<std::uint32_t, std::uint32_t> range{0xffffffffu, 0};
            for (std::int32_t z = around.min.z; z < around.max.z; ++z)
                for (std::int32_t x = around.min.x; x < around.max.x; ++x) {
                    const std::uint32_t code = world.ground->coarse().code({x, z});
                    range = {std::min(range.first, code), std::max(range.second, code)};
                }
            return range;
        };
        const auto before = extremes();
        const StampRange range = range_after(stamp, before.first, before.second);
        const ApplyResult applied = world.ground->apply(record);
        const auto after = extremes();
        ASSERT_LE(range.min, after.first);
        ASSERT_GE(range.max, after.second);
        ASSERT_TRUE(range.may_saturate || applied.saturated == 0u);
    }
}

INSTANTIATE_TEST_SUITE_P(Contexts, DeformerTest, test::every_route_and_precision(), test::name_of);

}  // namespace
}  // namespace tilth
