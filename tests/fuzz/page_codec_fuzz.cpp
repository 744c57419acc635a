// Pages and records as blobs: what is taken has the checksum's content, and comes back through the encoder; the
// decoders are held against ones that follow FORMATS.md word by word.
#include <zstd.h>

#include <bit>
#include <optional>

#include "fuzz/fuzz_input.h"
#include "tilth/core/hash.h"
#include "tilth/store/byte_fields.h"
#include "tilth/store/page_codec.h"

namespace tilth::fuzz {
namespace {

constexpr std::size_t kTexels = 64 * 64, kMostRecords = 1u << 20;

Bytes frame_of(std::span<const std::byte> content) {
    Bytes frame(ZSTD_compressBound(content.size()));
    frame.resize(ZSTD_compress(frame.data(), frame.size(), content.data(), content.size(), 1));
    return frame;
}

/// What one zstd frame holds, where it is one and holds what it says it does, `size` bytes.
std::optional<Bytes> content_of(std::span<const std::byte> frame, std::size_t size) {
    if (frame.size() < 4 || get_field<std::uint32_t>(frame, 0) != 0xFD2FB528u ||
        ZSTD_getFrameContentSize(frame.data(), frame.size()) != size ||
        ZSTD_findFrameCompressedSize(frame.data(), frame.size()) != frame.size())
        return {};
    Bytes content(size);
    if (ZSTD_decompress(content.data(), size, frame.data(), frame.size()) != size) return {};
    return content;
}

/// The codes that FORMATS.md says a page of this form has.
PageCodes codes_of(std::uint8_t form, std::size_t width, std::span<const std::byte> content) {
    PageCodes codes{};
    const auto at = [&](std::size_t x, std::size_t z) { return x == 0 || z == 0 ? 0 : codes[(z - 1) * 64 + x - 1]; };
    for (std::size_t i = 0; i < kTexels; ++i) {
        std::uint32_t word = 0;
        for (std::size_t b = 0; b < width; ++b)  // b = 0: the lowest byte
            word |= std::to_integer<std::uint32_t>(form == 1 ? content[i * width + b]
                                                             : content[(width - 1 - b) * kTexels + i])
                    << (8 * b);
        if (form == 2) {
            const std::uint32_t d = (word & 1) != 0 ? 0u - (word / 2) - 1u : word / 2;
            const std::size_t x = i % 64 + 1, z = i / 64 + 1;  // of `at`: 0 is outside
            word = d + at(x - 1, z) + at(x, z - 1) - at(x - 1, z - 1);
            if (width == 2) word &= 0xffff;
        }
        codes[i] = word;
    }
    if (width == 2)
        for (std::uint32_t& code : codes) code <<= 16;
    return codes;
}

Bytes sealed_page(std::uint8_t form, std::uint8_t width, std::uint32_t code, const PageCodes& codes,
                  std::span<const std::byte> frame) {
    Bytes blob(16);
    put_field(blob, 0, std::uint8_t{1});
    put_field(blob, 1, form);
    put_field(blob, 2, width);
    put_field(blob, 4, code);
    put_field(blob, 8, hash_bytes(std::as_bytes(std::span(codes))));
    append(blob, frame);
    return blob;
}

/// `expected`: nullptr where it is not known whether it is good.
void check_page(Bytes blob, const PageCodes* expected) {
    if (expected != nullptr) {
        blob[8] ^= std::byte{1};
        check(!decode_page(blob, "page").ok(), "a page with another checksum is refused");
        blob[8] ^= std::byte{1};
    }
    const auto codes = decode_page(blob, "page");
    if (!codes) {
        check(codes.error().code == ErrorCode::FileFormat && codes.error().message.starts_with("page: "),
              "an error says where");
        check(expected == nullptr, "a page in good order is read");
        return;
    }
    check(expected == nullptr || **codes == *expected, "a page is read as the format says");
    check(hash_of(**codes) == get_field<std::uint64_t>(blob, 8), "a page that is read has its checksum");
    for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16}) {
        const Bytes again = encode_page(**codes, precision);
        const auto back = decode_page(again, "page");
        check(back.ok() && **back == **codes, "a page comes back");
    }
}

