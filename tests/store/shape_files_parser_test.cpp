// Shapes on disk: they come back bit for bit, and a damaged file is refused before anything of it is used.
#include "tilth/store/shape_files.h"

#include <gtest/gtest.h>

#include <random>

#include "support/fault_files.h"

namespace tilth {
namespace {

using test::FaultFiles;

constexpr std::uint64_t kSalt = 77;

std::vector<std::uint16_t> noise(std::int32_t width, std::int32_t height) {
    std::mt19937 random(5);
    std::vector<std::uint16_t> texels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::uint16_t& texel : texels) texel = static_cast<std::uint16_t>(random());
    return texels;
}

/// A profile with both signs, an odd image, a baked one with both signs, and the smallest image.
void add_shapes(ShapeLibrary& shapes) {
    ASSERT_TRUE(shapes
                    .add_profile(
                        "rim", [](double t) { return (1 - t) * (2 * t - 0.5); }, 2.0003)
                    .ok());
    ASSERT_TRUE(shapes.add_image("sole of a boot, größe 45", 37, 23, noise(37, 23)).ok());
    ASSERT_TRUE(shapes.bake("saddle", 16, [](double x, double z) { return x * z; }).ok());
    ASSERT_TRUE(shapes.add_image("dot", 1, 1, noise(1, 1)).ok());
}

std::unique_ptr<FaultFiles> disk_with(const ShapeLibrary& shapes) {
    auto disk = std::make_unique<FaultFiles>();
    EXPECT_TRUE(disk->make_folder("world").ok());
    for (std::uint32_t id = kBuiltinProfiles; id < shapes.size(); ++id)
        EXPECT_TRUE(write_shape(*disk, "world", kSalt, {id}, shapes.shape({id})).ok());
    return disk;
}

void expect_same(const ShapeLibrary& a, const ShapeLibrary& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::uint32_t id = 0; id < a.size(); ++id) {
        const Shape &left = a.shape({id}), &right = b.shape({id});
        EXPECT_EQ(left.name, right.name);
        EXPECT_EQ(left.is_image, right.is_image);
        EXPECT_EQ(left.width, right.width);
        EXPECT_EQ(left.height, right.height);
        EXPECT_EQ(left.weights, right.weights);
        EXPECT_EQ(left.lowest_weight, right.lowest_weight);
        EXPECT_EQ(left.highest_weight, right.highest_weight);
        EXPECT_EQ(left.least_radius_texels, right.least_radius_texels);
        EXPECT_EQ(left.zero_volume, right.zero_volume);
        EXPECT_EQ(left.hash, right.hash);
    }
}

TEST(ShapeFiles, ShapesComeBackBitForBit) {
    ShapeLibrary shapes;
    add_shapes(shapes);
    Shape crater = shapes.shape({static_cast<std::uint32_t>(BuiltinProfile::Crater)});
    crater.name = "crater again";  // of zero volume
    ASSERT_TRUE(shapes.add_exact(crater).ok());
    const std::unique_ptr<FaultFiles> disk = disk_with(shapes);
    ShapeLibrary back;
    const Result<std::uint32_t> read = read_shapes(*disk, "world", kSalt, back);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(*read, kBuiltinProfiles + 5);
    expect_same(back, shapes);
    EXPECT_TRUE(back.shape({kBuiltinProfiles + 4}).zero_volume);

    // The host adds its shapes again: the same ids. And it may have added them, or the first of them, before.
    add_shapes(back);
    expect_same(back, shapes);
    EXPECT_TRUE(read_shapes(*disk, "world", kSalt, back).ok());
    expect_same(back, shapes);
    ShapeLibrary some;
    ASSERT_TRUE(some.add_profile(
                        "rim", [](double t) { return (1 - t) * (2 * t - 0.5); }, 2.0003)
                    .ok());
    EXPECT_TRUE(read_shapes(*disk, "world", kSalt, some).ok());
    expect_same(some, shapes);
    // More of them than the world has.
    ASSERT_TRUE(back.add_image("new", 1, 1, noise(1, 1)).ok());
    EXPECT_EQ(*read_shapes(*disk, "world", kSalt, back), kBuiltinProfiles + 5);
}

