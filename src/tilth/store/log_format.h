// The bytes of `pages-<n>.tlp`: header, superblocks, frames and indexes, as FORMATS.md has them. No files here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tilth/store/blob_store.h"

namespace tilth::log_format {

inline constexpr std::uint32_t kVersion = 1;
inline constexpr std::size_t kHeaderBytes = 40, kSuperblockBytes = 64, kFrameHeaderBytes = 40;
/// Header and superblocks lie in disk blocks of their own: a block that a power cut ruins takes no other with it.
inline constexpr std::uint64_t kBlockBytes = 4096;
inline constexpr std::uint64_t kFirstFrame = 3 * kBlockBytes;
inline constexpr std::uint64_t kMostBlobBytes = 64u << 20;

/// What every checksum of a file also covers, so that bytes of another world or another file are never taken for its
/// own.
struct FileTag {
    std::uint64_t salt = 0, number = 0;
};

using HeaderBytes = std::array<std::byte, kHeaderBytes>;
HeaderBytes encode_header(const FileTag& tag);

enum class HeaderState : std::uint8_t { Good, Damaged, Foreign, Newer, OtherWorld };
/// Foreign: not the beginning of such a file, nor what a torn one leaves.
HeaderState check_header(std::span<const std::byte> bytes, const FileTag& tag);

/// A commit: it points to the index, and is the last thing of it to be written. Two places, by turns.
struct Superblock {
    std::uint64_t generation = 0;  ///< counts commits, over all files of a world; 0: none yet
    std::uint64_t mark = 0;
    std::uint64_t index_offset = 0;
    std::uint64_t end = kFirstFrame;  ///< of the index: what lies behind is not committed
    std::uint64_t blobs = 0;          ///< that can be got
    friend bool operator==(const Superblock&, const Superblock&) = default;
};
using SuperblockBytes = std::array<std::byte, kSuperblockBytes>;
constexpr std::uint64_t superblock_offset(unsigned slot) { return (1 + slot) * kBlockBytes; }
SuperblockBytes encode_superblock(const Superblock& superblock, const FileTag& tag, unsigned slot);
std::optional<Superblock> decode_superblock(std::span<const std::byte> bytes, const FileTag& tag, unsigned slot);

/// Header, and superblocks of generation 0: what a file is born with, as one.
std::vector<std::byte> encode_empty_file(const FileTag& tag);

enum class FrameType : std::uint8_t { Blob = 1, Erase = 2, Index = 3 };

struct FrameHeader {
    FrameType type = FrameType::Blob;
    BlobKey key;               ///< of an index: its mark, the low half in x
    std::uint32_t length = 0;  ///< of the payload, which follows at once
    std::uint64_t payload_hash = 0;

    [[nodiscard]] std::uint64_t bytes() const { return kFrameHeaderBytes + std::uint64_t{length}; }
    [[nodiscard]] std::uint64_t mark() const {
        return std::uint64_t{static_cast<std::uint32_t>(key.z)} << 32 | static_cast<std::uint32_t>(key.x);
    }
};
inline BlobKey key_of_mark(std::uint64_t mark) {
    return {BlobKind{}, static_cast<std::int32_t>(static_cast<std::uint32_t>(mark)),
            static_cast<std::int32_t>(static_cast<std::uint32_t>(mark >> 32))};
}
using FrameHeaderBytes = std::array<std::byte, kFrameHeaderBytes>;
/// The first bytes of every frame, for finding the next one behind damage.
inline constexpr std::array<std::byte, 4> kFrameMagic{std::byte{'T'}, std::byte{'L'}, std::byte{'P'}, std::byte{'F'}};
FrameHeaderBytes encode_frame_header(const FrameHeader& header, const FileTag& tag, std::uint64_t offset);
/// Empty: damaged, or not a frame of this file at this place.
std::optional<FrameHeader> decode_frame_header(std::span<const std::byte> bytes, const FileTag& tag,
                                               std::uint64_t offset);

/// Where a blob lies.
struct Entry {
    std::uint64_t offset = 0;  ///< of its frame
    std::uint64_t mark = 0;    ///< of the commit that made it durable
    std::uint32_t length = 0;  ///< of its payload
    [[nodiscard]] std::uint64_t frame_bytes() const { return kFrameHeaderBytes + std::uint64_t{length}; }
    friend bool operator==(const Entry&, const Entry&) = default;
};
inline constexpr std::uint64_t kUnknownMark = ~std::uint64_t{0};

struct AddedBlob {
    BlobKey key;
    Entry entry;
};
/// What changed since another index, the previous one, or everything.
struct Index {
    std::uint64_t generation = 0, mark = 0;
    std::uint64_t previous = 0, previous_end = 0;  ///< its frame; 0, 0: there is none
    std::vector<AddedBlob> added;
    std::vector<BlobKey> erased;
};
inline constexpr std::size_t kIndexHeadBytes = 40, kAddedBytes = 32, kErasedBytes = 12;
constexpr std::uint64_t index_frame_bytes(std::uint64_t added) {
    return kFrameHeaderBytes + kIndexHeadBytes + added * kAddedBytes;
}
std::vector<std::byte> encode_index(const Index& index);
/// `offset`: of its frame. Empty where a count, a kind or a place cannot be: everything lies between the first frame
/// and `offset`.
std::optional<Index> decode_index(std::span<const std::byte> payload, std::uint64_t offset);

/// `pages-<n>.tlp`, and back; empty for any other name.
std::string file_name(std::uint64_t number);
std::optional<std::uint64_t> number_of(const std::string& file_name);

}  // namespace tilth::log_format
