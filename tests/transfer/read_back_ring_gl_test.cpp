// Do the texels come back, in every bit, and is no buffer mapped before its fence has passed?
#include "support/gl_state.h"
#include "tilth/gl/state_guard.h"
#include "transfer_support.h"

namespace tilth {
namespace {

using gl::Format;
using State = ReadBackRing::State;

class ReadBackRingTest : public test::TransferTest {
protected:
    void SetUp() override {
        test::TransferTest::SetUp();
        if (IsSkipped() || HasFatalFailure()) return;
        make({});
    }
    /// Polls until the ticket is spent. Nothing: it failed.
    std::optional<std::vector<std::byte>> fetch(ReadBackRing& ring, std::uint64_t ticket) {
        std::optional<std::vector<std::byte>> taken;
        State last = State::Pending;
        test::until([&] {
            last =
                ring.poll(ticket, [&](std::span<const std::byte> bytes) { taken.emplace(bytes.begin(), bytes.end()); });
            return last != State::Pending;
        });
        EXPECT_EQ(last, taken ? State::Done : State::Failed);
        return taken;
    }
    std::optional<std::uint64_t> begin(ReadBackRing& ring, const gl::Texture2D& texture, const gl::Rect& rect) {
        const ReadBackRing::Piece piece[] = {{&texture, rect}};
        return ring.begin(piece, stats_);
    }
    gl::TransferStats stats_;
};

TEST_F(ReadBackRingTest, rectangles_come_back_in_every_bit) {
    constexpr int width = 37, height = 29;
    ReadBackRing ring = test::value(ReadBackRing::create(device(), 8192, 2));
    EXPECT_EQ(ring.bytes(), 16384u);
    for (Format format : {Format::R16, Format::Rg8, Format::Rg16F}) {
        const auto image = test::random_texels(format, width * height * test::texel_bytes(format), 1);
        const gl::Texture2D texture = test::texture_of(device(), format, width, height, image);
        for (const gl::Rect rect :
             {gl::Rect{3, 5, 20, 24}, {0, 0, 1, 1}, {36, 28, 37, 29}, {1, 7, 36, 8}, {0, 0, 37, 29}}) {
            stats_ = {};
            const auto ticket = begin(ring, texture, rect);
            ASSERT_TRUE(ticket);
            EXPECT_EQ(stats_, (gl::TransferStats{0, test::bytes_in(rect, format)}));
            EXPECT_EQ(fetch(ring, *ticket), test::cut(image, width, rect, format))
                << gl::info_of(format).name << ", rectangle " << rect.min_x << ", " << rect.min_y;
        }
    }
}

TEST_F(ReadBackRingTest, negative_values_come_back_whatever_the_host_clamps) {
    ReadBackRing ring = test::value(ReadBackRing::create(device(), 4096, 1));
    auto image = test::random_texels(Format::Rg8Snorm, 16 * 16 * 2, 12);
    for (std::byte& byte : image)
        if (byte == std::byte{0x80}) byte = std::byte{0x81};  // both are -1
    const gl::Texture2D texture = test::texture_of(device(), Format::Rg8Snorm, 16, 16, image);
    gl::Framebuffer probe = test::value(gl::Framebuffer::create(device(), "probe"));
    const gl::Texture2D* const colours[] = {&texture};
    probe.attach(colours);
    if (const auto complete = probe.check(); !complete) GTEST_SKIP() << complete.error().message;
    device().gl().ClampColor(GL_CLAMP_READ_COLOR, GL_TRUE);
    const auto ticket = begin(ring, texture, texture.bounds());
    ASSERT_TRUE(ticket);
    EXPECT_EQ(fetch(ring, *ticket), image);
}

TEST_F(ReadBackRingTest, what_went_up_through_one_ring_comes_down_through_the_other) {
    constexpr int side = 64;
    for (bool persistent : {false, true}) {
        make({.buffer_storage = persistent});
        ReadBackRing down = test::value(ReadBackRing::create(device(), side * 4 * 2, 3));
        UploadRing up = test::value(UploadRing::create(device(), side * 4 * 2, 3));
        const auto image = test::random_texels(Format::R16, side * side * 2, 2);
        gl::Texture2D texture =
            test::texture_of(device(), Format::R16, side, side, std::vector<std::byte>(side * side * 2));
        for (int y = 0; y < side; y += 4) {
            const gl::Rect rect{0, y, side, y + 4};
            const auto part = test::cut(image, side, rect, Format::R16);
            const auto bytes = test::until([&] { return up.begin(part.size()); });
            ASSERT_TRUE(bytes);
            std::memcpy(bytes->data(), part.data(), part.size());
            ASSERT_TRUE(up.to_texture(texture, 0, rect, 0, stats_));
            up.end();
            const auto ticket = test::until([&] { return begin(down, texture, rect); });
            ASSERT_TRUE(ticket);
            EXPECT_EQ(fetch(down, *ticket), part) << "rows from " << y;
        }
    }
}

TEST_F(ReadBackRingTest, pieces_of_several_textures_lie_one_behind_the_other) {
    ReadBackRing ring = test::value(ReadBackRing::create(device(), 4096, 1));
    const auto high_image = test::random_texels(Format::R16, 16 * 16 * 2, 3);
    const auto slope_image = test::random_texels(Format::Rg8, 16 * 16 * 2, 4);
    const gl::Texture2D high = test::texture_of(device(), Format::R16, 16, 16, high_image);
    const gl::Texture2D slopes = test::texture_of(device(), Format::Rg8, 16, 16, slope_image);
    const ReadBackRing::Piece pieces[] = {{&high, {1, 2, 6, 5}},
                                          {&slopes, {7, 0, 8, 16}},
                                          {&slopes, {4, 4, 4, 9}},  // empty
                                          {&high, {0, 15, 16, 16}}};
    const auto ticket = ring.begin(pieces, stats_);
    ASSERT_TRUE(ticket);
    std::vector<std::byte> expected = test::cut(high_image, 16, pieces[0].rect, Format::R16);
    for (const auto& part : {test::cut(slope_image, 16, pieces[1].rect, Format::Rg8),
                             test::cut(high_image, 16, pieces[3].rect, Format::R16)})
        expected.insert(expected.end(), part.begin(), part.end());
    EXPECT_EQ(fetch(ring, *ticket), expected);
    EXPECT_EQ(stats_.bytes_down, expected.size());
}

TEST_F(ReadBackRingTest, sees_what_was_drawn_before_it_and_not_after) {
    ReadBackRing ring = test::value(ReadBackRing::create(device(), 64 * 64 * 2, 4));
    const gl::Texture2D texture = test::value(gl::Texture2D::create(device(), "drawn", {Format::R16, 64, 64}));
    gl::Framebuffer target = test::value(gl::Framebuffer::create(device(), "drawn"));
    std::vector<std::uint64_t> tickets;
    for (unsigned code : {1u, 40000u, 65535u, 7u}) {
        const gl::Texture2D* const colours[] = {&texture};
        target.attach(colours);
        const GLfloat colour[] = {(static_cast<float>(code)) / 65535.0f, 0, 0, 0};
        device().gl().ClearBufferfv(GL_COLOR, 0, colour);
        const auto ticket = begin(ring, texture, texture.bounds());
        ASSERT_TRUE(ticket);
        tickets.push_back(*ticket);
    }
    std::size_t i = 0;
    for (unsigned code : {1u, 40000u, 65535u, 7u}) {
        const auto bytes = fetch(ring, tickets[i++]);
        ASSERT_TRUE(bytes);
        std::vector<std::uint16_t> codes(64 * 64);
        std::memcpy(codes.data(), bytes->data(), bytes->size());
        EXPECT_EQ(codes, std::vector<std::uint16_t>(64 * 64, static_cast<std::uint16_t>(code)));
    }
}

TEST_F(ReadBackRingTest, is_pending_until_its_fence_passes_and_maps_nothing_before) {
    ReadBackRing ring = test::value(ReadBackRing::create(device(), 512, 1));
    const auto image = test::random_texels(Format::R16, 512, 5);
    const gl::Texture2D texture = test::texture_of(device(), Format::R16, 16, 16, image);
    const auto ticket = begin(ring, texture, texture.bounds());
    ASSERT_TRUE(ticket);
    recorder().polls_expired = 5;
    for (int frame = 0; frame < 5; ++frame) {
        EXPECT_EQ(ring.poll(*ticket, [](auto) { ADD_FAILURE() << "taken too early"; }), State::Pending);
        EXPECT_EQ(recorder().count("glMapBufferRange"), 0);
    }
    EXPECT_EQ(fetch(ring, *ticket), image);
}

TEST_F(ReadBackRingTest, with_all_slots_taken_it_gives_nothing) {
    ReadBackRing ring = test::value(ReadBackRing::create(device(), 512, 2));
    const auto image = test::random_texels(Format::R16, 512, 6);
    const gl::Texture2D texture = test::texture_of(device(), Format::R16, 16, 16, image);
    const auto first = begin(ring, texture, texture.bounds()), second = begin(ring, texture, texture.bounds());
    ASSERT_TRUE(first && second);
    EXPECT_NE(*first, *second);
    const auto reads = recorder().count("glReadPixels");
    stats_ = {};
    EXPECT_FALSE(begin(ring, texture, texture.bounds()));
    EXPECT_EQ(recorder().count("glReadPixels"), reads);
    EXPECT_EQ(stats_, gl::TransferStats{});
    // The second first: tickets are spent in any order.
    EXPECT_EQ(fetch(ring, *second), image);
    const auto third = begin(ring, texture, {1, 1, 5, 5});
    ASSERT_TRUE(third);
    EXPECT_EQ(fetch(ring, *first), image);
    EXPECT_EQ(fetch(ring, *third), test::cut(image, 16, {1, 1, 5, 5}, Format::R16));
}

TEST_F(ReadBackRingTest, a_cancelled_slot_is_free_once_its_fence_has_passed) {
    ReadBackRing ring = test::value(ReadBackRing::create(device(), 512, 1));
    const auto image = test::random_texels(Format::R16, 512, 7);
    const gl::Texture2D texture = test::texture_of(device(), Format::R16, 16, 16, image);
    const auto ticket = begin(ring, texture, texture.bounds());
    ASSERT_TRUE(ticket);
    ring.cancel(*ticket);
    recorder().polls_expired = 2;
    EXPECT_FALSE(begin(ring, texture, texture.bounds()));
    EXPECT_FALSE(begin(ring, texture, texture.bounds()));
    const auto again = test::until([&] { return begin(ring, texture, {2, 2, 9, 9}); });
    ASSERT_TRUE(again);
    EXPECT_NE(*again, *ticket);
    EXPECT_EQ(fetch(ring, *again), test::cut(image, 16, {2, 2, 9, 9}, Format::R16));
    EXPECT_EQ(recorder().count("glMapBufferRange"), 1) << "nobody wanted the first";
}

TEST_F(ReadBackRingTest, keeps_no_deleted_texture_alive) {
    ReadBackRing ring = test::value(ReadBackRing::create(device(), 512, 1));
    std::optional<gl::Texture2D> texture = test::texture_of(device(), Format::R16, 16, 16, std::vector<std::byte>(512));
    ASSERT_TRUE(begin(ring, *texture, texture->bounds()));
    // The ring's is the only framebuffer of this device, and still bound.
    GLint attached = -1;
    device().gl().GetFramebufferAttachmentParameteriv(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                                                      GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE, &attached);
    EXPECT_EQ(attached, GL_NONE);
}

TEST_F(ReadBackRingTest, puts_the_hosts_state_back_under_a_guard) {
    const auto image = test::random_texels(Format::R16, 512, 8);
    const gl::Texture2D texture = test::texture_of(device(), Format::R16, 16, 16, image);
    gl::Buffer bait = test::value(gl::Buffer::create(device(), "bait", 4096));
    const gl::Api& gl = device().gl();
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    for (GLenum what : {GL_PACK_ROW_LENGTH, GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS}) gl.PixelStorei(what, 5);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 8);
    gl.PixelStorei(GL_PACK_SWAP_BYTES, GL_TRUE);
    gl.ClampColor(GL_CLAMP_READ_COLOR, GL_TRUE);
    for (GLenum target : {GL_PIXEL_UNPACK_BUFFER, GL_PIXEL_PACK_BUFFER, GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER})
        gl.BindBuffer(target, bait.id());
    const test::GlState before = test::capture_state(test::device());
    {
        const gl::StateGuard guard(device());
        ReadBackRing ring = test::value(ReadBackRing::create(device(), 512, 1));
        const auto ticket = begin(ring, texture, texture.bounds());
        ASSERT_TRUE(ticket);
        EXPECT_EQ(fetch(ring, *ticket), image);
    }
    EXPECT_EQ(test::difference(before, test::capture_state(test::device())), "");
    for (GLenum target : {GL_PIXEL_UNPACK_BUFFER, GL_PIXEL_PACK_BUFFER, GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER})
        gl.BindBuffer(target, 0);
}

TEST_F(ReadBackRingTest, refuses_a_ring_of_nothing) {
    for (const auto& [bytes, slots] : {std::pair{std::size_t{0}, 2}, {std::size_t{16}, 0}}) {
        const auto ring = ReadBackRing::create(device(), bytes, slots);
        ASSERT_FALSE(ring.ok());
        EXPECT_EQ(ring.error().code, ErrorCode::InvalidArgument);
    }
}

// ---- Faults of the driver (SCIENCE P11).

TEST_F(ReadBackRingTest, a_failed_map_or_lost_content_spends_the_ticket_takes_nothing_and_can_be_tried_again) {
    ReadBackRing ring = test::value(ReadBackRing::create(device(), 512, 1));
    const auto image = test::random_texels(Format::R16, 512, 9);
    const gl::Texture2D texture = test::texture_of(device(), Format::R16, 16, 16, image);
    for (int* fault : {&recorder().maps_refused, &recorder().contents_lost}) {
        *fault = 1;
        const auto ticket = begin(ring, texture, texture.bounds());
        ASSERT_TRUE(ticket);
        EXPECT_EQ(fetch(ring, *ticket), std::nullopt) << "bytes that the driver lost";
        const auto again = begin(ring, texture, texture.bounds());
        ASSERT_TRUE(again) << "the slot is free";
        EXPECT_EQ(fetch(ring, *again), image);
    }
}

TEST_F(ReadBackRingTest, random_faults_corrupt_nothing) {
    constexpr int side = 32;
    ReadBackRing ring = test::value(ReadBackRing::create(device(), side * 2, 3));
    const auto image = test::random_texels(Format::R16, side * side * 2, 10);
    const gl::Texture2D texture = test::texture_of(device(), Format::R16, side, side, image);
    std::mt19937 random(11);
    struct Pending {
        std::uint64_t ticket;
        gl::Rect rect;
    };
    std::vector<Pending> pending;
    int done = 0, failed = 0, cancelled = 0;
    for (int frame = 0; frame < 3000 && done < 200; ++frame) {
        recorder().maps_refused = random() % 5 == 0;
        recorder().contents_lost = random() % 5 == 0;
        recorder().polls_expired = random() % 2 == 0 ? 2 : 0;
        const int y = static_cast<int>(random() % side);
        if (const auto ticket = begin(ring, texture, {0, y, side, y + 1}))
            pending.push_back({*ticket, {0, y, side, y + 1}});
        std::erase_if(pending, [&](const Pending& p) {
            if (random() % 16 == 0) {
                ring.cancel(p.ticket);
                ++cancelled;
                return true;
            }
            const State state = ring.poll(p.ticket, [&](std::span<const std::byte> bytes) {
                EXPECT_EQ(std::vector<std::byte>(bytes.begin(), bytes.end()),
                          test::cut(image, side, p.rect, Format::R16));
            });
            done += state == State::Done, failed += state == State::Failed;
            return state != State::Pending;
        });
    }
    EXPECT_EQ(done, 200);
    EXPECT_GT(failed, 0);
    EXPECT_GT(cancelled, 0);
}

}  // namespace
}  // namespace tilth