TEST(ShapeFiles, AFolderWithoutShapesHasTheBuiltInOnes) {
    FaultFiles disk;
    ShapeLibrary shapes;
    ASSERT_TRUE(disk.make_folder("world").ok());
    disk.set_bytes("world/shape-06.tls", {});  // a name that is not ours
    EXPECT_EQ(*read_shapes(disk, "world", kSalt, shapes), kBuiltinProfiles);
}

TEST(ShapeFiles, TheLargestImageIsKept) {
    ShapeLibrary shapes;
    ASSERT_TRUE(shapes.add_image("largest", 4096, 4096, noise(4096, 4096)).ok());
    const std::unique_ptr<FaultFiles> disk = disk_with(shapes);
    ShapeLibrary back;
    ASSERT_TRUE(read_shapes(*disk, "world", kSalt, back).ok());
    EXPECT_EQ(back.shape({kBuiltinProfiles}).hash, shapes.shape({kBuiltinProfiles}).hash);
    EXPECT_EQ(back.shape({kBuiltinProfiles}).weights, shapes.shape({kBuiltinProfiles}).weights);
}

TEST(ShapeFiles, AnotherShapeUnderTheIdOrNameIsRefused) {
    ShapeLibrary shapes;
    add_shapes(shapes);
    const std::unique_ptr<FaultFiles> disk = disk_with(shapes);
    const auto refused = [&](ShapeLibrary& library, const char* because) {
        const std::uint32_t size = library.size();
        const Result<std::uint32_t> read = read_shapes(*disk, "world", kSalt, library);
        ASSERT_FALSE(read.ok());
        EXPECT_EQ(read.error().code, ErrorCode::InvalidArgument);
        EXPECT_NE(read.error().message.find(because), std::string::npos) << read.error().message;
        EXPECT_EQ(library.size(), size);  // nothing was added
    };
    ShapeLibrary other_data, other_order, later_name;
    ASSERT_TRUE(other_data.add_profile("rim", [](double) { return 1.0; }).ok());
    refused(other_data, "shape 6: is 'rim'");
    ASSERT_TRUE(other_order.add_image("dot", 1, 1, noise(1, 1)).ok());
    refused(other_order, "has 'dot' there");
    ASSERT_TRUE(later_name
                    .add_profile(
                        "rim", [](double t) { return (1 - t) * (2 * t - 0.5); }, 2.0003)
                    .ok());
    ASSERT_TRUE(later_name.add_image("sole of a boot, größe 45", 37, 23, noise(37, 23)).ok());
    ASSERT_TRUE(later_name.bake("saddle", 16, [](double x, double z) { return x * z; }).ok());
    ASSERT_TRUE(later_name.add_image("others", 1, 1, noise(1, 1)).ok());
    refused(later_name, "shape 9");
}

TEST(ShapeFiles, AFileThatIsThereIsNeverReplacedByAnother) {
    ShapeLibrary shapes;
    add_shapes(shapes);
    const std::unique_ptr<FaultFiles> disk = disk_with(shapes);
    const std::vector<std::byte> before = disk->bytes("world/shape-6.tls");
    EXPECT_FALSE(write_shape(*disk, "world", kSalt, {6}, shapes.shape({7})).ok());
    EXPECT_EQ(disk->bytes("world/shape-6.tls"), before);
    EXPECT_TRUE(write_shape(*disk, "world", kSalt, {6}, shapes.shape({6})).ok());  // an earlier attempt, again
    EXPECT_EQ(disk->bytes("world/shape-6.tls"), before);
    Shape long_name = shapes.shape({6});
    long_name.name.assign(1001, 'x');
    EXPECT_FALSE(write_shape(*disk, "world", kSalt, {10}, long_name).ok());
    EXPECT_FALSE(disk->exists("world/shape-10.tls"));
}

TEST(ShapeFiles, AMissingNumberIsRefused) {
    ShapeLibrary shapes;
    add_shapes(shapes);
    for (const std::uint32_t missing : {6u, 7u, 8u}) {
        const std::unique_ptr<FaultFiles> disk = disk_with(shapes);
        ASSERT_TRUE(disk->remove(text("world/shape-", missing, ".tls")).ok());
        ShapeLibrary back;
        const Result<std::uint32_t> read = read_shapes(*disk, "world", kSalt, back);
        ASSERT_FALSE(read.ok());
        EXPECT_EQ(read.error().message.rfind(text("world/shape-", missing, ".tls: is missing"), 0), 0u);
        EXPECT_EQ(back.size(), kBuiltinProfiles);
    }
}

