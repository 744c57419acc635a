#include "tilth/store/shape_files.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "tilth/core/hash.h"
#include "tilth/store/byte_fields.h"
#include "tilth/store/page_codec.h"

namespace tilth {
namespace {

constexpr std::string_view kPrefix = "shape-", kSuffix = ".tls";
constexpr std::uint64_t kMagic = magic_of("TILTH-S\n");
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kLongestName = 1000;
constexpr std::int32_t kMostTexels = 4096;  // a side of an image
constexpr std::uint64_t kMostWeightBytes = 4ull * kMostTexels * kMostTexels;

// Where the fields lie; FORMATS.md draws it. Behind the header: the name, then the weights as `encode_records` has
// them.
enum Place : std::size_t {
    kMagicAt = 0,
    kVersionAt = 8,
    kId = 12,
    kSalt = 16,
    kLeastRadius = 24,
    kHash = 32,
    kWidth = 40,
    kHeight = 44,
    kNameBytes = 48,
    kIsImage = 52,
    kZeroVolume = 53,
    kZero = 54,  // 2 bytes
    kChecksum = 56,
    kHeaderBytes = 64,
};
// Weights that do not compress grow a little.
constexpr std::uint64_t kMostFileBytes = kHeaderBytes + kLongestName + kMostWeightBytes + (1u << 20);

std::string path_of(const std::string& folder, std::uint32_t id) { return text(folder, "/", kPrefix, id, kSuffix); }

std::optional<std::uint32_t> id_of(std::string_view name) {
    if (name.size() <= kPrefix.size() + kSuffix.size() || !name.starts_with(kPrefix) || !name.ends_with(kSuffix))
        return std::nullopt;
    const std::string_view digits = name.substr(kPrefix.size(), name.size() - kPrefix.size() - kSuffix.size());
    std::uint32_t id = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), id);
    if (error != std::errc() || end != digits.data() + digits.size() || std::to_string(id) != digits)
        return std::nullopt;
    return id;
}

/// Of header and rest, the checksum's own place apart.
std::uint64_t checksum(std::span<const std::byte> bytes) {
    StateHasher hasher;
    for (std::size_t at = 0; at < kChecksum; at += 8) hasher.add_i64(get_field<std::int64_t>(bytes, at));
    hasher.add_i64(static_cast<std::int64_t>(hash_bytes(bytes.subspan(kHeaderBytes))));
    return hasher.digest();
}

std::vector<std::byte> encode_shape(std::uint64_t salt, ShapeId id, const Shape& shape) {
    const std::vector<std::byte> weights = encode_records(std::as_bytes(std::span(shape.weights)), 4);
    std::vector<std::byte> bytes(kHeaderBytes + shape.name.size());
    put_field(bytes, kMagicAt, kMagic);
    put_field(bytes, kVersionAt, kVersion);
    put_field(bytes, kId, id.value);
    put_field(bytes, kSalt, salt);
    put_field(bytes, kLeastRadius, shape.least_radius_texels);
    put_field(bytes, kHash, shape.hash);
    put_field(bytes, kWidth, shape.width);
    put_field(bytes, kHeight, shape.height);
    put_field(bytes, kNameBytes, static_cast<std::uint32_t>(shape.name.size()));
    put_field(bytes, kIsImage, static_cast<std::uint8_t>(shape.is_image));
    put_field(bytes, kZeroVolume, static_cast<std::uint8_t>(shape.zero_volume));
    std::transform(shape.name.begin(), shape.name.end(), bytes.begin() + kHeaderBytes,
                   [](char c) { return static_cast<std::byte>(c); });
    bytes.insert(bytes.end(), weights.begin(), weights.end());
    put_field(bytes, kChecksum, checksum(bytes));
    return bytes;
}

