// The structures of pages-<n>.tlp, each by itself, and the names of such files.
#include "fuzz/fuzz_input.h"
#include "tilth/core/hash.h"
#include "tilth/store/byte_fields.h"
#include "tilth/store/log_format.h"

namespace tilth::fuzz {
namespace {

using namespace log_format;

/// The checksum that FORMATS.md calls bound, put behind `bytes`.
void seal(Bytes& bytes, std::size_t size, const FileTag& tag, std::uint64_t offset) {
    bytes.resize(size + 8);
    Bytes all(24);
    put_field(all, 0, tag.salt);
    put_field(all, 8, tag.number);
    put_field(all, 16, offset);
    append(all, std::span(bytes).first(size));
    put_field(bytes, size, hash_bytes(all));
}

void superblock(Bytes bytes, const FileTag& tag, unsigned slot, bool is_sealed) {
    if (is_sealed) {
        bytes.resize(56);
        if (bytes[0] == std::byte{}) std::memcpy(bytes.data(), "TLPS\1\0\0", 8);
        std::fill(bytes.begin() + 48, bytes.end(), std::byte{});  // written as 0, and not read
        seal(bytes, 56, tag, superblock_offset(slot));
    }
    const std::optional<Superblock> read = decode_superblock(bytes, tag, slot);
    if (!read || !is_sealed) return;
    check(std::ranges::equal(encode_superblock(*read, tag, slot), bytes), "a superblock is written as it was read");
    check(!decode_superblock(bytes, tag, slot ^ 1), "and is none in the other slot");
}

void frame(Bytes bytes, const FileTag& tag, std::uint64_t offset, bool is_sealed) {
    if (is_sealed) {
        bytes.resize(32);
        std::ranges::copy(kFrameMagic, bytes.begin());
        for (const std::size_t zero : {6, 7, 20, 21, 22, 23}) bytes[zero] = {};
        seal(bytes, 32, tag, offset);
    }
    const std::optional<FrameHeader> read = decode_frame_header(bytes, tag, offset);
    if (!read || !is_sealed) return;
    check(std::ranges::equal(encode_frame_header(*read, tag, offset), bytes), "a frame is written as it was read");
    check(!decode_frame_header(bytes, tag, offset + 1), "and is none at another place");
}

void index(std::span<const std::byte> payload, std::uint64_t offset) {
    const std::optional<Index> read = decode_index(payload, offset);
    if (!read) return;
    check(std::ranges::equal(encode_index(*read), payload), "an index is written as it was read");
    check(read->previous_end <= offset, "the index before it lies before it");
    for (const AddedBlob& blob : read->added)
        check(blob.entry.offset >= kFirstFrame && blob.entry.offset + blob.entry.frame_bytes() <= offset,
              "blobs lie between the first frame and their index");
}

void header(Bytes bytes, const FileTag& tag, bool is_sealed) {
    if (is_sealed) {
        bytes.resize(40);
        put_field(bytes, 32, hash_bytes(std::span(bytes).first(32)));
    }
    if (check_header(bytes, tag) != HeaderState::Good) return;
    bytes.resize(kHeaderBytes);
    check(get_field<std::uint64_t>(bytes, 16) == tag.salt && get_field<std::uint64_t>(bytes, 24) == tag.number,
          "a good header is this file's");
}

void run(Input input) {
    const std::uint8_t how = input.byte();
    const FileTag tag{input.any_number(), input.any_number()};
    const std::uint64_t offset = input.any_number();
    const bool is_sealed = how >= 64;
    switch (how % 5) {
        case 0:
            return superblock(copy_of(input.rest()), tag, how / 8 % 2, is_sealed);
        case 1:
            return frame(copy_of(input.rest()), tag, offset, is_sealed);
        case 2:
            return index(input.rest(), offset);
        case 3:
            return header(how % 2 == 0 ? copy_of(input.rest()) : copy_of(encode_header(tag)), tag, is_sealed);
        default:
            break;
    }
    const std::string name(text_of(input.rest()));
    if (const std::optional<std::uint64_t> number = number_of(name))
        check(file_name(*number) == name && *number > 0, "a file has one name");
    if (tag.number > 0 && tag.number < ~std::uint64_t{0})
        check(number_of(file_name(tag.number)) == tag.number, "a name is read back");
}

}  // namespace
}  // namespace tilth::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    tilth::fuzz::run({data, size});
    return 0;
}
