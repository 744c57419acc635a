// Codes gathered from a sparse field and scattered back are the same, and untouched ground makes no pages.
#include "tilth/pool/code_view.h"

#include <gtest/gtest.h>

#include "tilth/ground/random_stamps.h"

namespace tilth {
namespace {

TEST(CodeView, ScatteredCodesAreGatheredAgainAndNothingElseChanges) {
    SplitMix64 random{9};
    DetailField field;
    for (std::uint32_t& code : field.touch({1, 1})) code = static_cast<std::uint32_t>(random.next());
    GatheredCodes gathered, whole;
    const TexelRect all{{0, 0}, {256, 256}};
    const CodeView before = whole.gather(field, all);
    const std::vector<std::uint32_t> old(before.codes, before.codes + all.count());

    const TexelRect rect{{50, 70}, {140, 131}};
    std::vector<std::uint32_t> codes(static_cast<std::size_t>(rect.count()));
    for (std::uint32_t& code : codes) code = static_cast<std::uint32_t>(random.next());
    scatter({codes.data(), static_cast<std::size_t>(rect.width()), rect}, field);
    const CodeView after = gathered.gather(field, all);
    for (std::int32_t z = 0; z < 256; ++z)
        for (std::int32_t x = 0; x < 256; ++x) {
            const std::uint32_t expected =
                rect.contains({x, z})
                    ? codes[static_cast<std::size_t>((z - rect.min.z) * rect.width() + x - rect.min.x)]
                    : old[static_cast<std::size_t>(z * 256 + x)];
            ASSERT_EQ(after.code({x, z}), expected) << x << ", " << z;
        }
}

TEST(CodeView, UntouchedGroundMakesNoPagesButOverwritesThoseThere) {
    DetailField field;
    field.touch({1, 0}).fill(7);
    const TexelRect rect{{0, 0}, {192, 64}};
    const std::vector<std::uint32_t> codes(static_cast<std::size_t>(rect.count()), kMidCode);
    scatter({codes.data(), 192, rect}, field);
    EXPECT_EQ(field.pages().size(), 1u);
    EXPECT_TRUE(is_untouched(*field.find({1, 0})));
}

TEST(CodeView, OfADenseFieldIsThatField) {
    HeightField field(5, 3);
    field.set_code({4, 2}, 11);
    const CodeView view = field;
    EXPECT_EQ(view.rect, field.rect());
    EXPECT_EQ(view.code({4, 2}), 11u);
}

}  // namespace
}  // namespace tilth
