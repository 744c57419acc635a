// The ground of one world on the CPU: original heights, codes of both maps, stamps, queries and hashes. No GL.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/core/vec.h"
#include "tilth/ground/apply_result.h"
#include "tilth/ground/detail_field.h"
#include "tilth/ground/height_field.h"
#include "tilth/ground/map_geometry.h"
#include "tilth/ground/shape_library.h"
#include "tilth/ground/stamp.h"
#include "tilth/source/height_source.h"
#include "tilth/world/grid.h"
#include "tilth/world/height_codec.h"

namespace tilth {

/// How a world is laid out. Fixed when the world is created.
struct GroundSettings {
    WorldPos origin;                   ///< of post (0, 0), metres; finite, at most 1e9 from zero
    double spacing_m = 1.0;            ///< between posts, > 0
    std::optional<double> quantum_m;   ///< of the coarse high plane; a power of two; default by range
    bool mirror = false;               ///< the source repeated by reflection to 2^20 x 2^20 posts;
                                       ///< such a world takes no coarse stamps
    bool detail = true;                ///< a detail map exists
    std::int32_t texels_per_post = 3;  ///< detail texels per post spacing, 1..64
    std::int32_t tile_size = 2048;     ///< detail texels a tile, a multiple of 64 in 64..8192
    HeightPrecision precision = HeightPrecision::bits32;
};

/// Which maps a query reads.
enum class MapSelect : std::uint8_t { Sum, Coarse, Detail };

struct StateHash {
    std::uint64_t coarse = 0, detail = 0;
    friend bool operator==(const StateHash&, const StateHash&) = default;
};

/// The ground of one world.
///
/// Persistent edits are integer arithmetic on height codes: no drift, additive stamps commute, a log of records
/// replays to the same bits on any machine, with or without a GPU. This class is the CPU executor's side; it is all
/// that a dedicated server needs.
/// Units: metres, world space, +y up. Threads: one at a time for anything that changes it; const calls may run
/// together. Memory: four bytes a post (two with bits16) once; detail 16 KiB per touched 64 x 64 page. A mirrored
/// world: the source's posts only.
class Ground {
public:
    /// Fails on settings out of range (the message names the field) and on sources whose heights do not fit
    /// `quantum_m`.
    static Result<std::unique_ptr<Ground>> create(std::shared_ptr<const HeightSource> source,
                                                  const GroundSettings& settings);

    [[nodiscard]] const GroundSettings& settings() const { return settings_; }
    [[nodiscard]] const MapGeometry& map(MapKind kind) const {
        return kind == MapKind::Coarse ? coarse_map_ : detail_map_;
    }
    [[nodiscard]] ShapeLibrary& shapes() { return shapes_; }
    [[nodiscard]] const ShapeLibrary& shapes() const { return shapes_; }

    /// Checks a request, settles its map and key and gives it the next sequence number. Touches no height.
    /// Fails with `InvalidArgument` and the field's name; the sequence number is then not used.
    Result<StampRecord> issue(const StampRequest& request);

    /// The map that a request goes to: `Auto` is coarse from a radius of eight posts on, else detail where there is
    /// one.
    [[nodiscard]] MapKind settled_map(const StampRequest& request) const;

    /// Checks a record that was made earlier or elsewhere (a log, another machine, `negated`) against this world: its
    /// map, rule, ranges, and that its shape has the same data here. Later sequence numbers continue behind it. Fails
    /// with `InvalidArgument` and the field's name.
    Result<void> accept(const StampRecord& record);

    /// The number that the next record issued gets.
    [[nodiscard]] std::uint64_t next_sequence() const { return next_sequence_; }
    /// The next record issued gets `sequence` or a later number: a world that was saved goes on counting.
    void continue_from(std::uint64_t sequence) { next_sequence_ = std::max(next_sequence_, sequence); }

    /// Applies one record on the CPU. Cost: about 3 ns a texel with AVX2. The record was issued or accepted by this
    /// ground; another is the caller's mistake and stops the program.
    ApplyResult apply(const StampRecord& record);

    /// Height of the surface at `at`, metres: each map interpolated linearly on cells split along the diagonal from
    /// (i, j) to (i + 1, j + 1). Outside the map the border's height continues. NaN in, NaN out.
    [[nodiscard]] double height_m(WorldPos at, MapSelect select = MapSelect::Sum) const;

    /// Original height of a coarse post, metres, as its code holds it.
    [[nodiscard]] double original_height_m(Texel post) const;
    /// Its code, before any stamp. `post` is clamped to the map.
    [[nodiscard]] std::uint32_t original_code(Texel post) const;
    /// The same as a function that may outlive this object and be called on any thread.
    [[nodiscard]] std::function<std::uint32_t(Texel)> original_codes() const;

    /// XXH3-64 of both maps, of 32-bit little-endian words (`bits16`: code << 16). Coarse: all codes, row by row; in a
    /// mirrored world those of the source. Detail: every 64 x 64 page whose codes are not all 2^31, touched or not, in
    /// the order of (tile z, tile x, page z, page x), each as those four indices in 64 bits, pages counted within the
    /// tile, and its codes. Costs one pass over all codes.
    [[nodiscard]] StateHash hash() const;
    /// The coarse part alone.
    [[nodiscard]] std::uint64_t coarse_hash() const;

    /// Coarse codes: the base level of everything. In a mirrored world those of the source's own posts.
    [[nodiscard]] const HeightField& coarse() const { return coarse_; }
    [[nodiscard]] const DetailField& detail() const { return detail_; }
    /// For executors and read-backs that write codes themselves.
    [[nodiscard]] HeightField& mutable_coarse() { return coarse_; }
    [[nodiscard]] DetailField& mutable_detail() { return detail_; }

    /// The code of any coarse post of the world, mirrored worlds included. `post` is clamped to the map.
    [[nodiscard]] std::uint32_t coarse_code(Texel post) const;

    [[nodiscard]] std::uint64_t bytes() const;

private:
    [[nodiscard]] Result<void> check(const StampRecord& record) const;
    Ground(std::shared_ptr<const HeightSource> source, const GroundSettings& settings, MapGeometry coarse_map,
           MapGeometry detail_map);

    std::shared_ptr<const HeightSource> source_;
    GroundSettings settings_;
    MapGeometry coarse_map_, detail_map_;
    ShapeLibrary shapes_;
    HeightField coarse_;
    DetailField detail_;
    std::uint64_t next_sequence_ = 1;
};

}  // namespace tilth
