// What a world keeps in its store beside pages: counters, waiting stamps and strokes, as bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/undo_history.h"
#include "tilth/store/blob_store.h"
#include "tilth/store/snapshot.h"
#include "tilth/world/height_codec.h"

namespace tilth {

// FORMATS.md, "Other blobs", has the bytes. All decoders: `where` begins the message of an error (FileFormat); what
// they allocate is bounded by the size of the blob and by `kMostRawBytes`, whatever the bytes claim.

/// Longest list of records in one blob, before compression.
inline constexpr std::uint64_t kMostRawBytes = 256u << 20;

struct WorldCounters {
    std::uint64_t next_sequence = 1, next_stroke = 1;
    std::vector<std::uint64_t> done, undone;  ///< numbers of strokes, the oldest first
    friend bool operator==(const WorldCounters&, const WorldCounters&) = default;
};

std::vector<std::byte> encode_counters(const WorldCounters& counters);
Result<WorldCounters> decode_counters(std::span<const std::byte> bytes, std::string_view where);

std::vector<std::byte> encode_waiting(std::span<const WaitingStamp> stamps);
Result<std::vector<WaitingStamp>> decode_waiting(std::span<const std::byte> bytes, std::string_view where);

/// A stroke of many images does not fit one blob: it has parts of some megabytes each, the first one always.
std::vector<std::vector<std::byte>> encode_stroke(const Stroke& stroke, HeightPrecision precision);
/// How many parts the stroke has, by its first.
Result<std::uint32_t> parts_of_stroke(std::span<const std::byte> first_part, std::string_view where);
/// `number`: of the stroke that the parts must be of.
Result<StrokePtr> decode_stroke(std::span<const std::vector<std::byte>> parts, std::uint64_t number,
                                std::string_view where);

/// `BlobStore::get`, a second time where the first one could not read (FileRead): a wire may be loose for a moment.
Result<std::optional<std::vector<std::byte>>> get_blob(BlobStore& blobs, BlobKey key);
/// Of an error of `get_blob` or of a decoder: the blob is lost, unless it is made again; an unreadable sector is as bad
/// as a flipped bit.
[[nodiscard]] inline bool is_damage(const Error& error) {
    return error.code == ErrorCode::FileFormat || error.code == ErrorCode::FileRead;
}

// Keys of blobs.

constexpr BlobKey key_of_page(MapKind map, PageIndex page) {
    return {map == MapKind::Coarse ? BlobKind::CoarsePage : BlobKind::DetailPage, page.x, page.z};
}
constexpr BlobKey key_of_waiting(TileIndex tile) { return {BlobKind::Waiting, tile.x, tile.z}; }
inline constexpr BlobKey kCountersKey{BlobKind::World, 0, 0};

/// Strokes are numbered below 2^48; the part is in the bits above.
inline constexpr std::uint64_t kMostStrokeNumber = (std::uint64_t{1} << 48) - 1;
inline constexpr std::uint32_t kMostStrokeParts = 1u << 16;
constexpr BlobKey key_of_stroke(std::uint64_t number, std::uint32_t part) {
    const std::uint64_t whole = (std::uint64_t{part} << 48) | number;
    return {BlobKind::Stroke, static_cast<std::int32_t>(static_cast<std::uint32_t>(whole)),
            static_cast<std::int32_t>(static_cast<std::uint32_t>(whole >> 32))};
}
constexpr std::uint64_t whole_of_stroke_key(BlobKey key) {
    return (std::uint64_t{static_cast<std::uint32_t>(key.z)} << 32) | static_cast<std::uint32_t>(key.x);
}
constexpr std::uint64_t stroke_of_key(BlobKey key) { return whole_of_stroke_key(key) & kMostStrokeNumber; }
constexpr std::uint32_t part_of_key(BlobKey key) { return static_cast<std::uint32_t>(whole_of_stroke_key(key) >> 48); }
static_assert(stroke_of_key(key_of_stroke(0x1234'5678'9abcu, 0xfedc)) == 0x1234'5678'9abcu);
static_assert(part_of_key(key_of_stroke(0x1234'5678'9abcu, 0xfedc)) == 0xfedc);

}  // namespace tilth
