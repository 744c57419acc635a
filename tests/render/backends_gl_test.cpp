// All detail backends show the same ground: their depth images against the contract surface at full texel resolution,
// over the real path of stamps, tiles, relief window and backend. Errors in pixels, per backend.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "render/support/holes.h"
#include "render/support/relief_world.h"

namespace tilth::test {
namespace {

/// Settings by the name under which they stand in the table.
struct Shown {
    std::string name;
    DetailSettings settings;
};

DetailSettings preset(DetailBackend backend, DetailPreset name) {
    DetailSettings settings = detail_preset(backend, name);
    settings.parallax.depth = true;  // what is measured is depth
    settings.reach = 1;
    return settings;
}

Shown parallax(const char* name, ParallaxMethod method, std::int32_t steps) {
    return {name, {.backend = DetailBackend::Parallax, .parallax = {.method = method, .steps = steps, .depth = true}}};
}

const char* const kNone = "none";
const char* const kIterative = "parallax iterative 4";
const char* const kSecant = "parallax secant 16";
const char* const kExact = "parallax exact";
const char* const kGeometry = "geometry exact";
const char* const kTessellation = "tessellation exact";
const char* const kHybrid = "hybrid exact";

std::vector<Shown> methods() {
    return {{kNone, {}},
            parallax(kIterative, ParallaxMethod::Iterative, 4),
            parallax(kSecant, ParallaxMethod::Secant, 16),
            {kExact, preset(DetailBackend::Parallax, DetailPreset::Exact)},
            {kGeometry, preset(DetailBackend::Geometry, DetailPreset::Exact)},
            {kTessellation, preset(DetailBackend::Tessellation, DetailPreset::Exact)},
            {kHybrid, preset(DetailBackend::Hybrid, DetailPreset::Exact)}};
}

/// What each of them showed.
using Table = std::map<std::string, ShownGround>;

class BackendsGlTest : public GlTest {
protected:
    static constexpr int kWidth = 480, kHeight = 270;

    /// Draws the view with each and compares the ground up to `to_m`; prints the table. What the context cannot do
    /// (tessellation needs GL 4) is left out, and said.
    static Table compare(ReliefWorld& world, const char* scene, const View& view, double to_m,
                         const std::vector<Shown>& all = methods()) {
        const Target target(view.width, view.height);
        const ContractSurface surface(world.truth(), {view.eye.x, view.eye.z}, to_m + 1);
        DetailMesh mesh(surface);
        mesh.draw(target, view);
        const std::vector<float> truth = target.depths();
        keep_picture(text(scene, "_truth"), target.pixels(), view.width, view.height);
        std::printf("%s, ground up to %.2f m:\n", scene, to_m);
        const ShownGround itself = compare_ground(view, truth, truth, surface, to_m);
        print_ground("  (the mesh itself)", itself);
        EXPECT_GT(itself.pixels, 10000);
        Table table;
        for (const Shown& shown : all) {
            std::string why;
            if (!world.show(shown.settings, &why)) {
                std::printf("  %s is not to be had: %s\n", shown.name.c_str(), why.c_str());
                continue;
            }
            const Frame frame = world.draw(target, view);
            if (frame.depth.empty()) continue;  // refused, and reported
            table[shown.name] = compare_ground(view, frame.depth, truth, surface, to_m);
            print_ground(("  " + shown.name).c_str(), table[shown.name]);
            keep_picture(text(scene, "_", shown.name), frame.rgba, view.width, view.height);
        }
        EXPECT_TRUE(world.show({}));
        return table;
    }

