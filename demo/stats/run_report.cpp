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

Json cache_json(const gl::CacheStats& c) {
    return {{"loads", c.loads},
            {"saves", c.saves},
            {"evictions", c.evictions},
            {"rescues", c.rescues},
            {"cancelled", c.cancelled},
            {"failures", c.failures},
            {"late_stamps", c.late_stamps},
            {"missing_active", c.missing_active},
            {"transfer_ms", c.transfer_ms}};
}

Json store_json(const gl::StoreStats& s) {
    return {{"snapshots", s.snapshots},
            {"compactions", s.compactions},
            {"failures", s.failures},
            {"snapshot_ms", s.snapshot_ms}};
}

Json world_json(const WorldReport& w) {
    return {{"edits", w.edits},
            {"durable", w.durable},
            {"committed", w.committed},
            {"journal_bytes", w.journal_bytes},
            {"page_bytes", w.page_bytes}};
}

Json number_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json walk_json(const WalkStats& w) {
    return {{"missing_frames", w.missing_frames},
            {"smallest_lead_m", number_or_null(w.smallest_lead_m)},
            {"smallest_lead_ms", number_or_null(w.smallest_lead_ms)}};
}

/// Of walks if there were any, else of all timed frames: the first frames of a run compile what they need. 1 when all
/// frames took the same; nothing when none was timed.
std::optional<double> longest_over_median(const RunReport& r) {
    const std::vector<double>& ms = r.walk_frames.wall_ms.empty() ? r.frames.wall_ms : r.walk_frames.wall_ms;
    const double median = percentile(ms, 0.5);
    if (!(median > 0)) return {};
    return percentile(ms, 1) / median;
}

Json stats_json(const gl::FrameStats& f) {
    return {{"deform", stage_json(f.deform)},
            {"derive", stage_json(f.derive)},
            {"mips", stage_json(f.mips)},
            {"render", stage_json(f.render)},
            {"cache", cache_json(f.cache)},
            {"store", store_json(f.store)},
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
    Json json{
        {"tilth", TILTH_VERSION},
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
        {"walk", walk_json(r.walk)},
        {"cache", {{"longest_frame_over_median", number_or_null(longest_over_median(r))}}},
        {"resident",
         {{"tiles", r.tiles}, {"tile_bytes", r.tile_bytes}, {"gpu_bytes", r.gpu_bytes}, {"cpu_bytes", r.cpu_bytes}}},
        {"queries", r.queries},
        {"failures", r.failures}};
    if (r.world) json["world"] = world_json(*r.world);
    return json;
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
    RunReport measured;  // with everything that some runs do not measure
    measured.frames = {{1}, {1}};
    measured.world.emplace();
    measured.walk.smallest_lead_m = measured.walk.smallest_lead_ms = 1;
    const std::optional<Json> value = value_at(to_json(measured), path);
    return value && (value->is_number() || value->is_string());
}

}  // namespace tilth::demo
