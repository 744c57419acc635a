// Slopes of a Gaussian hill against its derivatives, by both executors; edits against a map computed anew.
#include "tilth/derive/slope_pass.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/gl_context.h"
#include "support/random_world.h"
#include "tilth/gl/state_guard.h"

namespace tilth {
namespace {

constexpr double kPeakM = 4;

/// A Gaussian hill in the middle of a map, as codes.
struct Hill {
    std::int32_t posts = 0;
    double spacing_m = 1, sigma_m = 1;
    HeightCodec codec = HeightCodec::for_range(0, kPeakM);

    [[nodiscard]] double centre_m() const { return (posts - 1) * spacing_m / 2; }
    [[nodiscard]] double height(double x, double z) const {
        const double dx = x - centre_m(), dz = z - centre_m();
        return kPeakM * std::exp(-(dx * dx + dz * dz) / (2 * sigma_m * sigma_m));
    }
    [[nodiscard]] HeightField field() const {
        HeightField made(posts, posts);
        for (std::int32_t z = 0; z < posts; ++z)
            for (std::int32_t x = 0; x < posts; ++x)
                made.set_code({x, z}, codec.code(height(x * spacing_m, z * spacing_m), HeightPrecision::bits32));
        return made;
    }
};

enum class Way { Gpu, Cpu };

struct Case {
    Way way;
    SlopeFormat format;
    SlopeStencil stencil;
};

class SlopeTest : public test::GlTest, public ::testing::WithParamInterface<Case> {};

/// One level of a slope map as slopes, dh/dx and dh/dz.
std::vector<Slope> slopes_of(const SlopeMap& map, std::int32_t level) {
    const std::size_t texels =
        static_cast<std::size_t>(map.texture().width(level)) * static_cast<std::size_t>(map.texture().height(level));
    std::vector<Slope> slopes(texels);
    if (map.format() == SlopeFormat::rg8) {
        std::vector<std::uint8_t> stored(texels * 2);
        map.texture().read(level, stored.data());
        for (std::size_t i = 0; i < texels; ++i) {
            const double x = (stored[2 * i] - 128) / 127.0, z = (stored[2 * i + 1] - 128) / 127.0;
            const double expansion = 1 / std::max(1 - std::hypot(x, z), 1 / 255.0);
            slopes[i] = {static_cast<float>(x * expansion), static_cast<float>(z * expansion)};
        }
        return slopes;
    }
    std::vector<std::uint16_t> stored(texels * 2);
    map.texture().read(level, stored.data());
    const auto from_half = [](std::uint16_t h) {
        const int exponent = (h >> 10) & 31, fraction = h & 1023;
        const double size = exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024 + fraction, exponent - 25);
        return static_cast<float>(h >> 15 ? -size : size);
    };
    for (std::size_t i = 0; i < texels; ++i) slopes[i] = {from_half(stored[2 * i]), from_half(stored[2 * i + 1])};
    return slopes;
}

struct Maps {
    Maps(gl::Device& device, const HeightField& field, SlopeFormat format, const SlopeSettings& slope_settings, Way how)
        : settings(slope_settings),
          way(how),
          shaders(test::shaders()),
          planes(test::value(HeightPlanes::create(device, field.width(), field.depth(), HeightPrecision::bits32))),
          slopes(test::value(SlopeMap::create(device, field.width(), field.depth(), format))),
          pass(test::value(SlopePass::create(device, shaders, HeightPrecision::bits32, format, settings))) {
        planes.upload(field, field.rect(), transfer);
    }
    void derive(const HeightField& field, std::span<const TexelRect> changed) {
        if (way == Way::Gpu)
            pass.run(changed, planes, slopes, stage, mips);
        else
            upload_slopes(changed, field, settings, slopes, stage, mips, transfer);
    }
    SlopeSettings settings;
    Way way;
    gl::ShaderLibrary shaders;
    HeightPlanes planes;
    SlopeMap slopes;
    SlopePass pass;
    gl::TransferStats transfer;
    gl::StageStats stage, mips;
};

TEST_P(SlopeTest, OfAGaussianHillAreItsDerivatives) {
    const gl::StateGuard guard(device());
    for (const double spacing_m : {0.1, 0.25, 0.5, 1.0}) {
        const Hill hill{.posts = 97, .spacing_m = spacing_m, .sigma_m = 8 * spacing_m};
        const HeightField field = hill.field();
        Maps maps(device(), field, GetParam().format, {GetParam().stencil, hill.codec.code_quantum_m(), spacing_m},
                  GetParam().way);
        const TexelRect whole = field.rect();
        maps.derive(field, {&whole, 1});

        // Truncation: h^2 / 6 max|h'''| and h^4 / 30 max|h'''''|; along a line through the top of a Gaussian the maxima
        // are 1.3801 peak / sigma^3 and 5.7835 peak / sigma^5 (extremes of the Hermite functions He3, He5 times
        // exp(-t^2/2)).
        const double sigma = hill.sigma_m;
        const double truncation = GetParam().stencil == SlopeStencil::Central
                                      ? spacing_m * spacing_m / 6 * 1.3801 * kPeakM / std::pow(sigma, 3)
                                      : std::pow(spacing_m, 4) / 30 * 5.7835 * kPeakM / std::pow(sigma, 5);
        // Codes: half a quantum at each end of the difference, 1.5 times that for the fourth order.
        const double codes = 1.5 * hill.codec.code_quantum_m() / spacing_m;
        for (std::int32_t level = 0; level < 3; ++level) {
            const std::vector<Slope> slopes = slopes_of(maps.slopes, level);
            const std::int32_t row = maps.slopes.texture().width(level);
            for (std::int32_t z = 2; z << level < 95; ++z)
                for (std::int32_t x = 2; x << level < 95; ++x) {
                    const double px = (x << level) * spacing_m, pz = (z << level) * spacing_m;
                    const double h = hill.height(px, pz);
                    const double true_x = -(px - hill.centre_m()) / (sigma * sigma) * h;
                    const double true_z = -(pz - hill.centre_m()) / (sigma * sigma) * h;
                    const double size = std::hypot(true_x, true_z);
                    // Storage: half a step of 1/127 in c = p / (1 + |p|) on both components; dp/dc is at most (1 +
                    // |p|)^2. Half floats: GL may truncate, so a unit in the last place, 2^-10 of the size.
                    const double storage = GetParam().format == SlopeFormat::rg8
                                               ? 0.75 / 127 * (1 + size) * (1 + size)
                                               : std::max({std::abs(true_x), std::abs(true_z), 1e-4}) / 1024;
                    const Slope stored = slopes[static_cast<std::size_t>(z * row + x)];
                    ASSERT_NEAR(stored.x, true_x, truncation + codes + storage) << spacing_m << " m, level " << level;
                    ASSERT_NEAR(stored.z, true_z, truncation + codes + storage) << spacing_m << " m, level " << level;
                }
        }
    }
}

TEST_P(SlopeTest, AfterEditsEqualAMapComputedAnew) {
    const gl::StateGuard guard(device());
    const std::unique_ptr<Ground> ground = test::small_world(200, HeightPrecision::bits32);
    const SlopeSettings settings{GetParam().stencil, ground->map(MapKind::Coarse).codec.code_quantum_m(), 1.0};
    Maps edited(device(), ground->coarse(), GetParam().format, settings, GetParam().way);
    const TexelRect whole = ground->coarse().rect();
    edited.derive(ground->coarse(), {&whole, 1});
    for (int frame = 0; frame < 6; ++frame) {
        std::vector<TexelRect> changed;
        for (const StampRecord& record :
             test::random_records(*ground, 40 + static_cast<std::uint64_t>(frame), 12, 15)) {
            const TexelRect rect = ground->apply(record).rect;
            if (rect.empty()) continue;
            edited.planes.upload(ground->coarse(), rect, edited.transfer);
            changed.push_back(rect);
        }
        edited.derive(ground->coarse(), changed);
    }
    Maps anew(device(), ground->coarse(), GetParam().format, settings, GetParam().way);
    anew.derive(ground->coarse(), {&whole, 1});
    for (std::int32_t level = 0; level < SlopeMap::kLevels; ++level) {
        const std::vector<Slope> a = slopes_of(edited.slopes, level), b = slopes_of(anew.slopes, level);
        const std::int32_t row = edited.slopes.texture().width(level);
        for (std::int32_t z = 0; z << level < 200; ++z)
            for (std::int32_t x = 0; x << level < 200; ++x) {
                const std::size_t i = static_cast<std::size_t>(z * row + x);
                ASSERT_EQ(a[i].x, b[i].x) << "level " << level << " at " << x << ", " << z;
                ASSERT_EQ(a[i].z, b[i].z) << "level " << level << " at " << x << ", " << z;
            }
    }
}

TEST_P(SlopeTest, NothingChangedIsNothingDone) {
    const gl::StateGuard guard(device());
    const HeightField field(70, 70);
    Maps maps(device(), field, GetParam().format, {GetParam().stencil, 0.001, 1.0}, GetParam().way);
    maps.derive(field, {});
    const TexelRect empty{};
    maps.derive(field, {&empty, 1});
    EXPECT_EQ(maps.stage, gl::StageStats{});
    EXPECT_EQ(maps.mips, gl::StageStats{});
}

TEST_P(SlopeTest, ACliffSaturatesWithoutTurning) {
    const gl::StateGuard guard(device());
    HeightField field(33, 33, 0x40000000u);
    for (std::int32_t z = 0; z < 33; ++z)
        for (std::int32_t x = 0; x < 33; ++x)
            if (x + 2 * z > 48) field.set_code({x, z}, 0x80000000u);
    Maps maps(device(), field, GetParam().format, {GetParam().stencil, 1.0 / 65536 / 1024, 1.0}, GetParam().way);
    const TexelRect whole = field.rect();
    maps.derive(field, {&whole, 1});
    const std::vector<Slope> slopes = slopes_of(maps.slopes, 0);
    const std::int32_t row = maps.slopes.texture().width(0);
    int steep = 0;
    for (std::int32_t z = 3; z < 30; ++z)
        for (std::int32_t x = 3; x < 30; ++x) {
            const Slope stored = slopes[static_cast<std::size_t>(z * row + x)];
            const Slope truth = slope_at(field, {x, z}, maps.settings);
            const double size = std::hypot(truth.x, truth.z);
            if (size < 1) continue;
            ++steep;
            const double turn = std::atan2(stored.z, stored.x) - std::atan2(truth.z, truth.x);
            EXPECT_LT(std::abs(turn), 1.0 / 57.3) << x << ", " << z;
        }
    EXPECT_GT(steep, 20);
}

TEST(SlopeStorage, FlatGroundIsExactlyFlat) {
    const HeightField field(9, 9);
    const Slope slope = slope_at(field, {4, 4}, {SlopeStencil::Fourth, 1, 1});
    EXPECT_EQ(slope.x, 0);
    EXPECT_EQ(slope.z, 0);
}

INSTANTIATE_TEST_SUITE_P(Ways, SlopeTest,
                         ::testing::Values(Case{Way::Gpu, SlopeFormat::rg8, SlopeStencil::Central},
                                           Case{Way::Gpu, SlopeFormat::rg8, SlopeStencil::Fourth},
                                           Case{Way::Gpu, SlopeFormat::rg16f, SlopeStencil::Fourth},
                                           Case{Way::Gpu, SlopeFormat::rg16f, SlopeStencil::Central},
                                           Case{Way::Cpu, SlopeFormat::rg8, SlopeStencil::Central},
                                           Case{Way::Cpu, SlopeFormat::rg8, SlopeStencil::Fourth},
                                           Case{Way::Cpu, SlopeFormat::rg16f, SlopeStencil::Fourth}));

}  // namespace
}  // namespace tilth
