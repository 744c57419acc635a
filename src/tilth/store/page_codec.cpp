#include "tilth/store/page_codec.h"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>

#include "tilth/core/checks.h"
#include "tilth/core/hash.h"

namespace tilth {
namespace {

constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kRow = kPageTexels, kTexels = kRow * kRow;
// Measured, benchmarks/README.md: level 3 saves 2 % of the bytes and costs 30 % more time.
constexpr int kLevel = 1;
// Pages that come out this small are mostly flat, and may be smaller still as plain words.
constexpr std::size_t kSmallBytes = 1024;

/// How the codes of a page lie before zstd.
enum class Form : std::uint8_t {
    Uniform = 0,   ///< one code for all; nothing behind the header
    Words = 1,     ///< the codes, one after the other
    Gradient = 2,  ///< what a plane through three neighbours does not foretell, in byte planes
};

struct PageHeader {
    std::uint8_t version = kVersion;
    Form form = Form::Uniform;
    std::uint8_t code_bytes = 0;  ///< of each code, from the top: 4, or 2 where the low halves are all zero; Uniform: 0
    std::uint8_t zero = 0;
    std::uint32_t code = 0;  ///< Uniform: the code; else 0
    std::uint64_t hash = 0;  ///< of the codes
};
static_assert(sizeof(PageHeader) == 16);

struct RecordsHeader {
    std::uint8_t version = kVersion;
    std::uint8_t zero = 0;
    std::uint16_t stride = 0;
    std::uint32_t size = 0;
    std::uint64_t hash = 0;  ///< of the bytes
};
static_assert(sizeof(RecordsHeader) == 16);

template <class Header>
Header header_of(std::span<const std::byte> bytes) {
    Header header;
    std::memcpy(&header, bytes.data(), sizeof header);
    return header;
}

// ---------------------------------------------------------------------------------------------------- zstd

/// Its working memory is kept, one per thread: making it costs more than a page does.
ZSTD_CCtx* compressor() {
    struct Free {
        void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    };
    thread_local const std::unique_ptr<ZSTD_CCtx, Free> context(ZSTD_createCCtx());
    TILTH_ASSERT(context != nullptr, "no memory for a zstd context");
    return context.get();
}

ZSTD_DCtx* expander() {
    struct Free {
        void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
    };
    thread_local const std::unique_ptr<ZSTD_DCtx, Free> context(ZSTD_createDCtx());
    TILTH_ASSERT(context != nullptr, "no memory for a zstd context");
    return context.get();
}

/// The header, and one frame behind it.
template <class Header>
std::vector<std::byte> compressed(const Header& header, std::span<const std::byte> content) {
    std::vector<std::byte> blob(sizeof header + ZSTD_compressBound(content.size()));
    std::memcpy(blob.data(), &header, sizeof header);
    const std::size_t size = ZSTD_compressCCtx(compressor(), blob.data() + sizeof header, blob.size() - sizeof header,
                                               content.data(), content.size(), kLevel);
    TILTH_ASSERT(!ZSTD_isError(size), ZSTD_getErrorName(size));
    blob.resize(sizeof header + size);
    return blob;
}

/// Whether `frame` is one frame of today's format, to its last byte, and says that it holds `size` bytes. (zstd itself
/// takes several in a row, frames to be skipped, and formats from before 2016.)
bool is_frame_of(std::span<const std::byte> frame, std::size_t size) {
    std::uint32_t magic = 0;
    if (frame.size() < sizeof magic) return false;
    std::memcpy(&magic, frame.data(), sizeof magic);
    return magic == ZSTD_MAGICNUMBER && ZSTD_findFrameCompressedSize(frame.data(), frame.size()) == frame.size() &&
           ZSTD_getFrameContentSize(frame.data(), frame.size()) == size;
}

/// Fills all of `out`, or fails. Allocates nothing.
bool expand(std::span<const std::byte> frame, std::span<std::byte> out) {
    return ZSTD_decompressDCtx(expander(), out.data(), out.size(), frame.data(), frame.size()) == out.size();
}

// ---------------------------------------------------------------------------------------------------- the filter

// Small differences of either sign become small numbers: 0, -1, 1, -2 ... become 0, 1, 2, 3 ...
template <class Word>
Word folded(Word difference) {
    constexpr int kSign = std::numeric_limits<Word>::digits - 1;
    return static_cast<Word>((difference << 1) ^ (0u - (difference >> kSign)));
}
template <class Word>
Word unfolded(Word word) {
    return static_cast<Word>((word >> 1) ^ (0u - (word & 1u)));
}

/// Foretells each code as left + above - left above (0 outside the page), and writes what is wrong about that, folded,
/// by bytes: first the highest of all codes. Everything modulo 2^bits, so that it can be undone whatever the codes are.
template <class Word>
void to_gradient(const std::array<Word, kTexels>& codes, std::byte* out) {
    std::array<Word, kRow> none{};
    std::array<Word, kRow + 1> down{};  // what a row adds to the one above it; before its first texel: nothing
    const Word* above = none.data();
    for (std::size_t z = 0; z < kRow; ++z) {
        const Word* row = codes.data() + z * kRow;
        for (std::size_t x = 0; x < kRow; ++x) down[x + 1] = static_cast<Word>(row[x] - above[x]);
        std::array<Word, kRow> words;
        for (std::size_t x = 0; x < kRow; ++x) words[x] = folded(static_cast<Word>(down[x + 1] - down[x]));
        for (std::size_t b = 0; b < sizeof(Word); ++b) {
            std::byte* plane = out + b * kTexels + z * kRow;
            for (std::size_t x = 0; x < kRow; ++x)
                plane[x] = static_cast<std::byte>(words[x] >> (8 * (sizeof(Word) - 1 - b)));
        }
        above = row;
    }
}

template <class Word>
void from_gradient(const std::byte* in, std::array<Word, kTexels>& codes) {
    std::array<Word, kRow> none{};
    const Word* above = none.data();
    for (std::size_t z = 0; z < kRow; ++z) {
        std::array<Word, kRow> words{};
        for (std::size_t b = 0; b < sizeof(Word); ++b) {
            const std::byte* plane = in + b * kTexels + z * kRow;
            for (std::size_t x = 0; x < kRow; ++x)
                words[x] = static_cast<Word>(words[x] | (static_cast<Word>(plane[x]) << (8 * (sizeof(Word) - 1 - b))));
        }
        for (std::size_t x = 0; x < kRow; ++x) words[x] = unfolded(words[x]);
        for (std::size_t x = 1; x < kRow; ++x) words[x] = static_cast<Word>(words[x] + words[x - 1]);
        Word* row = codes.data() + z * kRow;
        for (std::size_t x = 0; x < kRow; ++x) row[x] = static_cast<Word>(above[x] + words[x]);
        above = row;
    }
}

/// A page of which the top `sizeof(Word)` bytes of each code are kept.
template <class Word>
std::vector<std::byte> encode_words(PageHeader header, const std::array<Word, kTexels>& codes) {
    header.code_bytes = sizeof(Word);
    std::array<std::byte, sizeof codes> planes;
    to_gradient(codes, planes.data());
    header.form = Form::Gradient;
    std::vector<std::byte> blob = compressed(header, planes);
    if (blob.size() > kSmallBytes) return blob;
    header.form = Form::Words;
    std::vector<std::byte> words = compressed(header, std::as_bytes(std::span(codes)));
    return words.size() < blob.size() ? words : blob;
}

template <class Word>
bool decode_words(Form form, std::span<const std::byte> frame, std::array<Word, kTexels>& codes) {
    if (!is_frame_of(frame, sizeof codes)) return false;
    if (form == Form::Words) return expand(frame, std::as_writable_bytes(std::span(codes)));
    std::array<std::byte, sizeof codes> planes;
    if (!expand(frame, planes)) return false;
    from_gradient(planes.data(), codes);
    return true;
}

bool decode_codes(const PageHeader& header, std::span<const std::byte> frame, PageCodes& codes) {
    if (header.form == Form::Uniform) {
        codes.fill(header.code);
        return header.code_bytes == 0 && frame.empty();
    }
    if (header.code != 0 || (header.form != Form::Words && header.form != Form::Gradient)) return false;
    if (header.code_bytes == 4) return decode_words(header.form, frame, codes);
    std::array<std::uint16_t, kTexels> highs;
    if (header.code_bytes != 2 || !decode_words(header.form, frame, highs)) return false;
    for (std::size_t i = 0; i < kTexels; ++i) codes[i] = static_cast<std::uint32_t>(highs[i]) << 16;
    return true;
}

// ---------------------------------------------------------------------------------------------------- errors

template <class Header>
Result<void> check_version(std::span<const std::byte> bytes, const char* what, std::string_view where) {
    if (bytes.size() < sizeof(Header))
        return Error{ErrorCode::FileFormat, text(where, ": ", what, " ends after ", bytes.size(),
                                                 " bytes, its header alone has ", sizeof(Header))};
    if (const auto version = static_cast<unsigned>(bytes[0]); version != kVersion)
        return Error{ErrorCode::FileFormat, text(where, ": ", what, " has version ", version, ", this build knows ",
                                                 unsigned{kVersion}, ": it is damaged, or was written by a newer one")};
    return {};
}

Error damaged(const char* what, std::string_view where) {
    return {ErrorCode::FileFormat, text(where, ": ", what, " is damaged: what it holds is not what its checksum says")};
}

}  // namespace

std::uint64_t hash_of(const PageCodes& codes) { return hash_bytes(std::as_bytes(std::span(codes))); }

std::vector<std::byte> encode_page(const PageCodes& codes, HeightPrecision precision) {
    PageHeader header;
    header.hash = hash_of(codes);
    if (std::all_of(codes.begin(), codes.end(), [&](std::uint32_t code) { return code == codes[0]; })) {
        header.code = codes[0];
        const auto bytes = std::as_bytes(std::span(&header, 1));
        return {bytes.begin(), bytes.end()};
    }
    // Whoever has other low halves than zero with bits16 gets them back all the same.
    const auto has_low = [](std::uint32_t code) { return (code & 0xffffu) != 0; };
    if (precision == HeightPrecision::bits32 || std::any_of(codes.begin(), codes.end(), has_low))
        return encode_words(header, codes);
    std::array<std::uint16_t, kTexels> highs;
    for (std::size_t i = 0; i < kTexels; ++i) highs[i] = static_cast<std::uint16_t>(codes[i] >> 16);
    return encode_words(header, highs);
}

Result<std::shared_ptr<PageCodes>> decode_page(std::span<const std::byte> bytes, std::string_view where) {
    if (const Result<void> known = check_version<PageHeader>(bytes, "page", where); !known) return known.error();
    const auto header = header_of<PageHeader>(bytes);
    auto codes = std::make_shared<PageCodes>();
    if (header.zero != 0 || !decode_codes(header, bytes.subspan(sizeof header), *codes) ||
        hash_of(*codes) != header.hash)
        return damaged("page", where);
    return codes;
}

std::vector<std::byte> encode_records(std::span<const std::byte> bytes, std::size_t stride) {
    TILTH_ASSERT(stride >= 1 && stride <= 0xffff, text("stride ", stride));
    TILTH_ASSERT(bytes.size() <= 0xffff'ffffu, text(bytes.size(), " bytes of records"));
    const RecordsHeader header{.stride = static_cast<std::uint16_t>(stride),
                               .size = static_cast<std::uint32_t>(bytes.size()),
                               .hash = hash_bytes(bytes)};
    std::vector<std::byte> columns(bytes.size());
    const std::size_t count = bytes.size() / stride;
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t b = 0; b < stride; ++b) columns[b * count + i] = bytes[i * stride + b];
    std::copy(bytes.begin() + static_cast<std::ptrdiff_t>(count * stride), bytes.end(),
              columns.begin() + static_cast<std::ptrdiff_t>(count * stride));
    return compressed(header, columns);
}

Result<std::vector<std::byte>> decode_records(std::span<const std::byte> bytes, std::uint64_t most_bytes,
                                              std::string_view where) {
    if (const Result<void> known = check_version<RecordsHeader>(bytes, "block of records", where); !known)
        return known.error();
    const auto header = header_of<RecordsHeader>(bytes);
    const std::span<const std::byte> frame = bytes.subspan(sizeof header);
    if (header.size > most_bytes)
        return Error{ErrorCode::FileFormat, text(where, ": block of records says that it holds ", header.size,
                                                 " bytes, at most ", most_bytes, " are allowed here: it is damaged")};
    if (header.zero != 0 || header.stride == 0 || !is_frame_of(frame, header.size))
        return damaged("block of records", where);
    std::vector<std::byte> columns(header.size);
    if (!expand(frame, columns)) return damaged("block of records", where);
    std::vector<std::byte> records(header.size);
    const std::size_t stride = header.stride, count = records.size() / stride;
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t b = 0; b < stride; ++b) records[i * stride + b] = columns[b * count + i];
    std::copy(columns.begin() + static_cast<std::ptrdiff_t>(count * stride), columns.end(),
              records.begin() + static_cast<std::ptrdiff_t>(count * stride));
    if (hash_bytes(records) != header.hash) return damaged("block of records", where);
    return records;
}

}  // namespace tilth
