// An edit as the 64 bytes that the journal keeps of it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "tilth/ground/edit.h"

namespace tilth {

inline constexpr std::size_t kJournalEntryBytes = 64;
using JournalBytes = std::array<std::byte, kJournalEntryBytes>;

/// `number`: which edit of the world it is, from 1; with `salt`, the world's, it goes into the checksum, so that an
/// entry of another place or another world is not taken for this one. FORMATS.md has the bytes.
JournalBytes encode_entry(const Edit& edit, std::uint64_t number, std::uint64_t salt);

/// Empty: damaged, torn, never written, or not number `number` of this world.
std::optional<Edit> decode_entry(std::span<const std::byte, kJournalEntryBytes> bytes, std::uint64_t number,
                                 std::uint64_t salt);

}  // namespace tilth