Result<Shape> read_shape(FileSystem& files, const std::string& path, std::uint64_t salt, std::uint32_t id) {
    const Result<std::vector<std::byte>> read = read_file(files, path, kMostFileBytes);
    if (!read) return read.error();
    const std::span<const std::byte> bytes = *read;
    const auto damaged = [&](const auto&... what) {
        return Error{ErrorCode::FileFormat, text(path, ": ", what..., "; restore it from a backup")};
    };
    if (bytes.size() < kHeaderBytes) return damaged("is cut short");
    if (get_field<std::uint64_t>(bytes, kMagicAt) != kMagic) return damaged("is no shape");
    if (const auto version = get_field<std::uint32_t>(bytes, kVersionAt); version != kVersion)
        return Error{ErrorCode::FileFormat, text(path, ": is of version ", version, ", this build reads ", kVersion,
                                                 "; open the world with a newer tilth")};
    if (get_field<std::uint64_t>(bytes, kChecksum) != checksum(bytes)) return damaged("is damaged (checksum)");
    if (get_field<std::uint64_t>(bytes, kSalt) != salt) return damaged("belongs to another world");
    if (const auto stored = get_field<std::uint32_t>(bytes, kId); stored != id)
        return damaged("is shape ", stored, " under the name of another");

    const auto name_bytes = get_field<std::uint32_t>(bytes, kNameBytes);
    const auto is_image = get_field<std::uint8_t>(bytes, kIsImage);
    const auto zero_volume = get_field<std::uint8_t>(bytes, kZeroVolume);
    const auto width = get_field<std::int32_t>(bytes, kWidth), height = get_field<std::int32_t>(bytes, kHeight);
    if (name_bytes > kLongestName || name_bytes > bytes.size() - kHeaderBytes) return damaged("has no name");
    if (is_image > 1 || zero_volume > 1 || get_field<std::uint16_t>(bytes, kZero) != 0)
        return damaged("is of a kind that does not exist");
    const std::int32_t least = is_image == 1 ? 1 : 0, most = is_image == 1 ? kMostTexels : 0;
    if (width < least || height < least || width > most || height > most)
        return damaged("has a size of ", width, " x ", height);
    const std::uint64_t weights =
        is_image == 1 ? static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) : kProfileEntries;
    const Result<std::vector<std::byte>> expanded =
        decode_records(bytes.subspan(kHeaderBytes + name_bytes), 4 * weights, path);
    if (!expanded) return expanded.error();
    if (expanded->size() != 4 * weights) return damaged("has ", expanded->size() / 4, " weights of ", weights);

    Shape shape{.name = {},
                .is_image = is_image == 1,
                .width = width,
                .height = height,
                .weights = std::vector<std::int32_t>(weights),
                .least_radius_texels = get_field<double>(bytes, kLeastRadius),
                .zero_volume = zero_volume == 1,
                .hash = get_field<std::uint64_t>(bytes, kHash)};
    for (const std::byte byte : bytes.subspan(kHeaderBytes, name_bytes)) shape.name += static_cast<char>(byte);
    std::memcpy(shape.weights.data(), expanded->data(), expanded->size());
    return shape;
}

bool is_same(const Shape& a, const Shape& b) { return a.name == b.name && a.hash == b.hash; }

/// Whether the library has the world's shape under its id, or can have it.
Result<void> check_fits(const ShapeLibrary& shapes, std::uint32_t id, const Shape& shape) {
    const auto clashes = [&](const std::string& with) {
        return Error{ErrorCode::InvalidArgument,
                     text("shape ", id, ": is '", shape.name, "' in the world on disk, and the library has ", with,
                          "; open the world before adding shapes, or add them in the order they had")};
    };
    if (id < shapes.size()) {
        if (is_same(shapes.shape({id}), shape)) return {};
        return clashes(text("'", shapes.shape({id}).name, "' there, with other data"));
    }
    if (const std::optional<ShapeId> known = shapes.find(shape.name))
        return clashes(text("that name as shape ", known->value));
    return {};
}

}  // namespace

Result<void> write_shape(FileSystem& files, const std::string& folder, std::uint64_t salt, ShapeId id,
                         const Shape& shape) {
    if (shape.name.size() > kLongestName)
        return Error{ErrorCode::InvalidArgument,
                     text("name: a shape's of ", shape.name.size(), " bytes; at most 1000 can be kept on disk")};
    const std::string path = path_of(folder, id.value);
    if (files.exists(path)) {  // of an earlier attempt whose end failed; written again, so that it is durable
        const Result<Shape> there = read_shape(files, path, salt, id.value);
        if (!there) return there.error();
        if (!is_same(*there, shape))
            return Error{ErrorCode::FileFormat, text(path, ": holds '", there->name, "', and '", shape.name,
                                                     "' would replace it; add the shapes in the order they had")};
    }
    return replace_file(files, path, encode_shape(salt, id, shape));
}

Result<std::uint32_t> read_shapes(FileSystem& files, const std::string& folder, std::uint64_t salt,
                                  ShapeLibrary& shapes) {
    const Result<std::vector<std::string>> names = files.list(folder);
    if (!names) return names.error();
    std::set<std::uint32_t> ids;
    for (const std::string& name : *names)
        if (const std::optional<std::uint32_t> id = id_of(name)) ids.insert(*id);
    // Everything is looked at before anything is added.
    ShapeLibrary found;
    for (const std::uint32_t id : ids) {
        if (id != found.size())
            return Error{ErrorCode::FileFormat, text(path_of(folder, found.size()),
                                                     ": is missing, and there are others; restore it from a backup")};
        const std::string path = path_of(folder, id);
        Result<Shape> shape = read_shape(files, path, salt, id);
        if (!shape) return shape.error();
        const std::uint64_t hash = shape->hash;
        const Result<ShapeId> added = found.add_exact(*std::move(shape));
        if (!added || added->value != id || found.shape({id}).hash != hash)
            return Error{ErrorCode::FileFormat,
                         text(path, ": is no shape that can be: ", added ? "its hash" : added.error().message)};
        if (const Result<void> fits = check_fits(shapes, id, found.shape({id})); !fits) return fits.error();
    }
    for (const std::uint32_t id : ids)
        if (id >= shapes.size())
            if (const Result<ShapeId> added = shapes.add_exact(found.shape({id})); !added) return added.error();
    return found.size();
}

}  // namespace tilth
