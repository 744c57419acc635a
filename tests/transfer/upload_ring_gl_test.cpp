// Do the bytes arrive, in every bit and nowhere else, and is no slot written that the GPU may still read?
#include "support/gl_state.h"
#include "tilth/core/log.h"
#include "tilth/gl/state_guard.h"
#include "transfer_support.h"

namespace tilth {
namespace {

using gl::Format;
using test::RecordingGl;

/// true: mapped persistently, where the context can.
class UploadRingTest : public test::TransferTest, public ::testing::WithParamInterface<bool> {
protected:
    void SetUp() override {
        test::TransferTest::SetUp();
        if (IsSkipped() || HasFatalFailure()) return;
        if (GetParam() && !test::device().capabilities().buffer_storage)
            GTEST_SKIP() << "no GL_ARB_buffer_storage: " << test::device().capabilities().renderer;
        make({.buffer_storage = GetParam()});
    }
    UploadRing ring_of(std::size_t slot_bytes, int slots) {
        UploadRing ring = test::value(UploadRing::create(device(), slot_bytes, slots));
        EXPECT_EQ(ring.persistent(), GetParam());
        return ring;
    }
    /// One slot's worth: written, uploaded, closed. False: not now.
    bool send(UploadRing& ring, gl::Texture2D& texture, const gl::Rect& rect, const std::vector<std::byte>& part) {
        const auto bytes = ring.begin(part.size());
        if (!bytes) return false;
        EXPECT_FALSE(recorder().busy(bytes->data())) << "the GPU may still read the slot";
        std::memcpy(bytes->data(), part.data(), part.size());
        const bool sent = ring.to_texture(texture, 0, rect, 0, stats_);
        ring.end();
        return sent;
    }
    gl::TransferStats stats_;
};

INSTANTIATE_TEST_SUITE_P(Mapped, UploadRingTest, ::testing::Bool(),
                         [](const auto& kind) { return kind.param ? "persistently" : "for_each_use"; });

TEST_P(UploadRingTest, rectangles_arrive_in_every_bit_and_touch_nothing_else) {
    constexpr int width = 37, height = 29;
    UploadRing ring = ring_of(4096, 2);
    EXPECT_EQ(ring.bytes(), 8192u);
    for (Format format : {Format::R16, Format::Rg8, Format::Rg16F}) {
        std::vector<std::byte> expected = test::random_texels(format, width * height * test::texel_bytes(format), 1);
        gl::Texture2D texture = test::texture_of(device(), format, width, height, expected);
        unsigned seed = 10;
        for (const gl::Rect rect :
             {gl::Rect{3, 5, 20, 24}, {0, 0, 1, 1}, {36, 28, 37, 29}, {1, 7, 36, 8}, {9, 0, 10, 29}})
            for (std::size_t offset : {0u, 6u, 1022u}) {
                // 6 and 1022: no multiples of 4. What lies before the offset must not be read.
                const auto part = test::random_texels(format, test::bytes_in(rect, format), ++seed);
                const auto bytes = test::until([&] { return ring.begin(offset + part.size()); });
                ASSERT_TRUE(bytes);
                ASSERT_EQ(bytes->size(), offset + part.size());
                std::memset(bytes->data(), 0x5a, offset);
                std::memcpy(bytes->data() + offset, part.data(), part.size());
                ASSERT_TRUE(ring.to_texture(texture, 0, rect, offset, stats_));
                ring.end();
                test::paste(expected, width, rect, format, part);
                ASSERT_EQ(test::texels_of(texture), expected) << gl::info_of(format).name << " from byte " << offset
                                                              << ", rectangle " << rect.min_x << ", " << rect.min_y;
            }
    }
}

TEST_P(UploadRingTest, one_slot_feeds_several_textures_and_counts_its_bytes) {
    UploadRing ring = ring_of(1000, 1);
    gl::Texture2D high = test::texture_of(device(), Format::R16, 8, 8, std::vector<std::byte>(128));
    gl::Texture2D low = test::texture_of(device(), Format::R16, 8, 8, std::vector<std::byte>(128));
    const auto part = test::random_texels(Format::R16, 256, 3);
    const auto bytes = ring.begin(256);
    ASSERT_TRUE(bytes);
    std::memcpy(bytes->data(), part.data(), 256);
    EXPECT_TRUE(ring.to_texture(high, 0, {0, 0, 8, 8}, 0, stats_));
    EXPECT_TRUE(ring.to_texture(low, 0, {0, 0, 8, 8}, 128, stats_));
    EXPECT_TRUE(ring.to_texture(low, 0, {3, 3, 3, 8}, 0, stats_)) << "nothing to upload";
    ring.end();
    EXPECT_EQ(stats_, (gl::TransferStats{256, 0}));
    EXPECT_EQ(recorder().count("glTexSubImage2D"), 2 + 2) << "two were the test's own";
    EXPECT_EQ(test::texels_of(high), std::vector<std::byte>(part.begin(), part.begin() + 128));
    EXPECT_EQ(test::texels_of(low), std::vector<std::byte>(part.begin() + 128, part.end()));
}

TEST_P(UploadRingTest, many_slices_through_few_slots) {
    constexpr int side = 256, rows = 16;
    UploadRing ring = ring_of(side * rows * 2, 3);
    gl::Texture2D texture =
        test::texture_of(device(), Format::R16, side, side, std::vector<std::byte>(side * side * 2));
    for (unsigned round = 1; round <= 3; ++round) {
        const auto image = test::random_texels(Format::R16, side * side * 2, round);
        for (int y = 0; y < side; y += rows) {
            // Every third fence is late, so the ring runs full now and then.
            if (y % (3 * rows) == 0) recorder().polls_expired = 2;
            const gl::Rect rect{0, y, side, y + rows};
            const auto part = test::cut(image, side, rect, Format::R16);
            ASSERT_TRUE(test::until([&] { return send(ring, texture, rect, part); }));
        }
        EXPECT_EQ(test::texels_of(texture), image) << "round " << round;
    }
    EXPECT_EQ(stats_.bytes_up, 3u * side * side * 2);
}

TEST_P(UploadRingTest, with_all_slots_in_flight_it_gives_nothing_and_does_not_wait) {
    UploadRing ring = ring_of(128, 3);
    gl::Texture2D texture = test::texture_of(device(), Format::R16, 8, 8, std::vector<std::byte>(128));
    std::vector<std::byte> expected = test::texels_of(texture);
    recorder().polls_expired = 5;
    for (int y = 0; y < 3; ++y) {
        const auto part = test::random_texels(Format::R16, 16, static_cast<unsigned>(y));
        ASSERT_TRUE(send(ring, texture, {0, y, 8, y + 1}, part)) << "slot " << y << " was never used";
        test::paste(expected, 8, {0, y, 8, y + 1}, Format::R16, part);
    }
    EXPECT_EQ(recorder().count("glClientWaitSync"), 0) << "no slot had a fence yet";
    for (int frame = 0; frame < 5; ++frame) {
        EXPECT_FALSE(ring.begin(16));
        EXPECT_EQ(recorder().count("glClientWaitSync"), frame + 1) << "one poll of the oldest fence";
    }
    EXPECT_TRUE(test::until([&] { return ring.begin(16); }));
    ring.end();
    EXPECT_EQ(test::texels_of(texture), expected);
}

TEST_P(UploadRingTest, a_slot_that_uploaded_nothing_is_free_again) {
    UploadRing ring = ring_of(64, 1);
    for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(ring.begin(64));
        ring.end();
    }
    EXPECT_EQ(recorder().count("glFenceSync"), 0);
}

TEST_P(UploadRingTest, puts_the_hosts_state_back_under_a_guard) {
    UploadRing ring = ring_of(4096, 2);
    gl::Texture2D texture = test::texture_of(device(), Format::R16, 8, 8, std::vector<std::byte>(128));
    gl::Buffer bait = test::value(gl::Buffer::create(device(), "bait", 4096));
    const gl::Api& gl = device().gl();
    for (GLenum what : {GL_UNPACK_ROW_LENGTH, GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_PIXELS}) gl.PixelStorei(what, 5);
    gl.PixelStorei(GL_UNPACK_ALIGNMENT, 8);
    gl.PixelStorei(GL_UNPACK_SWAP_BYTES, GL_TRUE);
    for (GLenum target : {GL_PIXEL_UNPACK_BUFFER, GL_PIXEL_PACK_BUFFER, GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER})
        gl.BindBuffer(target, bait.id());
    const auto part = test::random_texels(Format::R16, 128, 4);
    const test::GlState before = test::capture_state(test::device());
    {
        const gl::StateGuard guard(device());
        ASSERT_TRUE(send(ring, texture, texture.bounds(), part));
        UploadRing another = test::value(UploadRing::create(device(), 64, 2));
    }
    EXPECT_EQ(test::difference(before, test::capture_state(test::device())), "");
    EXPECT_EQ(test::texels_of(texture), part);
    for (GLenum target : {GL_PIXEL_UNPACK_BUFFER, GL_PIXEL_PACK_BUFFER, GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER})
        gl.BindBuffer(target, 0);
}

TEST_P(UploadRingTest, refuses_a_ring_of_nothing) {
    for (const auto& [bytes, slots] : {std::pair{std::size_t{0}, 2}, {std::size_t{16}, 0}}) {
        const auto ring = UploadRing::create(device(), bytes, slots);
        ASSERT_FALSE(ring.ok());
        EXPECT_EQ(ring.error().code, ErrorCode::InvalidArgument);
    }
}

// ---- Faults of the driver (SCIENCE P11).

class UploadRingFaultTest : public test::TransferTest {
protected:
    void SetUp() override {
        test::TransferTest::SetUp();
        if (IsSkipped() || HasFatalFailure()) return;
        make({.buffer_storage = false});
    }
};

TEST_F(UploadRingFaultTest, a_map_that_is_refused_is_tried_again_and_the_data_arrives) {
    UploadRing ring = test::value(UploadRing::create(device(), 128, 2));
    gl::Texture2D texture = test::texture_of(device(), Format::R16, 8, 8, std::vector<std::byte>(128));
    const auto part = test::random_texels(Format::R16, 128, 5);
    recorder().maps_refused = 3;
    for (int frame = 0; frame < 3; ++frame) EXPECT_FALSE(ring.begin(128));
    const auto bytes = ring.begin(128);
    ASSERT_TRUE(bytes);
    std::memcpy(bytes->data(), part.data(), 128);
    gl::TransferStats stats;
    EXPECT_TRUE(ring.to_texture(texture, 0, texture.bounds(), 0, stats));
    ring.end();
    EXPECT_EQ(test::texels_of(texture), part);
}

TEST_F(UploadRingFaultTest, lost_content_is_not_uploaded_but_sent_again) {
    UploadRing ring = test::value(UploadRing::create(device(), 128, 2));
    const auto sentinel = test::random_texels(Format::R16, 128, 6), part = test::random_texels(Format::R16, 128, 7);
    gl::Texture2D texture = test::texture_of(device(), Format::R16, 8, 8, sentinel);
    gl::TransferStats stats;
    const auto attempt = [&] {
        const auto bytes = ring.begin(128);
        if (!bytes) return false;
        std::memcpy(bytes->data(), part.data(), 128);
        const bool first = ring.to_texture(texture, 0, {0, 0, 8, 4}, 0, stats);
        const bool second = ring.to_texture(texture, 0, {0, 4, 8, 8}, 64, stats);
        ring.end();
        EXPECT_EQ(first, second);
        return first && second;
    };
    recorder().contents_lost = 2;
    EXPECT_FALSE(attempt());
    EXPECT_FALSE(attempt());
    EXPECT_EQ(test::texels_of(texture), sentinel) << "not a texel of the lost content";
    EXPECT_EQ(stats.bytes_up, 0u);
    EXPECT_EQ(recorder().count("glFenceSync"), 0) << "nothing reads the slot";
    EXPECT_TRUE(attempt());
    EXPECT_EQ(test::texels_of(texture), part);
    EXPECT_EQ(stats.bytes_up, 128u);
}

TEST_F(UploadRingFaultTest, random_faults_corrupt_nothing) {
    constexpr int side = 32;
    UploadRing ring = test::value(UploadRing::create(device(), side * 2, 2));
    gl::Texture2D texture =
        test::texture_of(device(), Format::R16, side, side, std::vector<std::byte>(side * side * 2));
    std::vector<std::byte> expected(side * side * 2);
    gl::TransferStats stats;
    std::mt19937 random(8);
    for (int i = 0; i < 400; ++i) {
        const int y = static_cast<int>(random() % side);
        const gl::Rect rect{0, y, side, y + 1};
        const auto part = test::random_texels(Format::R16, side * 2, static_cast<unsigned>(i));
        recorder().maps_refused = random() % 5 == 0 ? 2 : 0;
        recorder().contents_lost = random() % 5 == 0 ? 2 : 0;
        recorder().polls_expired = random() % 3 == 0 ? 3 : 0;
        ASSERT_TRUE(test::until([&] {
            const auto bytes = ring.begin(part.size());
            if (!bytes) return false;
            std::memcpy(bytes->data(), part.data(), part.size());
            const bool sent = ring.to_texture(texture, 0, rect, 0, stats);
            ring.end();
            return sent;
        }));
        test::paste(expected, side, rect, Format::R16, part);
    }
    EXPECT_EQ(test::texels_of(texture), expected);
    EXPECT_EQ(stats.bytes_up, 400u * side * 2);
}

class UploadRingRefusedTest : public test::TransferTest {};

TEST_F(UploadRingRefusedTest, a_persistent_map_that_is_refused_gives_the_other_kind_and_says_so) {
    if (!test::device().capabilities().buffer_storage)
        GTEST_SKIP() << "no GL_ARB_buffer_storage: " << test::device().capabilities().renderer;
    make({.buffer_storage = true});
    std::string logged;
    set_log_callback(
        [](LogLevel, std::string_view message, void* user) { *static_cast<std::string*>(user) += message; }, &logged);
    recorder().maps_refused = 1;
    const std::uint64_t before = device().resident_bytes();
    {
        UploadRing ring = test::value(UploadRing::create(device(), 64, 2));
        EXPECT_FALSE(ring.persistent());
        EXPECT_EQ(device().resident_bytes() - before, ring.bytes());
        EXPECT_TRUE(ring.begin(64));
        ring.end();
    }
    set_log_callback(nullptr, nullptr);
    EXPECT_EQ(device().resident_bytes(), before);
    EXPECT_NE(logged.find("upload ring"), std::string::npos) << logged;
}

}  // namespace
}  // namespace tilth
