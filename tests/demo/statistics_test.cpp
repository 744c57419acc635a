// Percentiles, the JSON's keys, paths into it, and what `expect` calls met.
#include <gtest/gtest.h>

#include <numeric>

#include "demo/player/expectations.h"
#include "demo/player/screen.h"
#include "demo/stats/run_report.h"

namespace tilth::demo {
namespace {

TEST(Percentile, NearestRank) {
    std::vector<double> hundred(100);
    std::iota(hundred.rbegin(), hundred.rend(), 1.0);  // 100, 99, ..., 1
    EXPECT_EQ(percentile(hundred, 0.50), 50);
    EXPECT_EQ(percentile(hundred, 0.95), 95);
    EXPECT_EQ(percentile(hundred, 0.99), 99);
    EXPECT_EQ(percentile(hundred, 1.00), 100);
    EXPECT_EQ(percentile({7, 3}, 0.5), 3);
    EXPECT_EQ(percentile({7}, 0.99), 7);
    EXPECT_EQ(percentile({}, 0.5), 0);
}

RunReport some_report() {
    RunReport report;
    report.executor = "cpu";
    report.hash = {0x0123456789abcdef, 0x1};
    report.frames = {{4, 2, 6}, {5, 3, 7}};
    report.total.deform.passes = 12;
    report.last_frame.transfer.bytes_up = 34;
    report.total.cache = {1, 2, 3, 4, 5, 6, 7, 8, 9.5};
    report.last_frame.cache.missing_active = 11;
    report.total.store = {15, 16, 17, 18.5};
    report.last_frame.store.failures = 19;
    report.walk.missing_frames = 12;
    report.tiles = 13, report.tile_bytes = 14;
    report.queries = Json::parse("[[9.5, 9.75], []]");
    report.failures = {"f.toml:3: step 1: expect"};
    return report;
}

TEST(RunReport, HasEveryKeyOfTheForm) {
    const Json json = to_json(some_report());
    std::vector<std::string> paths{"tilth",
                                   "context.route",
                                   "context.renderer",
                                   "context.gl",
                                   "context.executor",
                                   "hash.coarse",
                                   "hash.detail",
                                   "frames.count",
                                   "resident.tiles",
                                   "resident.gpu_bytes",
                                   "resident.cpu_bytes",
                                   "queries",
                                   "failures",
                                   "resident.tile_bytes",
                                   "walk.missing_frames",
                                   "walk.smallest_lead_m",
                                   "walk.smallest_lead_ms",
                                   "cache.longest_frame_over_median"};
    for (const char* times : {"cpu_ms", "wall_ms"})
        for (const char* share : {"p50", "p95", "p99", "max"})
            paths.push_back(std::string("frames.") + times + "." + share);
    for (const std::string part : {"total.", "last_frame."}) {
        for (const char* key : {"passes", "draws", "texels", "bytes", "programs", "saturated"})
            paths.push_back(part + "deform." + key);
        for (const char* key : {"derive",
                                "render.primitives",
                                "cache.loads",
                                "cache.evictions",
                                "cache.rescues",
                                "cache.saves",
                                "cache.cancelled",
                                "cache.failures",
                                "cache.late_stamps",
                                "cache.missing_active",
                                "cache.transfer_ms",
                                "transfer.bytes_up",
                                "transfer.bytes_down",
                                "store.snapshots",
                                "store.compactions",
                                "store.failures",
                                "store.snapshot_ms",
                                "effects.wave.passes",
                                "effects.wave.texels",
                                "effects.wave.bytes",
                                "effects.wave.programs"})
            paths.push_back(part + key);
    }
    for (const std::string& path : paths) EXPECT_TRUE(value_at(json, path)) << path;
    EXPECT_EQ(json["hash"]["coarse"], "0123456789abcdef");
    EXPECT_EQ(json["hash"]["detail"], "0000000000000001");
    EXPECT_EQ(json["frames"]["count"], 3);
    EXPECT_EQ(json["frames"]["cpu_ms"]["p50"], 4);
    EXPECT_EQ(json["frames"]["wall_ms"]["max"], 7);
}

TEST(RunReport, CacheFieldsStandUnderTheirNames) {
    const Json json = to_json(some_report());
    EXPECT_EQ(json["total"]["cache"].dump(),
              "{\"loads\":1,\"saves\":2,\"evictions\":3,\"rescues\":4,\"cancelled\":5,\"failures\":6,"
              "\"late_stamps\":7,\"missing_active\":8,\"transfer_ms\":9.5}");
    EXPECT_EQ(json["last_frame"]["cache"]["missing_active"], 11);
    EXPECT_EQ(json["walk"]["missing_frames"], 12);
    EXPECT_EQ(json["resident"]["tiles"], 13);
    EXPECT_EQ(json["resident"]["tile_bytes"], 14);
    EXPECT_EQ(json["cache"]["longest_frame_over_median"], 7.0 / 5) << "wall time: waiting is what it is to show";
    RunReport walked = some_report();
    walked.walk_frames = {{1, 1, 1}, {2, 3, 2}};
    EXPECT_EQ(to_json(walked)["cache"]["longest_frame_over_median"], 1.5) << "of walks, where there are any";
}

TEST(RunReport, TheWorldOnDiskStandsUnderItsNames) {
    RunReport report = some_report();
    EXPECT_FALSE(to_json(report).contains("world")) << "only where there is one";
    report.world = WorldReport{.edits = 1, .durable = 2, .committed = 3, .journal_bytes = 4, .page_bytes = 5};
    const Json json = to_json(report);
    EXPECT_EQ(json["world"].dump(), "{\"edits\":1,\"durable\":2,\"committed\":3,\"journal_bytes\":4,\"page_bytes\":5}");
    EXPECT_EQ(json["total"]["store"].dump(),
              "{\"snapshots\":15,\"compactions\":16,\"failures\":17,\"snapshot_ms\":18.5}");
    EXPECT_EQ(json["last_frame"]["store"]["failures"], 19);
    for (const char* path : {"world.edits", "world.page_bytes", "total.store.snapshots", "last_frame.store.failures"})
        EXPECT_TRUE(has_stat(path)) << path;
    EXPECT_FALSE(has_stat("world")) << "is no number";
    const ExpectStat expected{.path = "world.edits", .equals = 0, .at_most = {}, .at_least = {}, .equals_text = {}};
    EXPECT_TRUE(unmet(expected, to_json(some_report()))) << "no world has no edits to count";
}

TEST(RunReport, WhatWasNotMeasuredIsNull) {
    const Json json = to_json(RunReport{});
    EXPECT_TRUE(json["walk"]["smallest_lead_m"].is_null());
    EXPECT_TRUE(json["walk"]["smallest_lead_ms"].is_null());
    EXPECT_TRUE(json["cache"]["longest_frame_over_median"].is_null());
    for (const char* path : {"walk.smallest_lead_m", "walk.smallest_lead_ms", "cache.longest_frame_over_median"}) {
        EXPECT_TRUE(has_stat(path)) << path;
        const ExpectStat expected{.path = path, .equals = {}, .at_most = 1e9, .at_least = -1e9, .equals_text = {}};
        EXPECT_TRUE(unmet(expected, json)) << "null meets no bound";
    }
}

TEST(StatPath, LeadsThroughTablesAndLists) {
    const Json json = to_json(some_report());
    EXPECT_EQ(*value_at(json, "total.deform.passes"), 12);
    EXPECT_EQ(*value_at(json, "last_frame.transfer.bytes_up"), 34);
    EXPECT_EQ(*value_at(json, "queries.0.1"), 9.75);
    for (const char* wrong : {"", ".", "total.", "total..passes", "total.deform.passes.more", "queries.2", "queries.-1",
                              "queries.0.x", "nothing"})
        EXPECT_FALSE(value_at(json, wrong)) << wrong;
}

TEST(StatPath, OnlyPathsToValuesExist) {
    EXPECT_TRUE(has_stat("last_frame.deform.passes"));
    EXPECT_TRUE(has_stat("context.executor"));
    EXPECT_TRUE(has_stat("queries.3.1"));
    EXPECT_FALSE(has_stat("last_frame.deform"));
    EXPECT_FALSE(has_stat("last_frame.deform.pases"));
    EXPECT_FALSE(has_stat(""));
}

TEST(Expect, TheBorderOfAToleranceIsInsideIt) {
    const ExpectHeight expected{{1, 2}, 10, 0.5};
    EXPECT_FALSE(unmet(expected, 10.5));
    EXPECT_FALSE(unmet(expected, 9.5));
    EXPECT_TRUE(unmet(expected, 10.500001));
    EXPECT_NE(unmet(expected, 11)->find("expected 10 within 0.5"), std::string::npos);
    EXPECT_FALSE(unmet(ExpectHeight{{}, 3, 0}, 3));
    EXPECT_TRUE(unmet(expected, std::nan("")).has_value()) << "no number is near anything";
}

TEST(Expect, HashesAreComparedOneByOne) {
    const StateHash hash{1, 2};
    EXPECT_FALSE(unmet(ExpectHash{"0000000000000001", {}}, hash));
    EXPECT_FALSE(unmet(ExpectHash{"0000000000000001", "0000000000000002"}, hash));
    EXPECT_TRUE(unmet(ExpectHash{"0000000000000001", "0000000000000003"}, hash));
    EXPECT_TRUE(unmet(ExpectHash{"0000000000000002", {}}, hash));
}

ExpectStat stat(std::optional<double> equals, std::optional<double> at_most, std::optional<double> at_least) {
    return {
        .path = "total.deform.passes", .equals = equals, .at_most = at_most, .at_least = at_least, .equals_text = {}};
}

TEST(Expect, StatsEqualOrStayWithinBounds) {
    const Json json = to_json(some_report());  // 12 passes
    EXPECT_FALSE(unmet(stat(12, {}, {}), json));
    EXPECT_TRUE(unmet(stat(11, {}, {}), json));
    EXPECT_FALSE(unmet(stat({}, 12, 12), json));
    EXPECT_TRUE(unmet(stat({}, 11, {}), json));
    EXPECT_TRUE(unmet(stat({}, {}, 13), json));
    ExpectStat text{.path = "context.executor", .equals = {}, .at_most = {}, .at_least = {}, .equals_text = "cpu"};
    EXPECT_FALSE(unmet(text, json));
    text.equals_text = "gpu";
    EXPECT_TRUE(unmet(text, json));
    text.path = "queries.7.0";
    EXPECT_TRUE(unmet(text, json));
}

TEST(Depth, IsTheInverseOfTheProjection) {
    const double near_m = 0.5, far_m = 5000;
    for (const double z : {0.5, 1.0, 10.0, 4999.0}) {
        const double stored = far_m / (far_m - near_m) * (1 - near_m / z);
        EXPECT_NEAR(depth_m(stored, near_m, far_m), z, 1e-9 * z * z / near_m);
    }
    EXPECT_TRUE(std::isinf(depth_m(1, near_m, far_m)));
}

}  // namespace
}  // namespace tilth::demo
