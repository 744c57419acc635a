// Worlds on disk behind the facade: what comes back after a crash, by whichever executor, with and without GL.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "io/scratch_folder.h"
#include "support/gl_context.h"
#include "support/random_world.h"
#include "tilth/source/ridged_source.h"
#include "tilth/terrain.h"

namespace tilth {
namespace {

enum class Kind : std::uint8_t { Gpu, Cpu, Server };
constexpr Kind kKinds[] = {Kind::Gpu, Kind::Cpu, Kind::Server};

struct Options {
    Kind kind = Kind::Cpu;
    HeightPrecision precision = HeightPrecision::bits32;
    std::string folder;
    FlushPolicy::When flush = FlushPolicy::When::Manual;
    std::uint64_t snapshot_edits = 1u << 20;
    std::uint64_t undo_bytes = 64u << 20;
};

class WorldTest : public test::GlTest {
protected:
    static Result<std::unique_ptr<Terrain>> open(const Options& options) {
        TerrainSettings settings{.clipmap = {.n = 31, .levels = 3}};
        settings.ground.precision = options.precision;
        settings.ground.tile_size = 128;
        settings.executor = options.kind == Kind::Gpu ? ExecutorKind::Gpu : ExecutorKind::Cpu;
        settings.world.folder = options.folder;
        settings.world.options.flush.when = options.flush;
        settings.world.snapshot_edits = options.snapshot_edits;
        settings.undo_bytes = options.undo_bytes;
        const gl::GetProc get_proc = test::test_context(test::default_route()).context->get_proc();
        return Terrain::create(make_ridged_source({.seed = 3, .size = 257, .relief_m = 100}), settings,
                               options.kind == Kind::Server ? nullptr : get_proc);
    }

    /// A deterministic life of a world: frame `number` walks, stamps both maps in strokes, undoes and redoes.
    static void live(Terrain& terrain, std::uint64_t number) {
        const WorldPos viewer{20.0 + static_cast<double>(number * 5 % 210), 120};
        terrain.set_viewers({&viewer, 1});
        for (const MapChoice map : {MapChoice::Coarse, MapChoice::Detail}) {
            RandomStamps stamps{.seed = 77 + number, .count = 4, .map = map};
            // Detail near the viewer and in the dark alike.
            const bool dark = number % 3 == 0;
            stamps.region = {WorldPos{dark ? 0 : viewer.x - 20, dark ? 0 : 100.0},
                             WorldPos{dark ? 256 : viewer.x + 20, dark ? 256 : 140.0}};
            stamps.radius_m = {0.1, map == MapChoice::Coarse ? 12.0 : 2.5};
            stamps.amplitude_m = {-1, 1};
            for (std::uint32_t shape = 0; shape < kBuiltinProfiles; ++shape) stamps.shapes.push_back({shape});
            stamps.rules = {StampRule::Add, StampRule::Min, StampRule::Max, StampRule::Set, StampRule::Smooth};
            if (number % 2 == 0) terrain.begin_stroke();
            for (const StampRequest& request : random_stamps(stamps, terrain.ground()))
                ASSERT_TRUE(terrain.stamp(request));
            terrain.end_stroke();
        }
        for (std::uint64_t undos = number % 4 == 1 ? 1 : number % 4 == 3 ? 2 : 0; undos > 0; --undos) {
            ASSERT_TRUE(terrain.undo());
        }
        if (number % 8 == 1) {
            ASSERT_TRUE(terrain.redo());
        }
        ASSERT_TRUE(terrain.update(1.0 / 60));
    }

    static StateHash hash_of(Terrain& terrain) { return test::value(terrain.hash()); }

