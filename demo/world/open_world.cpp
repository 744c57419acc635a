#include "demo/world/open_world.h"

#include <filesystem>

#include "demo/world/stamp_folder.h"
#include "tilth/io/height_file.h"
#include "tilth/source/source_spec.h"

namespace tilth::demo {

namespace {

/// Members of `TerrainSettings` that a scenario calls by another name.
struct Renamed {
    const char* member;
    const char* key;
};
constexpr Renamed kRenamed[] = {
    {"most_gpu_bytes", "tile_memory"}, {"frame_target_ms", "budget"}, {"most_ms", "budget"}, {"most_bytes", "budget"}};

/// Memory for undo, so that an evening's strokes can be taken back.
constexpr std::uint64_t kUndoBytes = 256u << 20;

constexpr std::size_t kLongestNote = 1000;

/// Where the heights come from, as the world on disk remembers it.
std::string note_of(const std::string& heights) {
    if (is_procedural(heights)) return heights;
    std::error_code error;
    const std::filesystem::path whole = std::filesystem::absolute(heights, error);
    const std::string path = whole.lexically_normal().string();
    return !error && path.size() <= kLongestNote ? path : whole.filename().string().substr(0, kLongestNote);
}

/// The key that a message of the library speaks of, e.g. "quantum_m" -> "quantum". What a world's folder has to say
/// begins with its path.
std::string key_in(const std::string& message, const TerrainPart& terrain) {
    const std::string& folder = terrain.settings.world.folder;
    if (!folder.empty() && message.starts_with(folder)) return terrain.lines.contains("store") ? "store" : "--store";
    if (message.starts_with("detail.backend")) return terrain.lines.contains("backend") ? "backend" : "--backend";
    if (message.starts_with("detail.phong")) return "phong";
    for (const Renamed& renamed : kRenamed)
        if (terrain.lines.contains(renamed.key) && message.find(renamed.member) != std::string::npos)
            return renamed.key;
    for (const auto& [key, line] : terrain.lines)
        if (message.find(key) != std::string::npos) return key;
    return "terrain";
}

}  // namespace

Result<std::shared_ptr<const HeightSource>> load_heights(const std::string& heights) {
    auto source = is_procedural(heights) ? make_source(heights) : io::read_heights(heights);
    if (!source) return source.error();
    return std::shared_ptr<const HeightSource>(std::move(*source));
}

std::shared_ptr<const HeightSource> load_heights(const TerrainPart& terrain, Problems& problems) {
    auto source = load_heights(terrain.heights);
    if (source) return *source;
    const auto line = terrain.lines.find("heights");
    problems.add(line == terrain.lines.end() ? terrain.line : line->second, "heights", source.error().message);
    return nullptr;
}

std::unique_ptr<Terrain> open_world(const TerrainPart& terrain, std::shared_ptr<const HeightSource> heights,
                                    const std::string& stamp_folder, gl::GetProc get_proc, Problems& problems) {
    TerrainSettings settings = terrain.settings;
    settings.undo_bytes = kUndoBytes;
    settings.world.options.heights = note_of(terrain.heights);
    auto world = Terrain::create(std::move(heights), settings, get_proc);
    if (!world) {
        const std::string key = key_in(world.error().message, terrain);
        const auto line = terrain.lines.find(key);
        problems.add(line == terrain.lines.end() ? terrain.line : line->second, key, world.error().message);
        return nullptr;
    }
    if (const auto added = add_stamps(stamp_folder, (*world)->shapes()); !added) {
        problems.add(terrain.line, "stamps", added.error().message);
        return nullptr;
    }
    return std::move(*world);
}

}  // namespace tilth::demo
