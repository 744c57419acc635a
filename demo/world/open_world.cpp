#include "demo/world/open_world.h"

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

/// The key that a message of the library speaks of, e.g. "quantum_m" -> "quantum".
std::string key_in(const std::string& message, const TerrainPart& terrain) {
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
    auto world = Terrain::create(std::move(heights), terrain.settings, get_proc);
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
