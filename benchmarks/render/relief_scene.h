// The reference configuration with dents in it: the ground, the walk and the stamps of all benchmarks of detail
// backends.
//
// As demo/scenarios/reference.toml: 4 096 x 4 096 posts 0.1 m apart with 40 m of relief, texels of 1/30 m in tiles of
// 2 048, clipmap n = 255 with 5 levels. The walk is that of the reference paper's own implementation: 60 m across the
// corner of four tiles, eye 2 m above ground, 90 degrees; as there each of the four tiles has 40 stamps within 12 m of
// the way, 20 footprints of 1 m and 20 gaussians of 1 to 4 m. The walker's own boot prints come on top.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "render/support/trail.h"
#include "tilth/ground/shape_library.h"
#include "tilth/source/ridged_source.h"
#include "tilth/terrain.h"

namespace tilth::bench {

enum class Dents : std::uint8_t {
    None,   ///< untouched ground
    Trail,  ///< 80 prints and 40 stamps a tile
    Dense,  ///< and 400 more gaussians a tile: detail nearly everywhere about the way
};
const char* name_of(Dents dents);

constexpr std::int32_t kReferencePosts = 4096;
constexpr double kReferenceSpacing_m = 0.1;
constexpr double kTileWidth_m = 2048 * kReferenceSpacing_m / 3;

std::shared_ptr<const HeightSource> reference_heights();
/// Executor cpu. `shader_folder`: empty for the tree's own shaders.
std::unique_ptr<Terrain> reference_terrain(std::string shader_folder = {});

/// The shape that the prints have; the same id in every library without other shapes.
ShapeId bake_boot(ShapeLibrary& shapes);
/// All stamps, for the detail map.
std::vector<StampRequest> dents_of(Dents dents, ShapeId boot);
void make_dents(Terrain& terrain, Dents dents);

/// Where the walk is after `share` (0..1) of its 60 m.
WorldPos walk_place(double share);
/// The view there, 2 m above the coarse ground; `terrain` or anything that has a `Ground`. Without a size.
View walk_view(const Ground& ground, WorldPos place);

/// The terrain's whole state.
std::uint64_t hash_of(Terrain& terrain);

/// A copy of the library's shaders with the files below benchmarks/render/shaders/`name` in their place; a folder that
/// is deleted with this.
class ShaderOverlay {
public:
    explicit ShaderOverlay(const std::string& name);
    ~ShaderOverlay();
    ShaderOverlay(const ShaderOverlay&) = delete;
    ShaderOverlay& operator=(const ShaderOverlay&) = delete;
    [[nodiscard]] const std::string& folder() const { return folder_; }

private:
    std::string folder_;
};

}  // namespace tilth::bench
