// Counters, waiting stamps and strokes: what is read is written and read again as the same.
#include <memory>

#include "fuzz/fuzz_input.h"
#include "tilth/store/byte_fields.h"
#include "tilth/store/page_codec.h"
#include "tilth/store/world_blobs.h"

namespace tilth::fuzz {
namespace {

/// The fuzzer's content, in a version and records that are in order.
Bytes enveloped(std::span<const std::byte> content, std::size_t stride) {
    Bytes blob(8);
    put_field(blob, 0, std::uint32_t{1});
    append(blob, encode_records(content, stride));
    return blob;
}

template <class T>
void check_error(const Result<T>& result) {
    check(result.ok() || (result.error().code == ErrorCode::FileFormat && result.error().message.starts_with("blob: ")),
          "an error says where");
}

void counters(std::span<const std::byte> blob) {
    const Result<WorldCounters> read = decode_counters(blob, "blob");
    check_error(read);
    if (!read) return;
    const Result<WorldCounters> again = decode_counters(encode_counters(*read), "blob");
    check(again.ok() && *again == *read, "counters come back");
}

/// A list of a few numbers in order, as the format wants them.
Bytes good_counters(Input& input) {
    Bytes content(32);
    const std::size_t done = input.below(5), undone = input.below(5);
    put_field(content, 0, input.any_number());
    put_field(content, 8, input.any_number());
    put_field(content, 16, std::uint64_t{done});
    put_field(content, 24, std::uint64_t{undone});
    std::uint64_t number = 0;
    const auto put = [&](std::uint64_t value) { append(content, std::as_bytes(std::span(&value, 1))); };
    for (std::size_t i = 0; i < done; ++i) put(number += input.byte());
    number += 1000;
    for (std::size_t i = 0; i < undone; ++i) put(number -= input.byte());
    return content;
}

/// Records whose small members are in their ranges.
Bytes good_records(Input& input, std::size_t stride) {
    const std::size_t count = 1 + input.below(20);
    const bool is_waiting = stride == 80;
    Bytes content = repeated(input.piece(200), count * stride);
    for (std::size_t i = 0; i < count; ++i) {
        const std::span<std::byte> record = std::span(content).subspan(i * stride, stride);
        record[56] = is_waiting ? std::byte{1} : record[56] & std::byte{1};
        record[57] &= std::byte{3};
        record[58] &= std::byte{1}, record[59] &= std::byte{1};
        std::fill(record.begin() + 60, record.begin() + 64, std::byte{});
        if (is_waiting) std::fill(record.begin() + 76, record.begin() + 80, std::byte{});
    }
    return content;
}

bool is_same(const WaitingStamp& a, const WaitingStamp& b) {
    return a.record == b.record && a.stroke == b.stroke && a.position == b.position;
}

void waiting(std::span<const std::byte> blob) {
    const Result<std::vector<WaitingStamp>> read = decode_waiting(blob, "blob");
    check_error(read);
    if (!read) return;
    check(read->size() * 80 == get_field<std::uint32_t>(blob, 12), "the stamps are all there is");
    const Result<std::vector<WaitingStamp>> again = decode_waiting(encode_waiting(*read), "blob");
    check(again.ok() && std::ranges::equal(*read, *again, is_same), "waiting stamps come back");
}

bool is_same(const Stroke::Images& a, const Stroke::Images& b) {
    return std::ranges::equal(a, b, [](const auto& x, const auto& y) {
        return x.first == y.first && (x.second == nullptr) == (y.second == nullptr) &&
               (x.second == nullptr || *x.second == *y.second);
    });
}

/// What the fields of a stroke's parts say of it.
struct Stated {
    bool is_bad = false;        ///< an image of a map that does not exist
    std::uint64_t version = 0;  ///< of the last part
};

void stroke(const std::vector<Bytes>& parts, std::uint64_t number, const Stated* stated = nullptr) {
    if (!parts.empty()) {
        const Result<std::uint32_t> count = parts_of_stroke(parts.front(), "blob");
        check_error(count);
        check(!count || (*count >= 1 && *count <= kMostStrokeParts), "a stroke has a number of parts");
    }
    const Result<StrokePtr> read = decode_stroke(parts, number, "blob");
    check_error(read);
    if (!read) return;
    check((*read)->number == number && !(*read)->records.empty(), "a stroke has stamps");
    check(stated == nullptr || (!stated->is_bad && (*read)->version == stated->version), "a stroke is what it says");
    for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16}) {
        const std::vector<Bytes> written = encode_stroke(**read, precision);
        const Result<StrokePtr> again = decode_stroke(written, number, "blob");
        check(again.ok() && (*again)->records == (*read)->records && (*again)->version == (*read)->version &&
                  is_same((*again)->coarse, (*read)->coarse) && is_same((*again)->detail, (*read)->detail),
              "a stroke comes back");
    }
}

