#include "tilth/store/world_identity.h"

#include <algorithm>
#include <span>
#include <vector>

#include "tilth/core/hash.h"
#include "tilth/store/byte_fields.h"

namespace tilth {
namespace {

constexpr std::uint64_t kMagic = magic_of("TILTH-W\n");
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kLongestNote = 1000;

// Where the fields lie; FORMATS.md draws it.
enum Place : std::size_t {
    kMagicAt = 0,
    kVersionAt = 8,
    kNoteBytes = 12,
    kSalt = 16,
    kOriginalHash = 24,
    kOriginX = 32,
    kOriginZ = 40,
    kSpacing = 48,
    kQuantum = 56,
    kWidth = 64,
    kDepth = 68,
    kTexelsPerPost = 72,
    kTileSize = 76,
    kMirror = 80,
    kDetail = 81,
    kPrecision = 82,
    kZero = 83,  // 5 bytes
    kMiddle = 88,
    kChecksum = 96,
    kNote = 104,
};

std::string path_in(const std::string& folder) { return folder + "/world.tlw"; }

/// Of everything but the checksum itself.
std::uint64_t checksum(std::span<const std::byte> bytes) {
    std::vector<std::byte> all(bytes.begin(), bytes.end());
    put_field(all, kChecksum, std::uint64_t{0});
    return hash_bytes(all);
}

Error differs(const char* field, const std::string& stored, const std::string& given) {
    return {ErrorCode::InvalidArgument,
            text(field, ": the world on disk was made with ", stored, ", it is opened with ", given,
                 "; open it on the ground it was made on, or use another folder")};
}

}  // namespace

WorldIdentity identity_of(const Ground& ground) {
    WorldIdentity identity{.settings = ground.settings(),
                           .width = ground.coarse().width(),
                           .depth = ground.coarse().depth(),
                           .middle_m = ground.map(MapKind::Coarse).codec.middle_m,
                           .original_hash = ground.coarse_hash(),
                           .salt = 0,
                           .heights = {}};
    identity.settings.quantum_m = ground.map(MapKind::Coarse).codec.quantum_m;
    return identity;
}

Result<void> write_identity(FileSystem& files, const std::string& folder, const WorldIdentity& identity) {
    const GroundSettings& s = identity.settings;
    if (identity.heights.size() > kLongestNote)
        return Error{ErrorCode::InvalidArgument,
                     text("heights: a note of ", identity.heights.size(), " bytes; at most 1000 are allowed")};
    if (!s.quantum_m)
        return Error{ErrorCode::InvalidArgument, "quantum: is not settled; take `identity_of` the ground"};
    std::vector<std::byte> bytes(kNote + identity.heights.size());
    put_field(bytes, kMagicAt, kMagic);
    put_field(bytes, kVersionAt, kVersion);
    put_field(bytes, kNoteBytes, static_cast<std::uint32_t>(identity.heights.size()));
    put_field(bytes, kSalt, identity.salt);
    put_field(bytes, kOriginalHash, identity.original_hash);
    put_field(bytes, kOriginX, s.origin.x);
    put_field(bytes, kOriginZ, s.origin.z);
    put_field(bytes, kSpacing, s.spacing_m);
    put_field(bytes, kQuantum, *s.quantum_m);
    put_field(bytes, kMiddle, identity.middle_m);
    put_field(bytes, kWidth, identity.width);
    put_field(bytes, kDepth, identity.depth);
    put_field(bytes, kTexelsPerPost, s.texels_per_post);
    put_field(bytes, kTileSize, s.tile_size);
    put_field(bytes, kMirror, static_cast<std::uint8_t>(s.mirror));
    put_field(bytes, kDetail, static_cast<std::uint8_t>(s.detail));
    put_field(bytes, kPrecision, static_cast<std::uint8_t>(s.precision == HeightPrecision::bits32 ? 32 : 16));
    std::transform(identity.heights.begin(), identity.heights.end(), bytes.begin() + kNote,
                   [](char c) { return static_cast<std::byte>(c); });
    put_field(bytes, kChecksum, checksum(bytes));
    return replace_file(files, path_in(folder), bytes);
}

Result<WorldIdentity> read_identity(FileSystem& files, const std::string& folder) {
    const std::string path = path_in(folder);
    const Result<std::vector<std::byte>> read = read_file(files, path, kNote + kLongestNote);
    if (!read) return read.error();
    const std::span<const std::byte> bytes = *read;
    const auto damaged = [&](const char* what) {
        return Error{ErrorCode::FileFormat, text(path, ": ", what, "; restore it from a backup")};
    };
    if (bytes.size() < kNote) return damaged("is cut short");
    if (get_field<std::uint64_t>(bytes, kMagicAt) != kMagic) return damaged("is not the identity of a world");
    if (const auto version = get_field<std::uint32_t>(bytes, kVersionAt); version != kVersion)
        return Error{ErrorCode::FileFormat, text(path, ": is of version ", version, ", this build reads ", kVersion,
                                                 "; open the world with a newer tilth")};
    if (get_field<std::uint64_t>(bytes, kChecksum) != checksum(bytes)) return damaged("is damaged (checksum)");
    if (get_field<std::uint32_t>(bytes, kNoteBytes) != bytes.size() - kNote) return damaged("has a wrong length");
    const auto mirror = get_field<std::uint8_t>(bytes, kMirror), detail = get_field<std::uint8_t>(bytes, kDetail);
    const auto bits = get_field<std::uint8_t>(bytes, kPrecision);
    if (mirror > 1 || detail > 1 || (bits != 16 && bits != 32)) return damaged("has a setting that does not exist");
    for (std::size_t at = kZero; at < kMiddle; ++at)
        if (bytes[at] != std::byte{}) return damaged("has a setting that does not exist");

    WorldIdentity identity{.settings = {},
                           .width = get_field<std::int32_t>(bytes, kWidth),
                           .depth = get_field<std::int32_t>(bytes, kDepth),
                           .middle_m = get_field<double>(bytes, kMiddle),
                           .original_hash = get_field<std::uint64_t>(bytes, kOriginalHash),
                           .salt = get_field<std::uint64_t>(bytes, kSalt),
                           .heights = {}};
    GroundSettings& s = identity.settings;
    s.origin = {get_field<double>(bytes, kOriginX), get_field<double>(bytes, kOriginZ)};
    s.spacing_m = get_field<double>(bytes, kSpacing);
    s.quantum_m = get_field<double>(bytes, kQuantum);
    s.mirror = mirror == 1;
    s.detail = detail == 1;
    s.texels_per_post = get_field<std::int32_t>(bytes, kTexelsPerPost);
    s.tile_size = get_field<std::int32_t>(bytes, kTileSize);
    s.precision = bits == 32 ? HeightPrecision::bits32 : HeightPrecision::bits16;
    for (const std::byte byte : bytes.subspan(kNote)) identity.heights += static_cast<char>(byte);
    return identity;
}

Result<void> check_same(const WorldIdentity& stored, const WorldIdentity& given) {
    Result<void> outcome;
    const auto check = [&](const char* field, const auto& a, const auto& b, const char* unit = "") {
        if (outcome && a != b) outcome = differs(field, text(a, unit), text(b, unit));
    };
    const auto yes = [](bool value) { return value ? "yes" : "no"; };
    const auto bits = [](const WorldIdentity& world) {
        return world.settings.precision == HeightPrecision::bits32 ? 32 : 16;
    };
    const GroundSettings &a = stored.settings, &b = given.settings;
    check("origin.x", a.origin.x, b.origin.x, " m");
    check("origin.z", a.origin.z, b.origin.z, " m");
    check("spacing", a.spacing_m, b.spacing_m, " m");
    check("quantum", a.quantum_m.value_or(0), b.quantum_m.value_or(0), " m");
    check("mirror", std::string(yes(a.mirror)), std::string(yes(b.mirror)));
    check("detail", std::string(yes(a.detail)), std::string(yes(b.detail)));
    check("texels_per_post", a.texels_per_post, b.texels_per_post);
    check("tile_size", a.tile_size, b.tile_size);
    check("precision", bits(stored), bits(given), " bits");
    check("heights: width", stored.width, given.width, " posts");
    check("heights: depth", stored.depth, given.depth, " posts");
    check("heights: middle", stored.middle_m, given.middle_m, " m");
    check("heights: hash", hex16(stored.original_hash), hex16(given.original_hash));
    return outcome;
}

}  // namespace tilth
