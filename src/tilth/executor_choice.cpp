#include "tilth/executor_choice.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "tilth/deform/deformer.h"
#include "tilth/derive/slope_pass.h"
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
    return text(gpu_is_faster() ? "gpu" : "cpu", ": a stamp of 64 x 64 texels and its slopes took ",
                std::lround(gpu_us), " us by gpu and ", std::lround(cpu_us), " us by cpu at start");
}

Result<ExecutorTimes> measure_executors(gl::Device& device, gl::ShaderLibrary& shaders, HeightPrecision precision,
                                        SlopeFormat slopes) {
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
    Result<SlopeMap> slope_map = SlopeMap::create(device, kMapPosts, kMapPosts, slopes);
    if (!slope_map) return slope_map.error();
    const SlopeSettings slope_settings{SlopeStencil::Central, map.codec.code_quantum_m(), map.grid.spacing_m};
    Result<SlopePass> slope_pass = SlopePass::create(device, shaders, precision, slopes, slope_settings);
    if (!slope_pass) return slope_pass.error();

    gl::StageStats stats;
    const DeformStamp for_gpu{.prepared = stamp};
    const TexelRect changed = stamp.rect();
    Result<void> works;
    ExecutorTimes times;
    times.gpu_us = best_us(device, [&] {
        if (works) works = deformer->apply({&for_gpu, 1}, *planes, stats);
        slope_pass->run({&changed, 1}, *planes, *slope_map, stats, stats);
    });
    if (!works) return works.error();
    times.cpu_us = best_us(device, [&] {
        apply_stamp(stamp, field);
        planes->upload(field, changed, transfer);
        upload_slopes({&changed, 1}, field, slope_settings, *slope_map, stats, stats, transfer);
    });
    return times;
}

}  // namespace tilth