void pages(Input& input, bool is_raw_frame) {
    const std::uint8_t form = input.byte() % 3, width = input.flag() ? 2 : 4;
    if (form == 0) {
        PageCodes codes;
        codes.fill(input.number<std::uint32_t>());
        return check_page(sealed_page(0, 0, codes[0], codes, {}), &codes);
    }
    Bytes frame, content;
    if (is_raw_frame) {  // with the checksum of what zstd makes of it
        frame = copy_of(input.rest());
        const std::optional<Bytes> found = content_of(frame, kTexels * width);
        content = found.value_or(Bytes(kTexels * width));
        const PageCodes codes = codes_of(form, width, content);
        return check_page(sealed_page(form, width, 0, codes, frame), found ? &codes : nullptr);
    }
    content = repeated(input.rest(), kTexels * width);
    const PageCodes codes = codes_of(form, width, content);
    check_page(sealed_page(form, width, 0, codes, frame_of(content)), &codes);
}

void check_records(Bytes blob, const Bytes* expected) {
    if (expected != nullptr) {
        blob[8] ^= std::byte{1};
        check(!decode_records(blob, kMostRecords, "records").ok(), "records with another checksum are refused");
        blob[8] ^= std::byte{1};
    }
    const auto records = decode_records(blob, kMostRecords, "records");
    if (!records) {
        check(records.error().code == ErrorCode::FileFormat && records.error().message.starts_with("records: "),
              "an error says where");
        check(expected == nullptr, "records in good order are read");
        return;
    }
    check(expected == nullptr || *records == *expected, "records are read as the format says");
    const std::size_t stride = get_field<std::uint16_t>(blob, 2);
    const auto back = decode_records(encode_records(*records, stride), records->size(), "records");
    check(back.ok() && *back == *records, "records come back");
    check(records->empty() || !decode_records(blob, records->size() - 1, "records").ok(), "the bound is kept");
}

void records(Input& input, bool is_raw_frame) {
    const std::size_t stride = input.flag() ? input.number<std::uint16_t>() : 1 + input.below(100);
    Bytes columns, frame;
    if (is_raw_frame) {
        const std::size_t size = input.number<std::uint16_t>();
        frame = copy_of(input.rest());
        const std::optional<Bytes> found = content_of(frame, size);
        columns = found.value_or(Bytes(size));
        if (!found) frame.push_back(std::byte{1});  // stays none
    } else {
        const std::size_t size = input.number<std::uint16_t>();
        columns = repeated(input.rest(), size);
        frame = frame_of(columns);
    }
    Bytes content(columns.size());
    const std::size_t count = stride == 0 ? 0 : columns.size() / stride;
    for (std::size_t i = 0; i < columns.size(); ++i)
        content[i] = i < count * stride ? columns[i % stride * count + i / stride] : columns[i];
    Bytes blob(16);
    put_field(blob, 0, std::uint8_t{1});
    put_field(blob, 2, static_cast<std::uint16_t>(stride));
    put_field(blob, 4, static_cast<std::uint32_t>(columns.size()));
    put_field(blob, 8, hash_bytes(content));
    append(blob, frame);
    const bool is_good = stride != 0 && content_of(frame, columns.size());
    check_records(blob, is_good ? &content : nullptr);
}

void run(Input input) {
    const std::uint8_t how = input.byte();
    switch (how % 6) {
        case 0:
        case 1:
            return pages(input, how % 6 == 1);
        case 2:
        case 3:
            return records(input, how % 6 == 3);
        case 4:
            return check_page(copy_of(input.rest()), nullptr);
        default:
            return check_records(copy_of(input.rest()), nullptr);
    }
}

}  // namespace
}  // namespace tilth::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    tilth::fuzz::run({data, size});
    return 0;
}
