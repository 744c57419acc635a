// shape-<id>.tls: a library has the shapes of files in good order, all of them, or none; what is read can be written
// and read again.
#include <limits>

#include "fuzz/fuzz_input.h"
#include "support/fault_files.h"
#include "tilth/core/hash.h"
#include "tilth/store/byte_fields.h"
#include "tilth/store/page_codec.h"
#include "tilth/store/shape_files.h"

namespace tilth::fuzz {
namespace {

constexpr std::uint64_t kSalt = 0x5a17;
constexpr std::size_t kHeaderBytes = 64;

void seal(Bytes& bytes) {
    StateHasher hasher;  // of bytes 0..55 and of the hash of the rest, FORMATS.md
    for (std::size_t at = 0; at < 56; at += 8) hasher.add_i64(get_field<std::int64_t>(bytes, at));
    hasher.add_i64(static_cast<std::int64_t>(hash_bytes(std::span(bytes).subspan(kHeaderBytes))));
    put_field(bytes, 56, hasher.digest());
}

/// The hash that the library computes, where there can be such a shape.
std::uint64_t hash_of(const Shape& shape) {
    ShapeLibrary library;
    const Result<ShapeId> added = library.add_exact(shape);
    return added ? library.shape(*added).hash : 0;
}

/// A shape in good order, but for what the fuzzer wants otherwise.
Bytes made_file(Input& input, std::uint32_t id) {
    const std::uint8_t how = input.byte();
    Shape shape{.name = std::string(text_of(input.piece(1 + input.below(20)))), .is_image = input.flag()};
    if (shape.is_image) shape.width = 1 + input.byte() % 16, shape.height = 1 + input.byte() % 16;
    shape.weights.resize(shape.is_image ? static_cast<std::size_t>(shape.width * shape.height)
                                        : std::size_t{kProfileEntries});
    const std::span<const std::byte> pattern = input.piece(input.below(64));
    for (std::size_t i = 0; i < shape.weights.size() && !pattern.empty(); ++i)
        shape.weights[i] = (std::to_integer<std::int32_t>(pattern[i % pattern.size()]) - 128) * 512;
    shape.zero_volume = how % 4 == 1;
    shape.least_radius_texels = how % 8 == 7 ? static_cast<double>(input.number<std::int32_t>()) : 0.5 + input.byte();
    shape.hash = hash_of(shape);

    Bytes bytes(kHeaderBytes);
    put_field(bytes, 0, magic_of("TILTH-S\n"));
    put_field(bytes, 8, std::uint32_t{1});
    put_field(bytes, 12, id);
    put_field(bytes, 16, kSalt);
    put_field(bytes, 24, shape.least_radius_texels);
    put_field(bytes, 32, shape.hash);
    put_field(bytes, 40, shape.width);
    put_field(bytes, 44, shape.height);
    put_field(bytes, 48, static_cast<std::uint32_t>(shape.name.size()));
    put_field(bytes, 52, static_cast<std::uint8_t>(shape.is_image));
    put_field(bytes, 53, static_cast<std::uint8_t>(shape.zero_volume));
    append(bytes, std::as_bytes(std::span(shape.name)));
    append(bytes, encode_records(std::as_bytes(std::span(shape.weights)), 4));
    if (how >= 128) damage(bytes, input);
    if (bytes.size() >= kHeaderBytes && how < 250) seal(bytes);
    return bytes;
}

void run(Input input) {
    const std::uint8_t how = input.byte();
    test::FaultFiles files;
    check(files.make_folder("world").ok(), "the disk works");
    if (how % 2 == 0) {
        Bytes bytes = copy_of(input.rest());
        if (how % 4 == 0 && bytes.size() >= kHeaderBytes) seal(bytes);
        files.set_bytes("world/shape-6.tls", bytes);
    } else {
        files.set_bytes("world/shape-6.tls", made_file(input, 6));
        if (how % 4 == 3) files.set_bytes("world/shape-7.tls", made_file(input, 7));
        if (how % 32 == 31) files.set_bytes("world/shape-9.tls", made_file(input, 9));
    }

    ShapeLibrary shapes;
    const Result<std::uint32_t> count = read_shapes(files, "world", kSalt, shapes);
    if (!count) {
        check(count.error().code == ErrorCode::FileFormat || count.error().code == ErrorCode::InvalidArgument,
              "the files are to blame");
        check(shapes.size() == kBuiltinProfiles, "all shapes or none");
        return;
    }
    check(*count == shapes.size() && *count == kBuiltinProfiles + files.paths().size(), "a shape for every file");
    ShapeLibrary again;
    check(read_shapes(files, "world", kSalt, again).ok() && read_shapes(files, "world", kSalt, shapes).ok(),
          "they can be read twice");
    check(files.make_folder("other").ok(), "the disk works");
    for (std::uint32_t id = kBuiltinProfiles; id < *count; ++id) {
        const Shape& shape = shapes.shape({id});
        check(write_shape(files, "other", kSalt, {id}, shape).ok(), "a shape can be written");
        const std::int64_t one = kWeightOne;
        check(shape.lowest_weight >= -one && shape.highest_weight <= one, "weights are in their range");
    }
    ShapeLibrary copies;
    check(read_shapes(files, "other", kSalt, copies).ok() && copies.size() == shapes.size(), "and read again");
    for (std::uint32_t id = kBuiltinProfiles; id < *count; ++id) {
        const Shape &a = shapes.shape({id}), &b = copies.shape({id});
        check(a.name == b.name && a.hash == b.hash && a.weights == b.weights && a.width == b.width &&
                  a.height == b.height && a.least_radius_texels == b.least_radius_texels &&
                  a.zero_volume == b.zero_volume && a.is_image == b.is_image,
              "the same shape");
    }
}

}  // namespace
}  // namespace tilth::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    tilth::fuzz::run({data, size});
    return 0;
}
