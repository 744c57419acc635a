// Images: refused sizes, bilinear values, quarter turns, mirrors, any angle.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "ground/support.h"
#include "tilth/ground/cpu_executor.h"
#include "tilth/ground/turn.h"

namespace tilth {
namespace {

constexpr std::uint32_t kAmplitude = 1u << 24;

HeightField stamped(const ShapeLibrary& shapes, const StampRecord& record, std::int32_t size) {
    HeightField field(size, size);
    apply_stamp(prepare(record, test::map_of(size), shapes), field);
    return field;
}

std::vector<std::uint16_t> noise(std::int32_t width, std::int32_t height) {
    std::mt19937 random(14);
    std::vector<std::uint16_t> texels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::uint16_t& texel : texels) texel = static_cast<std::uint16_t>(random());
    return texels;
}

TEST(StampImage, BadSizesAndNamesAreRefused) {
    ShapeLibrary shapes;
    const std::uint32_t size = shapes.size();
    const std::vector<std::uint16_t> four(4);
    for (const auto& [width, height] : {std::pair{0, 0}, {0, 4}, {4, 0}, {-1, 4}, {4097, 1}, {1, 4097}}) {
        const Result<ShapeId> result = shapes.add_image("bad", width, height, four);
        ASSERT_FALSE(result.ok());
        EXPECT_EQ(result.error().message.rfind("size:", 0), 0u) << result.error().message;
    }
    EXPECT_EQ(shapes.add_image("bad", 2, 3, four).error().message.rfind("texels:", 0), 0u);
    EXPECT_EQ(shapes.add_image("", 2, 2, four).error().message.rfind("name:", 0), 0u);
    EXPECT_EQ(shapes.add_image("disc", 2, 2, four).error().message.rfind("name:", 0), 0u);
    EXPECT_EQ(shapes.bake("bad", 0, [](double, double) { return 0.0; }).error().message.rfind("size:", 0), 0u);
    for (const double value : {1.001, -1.001, std::numeric_limits<double>::infinity(), std::nan("")}) {
        EXPECT_EQ(shapes.bake("bad", 3, [&](double, double) { return value; }).error().message.rfind("weight:", 0), 0u);
        EXPECT_EQ(shapes.add_profile("bad", [&](double) { return value; }).error().message.rfind("weight:", 0), 0u);
    }
    for (const double least : {0.0, -1.0, 0.49, 8192.0, std::nan("")})
        EXPECT_EQ(shapes
                      .add_profile(
                          "bad", [](double) { return 0.0; }, least)
                      .error()
                      .message.rfind("least_radius_texels:", 0),
                  0u);
    EXPECT_EQ(shapes.size(), size);
    EXPECT_TRUE(shapes.add_image("good", 2, 2, four).ok());
    EXPECT_EQ(shapes.size(), size + 1);
    EXPECT_TRUE(shapes.find("good"));
    EXPECT_FALSE(shapes.find("bad"));
}

// A host that opens a world adds its shapes again; what it draws for another must not pass for the same.
TEST(StampImage, TheSameShapeAddedAgainIsTheOneThatIsThere) {
    ShapeLibrary shapes;
    const auto cone = [](double t) { return 1 - t; };
    const auto saddle = [](double x, double z) { return x * z; };
    std::vector<std::uint16_t> texels = noise(5, 3);
    const ShapeId profile = *shapes.add_profile("profile", cone, 2.0), image = *shapes.add_image("image", 5, 3, texels);
    const ShapeId baked = *shapes.bake("baked", 8, saddle);
    const std::uint32_t size = shapes.size();
    EXPECT_EQ(*shapes.add_profile("profile", cone, 2.0), profile);
    EXPECT_EQ(*shapes.add_image("image", 5, 3, texels), image);
    EXPECT_EQ(*shapes.bake("baked", 8, saddle), baked);
    EXPECT_EQ(*shapes.add_exact(shapes.shape({0})), ShapeId{0});

    const auto refused = [&](const Result<ShapeId>& added) {
        ASSERT_FALSE(added.ok());
        EXPECT_EQ(added.error().message.rfind("name:", 0), 0u) << added.error().message;
    };
    refused(shapes.add_profile("profile", cone, 2.5));
    refused(shapes.add_profile(
        "profile", [](double t) { return t < 1 ? 1 - t : 1.0 / 65536; }, 2.0));
    refused(shapes.add_profile("image", cone, 2.0));
    refused(shapes.add_image("image", 3, 5, texels));
    refused(shapes.add_image("baked", 5, 3, texels));
    texels.back() ^= 1;
    refused(shapes.add_image("image", 5, 3, texels));
    EXPECT_EQ(shapes.size(), size);
    EXPECT_NE(*shapes.add_image("image 2", 5, 3, texels), image);
}

TEST(StampImage, AShapeCanBeTakenOverExactly) {
    ShapeLibrary from, to;
    const ShapeId rim = *from.add_profile(
        "rim", [](double t) { return (1 - t) * (2 * t - 0.5); }, 2.0003);
    Shape shape = from.shape(rim);
    const std::uint64_t hash = shape.hash;
    shape.hash = 1, shape.lowest_weight = 5, shape.highest_weight = -5;  // computed, not believed
    const Shape& taken = to.shape(*to.add_exact(shape));
    EXPECT_EQ(taken.hash, hash);
    EXPECT_EQ(taken.weights, shape.weights);
    EXPECT_EQ(taken.lowest_weight, from.shape(rim).lowest_weight);
    EXPECT_EQ(taken.highest_weight, from.shape(rim).highest_weight);
    EXPECT_EQ(taken.least_radius_texels, 2.0003);

    const auto refused = [&](const char* field, const auto& change) {
        Shape bad = from.shape(rim);
        bad.name = "bad";
        change(bad);
        const Result<ShapeId> added = to.add_exact(bad);
        ASSERT_FALSE(added.ok()) << field;
        EXPECT_EQ(added.error().message.rfind(field, 0), 0u) << added.error().message;
    };
    refused("name:", [](Shape& s) { s.name.clear(); });
    refused("weights:", [](Shape& s) { s.weights.pop_back(); });
    refused("weights:", [](Shape& s) { s.weights.clear(); });
    refused("weights:", [](Shape& s) { s.weights[7] = 65537; });
    refused("weights:", [](Shape& s) { s.weights[1024] = -65537; });
    refused("weights:", [](Shape& s) { s.is_image = true, s.width = 5, s.height = 204; });
    refused("size:", [](Shape& s) { s.width = 1; });
    refused("size:", [](Shape& s) { s.is_image = true, s.width = 1025, s.height = 0; });
    refused("size:", [](Shape& s) { s.is_image = true, s.width = 4097, s.height = 1; });
    refused("least_radius_texels:", [](Shape& s) { s.least_radius_texels = 0.4; });
    refused("least_radius_texels:", [](Shape& s) { s.least_radius_texels = std::nan(""); });
}

TEST(StampImage, WhiteIsOneAndBlackIsNothing) {
    ShapeLibrary shapes;
    const ShapeId white = *shapes.add_image("white", 1, 1, std::vector<std::uint16_t>{65535});
    const ShapeId black = *shapes.add_image("black", 1, 1, std::vector<std::uint16_t>{0});
    const HeightField raised = stamped(shapes, test::record_at(16, 16, 4, kAmplitude, white), 32);
    for (int z = 0; z < 32; ++z)
        for (int x = 0; x < 32; ++x)  // the square of side 2 x radius, half-open
            ASSERT_EQ(raised.code({x, z}), x >= 12 && x < 20 && z >= 12 && z < 20 ? kMidCode + kAmplitude : kMidCode)
                << x << ", " << z;
    EXPECT_EQ(test::volume(stamped(shapes, test::record_at(16, 16, 4, kAmplitude, black), 32)), 0);
}

// S13: against bilinear filtering in doubles, for sizes that are no powers of two, turned and mirrored.
TEST(StampImage, IsBilinear) {
    ShapeLibrary shapes;
    std::mt19937 random(15);
    for (const auto& [width, height] : {std::pair{1, 1}, {2, 2}, {3, 7}, {13, 5}, {64, 64}, {100, 33}, {257, 255}}) {
        const std::vector<std::uint16_t> texels = noise(width, height);
        const ShapeId id = *shapes.add_image(text("noise ", width, "x", height), width, height, texels);
        for (const double radius : {2.5, 9.75, 40.0})
            for (int i = 0; i < 6; ++i) {
                StampRecord record = test::record_at(60 + i * 0.1, 61 - i * 0.07, radius, kAmplitude, id);
                record.rotation = i == 0 ? 0 : static_cast<std::uint32_t>(random());
                record.mirror = static_cast<std::uint8_t>(i & 1);
                const HeightField field = stamped(shapes, record, 121);
                const double angle = 2 * std::numbers::pi * record.rotation / 4294967296.0, c = std::cos(angle),
                             s = std::sin(angle);
                // The centre is held to 1/1 024 texel, the fraction to 14 bits, the steps to 2^-16 of a pixel a texel
                // at worst: so many pixels, times the steepest change, one a pixel, on both axes; and three roundings
                // of weights.
                const double pixels_a_texel = std::max(width, height) / (2 * radius);
                const double pixels = 0.5 / 1024 * 1.5 * pixels_a_texel + 1.0 / 16384 + 60 * 0x1p-17;
                const double tolerance = 2 * pixels + 3.0 / 65536;
                int inside = 0;
                for (int z = 0; z < 121; ++z)
                    for (int x = 0; x < 121; ++x) {
                        const double dx = x - (60 + i * 0.1), dz = z - (61 - i * 0.07);
                        // Rotation a maps (1, 0) to (cos a, -sin a): the image's axes in the world.
                        double right = (dx * c - dz * s) / radius;
                        const double down = (dx * s + dz * c) / radius;
                        if (record.mirror != 0) right = -right;
                        const double u = (right + 1) / 2 * width - 0.5, v = (down + 1) / 2 * height - 0.5;
                        const double margin = 4 * pixels;  // texels on the very edge may fall to either side
                        if (std::abs(u + 0.5) < margin || std::abs(v + 0.5) < margin ||
                            std::abs(u - width + 0.5) < margin || std::abs(v - height + 0.5) < margin)
                            continue;
                        double expected = 0;
                        if (std::abs(right) < 1 && std::abs(down) < 1) {
                            ++inside;
                            const auto pixel = [&, width = width, height = height](double column, double row) {
                                const int cc = std::clamp(static_cast<int>(column), 0, width - 1),
                                          rr = std::clamp(static_cast<int>(row), 0, height - 1);
                                return texels[static_cast<std::size_t>(rr * width + cc)] / 65535.0;
                            };
                            const double u0 = std::floor(u), v0 = std::floor(v), a = u - u0, b = v - v0;
                            expected = (pixel(u0, v0) * (1 - a) + pixel(u0 + 1, v0) * a) * (1 - b) +
                                       (pixel(u0, v0 + 1) * (1 - a) + pixel(u0 + 1, v0 + 1) * a) * b;
                        }
                        const double got = (static_cast<double>(field.code({x, z})) - kMidCode) / kAmplitude;
                        ASSERT_NEAR(got, expected, tolerance) << width << "x" << height << " radius " << radius
                                                              << " turn " << i << " at " << x << ", " << z;
                    }
                EXPECT_GT(inside, 3 * radius * radius);
            }
    }
}

// S9: a quarter turn maps (1, 0) to (0, -1), so the map at (x, z) is the unturned one at (-z, x). Exact.
TEST(StampImage, QuarterTurnsAreExactlyTransposedMaps) {
    ShapeLibrary shapes;
    const test::UserShapes user(shapes);
    for (const ShapeId shape : {user.image, user.baked})
        for (const double radius : {2.0, 7.3, 30.1}) {
            constexpr int kMiddle = 50;
            StampRecord record = test::record_at(kMiddle, kMiddle, radius, kAmplitude, shape);
            const HeightField plain = stamped(shapes, record, 101);
            record.rotation = turns_of(std::numbers::pi / 2);
            const HeightField quarter = stamped(shapes, record, 101);
            record.rotation = turns_of(std::numbers::pi);
            const HeightField half = stamped(shapes, record, 101);
            record.rotation = turns_of(-std::numbers::pi / 2);
            const HeightField back = stamped(shapes, record, 101);
            for (int z = -kMiddle; z <= kMiddle; ++z)
                for (int x = -kMiddle; x <= kMiddle; ++x) {
                    const auto at = [&](const HeightField& field, int dx, int dz) {
                        return field.code({kMiddle + dx, kMiddle + dz});
                    };
                    ASSERT_EQ(at(quarter, x, z), at(plain, -z, x)) << x << ", " << z;
                    ASSERT_EQ(at(half, x, z), at(plain, -x, -z)) << x << ", " << z;
                    ASSERT_EQ(at(back, x, z), at(plain, z, -x)) << x << ", " << z;
                }
            EXPECT_NE(test::volume(plain), 0);
        }
}

// An image whose weight grows along +x: where does it point?
TEST(StampImage, RotationAndMirrorPointWhereTheContractSays) {
    ShapeLibrary shapes;
    const ShapeId arrow = *shapes.bake("arrow", 64, [](double x, double) { return x > 0 ? x : 0.0; });
    const auto heading = [&](double rotation_rad, bool mirror) {  // centre of mass
        StampRecord record = test::record_at(50, 50, 20, kAmplitude, arrow);
        record.rotation = turns_of(rotation_rad);
        record.mirror = mirror ? 1 : 0;
        const HeightField field = stamped(shapes, record, 101);
        double mass = 0, x_sum = 0, z_sum = 0;
        for (int z = 0; z < 101; ++z)
            for (int x = 0; x < 101; ++x) {
                const double m = static_cast<double>(field.code({x, z})) - kMidCode;
                mass += m, x_sum += m * (x - 50), z_sum += m * (z - 50);
            }
        return WorldPos{x_sum / mass / 20, z_sum / mass / 20};
    };
    // Centre of mass of w = x on 0 < x < 1: 2/3. The rows differ by half a texel at the edge: 1/20.
    for (const double a : {0.0, 0.3, std::numbers::pi / 2, 2.5, 4.0, 1e9}) {
        EXPECT_NEAR(heading(a, false).x, 2.0 / 3 * std::cos(a), 0.05) << a;
        EXPECT_NEAR(heading(a, false).z, 2.0 / 3 * -std::sin(a), 0.05) << a;
        EXPECT_NEAR(heading(a, true).x, 2.0 / 3 * -std::cos(a), 0.05) << a;  // flipped before it is turned
        EXPECT_NEAR(heading(a, true).z, 2.0 / 3 * std::sin(a), 0.05) << a;
    }
}

// A mirror flips the image's x axis only.
TEST(StampImage, MirrorIsAnExactFlip) {
    ShapeLibrary shapes;
    const test::UserShapes user(shapes);
    StampRecord record = test::record_at(50, 50, 17.25, kAmplitude, user.baked);
    const HeightField plain = stamped(shapes, record, 101);
    record.mirror = 1;
    const HeightField mirrored = stamped(shapes, record, 101);
    for (int z = 0; z < 101; ++z)
        for (int x = 0; x < 101;
             ++x)  // a fraction f becomes 1 - f in 14 bits, cut off: 2^-14 of two pixels' difference
            ASSERT_NEAR(static_cast<double>(mirrored.code({x, z})), static_cast<double>(plain.code({100 - x, z})),
                        4 * kAmplitude / 16384.0)
                << x << ", " << z;
}

TEST(StampImage, WidensSmallImagesWithTheirVolume) {
    ShapeLibrary shapes;
    const ShapeId bump =
        *shapes.bake("bump", 32, [](double x, double z) { return std::cos(x * 1.5707963) * std::cos(z * 1.5707963); });
    std::mt19937 random(16);
    constexpr double kUnit = 16 / (std::numbers::pi * std::numbers::pi);  // (4 / pi)^2 over the square of side 2
    double sum = 0;
    for (int i = 0; i < 2000; ++i) {
        StampRecord record = test::record_at(8 + 2e-10 * static_cast<double>(random()),
                                             8 + 2e-10 * static_cast<double>(random()), 0.5, 1u << 27, bump);
        record.rotation = static_cast<std::uint32_t>(random());
        sum += static_cast<double>(test::volume(stamped(shapes, record, 16))) / (kUnit * 0.25 * (1u << 27));
    }
    EXPECT_NEAR(sum / 2000, 1.0, 0.005);  // the baked 32 x 32 image itself holds its integral to 1e-3
}

TEST(StampImage, AThinLargeImageKeepsItsScaleOnBothAxes) {
    ShapeLibrary shapes;
    const std::vector<std::uint16_t> texels(4096, 65535);
    const ShapeId thin = *shapes.add_image("thin", 1, 4096, texels);
    const MapGeometry map{.grid = {.spacing_m = 1, .width = 64, .depth = 64}, .codec = HeightCodec::for_range(0, 10)};
    StampRecord record{.shape = thin.value, .radius = 7000u << 18};
    const StampParams params = prepare(record, map, shapes).params;
    // Pixels a texel: size / (2 radius), to half a unit of the last fraction bit.
    EXPECT_NEAR(std::ldexp(params.u_per_x, -static_cast<int>(params.u_bits)), 1 / 14000.0, std::ldexp(0.5, -30));
    EXPECT_NEAR(std::ldexp(params.v_per_z, -static_cast<int>(params.v_bits)), 4096 / 14000.0, std::ldexp(0.5, -18));
}

}  // namespace
}  // namespace tilth
