#include "tilth/store/log_format.h"

#include <algorithm>
#include <charconv>
#include <cstring>

#include "tilth/core/hash.h"

namespace tilth::log_format {

namespace {

constexpr std::array<char, 8> kHeaderMagic{'T', 'L', 'P', 'A', 'G', 'E', 'S', '\n'};
constexpr std::array<char, 4> kSuperblockMagic{'T', 'L', 'P', 'S'};
constexpr const char* kPrefix = "pages-";
constexpr const char* kEnding = ".tlp";

/// Little-endian memory (core/hash.cpp asserts it) is the format.
template <class T>
void put(std::span<std::byte> bytes, std::size_t at, const T& value) {
    std::memcpy(bytes.subspan(at, sizeof value).data(), &value, sizeof value);
}
template <class T>
T take(std::span<const std::byte> bytes, std::size_t at) {
    T value;
    std::memcpy(&value, bytes.subspan(at, sizeof value).data(), sizeof value);
    return value;
}

/// Of `bytes`, of the file they belong to and of their place in it.
std::uint64_t bound_hash(std::span<const std::byte> bytes, const FileTag& tag, std::uint64_t offset) {
    std::array<std::byte, 24 + kSuperblockBytes> all{};
    put(all, 0, tag.salt);
    put(all, 8, tag.number);
    put(all, 16, offset);
    std::copy(bytes.begin(), bytes.end(), all.begin() + 24);
    return hash_bytes(std::span(all).first(24 + bytes.size()));
}

bool is_kind(std::uint32_t kind) { return kind >= 1 && kind <= 255; }

void put_key(std::span<std::byte> bytes, std::size_t at, const BlobKey& key) {
    put(bytes, at, static_cast<std::uint32_t>(key.kind));
    put(bytes, at + 4, key.x);
    put(bytes, at + 8, key.z);
}
std::optional<BlobKey> take_key(std::span<const std::byte> bytes, std::size_t at) {
    const auto kind = take<std::uint32_t>(bytes, at);
    if (!is_kind(kind)) return {};
    return BlobKey{static_cast<BlobKind>(kind), take<std::int32_t>(bytes, at + 4), take<std::int32_t>(bytes, at + 8)};
}

}  // namespace

HeaderBytes encode_header(const FileTag& tag) {
    HeaderBytes bytes{};
    put(bytes, 0, kHeaderMagic);
    put(bytes, 8, kVersion);
    put(bytes, 16, tag.salt);
    put(bytes, 24, tag.number);
    put(bytes, 32, hash_bytes(std::span(bytes).first(32)));
    return bytes;
}

HeaderState check_header(std::span<const std::byte> bytes, const FileTag& tag) {
    if (bytes.size() < kHeaderBytes) return HeaderState::Damaged;
    const bool has_magic = take<std::array<char, 8>>(bytes, 0) == kHeaderMagic;
    if (!has_magic || take<std::uint64_t>(bytes, 32) != hash_bytes(bytes.first(32))) {
        const bool is_zero =
            std::ranges::all_of(bytes.first(kHeaderBytes), [](std::byte b) { return b == std::byte{}; });
        return has_magic || is_zero ? HeaderState::Damaged : HeaderState::Foreign;
    }
    if (take<std::uint32_t>(bytes, 8) > kVersion) return HeaderState::Newer;
    if (take<std::uint32_t>(bytes, 8) != kVersion) return HeaderState::Damaged;
    if (take<std::uint64_t>(bytes, 16) != tag.salt) return HeaderState::OtherWorld;
    return take<std::uint64_t>(bytes, 24) == tag.number ? HeaderState::Good : HeaderState::OtherWorld;
}

SuperblockBytes encode_superblock(const Superblock& superblock, const FileTag& tag, unsigned slot) {
    SuperblockBytes bytes{};
    put(bytes, 0, kSuperblockMagic);
    put(bytes, 4, kVersion);
    put(bytes, 8, superblock.generation);
    put(bytes, 16, superblock.mark);
    put(bytes, 24, superblock.index_offset);
    put(bytes, 32, superblock.end);
    put(bytes, 40, superblock.blobs);
    put(bytes, 56, bound_hash(std::span(bytes).first(56), tag, superblock_offset(slot)));
    return bytes;
}

std::optional<Superblock> decode_superblock(std::span<const std::byte> bytes, const FileTag& tag, unsigned slot) {
    if (bytes.size() < kSuperblockBytes) return {};
    if (take<std::array<char, 4>>(bytes, 0) != kSuperblockMagic || take<std::uint32_t>(bytes, 4) != kVersion) return {};
    if (take<std::uint64_t>(bytes, 56) != bound_hash(bytes.first(56), tag, superblock_offset(slot))) return {};
    return Superblock{.generation = take<std::uint64_t>(bytes, 8),
                      .mark = take<std::uint64_t>(bytes, 16),
                      .index_offset = take<std::uint64_t>(bytes, 24),
                      .end = take<std::uint64_t>(bytes, 32),
                      .blobs = take<std::uint64_t>(bytes, 40)};
}

std::vector<std::byte> encode_empty_file(const FileTag& tag) {
    std::vector<std::byte> bytes(kFirstFrame);
    std::ranges::copy(encode_header(tag), bytes.begin());
    for (const unsigned slot : {0u, 1u})
        std::ranges::copy(encode_superblock({}, tag, slot),
                          bytes.begin() + static_cast<std::ptrdiff_t>(superblock_offset(slot)));
    return bytes;
}

FrameHeaderBytes encode_frame_header(const FrameHeader& header, const FileTag& tag, std::uint64_t offset) {
    FrameHeaderBytes bytes{};
    std::ranges::copy(kFrameMagic, bytes.begin());
    put(bytes, 4, header.type);
    put(bytes, 5, header.key.kind);
    put(bytes, 8, header.key.x);
    put(bytes, 12, header.key.z);
    put(bytes, 16, header.length);
    put(bytes, 24, header.payload_hash);
    put(bytes, 32, bound_hash(std::span(bytes).first(32), tag, offset));
    return bytes;
}

std::optional<FrameHeader> decode_frame_header(std::span<const std::byte> bytes, const FileTag& tag,
                                               std::uint64_t offset) {
    if (bytes.size() < kFrameHeaderBytes || !std::ranges::equal(bytes.first(4), kFrameMagic)) return {};
    if (take<std::uint64_t>(bytes, 32) != bound_hash(bytes.first(32), tag, offset)) return {};
    const auto type = take<std::uint8_t>(bytes, 4);
    if (type < 1 || type > 3) return {};
    return FrameHeader{.type = static_cast<FrameType>(type),
                       .key = {static_cast<BlobKind>(take<std::uint8_t>(bytes, 5)), take<std::int32_t>(bytes, 8),
                               take<std::int32_t>(bytes, 12)},
                       .length = take<std::uint32_t>(bytes, 16),
                       .payload_hash = take<std::uint64_t>(bytes, 24)};
}

std::vector<std::byte> encode_index(const Index& index) {
    std::vector<std::byte> bytes(kIndexHeadBytes + index.added.size() * kAddedBytes +
                                 index.erased.size() * kErasedBytes);
    put(bytes, 0, index.generation);
    put(bytes, 8, index.mark);
    put(bytes, 16, index.previous);
    put(bytes, 24, index.previous_end);
    put(bytes, 32, static_cast<std::uint32_t>(index.added.size()));
    put(bytes, 36, static_cast<std::uint32_t>(index.erased.size()));
    std::size_t at = kIndexHeadBytes;
    for (const AddedBlob& added : index.added) {
        put_key(bytes, at, added.key);
        put(bytes, at + 12, added.entry.length);
        put(bytes, at + 16, added.entry.offset);
        put(bytes, at + 24, added.entry.mark);
        at += kAddedBytes;
    }
    for (const BlobKey& key : index.erased) {
        put_key(bytes, at, key);
        at += kErasedBytes;
    }
    return bytes;
}

std::optional<Index> decode_index(std::span<const std::byte> payload, std::uint64_t offset) {
    if (payload.size() < kIndexHeadBytes) return {};
    Index index{.generation = take<std::uint64_t>(payload, 0),
                .mark = take<std::uint64_t>(payload, 8),
                .previous = take<std::uint64_t>(payload, 16),
                .previous_end = take<std::uint64_t>(payload, 24)};
    const std::uint64_t added = take<std::uint32_t>(payload, 32), erased = take<std::uint32_t>(payload, 36);
    if (payload.size() != kIndexHeadBytes + added * kAddedBytes + erased * kErasedBytes) return {};
    const bool is_first = index.previous == 0 && index.previous_end == 0;
    if (!is_first &&
        (index.previous < kFirstFrame || index.previous >= index.previous_end || index.previous_end > offset))
        return {};

    index.added.reserve(added);
    index.erased.reserve(erased);
    std::size_t at = kIndexHeadBytes;
    for (std::uint64_t i = 0; i < added; ++i, at += kAddedBytes) {
        const std::optional<BlobKey> key = take_key(payload, at);
        const Entry entry{.offset = take<std::uint64_t>(payload, at + 16),
                          .mark = take<std::uint64_t>(payload, at + 24),
                          .length = take<std::uint32_t>(payload, at + 12)};
        if (!key || entry.offset < kFirstFrame || entry.offset > offset || entry.length > kMostBlobBytes ||
            entry.frame_bytes() > offset - entry.offset)
            return {};
        index.added.push_back({*key, entry});
    }
    for (std::uint64_t i = 0; i < erased; ++i, at += kErasedBytes) {
        const std::optional<BlobKey> key = take_key(payload, at);
        if (!key) return {};
        index.erased.push_back(*key);
    }
    return index;
}

std::string file_name(std::uint64_t number) { return kPrefix + std::to_string(number) + kEnding; }

std::optional<std::uint64_t> number_of(const std::string& name) {
    const std::size_t first = std::strlen(kPrefix);
    std::uint64_t number = 0;
    if (name.size() <= first) return {};
    std::from_chars(name.data() + first, name.data() + name.size(), number);
    // Written back, it must be the same: no sign, no leading zero, nothing behind.
    if (number == 0 || number == ~std::uint64_t{0} || file_name(number) != name) return {};
    return number;
}

}  // namespace tilth::log_format
