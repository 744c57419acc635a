// Textures, buffers, framebuffers: contents arrive whatever the host left in the pixel store, sizes are counted, and
// what cannot be is refused.
#include <gtest/gtest.h>

#include <numeric>

#include "support/gl_context.h"

namespace tilth::gl {
namespace {

class ObjectsTest : public test::GlTest {
protected:
    /// Pixel-store state and bindings that break every transfer which does not set its own.
    void spoil_transfers(const Buffer& buffer) {
        const Api& gl = device().gl();
        for (GLenum what : {GL_PACK_ROW_LENGTH, GL_UNPACK_ROW_LENGTH}) gl.PixelStorei(what, 77);
        for (GLenum what : {GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS, GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_PIXELS})
            gl.PixelStorei(what, 3);
        for (GLenum what : {GL_PACK_ALIGNMENT, GL_UNPACK_ALIGNMENT}) gl.PixelStorei(what, 8);
        for (GLenum what : {GL_PACK_SWAP_BYTES, GL_UNPACK_SWAP_BYTES}) gl.PixelStorei(what, GL_TRUE);
        buffer.bind(BufferTarget::PixelPack);
        buffer.bind(BufferTarget::PixelUnpack);
    }
};

TEST_F(ObjectsTest, a_rectangle_with_a_row_length_lands_where_it_should) {
    Texture2D texture = test::value(Texture2D::create(device(), "odd", {Format::R16, 7, 5}));
    Buffer bait = test::value(Buffer::create(device(), "bait", 65536));
    std::vector<std::uint16_t> sentinel(35, 0xbeef);
    spoil_transfers(bait);
    texture.upload(0, texture.bounds(), sentinel.data());
    std::vector<std::uint16_t> source(11 * 3);  // rows of 11, of which 3 are sent
    std::iota(source.begin(), source.end(), std::uint16_t{1});
    spoil_transfers(bait);
    texture.upload(0, {2, 1, 5, 4}, source.data(), 11);
    std::vector<std::uint16_t> result(35);
    spoil_transfers(bait);
    texture.read(0, result.data());
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 7; ++x) {
            const bool inside = x >= 2 && x < 5 && y >= 1 && y < 4;
            const int expected = inside ? 1 + (y - 1) * 11 + (x - 2) : 0xbeef;
            EXPECT_EQ(result[static_cast<std::size_t>(y * 7 + x)], expected) << x << ", " << y;
        }
}

TEST_F(ObjectsTest, uploads_from_a_buffer_read_at_its_offset) {
    Texture2D texture = test::value(Texture2D::create(device(), "from buffer", {Format::R8, 3, 2}));
    const std::array<std::uint8_t, 12> bytes{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
    Buffer buffer = test::value(Buffer::create(device(), "pixels", 12, BufferUsage::Stream, bytes.data()));
    texture.upload(0, texture.bounds(), buffer, 5);
    std::array<std::uint8_t, 6> result{};
    texture.read(0, result.data());
    EXPECT_EQ(result, (std::array<std::uint8_t, 6>{5, 6, 7, 8, 9, 10}));
}

TEST_F(ObjectsTest, bytes_count_every_level_and_return_to_zero) {
    const std::uint64_t before = device().resident_bytes();
    const std::size_t objects_before = device().live_objects().size();
    {
        Texture2D texture =
            test::value(Texture2D::create(device(), "levels", {Format::Rg8, 8, 4, 0, Filter::Trilinear}));
        EXPECT_EQ(texture.levels(), 4);
        EXPECT_EQ(texture.bytes(), 2u * (32 + 8 + 2 + 1));
        Buffer buffer = test::value(Buffer::create(device(), "bytes", 100));
        EXPECT_EQ(device().resident_bytes() - before, 2u * 43 + 100);
        std::vector<std::byte> more(300);
        buffer.replace(more);
        EXPECT_EQ(buffer.bytes(), 300u);
        EXPECT_EQ(device().resident_bytes() - before, 2u * 43 + 300);
        Texture2D moved = std::move(texture);
        EXPECT_EQ(device().live_objects().size(), objects_before + 2);
        EXPECT_EQ(device().live_objects()[objects_before].label, "levels");
    }
    EXPECT_EQ(device().resident_bytes(), before);
    EXPECT_EQ(device().live_objects().size(), objects_before);
}

TEST_F(ObjectsTest, refuses_what_cannot_be) {
    const int most = device().capabilities().max_texture_size;
    const auto expect_refused = [&](const TextureSpec& spec, const char* names) {
        const auto made = Texture2D::create(device(), "bad", spec);
        ASSERT_FALSE(made.ok());
        EXPECT_EQ(made.error().code, ErrorCode::InvalidArgument);
        EXPECT_NE(made.error().message.find(names), std::string::npos) << made.error().message;
    };
    expect_refused({Format::R8, most + 1, 1}, "size");
    expect_refused({Format::R8, 0, 1}, "size");
    expect_refused({Format::R8, 8, 8, 5}, "levels");
    expect_refused({Format::R32UI, 8, 8, 1, Filter::Linear}, "filter");
    const auto texels = static_cast<std::size_t>(device().capabilities().max_buffer_texels) + 1;
    EXPECT_FALSE(TextureBuffer::create(device(), "bad", Format::R8, texels).ok());
}

TEST_F(ObjectsTest, out_of_memory_is_an_error_and_not_a_pending_one) {
    // 2^62 bytes are beyond any address space.
    const auto made = Buffer::create(device(), "huge", std::size_t{1} << 62);
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error().code, ErrorCode::OutOfMemory);
    EXPECT_NE(made.error().message.find("huge"), std::string::npos);
    EXPECT_TRUE(device().take_errors().empty());
    device().take_debug_messages();  // the driver says so, too
}

TEST_F(ObjectsTest, errors_of_others_are_kept_when_a_creation_looks_for_its_own) {
    device().gl().Enable(0x1234);
    Buffer buffer = test::value(Buffer::create(device(), "fine", 16));
    EXPECT_EQ(device().take_errors(), std::vector<std::string>{"GL_INVALID_ENUM"});
    const auto messages = device().take_debug_messages();
    ASSERT_EQ(messages.size(), 1u);
    EXPECT_EQ(messages[0].kind, "error");
}

TEST_F(ObjectsTest, labels_reach_the_driver) {
    ASSERT_TRUE(device().capabilities().debug) << "Mesa has GL_KHR_debug on both routes";
    Texture2D texture = test::value(Texture2D::create(device(), "tile heights", {Format::R16, 4, 4}));
    std::array<char, 64> label{};
    device().gl().GetObjectLabel(GL_TEXTURE, texture.id(), 64, nullptr, label.data());
    EXPECT_STREQ(label.data(), "tile heights");
}

TEST_F(ObjectsTest, serials_are_never_used_again) {
    Texture2D first = test::value(Texture2D::create(device(), "one", {Format::R8, 4, 4}));
    const std::uint64_t serial = first.serial();
    first = test::value(Texture2D::create(device(), "two", {Format::R8, 4, 4}));
    Texture2D third = test::value(Texture2D::create(device(), "three", {Format::R8, 4, 4}));
    EXPECT_NE(first.serial(), serial);
    EXPECT_NE(third.serial(), serial);
    EXPECT_NE(third.serial(), first.serial());
}

TEST_F(ObjectsTest, a_framebuffer_follows_its_attachments) {
    Framebuffer framebuffer = test::value(Framebuffer::create(device(), "two targets"));
    Texture2D a = test::value(Texture2D::create(device(), "a", {Format::R16, 4, 4}));
    Texture2D b = test::value(Texture2D::create(device(), "b", {Format::R16, 4, 4}));
    const Texture2D* both[] = {&a, &b};
    framebuffer.attach(both);
    ASSERT_TRUE(framebuffer.check().ok());
    const GLfloat quarter[] = {0.25f, 0, 0, 0}, half[] = {0.5f, 0, 0, 0};
    device().gl().ClearBufferfv(GL_COLOR, 0, quarter);
    device().gl().ClearBufferfv(GL_COLOR, 1, half);
    std::uint16_t texel = 0;
    framebuffer.read({3, 3, 4, 4}, Format::R16, &texel, 1);
    EXPECT_NEAR(texel, 32767.5, 0.51);
    framebuffer.read({3, 3, 4, 4}, Format::R16, &texel, 0);
    EXPECT_NEAR(texel, 16383.75, 0.76);
    // The id comes back with another texture: the cached attachment must not pass for it.
    a = test::value(Texture2D::create(device(), "placeholder", {Format::R16, 4, 4}));
    Texture2D again = test::value(Texture2D::create(device(), "again", {Format::R16, 4, 4}));
    const Texture2D* one[] = {&again};
    framebuffer.attach(one);
    device().gl().ClearBufferfv(GL_COLOR, 0, half);
    std::array<std::uint16_t, 16> texels{};
    again.read(0, texels.data());
    EXPECT_NEAR(texels[5], 32767.5, 0.51);
    framebuffer.attach({});
    EXPECT_FALSE(framebuffer.check().ok());
    device().take_debug_messages();  // the driver says so, too
}

TEST_F(ObjectsTest, buffers_map_replace_and_read) {
    Buffer buffer = test::value(Buffer::create(device(), "bytes", 8, BufferUsage::Dynamic));
    std::byte* memory = buffer.map_write(0, 8);
    ASSERT_NE(memory, nullptr);
    for (int i = 0; i < 8; ++i) memory[i] = static_cast<std::byte>(i);
    EXPECT_TRUE(buffer.unmap());
    const std::array part{std::byte{90}, std::byte{91}};
    buffer.upload(3, part);
    const std::byte* read = buffer.map_read(2, 4);
    ASSERT_NE(read, nullptr);
    EXPECT_EQ(read[0], std::byte{2});
    EXPECT_EQ(read[1], std::byte{90});
    EXPECT_EQ(read[2], std::byte{91});
    EXPECT_TRUE(buffer.unmap());
    std::array<std::byte, 3> back{};
    buffer.read(4, back);
    EXPECT_EQ(back, (std::array{std::byte{91}, std::byte{5}, std::byte{6}}));
}

TEST_F(ObjectsTest, a_fence_passes_once_everything_is_done) {
    Fence fence = Fence::insert(device());
    static_cast<void>(fence.signaled());
    device().gl().Finish();
    EXPECT_TRUE(fence.signaled());
    EXPECT_TRUE(fence.wait(0));
}

}  // namespace
}  // namespace tilth::gl
