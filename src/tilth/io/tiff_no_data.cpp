#include "tilth/io/tiff_no_data.h"

#include <cstdint>

namespace tilth::io {
namespace {

constexpr std::uint64_t kGdalNoDataTag = 42113, kAsciiType = 2;
constexpr std::uint64_t kLongestText = 64;  // GDAL writes at most a double, or "nan"

/// Integers of the file's byte order at any offset; a read beyond the end clears `good` and gives 0.
struct Reader {
    std::span<const std::byte> file;
    bool little = true;
    bool good = true;

    std::uint64_t integer(std::uint64_t at, std::uint64_t bytes) {
        if (at > file.size() || file.size() - at < bytes) {
            good = false;
            return 0;
        }
        std::uint64_t value = 0;
        for (std::uint64_t i = 0; i < bytes; ++i)
            value = value << 8 | std::to_integer<std::uint64_t>(file[at + (little ? bytes - 1 - i : i)]);
        return value;
    }
};

std::optional<std::string> text_at(Reader& reader, std::uint64_t at, std::uint64_t length) {
    if (length > kLongestText) return std::nullopt;
    std::string found;
    for (std::uint64_t i = 0; i < length; ++i) {
        const char c = static_cast<char>(reader.integer(at + i, 1));
        if (c == '\0') break;
        if (c != ' ') found += c;
    }
    if (!reader.good) return std::nullopt;
    return found;
}

}  // namespace

// Classic TIFF: "II" or "MM", 42, offset of the directory (4 bytes); a directory is a count (2 bytes) and entries of
// tag 2, type 2, count 4, value or offset 4. BigTIFF: 43, 8, 0, offset (8 bytes); count 8; entries 2, 2, 8, 8.
std::optional<std::string> gdal_no_data_text(std::span<const std::byte> file) {
    Reader reader{file};
    const std::uint64_t order = reader.integer(0, 2);
    if (order != 0x4949 && order != 0x4d4d) return std::nullopt;
    reader.little = order == 0x4949;
    const std::uint64_t version = reader.integer(2, 2);
    if (version != 42 && version != 43) return std::nullopt;

    const bool big = version == 43;
    const std::uint64_t word = big ? 8 : 4, entry_bytes = big ? 20 : 12, count_bytes = big ? 8 : 2;
    const std::uint64_t directory = reader.integer(big ? 8 : 4, word);
    const std::uint64_t entries = reader.integer(directory, count_bytes);
    for (std::uint64_t i = 0; i < entries && reader.good; ++i) {
        const std::uint64_t entry = directory + count_bytes + i * entry_bytes;
        if (reader.integer(entry, 2) != kGdalNoDataTag || reader.integer(entry + 2, 2) != kAsciiType) continue;
        const std::uint64_t length = reader.integer(entry + 4, word), value = entry + 4 + word;
        return text_at(reader, length <= word ? value : reader.integer(value, word), length);
    }
    return std::nullopt;
}

}  // namespace tilth::io