    test::ScratchFolder scratch_;
};

TEST_F(WorldTest, WhatWasFlushedIsThereAfterACrash) {
    for (const Kind kind : kKinds)
        for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16}) {
            SCOPED_TRACE(testing::Message()
                         << "kind " << int(kind) << " bits16 " << (precision != HeightPrecision::bits32));
            Options options{.kind = kind, .precision = precision};
            const auto whole = test::value(open(options));  // in memory alone
            options.folder = scratch_.path("world" + std::to_string(int(kind)) + std::to_string(int(precision)));
            options.snapshot_edits = 40;  // several in the background
            // Edits and state after the flush, and after each later frame: a snapshot in the background may make those
            // durable, too, whole frames at a time, or may not come to it.
            std::vector<std::pair<std::uint64_t, StateHash>> states;
            {
                const auto terrain = test::value(open(options));
                for (std::uint64_t i = 0; i < 30; ++i) {
                    live(*whole, i);
                    live(*terrain, i);
                    if (HasFatalFailure()) return;
                }
                ASSERT_TRUE(terrain->flush());
                states.emplace_back(terrain->world()->edits, hash_of(*whole));
                EXPECT_EQ(hash_of(*terrain), states.front().second);
                for (std::uint64_t i = 30; i < 33; ++i) {
                    live(*terrain, i);
                    states.emplace_back(terrain->world()->edits, hash_of(*terrain));
                    EXPECT_NE(states.back().second, states[states.size() - 2].second);
                }
                EXPECT_EQ(terrain->take_errors().size(), 0u);
                terrain->abandon_world();
            }
            const auto again = test::value(open(options));
            EXPECT_EQ(again->take_errors().size(), 0u);
            const auto kept = std::find_if(states.begin(), states.end(),
                                           [&](const auto& state) { return state.first == again->world()->edits; });
            ASSERT_NE(kept, states.end()) << again->world()->edits << " edits, " << states.front().first << " flushed";
            EXPECT_EQ(hash_of(*again), kept->second);
            std::uint64_t next = 30;
            for (; next < 30 + static_cast<std::uint64_t>(kept - states.begin()); ++next) live(*whole, next);
            EXPECT_EQ(hash_of(*whole), kept->second);
            EXPECT_EQ(again->undoable(), whole->undoable());
            for (std::uint64_t i = next; i < 45; ++i) {  // and life goes on
                live(*whole, i);
                live(*again, i);
                if (HasFatalFailure()) return;
            }
            EXPECT_EQ(hash_of(*again), hash_of(*whole));
            ASSERT_TRUE(again->save());
            EXPECT_EQ(again->world()->committed, again->world()->edits);
            EXPECT_EQ(hash_of(*again), hash_of(*whole));
        }
}

TEST_F(WorldTest, UndoReachesBackOverTheClosingToUntouchedGround) {
    for (const Kind kind : kKinds) {
        Options options{.kind = kind, .folder = scratch_.path("undo" + std::to_string(int(kind)))};
        StateHash untouched;
        {
            const auto terrain = test::value(open(options));
            untouched = hash_of(*terrain);
            for (std::uint64_t i = 0; i < 9; ++i) live(*terrain, i);
            ASSERT_TRUE(terrain->save());
            for (std::uint64_t i = 9; i < 14; ++i) live(*terrain, i);
        }
        const auto terrain = test::value(open(options));
        EXPECT_NE(hash_of(*terrain), untouched);
        std::size_t strokes = 0;
        for (; terrain->undoable() > 0; ++strokes) {
            ASSERT_TRUE(terrain->undo());
            if (strokes % 3 == 0) {
                ASSERT_TRUE(terrain->update(0));
            }
        }
        EXPECT_GT(strokes, 20u);
        EXPECT_FALSE(terrain->undo());
        ASSERT_TRUE(terrain->update(0));
        EXPECT_EQ(hash_of(*terrain), untouched);
        while (terrain->redoable() > 0) {
            ASSERT_TRUE(terrain->redo());
        }
        ASSERT_TRUE(terrain->save());
    }
}

TEST_F(WorldTest, OneKindOpensWhatAnotherWrote) {
    Options options{.folder = scratch_.path("handed on")};
    const auto whole = test::value(open({}));
    std::uint64_t frame = 0;
    for (const Kind kind : {Kind::Gpu, Kind::Server, Kind::Cpu, Kind::Server, Kind::Gpu}) {
        options.kind = kind;
        const auto terrain = test::value(open(options));
        EXPECT_EQ(hash_of(*terrain), hash_of(*whole)) << "before frame " << frame;
        for (int i = 0; i < 7; ++i, ++frame) {
            live(*whole, frame);
            live(*terrain, frame);
        }
        if (frame % 2 == 0) {
            ASSERT_TRUE(terrain->save());
        }
    }
    EXPECT_EQ(hash_of(*test::value(open(options))), hash_of(*whole));
}

