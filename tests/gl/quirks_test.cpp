#include "tilth/gl/quirks.h"

#include <gtest/gtest.h>

#include "tilth/gl/frame_stats.h"

namespace tilth::gl {
namespace {

TEST(Quirks, software_renderers_are_known_by_name) {
    for (const char* renderer : {"llvmpipe (LLVM 15.0.6, 256 bits)", "softpipe", "SWR (LLVM 11)", "Google SwiftShader",
                                 "GDI Generic", "Apple Software Renderer"}) {
        const Quirks quirks = quirks_of("any", renderer);
        EXPECT_TRUE(quirks.software_rasterizer) << renderer;
        EXPECT_TRUE(quirks.timer_queries_lie) << renderer;
    }
}

TEST(Quirks, gpus_have_none) {
    const Quirks none;
    EXPECT_EQ(quirks_of("NVIDIA Corporation", "NVIDIA GeForce RTX 3060/PCIe/SSE2"), none);
    EXPECT_EQ(quirks_of("AMD", "AMD Radeon RX 6700 XT (radeonsi, navi22, LLVM 15.0.6, DRM 3.49)"), none);
    EXPECT_EQ(quirks_of("Intel", "Mesa Intel(R) UHD Graphics 620 (KBL GT2)"), none);
}

TEST(FrameStats, totals_add_every_member) {
    FrameStats frame;
    std::uint64_t n = 1;
    for (StageStats* stage : {&frame.deform, &frame.derive, &frame.mips, &frame.render}) {
        for (std::uint64_t* count : {&stage->passes, &stage->draws, &stage->primitives, &stage->texels, &stage->bytes,
                                     &stage->programs, &stage->saturated, &stage->fallbacks})
            *count = n++;
        stage->cpu_ms = static_cast<double>(n++);
    }
    frame.transfer = {n, n + 1};
    frame.cache = {n, n + 1, n + 2, n + 3, n + 4, n + 5, n + 6, n + 7, static_cast<double>(n + 8)};
    frame.store = {n + 9, n + 10, n + 11, static_cast<double>(n + 12)};
    // No padding: every member of the struct is eight bytes, so all of them can be walked.
    static_assert(sizeof(StageStats) == 8 * 8 + 8 && sizeof(CacheStats) == 8 * 8 + 8 && sizeof(StoreStats) == 4 * 8 &&
                  sizeof(FrameStats) == 4 * sizeof(StageStats) + 16 + sizeof(CacheStats) + sizeof(StoreStats));
    FrameStats total = frame;
    total += frame;
    for (auto [stage, sum] : {std::pair{&frame.deform, &total.deform},
                              {&frame.derive, &total.derive},
                              {&frame.mips, &total.mips},
                              {&frame.render, &total.render}}) {
        const auto* one = &stage->passes;
        const auto* two = &sum->passes;
        for (int i = 0; i < 8; ++i) EXPECT_EQ(two[i], 2 * one[i]) << "member " << i;
        EXPECT_EQ(sum->cpu_ms, 2 * stage->cpu_ms);
    }
    EXPECT_EQ(total.transfer, (TransferStats{2 * n, 2 * n + 2}));
    EXPECT_EQ(total.cache, (CacheStats{2 * n, 2 * n + 2, 2 * n + 4, 2 * n + 6, 2 * n + 8, 2 * n + 10, 2 * n + 12,
                                       2 * n + 14, static_cast<double>(2 * n + 16)}));
    EXPECT_EQ(total.store, (StoreStats{2 * n + 18, 2 * n + 20, 2 * n + 22, static_cast<double>(2 * n + 24)}));
    EXPECT_EQ(total.fallbacks(), 2 * frame.fallbacks());
}

}  // namespace
}  // namespace tilth::gl
