// A world's identity: every field comes back, every difference is named, nothing damaged is believed.
#include "tilth/store/world_identity.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "support/fault_files.h"
#include "tilth/source/analytic_sources.h"

namespace tilth {
namespace {

using test::FaultFiles;

WorldIdentity full_identity() {
    return {.settings = {.origin = {-1234.5, 1e9},
                         .spacing_m = 0.1,
                         .quantum_m = 1.0 / 64,
                         .mirror = true,
                         .detail = false,
                         .texels_per_post = 7,
                         .tile_size = 4096,
                         .precision = HeightPrecision::bits16},
            .width = 16384,
            .depth = 2,
            .middle_m = -17.25,
            .original_hash = 0xfedc'ba98'7654'3210,
            .salt = 0x0123'4567'89ab'cdef,
            .heights = "Gelände, ridged 7"};
}

void expect_same(const WorldIdentity& a, const WorldIdentity& b) {
    EXPECT_TRUE(check_same(a, b).ok());
    EXPECT_EQ(a.salt, b.salt);
    EXPECT_EQ(a.heights, b.heights);
}

std::unique_ptr<FaultFiles> disk_with(const WorldIdentity& identity) {
    auto disk = std::make_unique<FaultFiles>();
    EXPECT_TRUE(disk->make_folder("world").ok());
    const Result<void> written = write_identity(*disk, "world", identity);
    EXPECT_TRUE(written.ok()) << (written.ok() ? "" : written.error().message);
    return disk;
}

TEST(WorldIdentity, ComesBack) {
    WorldIdentity identity = full_identity();
    for (const std::size_t length : {0u, 1u, 17u, 1000u}) {
        identity.heights.assign(length, '\0');
        for (std::size_t i = 0; i < length; ++i) identity.heights[i] = static_cast<char>(i);
        const std::unique_ptr<FaultFiles> disk = disk_with(identity);
        const Result<WorldIdentity> read = read_identity(*disk, "world");
        ASSERT_TRUE(read.ok()) << read.error().message;
        expect_same(*read, identity);
        EXPECT_EQ(disk->bytes("world/world.tlw").size(), 104 + length);
    }
    identity.heights.assign(1001, 'x');
    FaultFiles disk;
    ASSERT_TRUE(disk.make_folder("world").ok());
    const Result<void> too_long = write_identity(disk, "world", identity);
    ASSERT_FALSE(too_long.ok());
    EXPECT_EQ(too_long.error().message.rfind("heights:", 0), 0u);
    EXPECT_TRUE(disk.paths().empty());
    const Result<WorldIdentity> nothing = read_identity(disk, "world");
    ASSERT_FALSE(nothing.ok());
    EXPECT_EQ(nothing.error().code, ErrorCode::NotFound);
}

TEST(WorldIdentity, OfAGround) {
    const auto source = std::make_shared<FlatSource>(33, 10.0);
    const Result<std::unique_ptr<Ground>> ground = Ground::create(source, {.spacing_m = 0.5, .mirror = true});
    ASSERT_TRUE(ground.ok());
    const WorldIdentity identity = identity_of(**ground);
    EXPECT_EQ(identity.width, 33);  // the source's, not the mirrored world's
    EXPECT_EQ(identity.depth, 33);
    EXPECT_EQ(identity.settings.quantum_m, (*ground)->map(MapKind::Coarse).codec.quantum_m);
    EXPECT_EQ(identity.settings.spacing_m, 0.5);
    EXPECT_EQ(identity.original_hash, (*ground)->coarse_hash());
    EXPECT_EQ(identity.salt, 0u);
    // The default quantum and the same one asked for are the same world.
    GroundSettings settled = (*ground)->settings();
    settled.quantum_m = identity.settings.quantum_m;
    const Result<std::unique_ptr<Ground>> again = Ground::create(source, settled);
    ASSERT_TRUE(again.ok());
    EXPECT_TRUE(check_same(identity, identity_of(**again)).ok());
    // Another height is another world, though flat ground has the same codes at any height.
    const Result<std::unique_ptr<Ground>> higher = Ground::create(std::make_shared<FlatSource>(33, 11.0), settled);
    ASSERT_TRUE(higher.ok());
    EXPECT_EQ((*higher)->coarse_hash(), (*ground)->coarse_hash());
    EXPECT_FALSE(check_same(identity, identity_of(**higher)).ok());
}

TEST(WorldIdentity, EveryDifferenceIsNamedWithBothValues) {
    const struct {
        const char* field;
        const char* stored;
        const char* given;
        std::function<void(WorldIdentity&)> change;
    } cases[] = {
        {"origin.x", "-1234.5", "7", [](WorldIdentity& w) { w.settings.origin.x = 7; }},
        {"origin.z", "1000000000", "8", [](WorldIdentity& w) { w.settings.origin.z = 8; }},
        {"spacing", "0.1", "0.2", [](WorldIdentity& w) { w.settings.spacing_m = 0.2; }},
        {"quantum", "0.015625", "0.5", [](WorldIdentity& w) { w.settings.quantum_m = 0.5; }},
        {"mirror", "yes", "no", [](WorldIdentity& w) { w.settings.mirror = false; }},
        {"detail", "no", "yes", [](WorldIdentity& w) { w.settings.detail = true; }},
        {"texels_per_post", "7", "3", [](WorldIdentity& w) { w.settings.texels_per_post = 3; }},
        {"tile_size", "4096", "64", [](WorldIdentity& w) { w.settings.tile_size = 64; }},
        {"precision", "16 bits", "32 bits", [](WorldIdentity& w) { w.settings.precision = HeightPrecision::bits32; }},
        {"heights: width", "16384", "5", [](WorldIdentity& w) { w.width = 5; }},
        {"heights: depth", "2 posts", "6 posts", [](WorldIdentity& w) { w.depth = 6; }},
        {"heights: middle", "-17.25", "3", [](WorldIdentity& w) { w.middle_m = 3; }},
        {"heights: hash", "fedcba9876543210", "0000000000000001", [](WorldIdentity& w) { w.original_hash = 1; }},
    };
    const WorldIdentity stored = full_identity();
    for (const auto& c : cases) {
        WorldIdentity given = stored;
        c.change(given);
        const Result<void> same = check_same(stored, given);
        ASSERT_FALSE(same.ok()) << c.field;
        EXPECT_EQ(same.error().code, ErrorCode::InvalidArgument);
        const std::string& message = same.error().message;
        EXPECT_EQ(message.rfind(std::string(c.field) + ":", 0), 0u) << message;
        const std::size_t first = message.find(c.stored), second = message.find(c.given, first + 1);
        EXPECT_NE(first, std::string::npos) << message;
        EXPECT_NE(second, std::string::npos) << message;
        // And it is stored: reading back gives the changed one.
        const std::unique_ptr<FaultFiles> disk = disk_with(given);
        const Result<WorldIdentity> read = read_identity(*disk, "world");
        ASSERT_TRUE(read.ok());
        expect_same(*read, given);
        EXPECT_FALSE(check_same(stored, *read).ok());
    }
    WorldIdentity other = stored;
    other.salt = 1;
    other.heights = "another note";
    EXPECT_TRUE(check_same(stored, other).ok());
}

TEST(WorldIdentity, DamageIsRefused) {
    const std::unique_ptr<FaultFiles> disk = disk_with(full_identity());
    const std::vector<std::byte> good = disk->bytes("world/world.tlw");
    const auto refused = [&](const std::vector<std::byte>& bytes) {
        disk->set_bytes("world/world.tlw", bytes);
        const Result<WorldIdentity> read = read_identity(*disk, "world");
        ASSERT_FALSE(read.ok());
        ASSERT_EQ(read.error().code, ErrorCode::FileFormat);
        ASSERT_EQ(read.error().message.rfind("world/world.tlw: ", 0), 0u) << read.error().message;
    };
    for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
        std::vector<std::byte> bytes = good;
        bytes[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
        refused(bytes);
    }
    for (std::size_t size = 0; size < good.size(); ++size)
        refused({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)});
    std::mt19937_64 random(8);
    for (int round = 0; round < 10'000; ++round) {
        std::vector<std::byte> bytes = good;
        if (random() % 2 == 0) bytes.resize(random() % 3000, static_cast<std::byte>(random()));
        for (std::uint64_t flips = random() % 20; flips > 0 && !bytes.empty(); --flips)
            bytes[random() % bytes.size()] = static_cast<std::byte>(random());
        if (bytes != good) refused(bytes);
        if (HasFatalFailure()) return;
    }
    std::vector<std::byte> newer = good;
    newer[8] = std::byte{2};
    disk->set_bytes("world/world.tlw", newer);
    EXPECT_NE(read_identity(*disk, "world").error().message.find("version 2"), std::string::npos);
}

TEST(WorldIdentity, WritingIsAllOrNothing) {
    for (std::uint64_t operation = 1; operation < 10; ++operation)
        for (std::uint64_t seed = 0; seed < 8; ++seed) {
            FaultFiles disk;
            ASSERT_TRUE(disk.make_folder("world").ok());
            ASSERT_TRUE(disk.sync_folder("").ok());
            disk.fail_at(operation, test::Fault::PowerOff, seed);
            const Result<void> written = write_identity(disk, "world", full_identity());
            const std::unique_ptr<FaultFiles> after = disk.crash(seed);
            const Result<WorldIdentity> read = read_identity(*after, "world");
            if (read)
                expect_same(*read, full_identity());
            else
                ASSERT_EQ(read.error().code, ErrorCode::NotFound);
            if (written) {
                ASSERT_TRUE(read.ok());
            }
        }
}

}  // namespace
}  // namespace tilth
