// From a scenario's [terrain] to a living world.
#pragma once

#include <memory>
#include <string>

#include "demo/scenario/problems.h"
#include "demo/scenario/scenario.h"
#include "tilth/source/height_source.h"
#include "tilth/terrain.h"

namespace tilth::demo {

/// Original heights from a file or a procedural specification. No GL; reading a large file takes seconds.
Result<std::shared_ptr<const HeightSource>> load_heights(const std::string& heights);

/// The same, with the scenario's line on failure.
std::shared_ptr<const HeightSource> load_heights(const TerrainPart& terrain, Problems& problems);

/// The world, with memory for undo and its stamp images loaded. With `get_proc` null it has no GL. What the library
/// refuses is reported at the line of the key that its message names, else at [terrain].
std::unique_ptr<Terrain> open_world(const TerrainPart& terrain, std::shared_ptr<const HeightSource> heights,
                                    const std::string& stamp_folder, gl::GetProc get_proc, Problems& problems);

}  // namespace tilth::demo
