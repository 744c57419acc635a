// One boot print at 2 m by each backend: the pictures that were accepted by eye (golden/README.md).
#ifdef TILTH_TEST_IO
#include <filesystem>

#include "demo/picture_compare.h"
#include "render/support/relief_world.h"

namespace tilth::test {
namespace {

namespace fs = std::filesystem;

class BootGoldenGlTest : public GlTest, public ::testing::WithParamInterface<DetailBackend> {};

io::Rgb8Picture picture_of(const std::vector<std::uint8_t>& rgba, int width, int height) {
    io::Rgb8Picture picture{width, height, {}};
    for (int y = height - 1; y >= 0; --y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c)
                picture.pixels.push_back(
                    rgba[static_cast<std::size_t>(y * width + x) * 4 + static_cast<std::size_t>(c)]);
    return picture;
}

/// Of a picture by `DebugView::Backend`: pixels more green (traced) than red (displaced).
double share_traced(const io::Rgb8Picture& picture) {
    std::size_t traced = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); i += 3)
        traced += picture.pixels[i + 1] > picture.pixels[i] ? 1 : 0;
    return 3.0 * double(traced) / double(picture.pixels.size());
}

TEST_P(BootGoldenGlTest, LooksAsAccepted) {
    ReliefWorld world(std::make_shared<FlatSource>(257, 0.0), {.tile_size = 2048});
    world.print({13.6, 12.83}, 0.5);
    // The eye 1.4 m up and as far off: 2 m away, 45 degrees.
    View view = world.view({12.2, 12.83}, 1.4, {1, -1, 0}, 640, 360);
    view.fov_y_rad = 0.15;  // the print fills the picture
    DetailSettings settings = detail_preset(GetParam(), DetailPreset::Exact);
    settings.parallax.shadow_steps = 0;
    // Hybrid: whole triangles up to a metre, none from two and a half on, so that the print is in the blend.
    settings.tessellated = 0.1, settings.blend = 0.15;
    std::string why;
    if (!world.show(settings, &why)) GTEST_SKIP() << why;
    const Target target(view.width, view.height);
    const io::Rgb8Picture actual = picture_of(world.draw(target, view).rgba, view.width, view.height);

    const std::string name = "boot_" + std::string(name_of(GetParam()));
    const fs::path accepted = fs::path(TILTH_SOURCE_DIR "/tests/render/golden") / (name + ".png"),
                   folder = fs::path(TILTH_BINARY_DIR) / "test-output" / "render" / "golden";
    fs::create_directories(folder);
    const auto expected = io::read_png_rgb8(accepted.string());
    const io::Rgb8Picture& beside = expected ? *expected : actual;
    ASSERT_TRUE(expected) << expected.error().message << leave_side_by_side(folder, name, actual, beside);
    ASSERT_TRUE(same_size(actual, *expected)) << leave_side_by_side(folder, name, actual, beside);
    const PictureDistance d = distance_between(actual, *expected);
    EXPECT_TRUE(alike(d)) << name << " is not the accepted picture: mean difference " << d.mean_steps << "/255, "
                          << 100 * d.share_far_off << " % of pixels far off; compare by eye:"
                          << leave_side_by_side(folder, name, actual, *expected)
                          << "\nIf the new one is right, golden/README.md says how to accept it.";
    if (GetParam() == DetailBackend::None) return;
    if (GetParam() == DetailBackend::Hybrid) {
        // The picture is that of triangles up to the tolerance: who drew it, the debug view tells.
        settings.debug_view = DebugView::Backend;
        ASSERT_TRUE(world.show(settings, &why)) << why;
        const io::Rgb8Picture who = picture_of(world.draw(target, view).rgba, view.width, view.height);
        EXPECT_GT(share_traced(who), 0.9)
            << "the print is traced more than displaced:" << leave_side_by_side(folder, name + "_who", who, who);
    }
    const auto none = io::read_png_rgb8(TILTH_SOURCE_DIR "/tests/render/golden/boot_none.png");
    ASSERT_TRUE(none) << none.error().message;
    EXPECT_FALSE(alike(distance_between(actual, *none))) << name << " cannot be told from slopes alone";
}
INSTANTIATE_TEST_SUITE_P(Each, BootGoldenGlTest,
                         ::testing::Values(DetailBackend::None, DetailBackend::Parallax, DetailBackend::Geometry,
                                           DetailBackend::Tessellation, DetailBackend::Hybrid),
                         [](const auto& tested) { return std::string(name_of(tested.param)); });

}  // namespace
}  // namespace tilth::test
#endif
