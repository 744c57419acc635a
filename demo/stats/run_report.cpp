#include "demo/stats/run_report.h"

#include <charconv>

#include "tilth/core/hash.h"

namespace tilth::demo {

namespace {

Json stage_json(const gl::StageStats& s) {
    return {{"passes", s.passes},       {"draws", s.draws},         {"primitives", s.primitives},
            {"texels", s.texels},       {"bytes", s.bytes},         {"programs", s.programs},
            {"saturated", s.saturated}, {"fallbacks", s.fallbacks}, {"cpu_ms", s.cpu_ms}};
}

Json stats_json(const gl::FrameStats& f) {
    return {{"deform", stage_json(f.deform)},
            {"derive", stage_json(f.derive)},
            {"mips", stage_json(f.mips)},
            {"render", stage_json(f.render)},
            {"cache", {{"loads", 0}, {"evictions", 0}, {"rescues", 0}}},
            {"transfer", {{"bytes_up", f.transfer.bytes_up}, {"bytes_down", f.transfer.bytes_down}}},
            {"effects", {{"wave", {{"passes", 0}, {"texels", 0}, {"bytes", 0}, {"programs", 0}}}}}};
}

Json times_json(const std::vector<double>& ms) {
    return {{"p50", percentile(ms, 0.50)},
            {"p95", percentile(ms, 0.95)},
            {"p99", percentile(ms, 0.99)},
            {"max", percentile(ms, 1.00)}};
}

}  // namespace

Json to_json(const RunReport& r) {
    return {{"tilth", TILTH_VERSION},
            {"context",
             {{"route", r.route},
              {"renderer", r.renderer},
              {"gl", r.gl_version},
              {"executor", r.executor},
              {"executor_reason", r.executor_reason}}},
            {"hash", {{"coarse", hex16(r.hash.coarse)}, {"detail", hex16(r.hash.detail)}}},
            {"frames",
             {{"count", r.frames.cpu_ms.size()},
              {"cpu_ms", times_json(r.frames.cpu_ms)},
              {"wall_ms", times_json(r.frames.wall_ms)}}},
            {"total", stats_json(r.total)},
            {"last_frame", stats_json(r.last_frame)},
            {"resident", {{"tiles", r.tiles}, {"gpu_bytes", r.gpu_bytes}, {"cpu_bytes", r.cpu_bytes}}},
            {"queries", r.queries},
            {"failures", r.failures}};
}

std::optional<Json> value_at(const Json& statistics, std::string_view path) {
    const Json* at = &statistics;
    while (true) {
        const std::size_t dot = path.find('.');
        const std::string name(path.substr(0, dot));
        if (at->is_object()) {
            const auto found = at->find(name);
            if (found == at->end()) return {};
            at = &*found;
        } else if (at->is_array()) {
            std::size_t index = 0;
            const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
            if (error != std::errc{} || end != name.data() + name.size() || index >= at->size()) return {};
            at = &(*at)[index];
        } else {
            return {};
        }
        if (dot == std::string_view::npos) return *at;
        path.remove_prefix(dot + 1);
    }
}

bool has_stat(std::string_view path) {
    if (path.starts_with("queries.")) return true;
    const std::optional<Json> value = value_at(to_json(RunReport{}), path);
    return value && (value->is_number() || value->is_string());
}

}  // namespace tilth::demo