    /// Triangles at every texel differ from the truth by roundings alone.
    ///
    /// Positions are floats below 16 m, right to a micrometre; depth is rounded (`kDepthSteps`). Beside a crease a
    /// pixel may take the neighbour's plane, by the 1/256 of a pixel to which rasterisers snap vertices, times the
    /// slope between the two as it looks from here: a few. So 99 % are bounded by the roundings and all by eight
    /// 256ths.
    static void expect_exact(const Table& table, const char* name) {
        if (!table.contains(name)) return;
        const ShownGround& g = table.at(name);
        EXPECT_LE(g.p99_roundings, 1) << name;
        EXPECT_LE(g.max_px, 8.0 / 256) << name;
        // A ray that grazes a crest within roundings may go on to the next slope.
        EXPECT_LE(static_cast<double>(g.wrong_inside), 5e-5 * static_cast<double>(g.pixels)) << name;
    }
    /// The tessellator puts points inside triangles beside the lattice of texels (render/tessellation/relief.tese): a
    /// tenth of what is not shown without it is what that costs, twice that is allowed. Hybrid has it from there.
    static void expect_tessellated(const Table& table) {
        for (const char* name : {kTessellation, kHybrid}) {
            if (!table.contains(name)) continue;
            EXPECT_LE(table.at(name).rms_px, 0.2 * table.at(kNone).rms_px) << name;
            EXPECT_LE(static_cast<double>(table.at(name).wrong), 0.2 * static_cast<double>(table.at(kNone).wrong))
                << name;
        }
        if (table.contains(kHybrid)) expect_between(table, kHybrid, kExact, kTessellation);
    }
    /// A blend of two is no worse than the worse of them, and what the blend itself costs: in its ring parallax follows
    /// the rest of the relief over triangles that it takes for the coarse plane. A fiftieth of all relief is allowed.
    static void expect_between(const Table& table, const std::string& hybrid, const std::string& a,
                               const std::string& b) {
        const ShownGround& none = table.at(kNone);
        EXPECT_LE(table.at(hybrid).rms_px, std::max(table.at(a).rms_px, table.at(b).rms_px) * 1.1 + 0.02 * none.rms_px)
            << hybrid;
        EXPECT_LE(static_cast<double>(table.at(hybrid).wrong),
                  static_cast<double>(std::max(table.at(a).wrong, table.at(b).wrong)) * 1.1 +
                      0.02 * static_cast<double>(none.wrong))
            << hybrid;
    }
    static void expect_better_than_none(const Table& table) {
        const ShownGround& none = table.at(kNone);
        EXPECT_GT(none.max_px, 3) << "there is something to see";
        for (const auto& [name, g] : table) {
            if (name == kNone) continue;
            EXPECT_LT(g.rms_px, none.rms_px) << name;
            EXPECT_LE(g.wrong, none.wrong) << name;
            EXPECT_LE(g.background, none.background) << name << ": horizons at worst are the coarse ground's";
        }
    }
};

// One print at 2 m, in the reference configuration.
TEST_F(BackendsGlTest, ABootPrintAtTwoMetres) {
    ReliefWorld world(std::make_shared<FlatSource>(257, 0.0), {.tile_size = 2048});
    world.print({14.0, 12.83}, 0.3);
    View view = world.view({12.61, 12.77}, 2, {1.39, -2, 0.06}, kWidth, kHeight);
    view.fov_y_rad = 0.35;
    const Table table = compare(world, "boot", view, 3);
    expect_better_than_none(table);
    // On flat ground the ray is followed to the triangle of the cell.
    for (const char* name : {kGeometry, kExact}) expect_exact(table, name);
    expect_tessellated(table);
    EXPECT_LE(table.at(kExact).rms_px, table.at(kSecant).rms_px);
    EXPECT_LE(table.at(kSecant).rms_px, table.at(kIterative).rms_px);
}

// Prints and small craters with rims ahead, seen from a person's eye and from close above the ground.
class TrailGlTest : public BackendsGlTest {
protected:
    static constexpr WorldPos kEye{12.8, 12.75};
    static void fill(ReliefWorld& world) {
        for (int i = 0; i < 14; ++i) {
            world.print({12.9 + 0.7 * i, 12.8 + (i % 2 == 0 ? 0.13 : -0.13)}, 0.02 * i, i % 2 == 1);
            const auto crater = static_cast<std::uint32_t>(BuiltinProfile::Crater);
            world.stamp({.shape = {crater},
                         .centre = {13.6 + 0.83 * i, 11.6 + 0.37 * (i % 7)},
                         .radius_m = 0.15 + 0.03 * (i % 5),
                         .amplitude_m = -0.08});
        }
    }
};

TEST_F(TrailGlTest, IsTheSameGroundFromEyeHeightAndAtGrazingAngles) {
    ReliefWorld world(std::make_shared<FlatSource>(257, 0.0));
    fill(world);
    const struct {
        const char* name;
        double above_m;
        Vec3d forward;
    } views[] = {{"trail", 1.7, {1, -0.35, 0.02}}, {"trail_grazing", 0.35, {1, -0.12, 0.02}}};
    for (const auto& v : views) {
        const Table table =
            compare(world, v.name, world.view(kEye, v.above_m, v.forward, kWidth, kHeight), world.whole_reach_m());
        expect_better_than_none(table);
        for (const char* name : {kGeometry, kExact}) expect_exact(table, name);
        expect_tessellated(table);
    }
}

// More quality is less error, with every backend, and no preset of the hybrid is behind parallax'.
TEST_F(TrailGlTest, PresetsAreOrdered) {
    ReliefWorld world(std::make_shared<FlatSource>(257, 0.0));
    fill(world);
    std::vector<Shown> all{{kNone, {}}};
    constexpr DetailPreset kPresets[] = {DetailPreset::Low, DetailPreset::Medium, DetailPreset::High,
                                         DetailPreset::Exact};
    constexpr DetailBackend kBackends[] = {DetailBackend::Parallax, DetailBackend::Geometry,
                                           DetailBackend::Tessellation, DetailBackend::Hybrid};
    const auto name = [](DetailBackend backend, DetailPreset p) {
        return std::string(name_of(backend)) + " " + std::string(name_of(p));
    };
    for (const DetailBackend backend : kBackends)
        for (const DetailPreset p : kPresets) all.push_back({name(backend, p), preset(backend, p)});
    const Table table =
        compare(world, "presets", world.view(kEye, 1.7, {1, -0.35, 0.02}, 320, 180), world.whole_reach_m(), all);
    expect_better_than_none(table);
    for (const DetailBackend backend : kBackends) {
        for (std::size_t p = 0; p < 4; ++p) {
            const std::string better = name(backend, kPresets[p]);
            if (!table.contains(better)) continue;
            if (p > 0) {
                const std::string worse = name(backend, kPresets[p - 1]);
                // Two that both reach every texel differ by roundings.
                EXPECT_LE(table.at(better).rms_px, table.at(worse).rms_px + 0.0005) << better << " after " << worse;
            }
            if (backend != DetailBackend::Hybrid) continue;
            expect_between(table, better, name(DetailBackend::Parallax, kPresets[p]),
                           name(DetailBackend::Tessellation, kPresets[p]));
        }
    }
}

// Soft dents across the borders of four tiles, the eye over their corner.
TEST_F(BackendsGlTest, TheCornerOfFourTiles) {
    ReliefWorld world(std::make_shared<FlatSource>(385, 0.0), {.tile_size = 512});
    const double corner = 512 / 30.0;  // m
    for (int i = 0; i < 24; ++i)
        world.stamp(
            {.shape = {static_cast<std::uint32_t>(i % 2 == 0 ? BuiltinProfile::Gaussian : BuiltinProfile::Cosine)},
             .centre = {corner - 3 + 6 * std::fmod(i * 0.618034, 1.0), corner - 3 + 6 * std::fmod(i * 0.414214, 1.0)},
             .radius_m = 0.3 + 0.05 * (i % 9),
             .amplitude_m = i % 3 == 0 ? 0.06 : -0.1});
    // Along both borders.
    for (int i = -3; i <= 3; ++i) {
        world.stamp({.shape = {0}, .centre = {corner, corner + i}, .radius_m = 0.4, .amplitude_m = -0.08});
        world.stamp({.shape = {0}, .centre = {corner + i, corner}, .radius_m = 0.4, .amplitude_m = -0.08});
    }
    const struct {
        const char* name;
        WorldPos eye;
        double above_m;
        Vec3d forward;
    } views[] = {{"corner_down", {corner, corner}, 1.8, {0.02, -1, 0.01}},
                 {"corner_along", {corner - 1.5, corner - 0.02}, 1.2, {1, -0.45, 0.02}}};
    for (const auto& v : views) {
        const Table table =
            compare(world, v.name, world.view(v.eye, v.above_m, v.forward, kWidth, kHeight), world.whole_reach_m());
        expect_better_than_none(table);
        for (const char* name : {kGeometry, kExact}) expect_exact(table, name);
        expect_tessellated(table);
    }
}

// Sloped and bumpy ground: parallax sees it as a plane at each pixel, triangles do not.
TEST_F(BackendsGlTest, SlopedAndBumpyGround) {
    const auto hills = [](double x, double z) {
        return 3 + 0.02 * x + 0.25 * std::sin(x / 9.0) * std::cos(z / 7.0) + 0.02 * std::sin(x / 1.7 + z / 2.1);
    };
    ReliefWorld world(std::make_shared<FormulaSource>(257, 0, 12, hills));
    for (int i = 0; i < 12; ++i) {
        world.print({12.2 + 0.6 * i, 12.8 + (i % 2 == 0 ? 0.13 : -0.13)}, 0.1 * i, i % 2 == 1);
        world.stamp({.shape = {static_cast<std::uint32_t>(BuiltinProfile::Crater)},
                     .centre = {12.6 + 0.47 * i, 11.9 + 0.31 * (i % 7)},
                     .radius_m = 0.25,
                     .amplitude_m = -0.08});
    }
    const Table table = compare(world, "bumpy", world.view({11.8, 12.75}, 1.7, {1, -0.5, 0.02}, kWidth, kHeight),
                                world.whole_reach_m());
    expect_better_than_none(table);
    expect_exact(table, kGeometry);
    expect_tessellated(table);
}

// A heap that rises into the picture from a block of which the coarse ground lies below it: culling by coarse bounds
// would drop it. Parallax cannot show it (outlines are the coarse ground's), triangles do.
TEST_F(BackendsGlTest, AHeapAboveCoarseGroundThatIsOutOfSight) {
    ReliefWorld world(std::make_shared<FlatSource>(257, 0.0));
    world.stamp({.shape = {static_cast<std::uint32_t>(BuiltinProfile::Cosine)},
                 .centre = {16.4, 12.8},
                 .radius_m = 1.6,
                 .amplitude_m = 2});
    View view = world.view({12.4, 12.8}, 1, {1, 0.33, 0}, 320, 180);
    view.fov_y_rad = 0.5;
    const Target target(view.width, view.height);
    const ContractSurface surface(world.truth(), {view.eye.x, view.eye.z}, world.whole_reach_m() + 1);
    DetailMesh(surface).draw(target, view);
    const std::vector<float> truth = target.depths();
    ASSERT_TRUE(world.show({}));
    EXPECT_EQ(magenta_pixels(world.draw(target, view).rgba), 320 * 180) << "no coarse ground is in sight";
    for (const Shown& shown : methods()) {
        if (shown.settings.backend == DetailBackend::None || shown.settings.backend == DetailBackend::Parallax ||
            !world.show(shown.settings))
            continue;
        const Frame frame = world.draw(target, view);
        const ShownGround g = compare_ground(view, frame.depth, truth, surface, world.whole_reach_m());
        print_ground(shown.name.c_str(), g);
        EXPECT_GT(g.pixels, 1000) << shown.name;
        EXPECT_LE(g.rms_px, 0.1) << shown.name;
        // Its outline is some 200 pixels long.
        EXPECT_LE(g.background, shown.name == kGeometry ? 2 : 40) << shown.name;
    }
}

// A heap seen from so low that rays come to the ground metres behind it, where nothing is dented for 32 texels about:
// it is searched for all the same. Against flat ground that goes on behind it, so that parallax can show all of it.
TEST_F(BackendsGlTest, AHeapIsSeenOverGroundFarBehindIt) {
    ReliefWorld world(std::make_shared<FlatSource>(257, 0.0));
    world.stamp({.shape = {static_cast<std::uint32_t>(BuiltinProfile::Cosine)},
                 .centre = {14.8, 12.8},
                 .radius_m = 0.6,
                 .amplitude_m = 0.3});
    const View view = world.view({11.8, 12.8}, 0.7, {1, -0.2, 0}, 320, 180);
    const Target target(view.width, view.height);
    const ContractSurface surface(world.truth(), {view.eye.x, view.eye.z}, world.whole_reach_m() + 1);
    DetailMesh(surface).draw(target, view);
    const std::vector<float> truth = target.depths();
    const auto ground_of = [&](const char* name, DetailSettings settings) {
        settings.parallax.depth = true;
        EXPECT_TRUE(world.show(settings));
        const ShownGround g =
            compare_ground(view, world.draw(target, view).depth, truth, surface, world.whole_reach_m());
        print_ground(name, g);
        return g;
    };
    const ShownGround none = ground_of("none", {});
    const ShownGround exact = ground_of("parallax exact", detail_preset(DetailBackend::Parallax, DetailPreset::Exact));
    const ShownGround medium =
        ground_of("parallax medium", detail_preset(DetailBackend::Parallax, DetailPreset::Medium));
    EXPECT_GT(none.wrong_inside, 500) << "the heap hides ground behind it";
    EXPECT_LE(exact.rms_px, 0.01);
    EXPECT_LE(exact.wrong_inside, 5);
    EXPECT_LE(medium.rms_px, 0.1 * none.rms_px);
    EXPECT_LE(medium.wrong_inside, none.wrong_inside / 10);
}

// Reversed depth shows the same ground, and says the same of where it is.
TEST_F(BackendsGlTest, ReversedDepthIsTheSameGround) {
    if (!device().capabilities().clip_control) GTEST_SKIP() << "no GL_ARB_clip_control";
    ReliefWorld world(std::make_shared<FlatSource>(257, 0.0));
    for (int i = 0; i < 6; ++i) world.print({13.2 + 0.4 * i, 12.6 + 0.13 * (i % 2)});
    View view = world.view({12.4, 12.8}, 1.2, {1, -0.55, 0}, 240, 135);
    const Target target(view.width, view.height);
    for (const Shown& shown : methods()) {
        DetailSettings settings = shown.settings;
        settings.parallax.depth = true;
        if (settings.backend == DetailBackend::None || !world.show(settings)) continue;
        view.depth = DepthConvention::Standard;
        const Frame standard = world.draw(target, view);
        view.depth = DepthConvention::Reversed;
        const Frame reversed = world.draw(target, view);
        int other_colour = 0, other_place = 0, ground = 0;
        for (std::size_t i = 0; i < standard.depth.size(); ++i) {
            const double near = view.near_m, far = view.far_m, d = standard.depth[i], r = reversed.depth[i];
            if (d >= 1) continue;
            ++ground;
            const double along = 2 * far * near / (far + near - (2 * d - 1) * (far - near));
            other_place += std::abs(along - far * near / (near + r * (far - near))) > 1e-4 * along;
            for (std::size_t c = 0; c < 3; ++c)
                other_colour += std::abs(standard.rgba[4 * i + c] - reversed.rgba[4 * i + c]) > 1;
        }
        EXPECT_GT(ground, 20'000) << shown.name;
        // Pixels on an edge between near and far that the two round to either side.
        EXPECT_LE(other_place, 10) << shown.name;
        EXPECT_LE(other_colour, 30) << shown.name;
    }
}

// ---- no cracks ----

class NoisyFlight {
protected:
    static constexpr int kWidth = 160, kHeight = 90, kFrames = 25;
    /// A small clipmap, so that the end of relief and other levels are in the picture; noise in every texel.
    static ReliefWorld noisy(const std::string& shader_folder = ReliefWorldOptions().shader_folder) {
        return ReliefWorld(
            make_ridged_source({.seed = 11, .size = 385, .relief_m = 5}),
            {.clipmap = {.n = 63, .levels = 4, .blend = 0.1}, .tile_size = 256, .shader_folder = shader_folder});
    }
    static void fill(ReliefWorld& world) {
        for (int z = 0; z < 3; ++z)
            for (int x = 0; x < 3; ++x)
                world.stamp({.shape = world.noise(),
                             .centre = {10.7 + 8.5 * x, 10.7 + 8.5 * z},
                             .radius_m = 256 / 30.0,
                             .amplitude_m = 0.06});
    }
    struct Found {
        long holes = 0, ground = 0;
        int frames = 0;
    };
    static Found fly_over(ReliefWorld& world, const Target& target, int frames, int first = 0) {
        Found found;
        for (int i = first; i < first + frames; ++i) {
            const double turn = i * 1.1234567;
            const double corner = 256 / 30.0;  // every fourth over a corner of tiles
            const WorldPos at = i % 4 == 0 ? WorldPos{2 * corner, 2 * corner}
                                           : WorldPos{19.2 + 5 * std::cos(turn), 19.2 + 5 * std::sin(turn)};
            const double above_m[] = {0.3, 0.8, 1.6, 3}, pitches[] = {-1.3, -0.9, -0.2, -0.45, -1.0};
            const double pitch = pitches[i % 5], heading = turn * 1.7;
            View view =
                world.view(at, above_m[(i / 2) % 4],
                           {std::cos(pitch) * std::cos(heading), std::sin(pitch), std::cos(pitch) * std::sin(heading)},
                           kWidth, kHeight);
            if (i % 7 == 0) view.forward = {0, -1, 0};
            view.near_m = 0.05;
            const Frame frame = world.draw(target, view);
            const bool all_ground = view.forward.y < -0.95;  // flatter, the end of the map may be in sight
            const long holes = all_ground ? magenta_pixels(frame.rgba) : sky_within_ground(frame.rgba, kWidth, kHeight);
            if (holes > 0) keep_picture(text("relief_holes_", i), frame.rgba, kWidth, kHeight);
            found.holes += holes;
            found.ground += kWidth * kHeight - magenta_pixels(frame.rgba);
            ++found.frames;
        }
        return found;
    }
};

class ReliefWatertightGlTest : public GlTest,
                               public NoisyFlight,
                               public ::testing::WithParamInterface<DetailBackend> {};
class ReliefMutationGlTest : public GlTest, public NoisyFlight {};

TEST_P(ReliefWatertightGlTest, NoFrameHasAHoleWithDetailEverywhere) {
    ReliefWorld world = noisy();
    fill(world);
    const Target target(kWidth, kHeight);
    int frames = 0;
    for (const DetailPreset p : {DetailPreset::Exact, DetailPreset::Medium}) {
        std::string why;
        if (!world.show(detail_preset(GetParam(), p), &why)) GTEST_SKIP() << why;
        const Found found = fly_over(world, target, kFrames, frames);
        EXPECT_EQ(found.holes, 0) << name_of(p);
        EXPECT_GT(found.ground, long{kFrames} * kWidth * kHeight / 2);
        frames += found.frames;
    }
}
INSTANTIATE_TEST_SUITE_P(Each, ReliefWatertightGlTest,
                         ::testing::Values(DetailBackend::None, DetailBackend::Parallax, DetailBackend::Geometry,
                                           DetailBackend::Tessellation, DetailBackend::Hybrid),
                         [](const auto& tested) { return std::string(name_of(tested.param)); });

/// A copy of the shaders in which the first `old_text` of `file` is `new_text`.
std::string mutated_shaders(const std::string& file, const std::string& old_text, const std::string& new_text) {
    namespace fs = std::filesystem;
    const fs::path folder = fs::path(TILTH_BINARY_DIR) / "test-output" / "render" / "mutated";
    fs::remove_all(folder);
    fs::create_directories(folder);
    fs::copy(ReliefWorldOptions().shader_folder, folder, fs::copy_options::recursive);
    std::stringstream text;
    text << std::ifstream(folder / file).rdbuf();
    std::string mutated = text.str();
    const std::size_t at = mutated.find(old_text);
    EXPECT_NE(at, std::string::npos) << file << " has no \"" << old_text << "\" to mutate";
    if (at != std::string::npos) mutated.replace(at, old_text.size(), new_text);
    std::ofstream(folder / file) << mutated;
    return folder.string();
}

// The proof that the test above can fail: points of an edge counted from the end at which each triangle happens to
// begin.
TEST_F(ReliefMutationGlTest, EdgesThatTwoTrianglesCountDifferentlyTear) {
    const struct {
        DetailBackend backend;
        const char *file, *line;
    } mutations[] = {{DetailBackend::Geometry, "render/geometry/refine.geom", "k = f - k;"},
                     {DetailBackend::Tessellation, "render/tessellation/relief.tese", "k = parts - k;"}};
    const Target target(kWidth, kHeight);
    for (const auto& m : mutations) {
        ReliefWorld world = noisy(mutated_shaders(m.file, m.line, ""));
        fill(world);
        if (!world.show(detail_preset(m.backend, DetailPreset::Exact))) continue;
        EXPECT_GT(fly_over(world, target, 10).holes, 0) << m.file;
    }
}

// And of the comparison: where every fourth post's marks are dropped, relief is missing.
TEST_F(ReliefMutationGlTest, DroppedMarksAreSeenInTheDepth) {
    const std::string folder = mutated_shaders("render/terrain.vert", "relief_is_near(r_from_base, position_m) ? 1 : 0",
                                               "relief_is_near(r_from_base, position_m) && (post.x & 3) != 0 ? 1 : 0");
    ReliefWorld world(std::make_shared<FlatSource>(257, 0.0), {.shader_folder = folder});
    for (int i = 0; i < 8; ++i) world.print({13.0 + 0.4 * i, 12.8});
    const View view = world.view({12.4, 12.8}, 1.7, {1, -0.9, 0}, kWidth, kHeight);
    const Target target(kWidth, kHeight);
    const ContractSurface surface(world.truth(), {view.eye.x, view.eye.z}, world.whole_reach_m() + 1);
    DetailMesh(surface).draw(target, view);
    const std::vector<float> truth = target.depths();
    ASSERT_TRUE(world.show(detail_preset(DetailBackend::Geometry, DetailPreset::Exact)));
    const Frame frame = world.draw(target, view);
    const ShownGround found = compare_ground(view, frame.depth, truth, surface, world.whole_reach_m());
    EXPECT_GT(found.p99_roundings, 10) << "99 % within 1 is what the comparison asks for";
    EXPECT_GT(found.max_px, 8.0 / 256);
}

// ---- nothing where there is nothing ----

class ReliefCostGlTest : public BackendsGlTest {};

TEST_F(ReliefCostGlTest, UntouchedGroundCostsWhatItCostsWithoutABackend) {
    ReliefWorld world(make_ridged_source({.seed = 7, .size = 257, .relief_m = 3}));
    const Target target(160, 90);
    const View view = world.view({12.8, 12.8}, 1.7, {1, -0.4, 0.2}, 160, 90);
    const Frame none = world.draw(target, view, 2);
    const std::uint64_t programs = world.terrain().total().render.programs;
    EXPECT_GT(none.primitives_generated, 1000u);
    for (const Shown& shown : methods()) {
        if (!world.show(shown.settings)) continue;
        const Frame frame = world.draw(target, view, 2);
        EXPECT_EQ(frame.primitives_generated, none.primitives_generated) << shown.name;
        EXPECT_EQ(frame.rgba, none.rgba) << shown.name;
        EXPECT_EQ(frame.depth, none.depth) << shown.name;
        EXPECT_EQ(frame.stats.render, none.stats.render) << shown.name;
        EXPECT_EQ(frame.stats.derive, gl::StageStats{}) << shown.name;
        EXPECT_EQ(world.terrain().total().render.programs, programs) << shown.name;
    }
}

// A print behind the eye, or out of reach, refines nothing; one in sight refines the triangles about it alone.
TEST_F(ReliefCostGlTest, OnlyTrianglesAboutDetailAreRefined) {
    ReliefWorld world(std::make_shared<FlatSource>(513, 0.0));
    world.print({25.6, 23.1});
    const Target target(160, 90);
    const View ahead = world.view({25.6, 25.6}, 1.7, {0, -0.7, -1}, 160, 90),
               behind = world.view({25.6, 25.6}, 1.7, {0, -0.3, 1}, 160, 90),
               away = world.view({25.6, 45}, 1.7, {0, -0.3, -1}, 160, 90);
    const auto generated = [&](const View& view) {  // by the second frame: the first draws with programs it makes
        return world.draw(target, view, 2).primitives_generated;
    };
    const std::uint64_t none_ahead = generated(ahead), none_behind = generated(behind), none_away = generated(away);
    for (const Shown& shown : methods()) {
        if (!world.show(shown.settings)) continue;
        EXPECT_EQ(generated(behind), none_behind) << shown.name;
        EXPECT_EQ(generated(away), none_away) << shown.name;
        const std::uint64_t refined = generated(ahead);
        std::printf("%-24s %llu triangles, %llu with a print in sight\n", shown.name.c_str(),
                    static_cast<unsigned long long>(none_ahead), static_cast<unsigned long long>(refined));
        const bool triangles = shown.name == kGeometry || shown.name == kTessellation || shown.name == kHybrid;
        // The print is 3.4 posts wide. Marks know detail by nodes of 8 texels, from two about a post: no triangle is
        // marked whose posts are further than 6 posts from the print. 8 to 12 more for one, at three texels a post.
        EXPECT_LE(refined, none_ahead + (triangles ? 16 * 16 * 2 * 12 : 0)) << shown.name;
        if (triangles) {
            EXPECT_GT(refined, none_ahead) << shown.name;
        }
    }
}

TEST_F(ReliefCostGlTest, BackToNoneIsAsIfItHadNeverBeenOtherwise) {
    const std::shared_ptr<const HeightSource> source = make_ridged_source({.seed = 7, .size = 257, .relief_m = 3});
    const auto prints = [](ReliefWorld& world) {
        for (int i = 0; i < 5; ++i) world.print({13.2 + 0.6 * i, 12.8}, 0.2 * i);
    };
    ReliefWorld world(source), never(source);
    prints(world);
    prints(never);
    const Target target(320, 180);
    const View view = world.view({12.8, 12.7}, 1.7, {1, -0.6, 0.02}, 320, 180);
    const Frame before = never.draw(target, view, 2);
    const std::uint64_t bytes = never.terrain().gpu_bytes();
    for (const Shown& shown : methods()) {
        if (!world.show(shown.settings)) continue;
        const Frame other = world.draw(target, view);
        if (shown.name != kNone) {
            EXPECT_NE(other.rgba, before.rgba) << shown.name;
        }
        ASSERT_TRUE(world.show({}));
        const Frame back = world.draw(target, view, 2);
        EXPECT_EQ(back.rgba, before.rgba) << "after " << shown.name;
        EXPECT_EQ(back.depth, before.depth) << "after " << shown.name;
        EXPECT_EQ(back.stats, before.stats) << "after " << shown.name;
        EXPECT_EQ(back.primitives_generated, before.primitives_generated) << "after " << shown.name;
        EXPECT_EQ(world.terrain().gpu_bytes(), bytes) << "after " << shown.name << ": the window is given back";
    }
}

}  // namespace
}  // namespace tilth::test
