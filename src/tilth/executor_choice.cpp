#include "tilth/executor_choice.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "tilth/deform/deformer.h"
#include "tilth/gl/api.h"
#include "tilth/ground/cpu_executor.h"

namespace tilth {
namespace {

constexpr std::int32_t kMapPosts = 256;
constexpr int kSamples = 9;

template <class Work>
double best_us(const gl::Device& device, const Work& work) {
    double best = 1e30;
    for (int sample = 0; sample < kSamples; ++sample) {
        device.gl().Finish();
        const auto start = std::chrono::steady_clock::now();
        work();
        device.gl().Finish();
        const std::chrono::duration<double, std::micro> passed = std::chrono::steady_clock::now() - start;
        if (sample > 0) best = std::min(best, passed.count());  // the first one compiles and allocates
    }
    return best;
}

}  // namespace

std::string ExecutorTimes::reason() const {
    return text(gpu_is_faster() ? "gpu" : "cpu", ": a stamp of 64 x 64 texels took ", std::lround(gpu_us),
                " us by gpu and ", std::lround(cpu_us), " us by cpu at start");
}

Result<ExecutorTimes> measure_executors(gl::Device& device, gl::ShaderLibrary& shaders, HeightPrecision precision) {
    const ShapeLibrary shapes;
    const MapGeometry map{.kind = MapKind::Coarse,
                          .grid = {.spacing_m = 1, .width = kMapPosts, .depth = kMapPosts},
                          .codec = HeightCodec::for_range(0, 100),
                          .precision = precision};
    const std::int64_t middle = std::int64_t{kMapPosts / 2} << 24;
    const StampRecord record{
        .centre_x = middle, .centre_z = middle, .radius = 32u << 18, .amplitude = 1u << 20, .key = 1};
    const PreparedStamp stamp = prepare(record, map, shapes);

    HeightField field(kMapPosts, kMapPosts);
    Result<HeightPlanes> planes = HeightPlanes::create(device, kMapPosts, kMapPosts, precision);
    if (!planes) return planes.error();
    gl::TransferStats transfer;
    planes->upload(field, field.rect(), transfer);
    Result<Deformer> deformer = Deformer::create(device, shaders);
    if (!deformer) return deformer.error();

    gl::StageStats stats;
    const DeformStamp for_gpu{.prepared = stamp};
    if (const Result<void> works = deformer->apply({&for_gpu, 1}, *planes, stats); !works) return works.error();
    ExecutorTimes times;
    times.gpu_us = best_us(device, [&] { static_cast<void>(deformer->apply({&for_gpu, 1}, *planes, stats).ok()); });
    times.cpu_us = best_us(device, [&] { planes->upload(field, apply_stamp(stamp, field).rect, transfer); });
    return times;
}

}  // namespace tilth