TEST_F(WorldTest, ASaveInTheBackgroundIsOfItsMoment) {
    for (const Kind kind : kKinds) {
        Options options{.kind = kind, .folder = scratch_.path("moment" + std::to_string(int(kind)))};
        const auto whole = test::value(open({}));
        std::map<std::uint64_t, StateHash> after;  // so many edits
        {
            const auto terrain = test::value(open(options));
            std::uint64_t frame = 0;
            const auto live_both = [&] {
                live(*whole, frame);
                live(*terrain, frame++);
                after[terrain->world()->edits] = hash_of(*whole);
            };
            for (int i = 0; i < 6; ++i) live_both();
            terrain->begin_save();
            EXPECT_TRUE(terrain->is_saving());
            while (terrain->is_saving() && frame < 3000) live_both();
            live_both();
            EXPECT_EQ(terrain->take_errors().size(), 0u);
            terrain->abandon_world();
        }
        for (const auto& file : std::filesystem::directory_iterator(options.folder))  // the pages alone
            if (file.path().extension() == ".tlj") std::filesystem::remove(file.path());
        const auto again = test::value(open(options));
        const std::uint64_t committed = again->world()->committed;
        ASSERT_TRUE(after.contains(committed)) << committed;
        EXPECT_LT(committed, after.rbegin()->first);
        EXPECT_EQ(hash_of(*again), after[committed]);
    }
}

TEST_F(WorldTest, ASecondOpeningIsRefusedUntilTheFirstIsClosed) {
    const Options options{.kind = Kind::Server, .folder = scratch_.path("locked")};
    auto first = test::value(open(options));
    const auto second = open(options);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::Locked);
    EXPECT_NE(second.error().message.find("locked"), std::string::npos) << second.error().message;
    first.reset();
    EXPECT_TRUE(open(options));
}

TEST_F(WorldTest, AnotherWorldsSettingsAreRefusedByName) {
    Options options{.kind = Kind::Server, .folder = scratch_.path("mine")};
    ASSERT_TRUE(open(options));
    options.precision = HeightPrecision::bits16;
    const auto other = open(options);
    ASSERT_FALSE(other);
    EXPECT_EQ(other.error().code, ErrorCode::InvalidArgument);
    EXPECT_NE(other.error().message.find("precision"), std::string::npos) << other.error().message;
}

TEST_F(WorldTest, AFolderThatCannotBeMadeIsAnError) {
    const auto missing = open({.kind = Kind::Server, .folder = scratch_.path("not there/world")});
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().message.find("not there"), std::string::npos) << missing.error().message;
    EXPECT_TRUE(open({.kind = Kind::Server, .folder = scratch_.path("Äcker und Wege")}));
}

TEST_F(WorldTest, ShapesOfTheHostsOwnComeBackWithTheWorld) {
    for (const Kind kind : {Kind::Cpu, Kind::Server}) {
        const Options options{.kind = kind, .folder = scratch_.path("shapes" + std::to_string(int(kind)))};
        const auto cone = [](double t) { return 1 - t; };
        StateHash before;
        {
            const auto terrain = test::value(open(options));
            ASSERT_TRUE(terrain->shapes().add_profile("never stamped", [](double) { return 0.5; }));
            const ShapeId mine = test::value(terrain->shapes().add_profile("mine", cone));
            for (const double radius_m : {0.5, 10.0})
                ASSERT_TRUE(
                    terrain->stamp({.shape = mine, .centre = {64, 64}, .radius_m = radius_m, .amplitude_m = -1}));
            ASSERT_TRUE(terrain->update(0));
            before = hash_of(*terrain);
        }
        const auto terrain = test::value(open(options));
        EXPECT_EQ(hash_of(*terrain), before);
        ASSERT_TRUE(terrain->shapes().find("mine").has_value());
        EXPECT_EQ(test::value(terrain->shapes().add_profile("mine", cone)), *terrain->shapes().find("mine"))
            << "adding it again, as every start of a program does, is no error";
        EXPECT_FALSE(terrain->shapes().add_profile("mine", [](double t) { return 1 - t * t; }));
    }
}

TEST_F(WorldTest, WithoutAWorldThereIsNothingToSave) {
    const auto terrain = test::value(open({.kind = Kind::Server}));
    EXPECT_FALSE(terrain->world().has_value());
    EXPECT_TRUE(terrain->save());
    EXPECT_TRUE(terrain->flush());
    EXPECT_FALSE(terrain->is_saving());
}

}  // namespace
}  // namespace tilth
