#include "support/bench_device.h"

#include <algorithm>

#include "tilth/core/hash.h"

namespace tilth::bench {
namespace {

struct Shared {
    context::OffscreenContext context;
    std::unique_ptr<gl::Device> device;
    std::unique_ptr<gl::ShaderLibrary> shaders;
};

Shared& shared() {
    static Shared* const made = [] {
        const char* name = std::getenv("TILTH_TEST_CONTEXT");
        const context::Route route = value(context::route_of(name != nullptr ? name : "egl"));
        auto* fresh = new Shared{value(context::OffscreenContext::create(route)), nullptr, nullptr};
        fresh->device = value(gl::Device::create(fresh->context.get_proc()));
        fresh->shaders = std::make_unique<gl::ShaderLibrary>(*fresh->device);
        return fresh;
    }();
    return *made;
}

double timed_ms(gl::GpuTimer& timer, const std::function<void()>& work) {
    timer.begin();
    work();
    timer.end();
    const std::vector<double> samples = timer.finish_samples_ms();
    return samples.empty() ? 0 : samples.back();
}

}  // namespace

gl::Device& device() { return *shared().device; }
gl::GetProc get_proc() { return shared().context.get_proc(); }
gl::ShaderLibrary& shaders() { return *shared().shaders; }
void make_current() { check(shared().context.make_current()); }

Percentiles percentiles_of(std::vector<double> samples) {
    if (samples.empty()) return {};
    std::sort(samples.begin(), samples.end());
    const auto at = [&](double share) {
        return samples[static_cast<std::size_t>(share * static_cast<double>(samples.size() - 1))];
    };
    return {at(0.50), at(0.95)};
}

Pair::Pair() : timer_(value(gl::GpuTimer::create(device(), "benchmark", gl::TimerPolicy::MayFinish))) {}

void Pair::run(benchmark::State& state, const std::function<void()>& subject, const std::function<void()>& floor) {
    floor_ms_.push_back(timed_ms(timer_, floor));
    subject_ms_.push_back(timed_ms(timer_, subject));
    state.SetIterationTime(subject_ms_.back() / 1000);
}

void Pair::report(benchmark::State& state, const char* floor_name) const {
    const Percentiles subject = percentiles_of(subject_ms_), floor = percentiles_of(floor_ms_);
    state.counters["p50_ms"] = subject.p50;
    state.counters["p95_ms"] = subject.p95;
    state.counters[std::string(floor_name) + "_p50_ms"] = floor.p50;
    state.counters[std::string(floor_name) + "_p95_ms"] = floor.p95;
    state.counters["ratio"] = floor.p50 > 0 ? subject.p50 / floor.p50 : 0;
}

Single::Single() : timer_(value(gl::GpuTimer::create(device(), "benchmark", gl::TimerPolicy::MayFinish))) {}

void Single::run(benchmark::State& state, const std::function<void()>& subject) {
    samples_ms_.push_back(timed_ms(timer_, subject));
    state.SetIterationTime(samples_ms_.back() / 1000);
}

void Single::report(benchmark::State& state) const {
    const Percentiles subject = percentiles_of(samples_ms_);
    state.counters["p50_ms"] = subject.p50;
    state.counters["p95_ms"] = subject.p95;
}

void report_hash(benchmark::State& state, std::uint64_t hash) {
    state.SetLabel("hash " + hex16(hash));
    state.counters["hash_low32"] = static_cast<double>(hash & 0xffffffffu);
}

}  // namespace tilth::bench
