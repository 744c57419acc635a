// Pages of height codes as bytes: filtered, compressed by zstd, with a checksum over the codes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/ground/page.h"
#include "tilth/world/height_codec.h"

namespace tilth {

/// XXH3-64 of a page's codes, as little-endian words: what `encode_page` writes and `decode_page` checks.
std::uint64_t hash_of(const PageCodes& codes);

/// A page as a blob of 16 bytes (one code all over) to 16.5 KiB, the same for the same codes. Any codes come back as
/// they were; with `bits16` the low halves are left out where they are all zero, as they should be. Which filter, which
/// level and why: benchmarks/README.md; the bytes: FORMATS.md. Cost: 15 to 50 us a page, of that zstd nearly all;
/// memory: one zstd context a thread. Threads: any.
std::vector<std::byte> encode_page(const PageCodes& codes, HeightPrecision precision);

/// `where` begins the message of an error (FileFormat): a page that is not what its checksum says, or of a version that
/// is not known. Allocates a page, whatever the bytes claim. Cost: 3 to 25 us.
Result<std::shared_ptr<PageCodes>> decode_page(std::span<const std::byte> bytes, std::string_view where);

/// The same compression for anything else (stamp records, shapes): zstd of `stride`-byte columns, with a checksum.
/// `stride` is 1..65 535, and `bytes` less than 4 GiB; what is left behind the last whole record is kept as well.
std::vector<std::byte> encode_records(std::span<const std::byte> bytes, std::size_t stride);
/// Fails (FileFormat) on bytes that are damaged and on ones that would grow beyond `most_bytes`, of which nothing is
/// allocated then.
Result<std::vector<std::byte>> decode_records(std::span<const std::byte> bytes, std::uint64_t most_bytes,
                                              std::string_view where);

}  // namespace tilth
