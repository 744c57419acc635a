#include <charconv>
#include <cmath>

#include "demo/scenario/names.h"
#include "demo/scenario/read_parts.h"
#include "tilth/source/source_spec.h"

namespace tilth::demo {

namespace {

bool is_power_of_two(double value) {
    int exponent = 0;
    return std::frexp(value, &exponent) == 0.5;
}

void read_heights(TableReader& reader, const std::filesystem::path& folder, TerrainPart& terrain) {
    const char* const allowed = "a file's path or ridged:..., flat:..., hill:...";
    const std::string heights = reader.required_string("heights", allowed);
    if (heights.empty()) return;
    if (is_procedural(heights)) {
        terrain.heights = heights;
        return;
    }
    const std::filesystem::path path = folder / heights;
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
        reader.wrong("heights", text("no such file: ", path.string(), "; allowed: ", allowed));
    terrain.heights = path.string();
}

void read_ground(TableReader& reader, GroundSettings& ground) {
    ground.mirror = reader.boolean("mirror").value_or(false);
    ground.spacing_m = reader.number("spacing", {1e-4, 1e5, false, "metres from 0.0001 to 100000"}).value_or(1.0);
    const Range origin{-1e9, 1e9, false, "metres within 1e9 of zero"};
    if (const auto at = reader.numbers("origin", 2, 2, origin)) ground.origin = {(*at)[0], (*at)[1]};
    const Range quantum{std::ldexp(1.0, -40), std::ldexp(1.0, 20), false, "a power of two from 2^-40 to 2^20 metres"};
    if (const auto value = reader.number("quantum", quantum)) {
        if (is_power_of_two(*value))
            ground.quantum_m = value;
        else
            reader.wrong("quantum", text("is ", *value, "; allowed: ", quantum.text));
    }
    ground.detail = reader.boolean("detail").value_or(true);
    ground.texels_per_post = static_cast<std::int32_t>(reader.integer("texels_per_post", 1, 64).value_or(3));
    if (const auto size = reader.integer("tile_size", 64, 16384)) {
        if (*size % 64 == 0)
            ground.tile_size = static_cast<std::int32_t>(*size);
        else
            reader.wrong("tile_size", text("is ", *size, "; allowed: a multiple of 64 from 64 to 16384"));
    }
    if (const auto bits = reader.choice("precision", kPrecisionNames))
        ground.precision = *bits == 0 ? HeightPrecision::bits32 : HeightPrecision::bits16;
}

void read_budget(TableReader& reader, BudgetSettings& budget) {
    const toml::table* table = reader.table("budget", "a table { target_ms, most_ms, most_bytes }");
    if (table == nullptr) return;
    TableReader inner(*table, "budget", reader.line_of("budget"), reader.problems());
    const Range ms{0, 1e6, true, "milliseconds above 0, at most 1e6"};
    budget.frame_target_ms = inner.number("target_ms", ms).value_or(budget.frame_target_ms);
    budget.most_ms = inner.number("most_ms", ms).value_or(budget.most_ms);
    if (const auto bytes = inner.integer("most_bytes", 1, std::int64_t{1} << 40))
        budget.most_bytes = static_cast<std::uint64_t>(*bytes);
    inner.finish();
}

void read_tiles(TableReader& reader, TileSettings& tiles) {
    tiles.band = reader.number("band", {0.02, 0.9, false, "a share of a tile from 0.02 to 0.9"}).value_or(tiles.band);
    read_budget(reader, tiles.budget);
    if (const auto bytes = reader.integer("tile_memory", 1, std::int64_t{1} << 50))
        tiles.most_gpu_bytes = static_cast<std::uint64_t>(*bytes);
}

/// The number in "<number>ms", digits and a point alone.
std::optional<double> milliseconds_of(std::string_view value) {
    if (!value.ends_with("ms")) return {};
    value.remove_suffix(2);
    double ms = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), ms, std::chars_format::fixed);
    if (error != std::errc{} || end != value.data() + value.size()) return {};
    return ms;
}

void read_flush(TableReader& reader, FlushPolicy& flush) {
    const char* const allowed = "\"each\", \"manual\" or \"<milliseconds>ms\", from 0.1 to 60000, as in \"5ms\"";
    flush.when = FlushPolicy::When::Each;
    const auto value = reader.string("flush", allowed);
    if (!value || *value == "each") return;
    const std::optional<double> ms = milliseconds_of(*value);
    if (*value == "manual") {
        flush.when = FlushPolicy::When::Manual;
    } else if (ms && *ms >= 0.1 && *ms <= 60'000) {
        flush = {.when = FlushPolicy::When::Every, .interval_ms = *ms};
    } else {
        reader.wrong("flush", text("is another word, or out of range; allowed: ", allowed));
    }
}