/// Its header and lists are in order, but for what the fuzzer wants otherwise.
Bytes made_part(Input& input, std::uint32_t part, std::uint32_t parts, std::uint64_t number, Stated& stated) {
    const std::uint8_t how = input.byte();
    Bytes blob(32);
    const std::uint32_t images = input.byte() % 4;
    put_field(blob, 0, std::uint32_t{1});
    put_field(blob, 4, how % 16 == 1 ? input.number<std::uint32_t>() : part);
    put_field(blob, 8, how % 16 == 2 ? input.number<std::uint32_t>() : parts);
    put_field(blob, 12, how % 16 == 3 ? input.number<std::uint32_t>() : images);
    put_field(blob, 16, how % 16 == 4 ? input.any_number() : number);
    stated.version = input.byte();
    put_field(blob, 24, stated.version);
    const auto sized = [&](const Bytes& bytes) {
        const auto size = how % 16 == 5 ? input.number<std::uint32_t>() : static_cast<std::uint32_t>(bytes.size());
        append(blob, std::as_bytes(std::span(&size, 1)));
        append(blob, bytes);
    };
    sized(encode_records(how >= 128 ? copy_of(input.piece(200)) : good_records(input, 64), 64));
    for (std::uint32_t i = 0; i < images; ++i) {
        const std::uint32_t map = how % 16 == 6 ? input.byte() : input.byte() & 1;
        stated.is_bad |= map > 1;
        append(blob, std::as_bytes(std::span(&map, 1)));
        const std::uint64_t place = input.number<std::uint16_t>();
        append(blob, std::as_bytes(std::span(&place, 1)));
        const Bytes pattern = copy_of(input.piece(input.below(16)));
        if (pattern.empty()) {
            sized({});
            continue;
        }
        PageCodes codes;
        for (std::size_t at = 0; at < codes.size(); ++at)
            codes[at] = std::to_integer<std::uint32_t>(pattern[at / 64 % pattern.size()]) << 20;
        sized(encode_page(codes, HeightPrecision::bits32));
    }
    return blob;
}

void run(Input input) {
    const std::uint8_t how = input.byte();
    switch (how % 8) {
        case 0:
            return counters(enveloped(good_counters(input), 8));
        case 1:
            return counters(enveloped(input.rest(), 8));
        case 2:
            return waiting(enveloped(good_records(input, 80), 80));
        case 3:
            return waiting(enveloped(input.rest(), 80));
        case 4:
        case 5: {
            const auto parts = static_cast<std::uint32_t>(1 + input.below(3));
            const std::uint64_t number = input.any_number();
            std::vector<Bytes> made;
            Stated stated;
            for (std::uint32_t part = 0; part < parts; ++part)
                made.push_back(made_part(input, part, parts, number, stated));
            if (how < 192) return stroke(made, number, &stated);
            damage(made.back(), input);
            return stroke(made, number);
        }
        case 6:
            return stroke({copy_of(input.rest())}, how / 8);
        default:
            return how < 128 ? counters(input.rest()) : waiting(input.rest());
    }
}

}  // namespace
}  // namespace tilth::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    tilth::fuzz::run({data, size});
    return 0;
}
