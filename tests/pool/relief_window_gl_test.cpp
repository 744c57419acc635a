// A new relief window is untouched ground in every texel of every level, and repeats.
#include "tilth/pool/relief_window.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/gl_context.h"
#include "tilth/gl/api.h"
#include "tilth/gl/state_guard.h"

namespace tilth {
namespace {

class ReliefWindowTest : public test::GlTest, public ::testing::WithParamInterface<SlopeFormat> {};

std::vector<std::uint8_t> bytes_of(const gl::Texture2D& texture, int level) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(texture.width(level) * texture.height(level)) *
                                        static_cast<std::size_t>(gl::info_of(texture.format()).transfer_bytes),
                                    0xcd);
    texture.read(level, bytes.data());
    return bytes;
}

TEST_P(ReliefWindowTest, StartsAsUntouchedGround) {
    const gl::StateGuard guard(device());
    for (const std::int32_t size : {256, 512}) {
        const ReliefWindow window = test::value(ReliefWindow::create(device(), size, GetParam()));
        EXPECT_EQ(window.size(), size);
        EXPECT_EQ(window.pyramid().width(), size / 2);
        EXPECT_EQ(window.pyramid().width(ReliefWindow::kLevels - 1), size / ReliefWindow::kTopCells);
        EXPECT_EQ(window.range().width(), size / ReliefWindow::kTopCells);
        const std::uint8_t flat = GetParam() == SlopeFormat::rg8 ? 128 : 0;
        const auto all = [](const gl::Texture2D& texture, std::uint8_t byte) {
            for (int level = 0; level < texture.levels(); ++level) {
                const std::vector<std::uint8_t> bytes = bytes_of(texture, level);
                if (bytes != std::vector<std::uint8_t>(bytes.size(), byte)) return false;
            }
            return true;
        };
        EXPECT_TRUE(all(window.heights(), 0));
        EXPECT_TRUE(all(window.slopes(), flat));
        EXPECT_TRUE(all(window.pyramid(), 0));
        EXPECT_TRUE(all(window.range(), 0));
        const double per_texel = static_cast<double>(window.bytes()) / (static_cast<double>(size) * size);
        EXPECT_GE(per_texel, GetParam() == SlopeFormat::rg8 ? 8.6 : 10.6);
        EXPECT_LE(per_texel, GetParam() == SlopeFormat::rg8 ? 8.7 : 10.7) << "4 + 2 or 4 + 8 / 3 bytes";
        for (const gl::Texture2D* texture : {&window.heights(), &window.slopes(), &window.range()}) {
            texture->bind(0);
            GLint value = 0;
            device().gl().GetTexParameteriv(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, &value);
            EXPECT_EQ(value, GL_REPEAT);
            device().gl().GetTexParameteriv(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, &value);
            EXPECT_EQ(value, GL_REPEAT);
            device().gl().GetTexParameteriv(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, &value);
            EXPECT_EQ(value, GL_LINEAR);
        }
    }
}

TEST_P(ReliefWindowTest, RefusesSizesThatCannotRepeatByAMask) {
    const gl::StateGuard guard(device());
    for (const std::int32_t size : {-256, 0, 128, 255, 300, 768, 4095, 8192}) {
        const Result<ReliefWindow> refused = ReliefWindow::create(device(), size, GetParam());
        ASSERT_FALSE(refused) << size;
        EXPECT_EQ(refused.error().code, ErrorCode::InvalidArgument);
        EXPECT_NE(refused.error().message.find(std::to_string(size)), std::string::npos) << refused.error().message;
    }
}

INSTANTIATE_TEST_SUITE_P(Formats, ReliefWindowTest, ::testing::Values(SlopeFormat::rg8, SlopeFormat::rg16f));

}  // namespace
}  // namespace tilth