void read_world(TableReader& reader, const std::filesystem::path& folder, WorldSettings& world) {
    if (const auto store = reader.string("store", "a folder's path"))
        world.folder = without_last_slash((folder / *store).string());
    read_flush(reader, world.options.flush);
}

}  // namespace

std::string without_last_slash(std::string folder) {
    while (folder.size() > 1 && folder.back() == '/') folder.pop_back();
    return folder;
}

void read_terrain(TableReader& reader, const std::filesystem::path& folder, TerrainPart& terrain) {
    terrain.line = reader.line();
    read_heights(reader, folder, terrain);
    read_ground(reader, terrain.settings.ground);
    read_tiles(reader, terrain.settings.tiles);
    if (const auto executor = reader.choice("executor", kExecutorNames))
        terrain.settings.executor = static_cast<ExecutorKind>(*executor);
    if (const auto slopes = reader.choice("slopes", kSlopeNames))
        terrain.settings.slopes = *slopes == 0 ? SlopeFormat::rg8 : SlopeFormat::rg16f;
    reader.empty_list("effects", "effects");
    read_world(reader, folder, terrain.settings.world);
    for (const char* key :
         {"heights", "mirror", "spacing", "origin", "quantum", "detail", "texels_per_post", "tile_size", "precision",
          "executor", "slopes", "band", "budget", "tile_memory", "store", "flush"})
        if (reader.has(key)) terrain.lines[key] = reader.line_of(key);
    reader.finish();
}

void read_view(TableReader& reader, ViewPart& view, TerrainPart& terrain) {
    ClipmapSettings& clipmap = terrain.settings.clipmap;
    if (const auto size = reader.numbers("size", 2, 2, {1, double(kMaxPictureSide), false, "pixels from 1 to 16384"})) {
        if ((*size)[0] != std::floor((*size)[0]) || (*size)[1] != std::floor((*size)[1]))
            reader.wrong("size", "is not whole; allowed: [width, height], integers from 1 to 16384");
        else
            view.width = static_cast<std::int32_t>((*size)[0]), view.height = static_cast<std::int32_t>((*size)[1]);
    }
    view.fov_degrees = reader.number("fov", {0.1, 175, false, "degrees from 0.1 to 175"}).value_or(view.fov_degrees);
    if (const auto backend = reader.choice("backend", kBackendNames)) {
        view.shown.backend = static_cast<DetailBackend>(*backend);
        terrain.lines["backend"] = reader.line_of("backend");
    }
    if (const auto preset = reader.choice("preset", kPresetNames))
        view.shown.preset = static_cast<DetailPreset>(*preset);
    if (const auto phong = reader.boolean("phong")) {
        view.shown.phong = *phong;
        terrain.lines["phong"] = reader.line_of("phong");
    }
    terrain.settings.detail = settings_of(view.shown);
    if (const auto c = reader.numbers("clear", 3, 3, {0, 1, false, "linear red, green, blue from 0 to 1"}))
        view.clear = {float((*c)[0]), float((*c)[1]), float((*c)[2])};
    view.fog_per_m = reader.number("fog", {0, 10, false, "a density per metre from 0 to 10"}).value_or(0.0);
    if (const auto l = reader.numbers("light", 3, 3, {-1e6, 1e6, false, "x, y, z of a direction towards the light"})) {
        if ((*l)[0] == 0 && (*l)[1] == 0 && (*l)[2] == 0)
            reader.wrong("light", "is [0, 0, 0]; allowed: a direction that is not zero");
        view.to_light = Vec3d{(*l)[0], (*l)[1], (*l)[2]};
    }
    const Range strength{0, 100, false, "a factor on the ground's colour from 0 to 100"};
    view.ambient = reader.number("ambient", strength);
    view.diffuse = reader.number("diffuse", strength);
    if (const auto t = reader.numbers("tint", 2, 2, kHeight)) view.tint_m = {(*t)[0], (*t)[1]};
    if (const toml::table* table = reader.table("clipmap", "a table { n, levels, blend, refine_above_px }")) {
        TableReader inner(*table, "clipmap", reader.line_of("clipmap"), reader.problems());
        if (const auto n = inner.integer("n", 15, 1023)) {
            if (((*n + 1) & *n) == 0)
                clipmap.n = static_cast<std::int32_t>(*n);
            else
                inner.wrong("n", text("is ", *n, "; allowed: 15, 31, 63, 127, 255, 511 or 1023"));
        }
        clipmap.levels = static_cast<std::int32_t>(inner.integer("levels", 1, 16).value_or(clipmap.levels));
        clipmap.blend = inner.number("blend", {0.02, 0.25, false, "a share from 0.02 to 0.25"}).value_or(clipmap.blend);
        const Range pixels{0.1, 1e6, false, "pixels from 0.1 to 1e6"};
        clipmap.refine_above_px = inner.number("refine_above_px", pixels).value_or(clipmap.refine_above_px);
        inner.finish();
    }
    reader.finish();
}

}  // namespace tilth::demo
