// What may run at the same time: different grounds, const queries of one, the log. Run under ThreadSanitizer.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <thread>
#include <vector>

#include "ground/support.h"
#include "tilth/core/log.h"
#include "tilth/ground/cpu_executor.h"
#include "tilth/ground/raycast.h"

namespace tilth {
namespace {

constexpr int kThreads = 4;

void together(const std::function<void(int)>& work) {
    std::atomic<int> ready = 0;
    std::vector<std::thread> threads;
    for (int i = 0; i < kThreads; ++i)
        threads.emplace_back([&, i] {
            for (++ready; ready < kThreads;) std::this_thread::yield();
            work(i);
        });
    for (std::thread& thread : threads) thread.join();
}

// First in this file, so that the first call of all is the race.
TEST(GroundThreads, KernelsAreChosenOnce) {
    std::array<const CpuKernels*, kThreads> chosen{};
    together([&](int i) { chosen[static_cast<std::size_t>(i)] = &cpu_kernels(); });
    for (const CpuKernels* kernels : chosen) EXPECT_EQ(kernels, &cpu_kernels());
}

void stamp_many(Ground& ground) {
    for (int i = 0; i < 60; ++i)
        test::stamp(ground, {.shape = {static_cast<std::uint32_t>(i % 6)},
                             .centre = {5.3 + i % 23, 9.1 + i % 17},
                             .radius_m = 0.2 + i * 0.15,
                             .amplitude_m = 0.05,
                             .rule = i % 3 == 0 ? StampRule::Add : StampRule::Smooth});
}

TEST(GroundThreads, DifferentGroundsAreIndependent) {
    std::array<StateHash, kThreads> hashes;
    together([&](int i) {
        auto ground = test::flat_ground(33);
        stamp_many(*ground);
        hashes[static_cast<std::size_t>(i)] = ground->hash();
    });
    for (const StateHash& hash : hashes) EXPECT_EQ(hash, hashes[0]);
    EXPECT_NE(hashes[0], test::flat_ground(33)->hash());
}

TEST(GroundThreads, FieldsShareOneLibrary) {
    ShapeLibrary shapes;
    const test::UserShapes user(shapes);
    const ShapeLibrary& shared = shapes;
    std::array<std::int64_t, kThreads> volumes{};
    together([&](int i) {
        HeightField field(96, 96);
        for (std::uint32_t shape = 0; shape < shared.size(); ++shape)
            apply_stamp(prepare(test::record_at(48, 48, 20, 1u << 20, {shape}), test::map_of(96), shared), field);
        volumes[static_cast<std::size_t>(i)] = test::volume(field);
    });
    for (const std::int64_t volume : volumes) EXPECT_EQ(volume, volumes[0]);
    EXPECT_NE(volumes[0], 0);
}

TEST(GroundThreads, ConstQueriesRunTogether) {
    auto ground = test::flat_ground(33);
    stamp_many(*ground);
    const Ground& asked = *ground;
    std::array<double, kThreads> sums{};
    std::array<StateHash, kThreads> hashes;
    together([&](int i) {
        double sum = 0;
        for (int k = 0; k < 500; ++k) {
            sum += asked.height_m({k * 0.06, k * 0.05});
            sum += raycast(asked, {16, 20, 16}, {std::cos(k * 0.1), -1, std::sin(k * 0.1)}, 100).value_or(0);
        }
        sums[static_cast<std::size_t>(i)] = sum;
        hashes[static_cast<std::size_t>(i)] = asked.hash();
    });
    for (const double sum : sums) EXPECT_EQ(sum, sums[0]);
    for (const StateHash& hash : hashes) EXPECT_EQ(hash, hashes[0]);
}

struct Counter {
    int seen = 0;  // plain: the log calls one at a time
    static void count(LogLevel, std::string_view, void* user) { ++static_cast<Counter*>(user)->seen; }
};

TEST(LogThreads, OneMessageAtATimeAndNoneToAnOldCallback) {
    Counter first, second;
    set_log_callback(Counter::count, &first);
    together([&](int i) {
        for (int k = 0; k < 500; ++k) {
            if (i == 0 && k == 250) set_log_callback(Counter::count, &second);
            log(LogLevel::Warning, "from a thread");
        }
    });
    set_log_callback(nullptr, nullptr);
    EXPECT_EQ(first.seen + second.seen, kThreads * 500);
    EXPECT_GE(second.seen, 250);
}

}  // namespace
}  // namespace tilth
