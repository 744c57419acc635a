// tilth-bench: Google Benchmark's own main, with the context's facts in the JSON.
#include <benchmark/benchmark.h>

#include "support/bench_device.h"

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    const tilth::gl::Device& device = tilth::bench::device();
    benchmark::AddCustomContext("renderer", device.capabilities().renderer);
    benchmark::AddCustomContext("gl", device.capabilities().version_text);
    benchmark::AddCustomContext(
        "time", device.quirks().timer_queries_lie ? "CPU time of all threads between two glFinish" : "GL_TIME_ELAPSED");
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
