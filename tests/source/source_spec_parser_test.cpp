#include "tilth/source/source_spec.h"

#include <gtest/gtest.h>

#include "tilth/source/ridged_source.h"

namespace tilth {
namespace {

TEST(SourceSpec, TellsKindsFromPaths) {
    for (const char* spec : {"ridged:seed=7", "flat:", "hill:size=3", "rigded:seed=7"})
        EXPECT_TRUE(is_procedural(spec)) << spec;
    for (const char* path : {"", ":", "map.tif", "a/b.tif", "C:\\map.tif", "c:map.tif", "./flat:size",
                             "dir/ridged:seed=7", "Map:1.tif", "my map:1", "ridged"})
        EXPECT_FALSE(is_procedural(path)) << path;
}

TEST(SourceSpec, MakesWhatItSays) {
    const auto ridged = make_source("ridged:seed=9,size=65,relief=50");
    ASSERT_TRUE(ridged.ok());
    const auto same = make_ridged_source({.seed = 9, .size = 65, .relief_m = 50});
    for (int z = 0; z < 65; ++z)
        for (int x = 0; x < 65; ++x) ASSERT_EQ((*ridged)->height_m({x, z}), same->height_m({x, z}));

    const auto flat = make_source("flat:size=16,height=-10.5");
    ASSERT_TRUE(flat.ok());
    EXPECT_EQ((*flat)->width(), 16);
    EXPECT_EQ((*flat)->height_m({3, 5}), -10.5);

    const auto hill = make_source("hill:sigma=20,peak=4,size=513");
    ASSERT_TRUE(hill.ok());
    EXPECT_EQ((*hill)->width(), 513);
    EXPECT_EQ((*hill)->height_m({256, 256}), 4);
    EXPECT_NEAR((*hill)->height_m({276, 256}), 4 * 0.60653065971263342, 1e-14);  // exp(-1/2) at one sigma
}

TEST(SourceSpec, DefaultsAreAsDocumented) {
    const auto flat = make_source("flat:");
    ASSERT_TRUE(flat.ok());
    EXPECT_EQ((*flat)->width(), 1025);
    EXPECT_EQ((*flat)->max_m(), 0);
    const auto hill = make_source("hill:");
    ASSERT_TRUE(hill.ok());
    EXPECT_EQ((*hill)->width(), 513);
    EXPECT_EQ((*hill)->max_m(), 4);
    const auto ridged = make_source("ridged:size=33");
    ASSERT_TRUE(ridged.ok());
    EXPECT_EQ((*ridged)->max_m(), 200);
}

struct Bad {
    const char* spec;
    const char* named;  // what the message must contain besides the specification
};

TEST(SourceSpec, EveryMistakeIsNamed) {
    const Bad all[] = {
        {"rigded:seed=7", "unknown kind 'rigded'"},
        {"", "unknown kind ''"},
        {"map.tif", "unknown kind 'map.tif'"},
        {"flat:seed=7", "unknown key 'seed'"},
        {"ridged:seed=7,height=3", "unknown key 'height'"},
        {"flat:size", "'size' has no '='"},
        {"flat:size=16,", "comma at the end"},
        {"flat:,size=16", "'' has no '='"},
        {"flat:size=16,size=17", "'size' is given twice"},
        {"flat:size=1", "'size': '1'"},
        {"flat:size=16385", "2 to 16384"},
        {"flat:size=-5", "'size': '-5'"},
        {"flat:size=1e3", "'size': '1e3'"},
        {"flat:size=", "'size': ''"},
        {"flat:size=99999999999999999999", "'size'"},
        {"flat:size= 16", "'size': ' 16'"},
        {"flat:height=nan", "'height': 'nan'"},
        {"flat:height=inf", "'height'"},
        {"flat:height=1e7", "'height'"},
        {"flat:height=ten", "'height': 'ten'"},
        {"flat:height=1x", "'height': '1x'"},
        {"hill:sigma=0", "'sigma': '0'"},
        {"hill:sigma=-1", "number above 0"},
        {"hill:sigma=nan", "'sigma'"},
        {"hill:peak=-inf", "'peak'"},
        {"ridged:relief=0", "'relief'"},
        {"ridged:relief=1e-999", "'relief'"},
        {"ridged:seed=-1", "'seed': '-1'"},
        {"ridged:seed=18446744073709551616", "'seed'"},
    };
    for (const Bad& bad : all) {
        const auto source = make_source(bad.spec);
        ASSERT_FALSE(source.ok()) << bad.spec;
        EXPECT_EQ(source.error().code, ErrorCode::InvalidArgument);
        EXPECT_NE(source.error().message.find(text("\"", bad.spec, "\"")), std::string::npos) << source.error().message;
        EXPECT_NE(source.error().message.find(bad.named), std::string::npos) << source.error().message;
    }
}

TEST(SourceSpec, EndsOfTheRangesAreAllowed) {
    EXPECT_TRUE(make_source("flat:size=2").ok());
    EXPECT_TRUE(make_source("flat:size=16384,height=1e6").ok());
    EXPECT_TRUE(make_source("ridged:size=2,seed=18446744073709551615").ok());
}

// Any bytes: an error or a source, never a crash. Sizes stay small because only prefixes of small sizes occur.
TEST(SourceSpec, CutAndFlippedSpecificationsNeverCrash) {
    const std::string whole = "hill:size=9,peak=4.5e-1,sigma=2";
    for (std::size_t cut = 0; cut <= whole.size(); ++cut) (void)make_source(whole.substr(0, cut));
    for (std::size_t at = 0; at < whole.size(); ++at)
        for (int bit = 0; bit < 8; ++bit) {
            std::string flipped = whole;
            flipped[at] = static_cast<char>(flipped[at] ^ (1 << bit));
            const auto source = make_source(flipped);
            if (!source.ok()) {
                EXPECT_FALSE(source.error().message.empty());
            }
        }
}

}  // namespace
}  // namespace tilth
