// world.tlw: what is read is written again byte for byte.
#include "fuzz/fuzz_input.h"
#include "support/fault_files.h"
#include "tilth/core/hash.h"
#include "tilth/store/byte_fields.h"
#include "tilth/store/world_identity.h"

namespace tilth::fuzz {
namespace {

const char* const kPath = "world/world.tlw";
constexpr std::size_t kHeaderBytes = 104;

/// The fields are the fuzzer's; magic, version, length and checksum are right, or nearly.
Bytes sealed(Input& input) {
    const std::uint8_t how = input.byte();
    Bytes bytes = copy_of(input.rest());
    bytes.resize(std::max(bytes.size(), kHeaderBytes));
    put_field(bytes, 0, magic_of("TILTH-W\n"));
    put_field(bytes, 8, std::uint32_t{how < 250 ? 1u : how});
    if (how % 8 != 7) put_field(bytes, 12, static_cast<std::uint32_t>(bytes.size() - kHeaderBytes));
    if (how % 2 == 0) {
        bytes[80] &= std::byte{1}, bytes[81] &= std::byte{1},
            bytes[82] = static_cast<std::byte>(how % 4 == 0 ? 16 : 32);
        std::fill(bytes.begin() + 83, bytes.begin() + 88, std::byte{});
    }
    put_field(bytes, 96, std::uint64_t{0});
    put_field(bytes, 96, hash_bytes(bytes));
    return bytes;
}

void run(Input input) {
    const bool is_raw = input.flag();
    const Bytes bytes = is_raw ? copy_of(input.rest()) : sealed(input);
    test::FaultFiles files;
    check(files.make_folder("world").ok(), "the disk works");
    files.set_bytes(kPath, bytes);
    const Result<WorldIdentity> identity = read_identity(files, "world");
    check(files.counts().most_read_bytes <= kHeaderBytes + 1000, "reads are bounded");
    check(files.bytes(kPath) == bytes, "reading changes nothing");
    if (!identity) {
        check(identity.error().code == ErrorCode::FileFormat, "the file is to blame");
        check(identity.error().message.starts_with(kPath), "an error says where");
        return;
    }
    check(write_identity(files, "world", *identity).ok(), "an identity can be written");
    check(files.bytes(kPath) == bytes, "an identity is written as it was read");
    (void)check_same(*identity, *identity);
}

}  // namespace
}  // namespace tilth::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    tilth::fuzz::run({data, size});
    return 0;
}
