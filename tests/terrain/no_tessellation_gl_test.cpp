// A context without GL 4: what needs the tessellator is refused with the reason, everything else is drawn. Mesa is told
// its version by the environment once a process, so that the test runs itself again.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

#include "support/gl_context.h"
#include "tilth/source/analytic_sources.h"
#include "tilth/terrain.h"

namespace tilth {
namespace {

class NoTessellationTest : public test::GlTest {};

TEST_F(NoTessellationTest, RefusesWhatNeedsItAndDrawsTheRest) {
    if (device().capabilities().tessellation) GTEST_SKIP() << "this context has it; run by TheSameWithoutGl4";
    TerrainSettings settings{.executor = ExecutorKind::Cpu, .clipmap = {.n = 63, .levels = 3}};
    settings.ground.spacing_m = 0.1;
    settings.ground.tile_size = 256;
    const auto get_proc = test::test_context(test::default_route()).context->get_proc();
    const auto source = std::make_shared<FlatSource>(257, 0.0);
    const std::unique_ptr<Terrain> ground = test::value(Terrain::create(source, settings, get_proc));
    ASSERT_TRUE(ground->stamp({.centre = {12.5, 12}, .radius_m = 0.5, .amplitude_m = -0.2, .map = MapChoice::Detail}));
    const WorldPos viewer{12, 12};
    ground->set_viewers({&viewer, 1});
    ASSERT_TRUE(ground->update(0));
    ASSERT_TRUE(ground->drain());
    const test::Target target(120, 80);
    const auto picture = [&] {
        target.clear(1, 0, 1);
        const Result<void> drawn = ground->draw(
            {.eye = {12.2, 0.7, 12}, .forward = {0.5, -1, 0}, .width = 120, .height = 80, .near_m = 0.1, .far_m = 100},
            {});
        EXPECT_TRUE(drawn) << (drawn ? "" : drawn.error().message);
        return target.pixels();
    };
    const std::vector<std::uint8_t> none = picture();
    for (const DetailBackend backend : {DetailBackend::Parallax, DetailBackend::Geometry}) {
        for (const DetailPreset preset : {DetailPreset::Low, DetailPreset::Exact}) {
            ASSERT_TRUE(ground->set_detail(detail_preset(backend, preset))) << name_of(backend);
            EXPECT_NE(picture(), none) << name_of(backend) << " " << name_of(preset);
        }
    }
    const DetailSettings shown = ground->detail();
    const std::vector<std::uint8_t> before = picture();
    const struct {
        DetailBackend backend;
        bool phong;
        const char* field;
    } refused[] = {{DetailBackend::Tessellation, false, "detail.backend: tessellation"},
                   {DetailBackend::Hybrid, false, "detail.backend: hybrid"},
                   {DetailBackend::None, true, "detail.phong.on"},
                   {DetailBackend::Geometry, true, "detail.phong.on"}};
    for (const auto& r : refused) {
        DetailSettings wanted = detail_preset(r.backend, DetailPreset::High);
        wanted.phong.on = r.phong;
        const auto check = [&](const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::Unsupported) << r.field;
            EXPECT_EQ(error.message.rfind(r.field, 0), 0u) << error.message;
            EXPECT_NE(error.message.find("GL 4.0"), std::string::npos) << error.message;
        };
        const Result<void> set = ground->set_detail(wanted);
        ASSERT_FALSE(set) << r.field;
        check(set.error());
        EXPECT_EQ(ground->detail(), shown) << r.field;
        EXPECT_EQ(picture(), before) << r.field;
        settings.detail = wanted;
        const auto created = Terrain::create(source, settings, get_proc);
        ASSERT_FALSE(created) << r.field;
        check(created.error());
        // Without GL nothing is drawn, and nothing is missing.
        EXPECT_TRUE(Terrain::create(source, settings, nullptr)) << r.field;
    }
}

TEST_F(NoTessellationTest, TheSameWithoutGl4) {
    if (!device().capabilities().tessellation) GTEST_SKIP() << "this context has none";
    const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
    const std::string command = "MESA_GL_VERSION_OVERRIDE=3.3 MESA_GLSL_VERSION_OVERRIDE=330 '" + self +
                                "' --gtest_filter=NoTessellationTest.RefusesWhatNeedsItAndDrawsTheRest 2>&1 </dev/null";
    std::FILE* pipe = popen(command.c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    std::string said;
    std::array<char, 4096> part{};
    while (std::fgets(part.data(), static_cast<int>(part.size()), pipe) != nullptr) said += part.data();
    EXPECT_EQ(pclose(pipe), 0) << said;
    if (said.find("this context has it") != std::string::npos) GTEST_SKIP() << "the driver is none of Mesa's";
    EXPECT_NE(said.find("[  PASSED  ] 1 test."), std::string::npos) << said;
}

}  // namespace
}  // namespace tilth
