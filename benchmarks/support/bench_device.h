// The context that all benchmarks share, and how they take time.
#pragma once

#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tilth/context/offscreen_context.h"
#include "tilth/gl/api.h"
#include "tilth/gl/device.h"
#include "tilth/gl/shader_library.h"
#include "tilth/gl/timer.h"

namespace tilth::bench {

/// The value of `result`; a failed one ends the program with its message: a benchmark has nobody to hand it to.
template <class T>
T value(Result<T> result) {
    if (!result) {
        std::fprintf(stderr, "tilth-bench: %s\n", result.error().message.c_str());
        std::exit(1);
    }
    return *std::move(result);
}
inline void check(const Result<void>& result) {
    if (result) return;
    std::fprintf(stderr, "tilth-bench: %s\n", result.error().message.c_str());
    std::exit(1);
}

/// One context for the whole run: EGL, or what TILTH_TEST_CONTEXT names.
gl::Device& device();
gl::GetProc get_proc();
gl::ShaderLibrary& shaders();
/// Where something else had a context of its own.
void make_current();

/// Median and percentiles of a list of samples, milliseconds.
struct Percentiles {
    double p50 = 0, p95 = 0;
};
Percentiles percentiles_of(std::vector<double> samples);

/// Times a subject and its floor in turn, so that a noisy neighbour hits both alike. On a GPU by timer queries, on a
/// software renderer by the CPU time of all threads between two glFinish.
class Pair {
public:
    Pair();
    /// One iteration: the floor, then the subject; the subject's time becomes the iteration's.
    void run(benchmark::State& state, const std::function<void()>& subject, const std::function<void()>& floor);
    /// Counters: p50, p95 of both in milliseconds and their ratio (medians).
    void report(benchmark::State& state, const char* floor_name) const;
    [[nodiscard]] Percentiles subject() const { return percentiles_of(subject_ms_); }

private:
    gl::GpuTimer timer_;
    std::vector<double> subject_ms_, floor_ms_;
};

/// Times a subject alone; for CPU code too.
class Single {
public:
    Single();
    void run(benchmark::State& state, const std::function<void()>& subject);
    void report(benchmark::State& state) const;
    [[nodiscard]] Percentiles subject() const { return percentiles_of(samples_ms_); }

private:
    gl::GpuTimer timer_;
    std::vector<double> samples_ms_;
};

/// Puts a state hash into the row: all of it as the label, its low 32 bits as a counter (a double holds those exactly).
void report_hash(benchmark::State& state, std::uint64_t hash);

}  // namespace tilth::bench
