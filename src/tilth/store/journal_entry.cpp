#include "tilth/store/journal_entry.h"

#define XXH_INLINE_ALL  // no global XXH symbol leaves the library
#include <xxhash.h>

#include <algorithm>
#include <cstdint>

#include "tilth/store/byte_fields.h"

namespace tilth {
namespace {

// Where the fields lie; FORMATS.md draws it.
enum Place : std::size_t {
    kSequence = 0,
    kCentreX = 8,
    kCentreZ = 16,
    kShapeHash = 24,
    kShape = 32,
    kRadius = 36,
    kAmplitude = 40,
    kLevel = 44,
    kRotation = 48,
    kKey = 52,
    kMap = 56,
    kRule = 57,
    kFlags = 58,
    kKind = 59,
    kChecksum = 60,
};
static_assert(kChecksum + sizeof(std::uint32_t) == kJournalEntryBytes);

enum Flag : std::uint8_t { kNegative = 1, kMirror = 2, kBeginsStroke = 4, kAllFlags = 7 };

// Kinds on disk begin at one, so that what was never written is none.
constexpr std::uint8_t byte_of(EditKind kind) { return static_cast<std::uint8_t>(static_cast<int>(kind) + 1); }

std::uint32_t checksum(std::span<const std::byte, kJournalEntryBytes> bytes, std::uint64_t number, std::uint64_t salt) {
    const std::uint64_t seed = salt + number * 0x9e37'79b9'7f4a'7c15u;  // odd: another number is another seed
    return static_cast<std::uint32_t>(XXH3_64bits_withSeed(bytes.data(), kChecksum, seed));
}

}  // namespace

JournalBytes encode_entry(const Edit& edit, std::uint64_t number, std::uint64_t salt) {
    JournalBytes bytes{};
    const StampRecord& record = edit.record;
    put_field(bytes, kSequence, record.sequence);
    std::uint8_t flags = edit.begins_stroke ? kBeginsStroke : 0;
    if (edit.kind == EditKind::Stamp) {
        put_field(bytes, kCentreX, record.centre_x);
        put_field(bytes, kCentreZ, record.centre_z);
        put_field(bytes, kShapeHash, record.shape_hash);
        put_field(bytes, kShape, record.shape);
        put_field(bytes, kRadius, record.radius);
        put_field(bytes, kAmplitude, record.amplitude);
        put_field(bytes, kLevel, record.level);
        put_field(bytes, kRotation, record.rotation);
        put_field(bytes, kKey, record.key);
        put_field(bytes, kMap, static_cast<std::uint8_t>(record.map));
        put_field(bytes, kRule, static_cast<std::uint8_t>(record.rule));
        flags |= record.negative != 0 ? kNegative : 0;
        flags |= record.mirror != 0 ? kMirror : 0;
    }
    put_field(bytes, kFlags, flags);
    put_field(bytes, kKind, byte_of(edit.kind));
    put_field(bytes, kChecksum, checksum(bytes, number, salt));
    return bytes;
}

std::optional<Edit> decode_entry(std::span<const std::byte, kJournalEntryBytes> bytes, std::uint64_t number,
                                 std::uint64_t salt) {
    const auto kind = get_field<std::uint8_t>(bytes, kKind), flags = get_field<std::uint8_t>(bytes, kFlags);
    const auto map = get_field<std::uint8_t>(bytes, kMap), rule = get_field<std::uint8_t>(bytes, kRule);
    if (kind < byte_of(EditKind::Stamp) || kind > byte_of(EditKind::Redo)) return std::nullopt;
    if (flags > kAllFlags || map > static_cast<std::uint8_t>(MapKind::Detail) ||
        rule > static_cast<std::uint8_t>(StampRule::Smooth))
        return std::nullopt;
    if (get_field<std::uint32_t>(bytes, kChecksum) != checksum(bytes, number, salt)) return std::nullopt;

    Edit edit{.kind = static_cast<EditKind>(kind - 1), .begins_stroke = (flags & kBeginsStroke) != 0, .record = {}};
    StampRecord& record = edit.record;
    record.sequence = get_field<std::uint64_t>(bytes, kSequence);
    if (edit.kind != EditKind::Stamp) {
        const auto nothing = bytes.subspan<kCentreX, kFlags - kCentreX>();
        const bool is_zero = std::all_of(nothing.begin(), nothing.end(), [](std::byte b) { return b == std::byte{}; });
        if (!is_zero || (flags & ~kBeginsStroke) != 0) return std::nullopt;
        return edit;
    }
    record.centre_x = get_field<std::int64_t>(bytes, kCentreX);
    record.centre_z = get_field<std::int64_t>(bytes, kCentreZ);
    record.shape_hash = get_field<std::uint64_t>(bytes, kShapeHash);
    record.shape = get_field<std::uint32_t>(bytes, kShape);
    record.radius = get_field<std::uint32_t>(bytes, kRadius);
    record.amplitude = get_field<std::uint32_t>(bytes, kAmplitude);
    record.level = get_field<std::uint32_t>(bytes, kLevel);
    record.rotation = get_field<std::uint32_t>(bytes, kRotation);
    record.key = get_field<std::uint32_t>(bytes, kKey);
    record.map = static_cast<MapKind>(map);
    record.rule = static_cast<StampRule>(rule);
    record.negative = (flags & kNegative) != 0;
    record.mirror = (flags & kMirror) != 0;
    return edit;
}

}  // namespace tilth