TEST(ShapeFiles, OtherWorldsNamesAndVersionsAreRefused) {
    ShapeLibrary shapes, back;
    add_shapes(shapes);
    const std::unique_ptr<FaultFiles> disk = disk_with(shapes);
    const Result<std::uint32_t> other = read_shapes(*disk, "world", kSalt + 1, back);
    ASSERT_FALSE(other.ok());
    EXPECT_NE(other.error().message.find("another world"), std::string::npos);
    std::vector<std::byte> newer = disk->bytes("world/shape-7.tls");
    newer[8] = std::byte{2};
    disk->set_bytes("world/shape-7.tls", newer);
    const Result<std::uint32_t> version = read_shapes(*disk, "world", kSalt, back);
    ASSERT_FALSE(version.ok());
    EXPECT_NE(version.error().message.find("version 2"), std::string::npos);
    disk->set_bytes("world/shape-7.tls", disk->bytes("world/shape-6.tls"));
    const Result<std::uint32_t> renamed = read_shapes(*disk, "world", kSalt, back);
    ASSERT_FALSE(renamed.ok());
    EXPECT_NE(renamed.error().message.find("shape-7.tls: is shape 6"), std::string::npos) << renamed.error().message;
}

TEST(ShapeFiles, TenThousandDamagesAreRefused) {
    ShapeLibrary shapes;
    add_shapes(shapes);
    const std::unique_ptr<FaultFiles> disk = disk_with(shapes);
    std::mt19937_64 random(6);
    for (int round = 0; round < 10'000; ++round) {
        const std::string path = text("world/shape-", 6 + random() % 4, ".tls");
        const std::vector<std::byte> good = disk->bytes(path);
        std::vector<std::byte> bytes = good;
        const std::uint64_t how = random() % 4;
        if (how == 0) {
            bytes.resize(random() % bytes.size());
        } else if (how == 1) {
            bytes.resize(bytes.size() + 1 + random() % 100, static_cast<std::byte>(random()));
        } else {
            for (std::uint64_t flips = 1 + random() % 3; flips > 0; --flips)
                bytes[random() % bytes.size()] ^= static_cast<std::byte>(1u << (random() % 8));
        }
        if (bytes == good) continue;
        disk->set_bytes(path, bytes);
        ShapeLibrary back;
        const Result<std::uint32_t> read = read_shapes(*disk, "world", kSalt, back);
        ASSERT_FALSE(read.ok()) << round;
        ASSERT_EQ(read.error().code, ErrorCode::FileFormat) << read.error().message;
        ASSERT_NE(read.error().message.find(path), std::string::npos) << read.error().message;
        ASSERT_EQ(back.size(), kBuiltinProfiles);
        disk->set_bytes(path, good);
    }
}

// P2: a disk that is full, or loses power, at every operation of the write: the file is wholly there or not at all.
TEST(ShapeFiles, WritingIsAllOrNothing) {
    ShapeLibrary shapes;
    add_shapes(shapes);
    for (const test::Fault fault : {test::Fault::NoSpace, test::Fault::PowerOff})
        for (std::uint64_t operation = 1; operation < 12; ++operation)
            for (std::uint64_t seed = 0; seed < 8; ++seed) {
                FaultFiles disk;
                ASSERT_TRUE(disk.make_folder("world").ok());
                ASSERT_TRUE(disk.sync_folder("").ok());
                disk.fail_at(operation, fault, seed);
                const Result<void> written = write_shape(disk, "world", kSalt, {6}, shapes.shape({6}));
                disk.make_room();
                const std::unique_ptr<FaultFiles> after = disk.crash(seed);
                ShapeLibrary back;
                const Result<std::uint32_t> read = read_shapes(*after, "world", kSalt, back);
                ASSERT_TRUE(read.ok()) << read.error().message;
                if (written) {
                    ASSERT_EQ(*read, 7u);
                }
                ASSERT_TRUE(write_shape(disk, "world", kSalt, {6}, shapes.shape({6})).ok());
                const std::unique_ptr<FaultFiles> later = disk.crash(seed);
                ShapeLibrary again;
                ASSERT_EQ(*read_shapes(*later, "world", kSalt, again), 7u);
            }
}

}  // namespace
}  // namespace tilth
