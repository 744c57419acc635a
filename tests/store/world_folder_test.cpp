// The world in its store: what is written, what waits, what is made again when it was damaged.
#include "tilth/store/world_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "store/edit_script.h"
#include "store/memory_blobs.h"
#include "support/fault_files.h"
#include "tilth/ground/before_image.h"
#include "tilth/ground/cpu_executor.h"
#include "tilth/store/log_store.h"
#include "tilth/store/world_blobs.h"
#include "tilth/store/world_identity.h"

namespace tilth {
namespace {

using test::EditScript;
using test::FaultFiles;
using test::joined;
using test::MemoryBlobs;
using test::ReferenceWorld;
using test::ScriptWorld;

constexpr FlushPolicy kManual{.when = FlushPolicy::When::Manual};

/// Another file system, but for reads of which `is_bad` says so: they fail (FileRead). Threads: one at a time.
class BadReads final : public FileSystem {
public:
    explicit BadReads(FileSystem& files) : files_(files) {}

    /// Of path, offset and size; called after the read was counted. Empty: all goes well.
    std::function<bool(const std::string&, std::uint64_t, std::size_t)> is_bad;
    std::uint64_t reads = 0;

    Result<std::unique_ptr<File>> open(const std::string& path, OpenMode mode) override {
        auto opened = files_.open(path, mode);
        if (!opened) return opened.error();
        return std::unique_ptr<File>(std::make_unique<BadFile>(*this, std::move(*opened)));
    }
    bool exists(const std::string& path) override { return files_.exists(path); }
    Result<void> make_folder(const std::string& path) override { return files_.make_folder(path); }
    Result<std::vector<std::string>> list(const std::string& folder) override { return files_.list(folder); }
    Result<void> rename(const std::string& from, const std::string& to) override { return files_.rename(from, to); }
    Result<void> remove(const std::string& path) override { return files_.remove(path); }
    Result<void> sync_folder(const std::string& folder) override { return files_.sync_folder(folder); }
    Result<std::unique_ptr<FileLock>> lock(const std::string& path) override { return files_.lock(path); }

private:
    class BadFile final : public File {
    public:
        BadFile(BadReads& disk, std::unique_ptr<File> file) : File(file->path()), disk_(disk), file_(std::move(file)) {}
        Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> out) override {
            ++disk_.reads;
            if (disk_.is_bad && disk_.is_bad(path(), offset, out.size()))
                return Error{ErrorCode::FileRead,
                             text(path(), ": at byte ", offset, ": Input/output error (the test says so)")};
            return file_->read(offset, out);
        }
        Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) override {
            return file_->write(offset, bytes);
        }
        Result<void> sync() override { return file_->sync(); }
        Result<void> truncate(std::uint64_t size) override { return file_->truncate(size); }
        Result<std::uint64_t> size() override { return file_->size(); }

    private:
        BadReads& disk_;
        std::unique_ptr<File> file_;
    };

    FileSystem& files_;
};

/// A script's world whose blobs are in memory, the rest on a disk in memory, and its reference.
class WorldInMemory : public testing::Test {
protected:
    std::unique_ptr<SavedGround> open() {
        auto opened = test::open_script_world(made_, "world", options());
        EXPECT_TRUE(opened) << opened.error().message;
        return opened ? std::move(*opened) : nullptr;
    }
    [[nodiscard]] WorldOptions options() {
        return {.flush = kManual, .keep_journal_bytes = keep_journal_bytes_, .files = &disk_, .blobs = blobs_};
    }
    /// Makes `edits` edits, saves, makes some more, and closes.
    void live(std::uint64_t edits, std::uint64_t more) {
        const auto world = open();
        EditScript script(11);
        ASSERT_TRUE(test::advance(*world, script, edits));
        ASSERT_TRUE(world->save());
        ASSERT_TRUE(test::advance(*world, script, edits + more));
        ASSERT_TRUE(world->flush());
        world->world().abandon();
        blobs_->crash();
    }
    [[nodiscard]] ReferenceWorld reference(std::uint64_t edits) const {
        ReferenceWorld reference(made_, 11);
        EXPECT_TRUE(reference.advance_to(edits));
        return reference;
    }
    [[nodiscard]] std::vector<BlobKey> keys(BlobKind kind) const { return *blobs_->keys(kind); }

    ScriptWorld made_;
    FaultFiles disk_;
    std::shared_ptr<MemoryBlobs> blobs_ = std::make_shared<MemoryBlobs>();
    std::uint64_t keep_journal_bytes_ = 64u << 20;
};

TEST_F(WorldInMemory, WritesOnlyPagesThatChanged) {
    const auto world = open();
    EditScript script(11);
    ASSERT_TRUE(test::advance(*world, script, 40));
    ASSERT_TRUE(world->save());
    const std::uint64_t before = blobs_->puts;
    ASSERT_TRUE(world->save());
    EXPECT_EQ(blobs_->puts, before + 1) << "the counters alone";
    const auto page = world->stamp({.centre = {60.3, 60.3}, .radius_m = 0.1, .amplitude_m = 0.01});
    ASSERT_TRUE(page);
    ASSERT_TRUE(world->save());
    EXPECT_EQ(blobs_->puts, before + 4) << "one page, one stroke, the counters";
}

TEST_F(WorldInMemory, HasNoBlobsOfWhatIsUntouchedOrForgotten) {
    live(40, 0);
    EXPECT_FALSE(keys(BlobKind::CoarsePage).empty());
    EXPECT_FALSE(keys(BlobKind::DetailPage).empty());
    const auto world = open();
    EXPECT_EQ(keys(BlobKind::Stroke).size(), world->history().undoable() + world->history().redoable());
    while (world->history().undoable() > 0) ASSERT_TRUE(world->undo());
    ASSERT_TRUE(world->stamp({.centre = {60, 60}, .radius_m = 0.5, .amplitude_m = 0.1}));
    ASSERT_TRUE(world->undo());
    ASSERT_TRUE(world->save());
    EXPECT_TRUE(keys(BlobKind::CoarsePage).empty());
    EXPECT_TRUE(keys(BlobKind::DetailPage).empty());
    EXPECT_EQ(keys(BlobKind::Stroke).size(), 1u);
}

// ---------------------------------------------------------------------------------------------------- damage

/// Spoils every blob in turn; the world must be what it was, and say what happened.
TEST_F(WorldInMemory, RebuildsEveryBlobFromTheJournal) {
    live(45, 20);  // the tail undoes strokes of the pages: edits 57 to 59
    const StateHash right = reference(65).hash();
    std::vector<BlobKey> all;
    for (const BlobKind kind : {BlobKind::World, BlobKind::DetailPage, BlobKind::CoarsePage, BlobKind::Stroke})
        for (const BlobKey& key : keys(kind)) all.push_back(key);
    ASSERT_GT(all.size(), 20u);
    for (const BlobKey& key : all) {
        SCOPED_TRACE(testing::Message() << "kind " << int(key.kind) << " (" << key.x << ", " << key.z << ")");
        blobs_->damaged = {key};
        {
            const auto world = open();
            ASSERT_NE(world, nullptr);
            EXPECT_EQ(world->ground().hash(), right);
            EXPECT_NE(joined(world->reports()).find("memory: offset"), std::string::npos) << joined(world->reports());
            EXPECT_EQ(joined(world->reports()).find("lost"), std::string::npos) << joined(world->reports());
            // The counters are written with every commit.
            EXPECT_EQ(blobs_->damaged.contains(key), key == kCountersKey) << "put back?";
            world->world().abandon();
        }
        blobs_->crash();
    }
}

TEST_F(WorldInMemory, UndoesStrokesThatWereMadeAgain) {
    live(45, 0);
    ReferenceWorld right = reference(45);
    for (const BlobKey& key : keys(BlobKind::Stroke)) blobs_->damaged.insert(key);
    const auto world = open();
    ASSERT_NE(world, nullptr);
    ASSERT_EQ(world->history().undoable(), right.history().undoable());
    while (world->history().undoable() > 0) {
        ASSERT_TRUE(world->undo());
        ASSERT_TRUE(right.undo());
        ASSERT_EQ(world->ground().hash(), right.hash()) << world->history().undoable() << " left";
    }
    while (right.history().redoable() > 0) {
        ASSERT_TRUE(world->redo());
        ASSERT_TRUE(right.redo());
    }
    EXPECT_EQ(world->ground().hash(), right.hash());
}

TEST_F(WorldInMemory, GoesOnCountingWhenItsCountersAreLost) {
    live(46, 0);
    blobs_->damaged.insert(kCountersKey);
    const auto world = open();
    ASSERT_NE(world, nullptr);
    EXPECT_GE(world->history().undoable(), 10u);
    ReferenceWorld right = reference(46);
    for (int i = 0; i < 10; ++i) {
        ASSERT_TRUE(world->undo());
        ASSERT_TRUE(right.undo());
    }
    EXPECT_EQ(world->ground().hash(), right.hash());
    const auto issued = world->stamp({.centre = {60, 60}, .radius_m = 0.5, .amplitude_m = 0.1});
    const auto expected = right.stamp({.centre = {60, 60}, .radius_m = 0.5, .amplitude_m = 0.1});
    ASSERT_TRUE(issued);
    EXPECT_EQ(*issued, *expected);
    ASSERT_TRUE(world->save());
    EXPECT_EQ(joined(world->world().verify()), "");
}

TEST_F(WorldInMemory, GoesOnCountingWithoutAHistory) {
    made_.undo_bytes = 0;
    std::uint64_t last = 0;
    {
        const auto world = open();
        for (int i = 0; i < 30; ++i) {
            const auto stamped = world->stamp({.centre = {60, 60.0 + i}, .radius_m = 0.5, .amplitude_m = 0.1});
            ASSERT_TRUE(stamped);
            last = stamped->sequence;
        }
        ASSERT_TRUE(world->save());
    }
    EXPECT_TRUE(keys(BlobKind::Stroke).empty());
    blobs_->damaged.insert(kCountersKey);
    const auto issued = open()->stamp({.centre = {60, 60}, .radius_m = 0.5, .amplitude_m = 0.1});
    ASSERT_TRUE(issued);
    EXPECT_EQ(issued->sequence, last + 1);
}

TEST_F(WorldInMemory, TellsWhatIsLostWhereTheJournalIsGone) {
    keep_journal_bytes_ = 0;
    live(45, 20);
    const StateHash right = reference(65).hash();
    for (const BlobKind kind : {BlobKind::World, BlobKind::DetailPage, BlobKind::CoarsePage, BlobKind::Stroke})
        for (const BlobKey& key : keys(kind)) {
            SCOPED_TRACE(testing::Message() << "kind " << int(kind) << " (" << key.x << ", " << key.z << ")");
            blobs_->damaged = {key};
            {
                const auto world = open();
                ASSERT_NE(world, nullptr);
                const std::string told = joined(world->reports());
                EXPECT_NE(told.find("memory: offset"), std::string::npos) << told;
                EXPECT_NE(told.find("journal begins at edit"), std::string::npos) << told;
                if (world->ground().hash() != right) {
                    EXPECT_TRUE(told.find("lost") != std::string::npos || told.find("undone") != std::string::npos)
                        << told;
                }
                if (kind == BlobKind::DetailPage || kind == BlobKind::CoarsePage) {
                    EXPECT_EQ(world->history().undoable(), reference(65).history().undoable());
                }
                world->world().abandon();
            }
            blobs_->crash();
            blobs_->damaged.clear();
        }
}

// ---------------------------------------------------------------------------------------------------- tiles that wait

/// Commits as a cache does: of the tiles at x = 1 the stamps since edit `applied` wait.
class WaitingWorld : public WorldInMemory {
protected:
    void SetUp() override {
        auto ground = made_.ground();
        RecoveredWorld recovered;
        auto opened = WorldFolder::open("world", *ground, options(), recovered);
        ASSERT_TRUE(opened) << opened.error().message;
        WorldFolder& world = **opened;
        // Apart, so that the strokes of the world have no images of tiles for which they wait.
        UndoHistory history(64u << 20), right_history(64u << 20);
        const TileGrid tiles{.size = 128, .map = ground->map(MapKind::Detail).grid.rect()};
        SplitMix64 random{3};
        Snapshot snapshot;
        std::map<TileIndex, std::vector<WaitingStamp>> waiting;
        for (int i = 0; i < 60; ++i) {
            StampRequest request = EditScript(5).request(16 + static_cast<std::uint64_t>(i), *ground);
            request.map = MapChoice::Detail;
            request.shape = {static_cast<std::uint32_t>(i % 6)};
            request.radius_m = random.between(0.5, 6);
            if (request.rule == StampRule::Smooth || i % 3 == 0) request.rule = StampRule::Add;
            request.amplitude_m = random.between(-0.4, 0.4);
            const auto record = ground->issue(request);
            ASSERT_TRUE(record) << record.error().message;
            world.append({.record = *record});
            GroundEdit edit = history.add(*record, true);
            const PreparedStamp stamp = prepare(*record, ground->map(MapKind::Detail), ground->shapes());
            hashes_.push_back(ground->hash());
            apply_edit(*ground, right_history.add(*record, true));  // what the world must be
            for_each_tile(tiles_of(tiles, stamp.rect()), [&](TileIndex tile) {
                if (tile.x == 1 && i >= 30) {
                    waiting[tile].push_back({*record, edit.stroke->number, 0});
                } else {
                    keep_images(edit, stamp, tiles.inside(tile), stored_, ground->map(MapKind::Detail),
                                ground->shapes());
                    apply_stamp(stamp, stored_, tiles.inside(tile));
                }
            });
        }
        ASSERT_GE(waiting.size(), 3u);
        snapshot.edits = world.appended();
        snapshot.next_sequence = 61;
        for_each_tile(tiles_of(tiles, tiles.map), [&](TileIndex tile) {
            snapshot.tiles.push_back({.tile = tile,
                                      .has_codes = true,
                                      .pages = stored_.pages_in(pages_of(tiles.interior(tile))),
                                      .waiting = waiting[tile]});
        });
        for (const StrokePtr& stroke : history.done()) {
            snapshot.history.done.push_back(stroke->number);
            snapshot.history.changed.push_back({.number = stroke->number,
                                                .records = stroke->records,
                                                .coarse = stroke->coarse,
                                                .detail = stroke->detail,
                                                .version = stroke->version});
        }
        snapshot.history.next_number = history.next_number();
        const auto committed = world.commit(snapshot);
        ASSERT_TRUE(committed) << committed.error().message;
        right_ = ground->hash();
        expect_repairs_as_committed(world, tiles);
    }
    /// Pages that are damaged while the world is open are made again as the commit left them.
    void expect_repairs_as_committed(WorldFolder& world, const TileGrid& tiles) {
        for (const BlobKey& key : keys(BlobKind::DetailPage)) blobs_->damaged.insert(key);
        for_each_tile(tiles_of(tiles, tiles.map), [&](TileIndex tile) {
            const auto pages = world.load(tile, pages_of(tiles.interior(tile)));
            ASSERT_TRUE(pages) << pages.error().message;
            for (const Page& page : *pages) {
                const PageCodes* const right = stored_.find(page.index);
                ASSERT_NE(right, nullptr);
                EXPECT_EQ(*page.codes, *right) << page.index.x << ", " << page.index.z;
            }
        });
        EXPECT_TRUE(blobs_->damaged.empty());
        EXPECT_FALSE(world.take_errors().empty());
    }
    /// Images of waiting tiles come in when their stamps are applied, so that undo takes back everything.
    void expect_right_and_undone(SavedGround& world) {
        EXPECT_EQ(world.ground().hash(), right_);
        EXPECT_EQ(world.history().undoable(), 60u);
        while (world.history().undoable() > 0) ASSERT_TRUE(world.undo());
        EXPECT_EQ(world.ground().hash(), made_.ground()->hash());
    }

    /// As many strokes as there are, each of which takes back what it did.
    void expect_undone_one_by_one(SavedGround& world) {
        ASSERT_GE(world.history().undoable(), 16u);
        for (std::size_t left = 60; world.history().undoable() > 0;) {
            ASSERT_TRUE(world.undo());
            ASSERT_EQ(world.ground().hash(), hashes_[--left]) << left << " left";
        }
    }

    DetailField stored_;
    StateHash right_;
    std::vector<StateHash> hashes_;  ///< before each stroke
};

TEST_F(WaitingWorld, AppliesWhatWaited) {
    const auto world = open();
    ASSERT_NE(world, nullptr);
    EXPECT_EQ(joined(world->reports()), "");
    expect_right_and_undone(*world);
}

TEST_F(WaitingWorld, WaitsNoMoreOnceItIsSaved) {
    {
        const auto world = open();
        ASSERT_TRUE(world->save());
    }
    EXPECT_TRUE(keys(BlobKind::Waiting).empty());
    expect_right_and_undone(*open());
}

TEST_F(WaitingWorld, RebuildsPagesWithoutWhatWaits) {
    for (const BlobKey& key : keys(BlobKind::DetailPage)) blobs_->damaged.insert(key);
    const auto world = open();
    ASSERT_NE(world, nullptr);
    expect_right_and_undone(*world);
    world->world().abandon();
}

TEST_F(WaitingWorld, RebuildsTilesWhoseListsAreDamaged) {
    for (const BlobKey& key : keys(BlobKind::Waiting)) {
        blobs_->damaged = {key};
        {
            const auto world = open();
            ASSERT_NE(world, nullptr);
            EXPECT_NE(joined(world->reports()).find("memory: offset"), std::string::npos);
            EXPECT_EQ(world->ground().hash(), right_);
            expect_undone_one_by_one(*world);
            EXPECT_EQ(world->ground().hash(), made_.ground()->hash());
            world->world().abandon();
        }
        blobs_->crash();
    }
    ASSERT_GE(keys(BlobKind::Waiting).size(), 3u);
}

TEST_F(WaitingWorld, MakesStrokesAgainThatWaitInPart) {
    for (const BlobKey& key : keys(BlobKind::Stroke)) blobs_->damaged.insert(key);
    const auto world = open();
    ASSERT_NE(world, nullptr);
    expect_right_and_undone(*world);
    world->world().abandon();
}

TEST_F(WaitingWorld, SurvivesTheLossOfItsCounters) {
    blobs_->damaged.insert(kCountersKey);
    const auto world = open();
    ASSERT_NE(world, nullptr);
    EXPECT_EQ(world->ground().hash(), right_);
    expect_undone_one_by_one(*world);
}

// ---------------------------------------------------------------------------------------------------- bad reads

/// A journal, shape or store that cannot be read at this moment is no reason to give anything up.
TEST_F(WaitingWorld, GivesNothingUpForWhatCannotBeReadAtTheMoment) {
    BadReads bad(disk_);
    const auto open_with_bad_reads = [&] {
        WorldOptions with = options();
        with.files = &bad;
        return test::open_script_world(made_, "world", with);
    };
    for (const BlobKind kind : {BlobKind::World, BlobKind::Waiting, BlobKind::DetailPage, BlobKind::Stroke}) {
        for (std::uint64_t k = 1;; ++k) {
            SCOPED_TRACE(testing::Message()
                         << "kind " << int(kind) << ", nothing can be read from read " << k << " on");
            blobs_->damaged = {keys(kind).front()};
            bad.reads = 0;
            bad.is_bad = [&](const std::string&, std::uint64_t, std::size_t) { return bad.reads >= k; };
            const auto world = open_with_bad_reads();
            const bool was_reached = bad.reads >= k;
            bad.is_bad = nullptr;
            if (!world) {
                EXPECT_EQ(world.error().code, ErrorCode::FileRead) << world.error().message;
            } else {
                EXPECT_EQ(joined((*world)->reports()).find("lost"), std::string::npos) << joined((*world)->reports());
                EXPECT_EQ((*world)->ground().hash(), right_);
                (*world)->world().abandon();
            }
            blobs_->crash();
            if (!was_reached) break;
            ASSERT_LT(k, 100u);
            if (HasFailure()) return;
        }
    }
}

TEST_F(WorldInMemory, LoadsATileLaterWhoseRepairCannotBeReadNow) {
    live(45, 0);
    const auto world = open();
    ASSERT_NE(world, nullptr);
    const BlobKey key = keys(BlobKind::DetailPage).front();
    const PageIndex page{key.x, key.z};
    const TileIndex tile{floor_divide(page.x, 2), floor_divide(page.z, 2)};  // of 128 texels
    const PageRect rect{page, {page.x + 1, page.z + 1}};
    for (const std::string& path : disk_.paths()) {
        if (!path.ends_with(".tlj") && !path.ends_with(".tls")) continue;
        SCOPED_TRACE(path);
        blobs_->damaged = {key};
        disk_.fail_reads(path);
        const auto failed = world->world().load(tile, rect);
        ASSERT_FALSE(failed);
        EXPECT_EQ(failed.error().code, ErrorCode::FileRead) << failed.error().message;
        EXPECT_EQ(joined(world->world().take_errors()), "");
        EXPECT_TRUE(blobs_->has(key));
        disk_.fail_reads("");
        const auto loaded = world->world().load(tile, rect);
        ASSERT_TRUE(loaded) << loaded.error().message;
        ASSERT_EQ(loaded->size(), 1u);
        EXPECT_EQ(*loaded->front().codes, *world->ground().detail().find(page));
        (void)world->world().take_errors();
        ASSERT_TRUE(world->world().commit({.edits = 45}));  // forgets what it read
    }
}

/// Sectors that can never be read again cost nothing either: what lay there is made again, and written elsewhere.
TEST(WorldFolder, RebuildsWhatLiesInUnreadableSectors) {
    FaultFiles disk;
    const ScriptWorld made;
    const std::string path = "world/pages-1.tlp";
    ReferenceWorld reference(made, 11);
    {
        auto world = test::open_script_world(made, "world", {.flush = kManual, .files = &disk});
        ASSERT_TRUE(world);
        EditScript script(11);
        ASSERT_TRUE(test::advance(**world, script, 45));
        ASSERT_TRUE((*world)->save());
    }
    ASSERT_TRUE(reference.advance_to(45));
    // Where each blob lies is what getting it reads last.
    std::vector<std::pair<std::uint64_t, std::uint64_t>> places;
    {
        BadReads files(disk);
        const auto identity = read_identity(files, "world");
        ASSERT_TRUE(identity);
        LogStoreReport report;
        const auto store = LogStore::open(files, "world", identity->salt, {}, report);
        ASSERT_TRUE(store);
        std::pair<std::uint64_t, std::uint64_t> last;
        files.is_bad = [&](const std::string&, std::uint64_t offset, std::size_t size) {
            last = {offset, offset + size};
            return false;
        };
        for (const BlobKind kind : {BlobKind::World, BlobKind::DetailPage, BlobKind::CoarsePage, BlobKind::Stroke}) {
            const auto keys = (*store)->keys(kind);
            ASSERT_TRUE(keys);
            for (const BlobKey& key : *keys) {
                ASSERT_TRUE((*store)->get(key));
                places.push_back(last);
            }
        }
    }
    ASSERT_GT(places.size(), 20u);
    for (const auto& [begin, end] : places) {
        SCOPED_TRACE(testing::Message() << "bytes " << begin << " to " << end);
        const std::unique_ptr<FaultFiles> copy = disk.crash(1);  // everything is durable: a copy
        BadReads files(*copy);
        const std::uint64_t first = begin, behind = end;
        const auto is_bad = [&](const std::string& of, std::uint64_t offset, std::size_t size) {
            return of == path && offset < behind && first < offset + size;
        };
        const WorldOptions options{.flush = kManual, .files = &files};
        for (const bool is_bad_at_opening : {true, false}) {
            if (is_bad_at_opening) files.is_bad = is_bad;
            auto world = test::open_script_world(made, "world", options);
            ASSERT_TRUE(world) << world.error().message;
            files.is_bad = is_bad;
            EXPECT_EQ((*world)->ground().hash(), reference.hash());
            const auto tiles = (*world)->world().tiles();
            ASSERT_TRUE(tiles);
            for (const TileIndex tile : *tiles) {
                const PageIndex corner{2 * tile.x, 2 * tile.z};
                const auto loaded = (*world)->world().load(tile, {corner, {corner.x + 2, corner.z + 2}});
                ASSERT_TRUE(loaded) << loaded.error().message;
                for (const Page& page : *loaded) EXPECT_EQ(*page.codes, *(*world)->ground().detail().find(page.index));
            }
            const std::string told = joined((*world)->reports()) + joined((*world)->world().take_errors());
            EXPECT_EQ(told.find("lost"), std::string::npos) << told;
            if (is_bad_at_opening) {
                EXPECT_NE(told.find("the test says so"), std::string::npos) << told;
                ASSERT_TRUE((*world)->save());
            } else {
                EXPECT_EQ(told, "") << "it lies elsewhere now";
            }
        }
        if (HasFailure()) return;
    }
}

// ---------------------------------------------------------------------------------------------------- as a tile store

TEST_F(WorldInMemory, IsTornUntilATileIsSavedWhole) {
    const auto world = open();
    ASSERT_TRUE(world->stamp({.centre = {20, 20}, .radius_m = 15, .amplitude_m = 0.5, .map = MapChoice::Detail}));
    const TileIndex tile{0, 0};
    const std::vector<Page> pages = world->ground().detail().pages_in({{0, 0}, {2, 2}});
    ASSERT_EQ(pages.size(), 4u);
    blobs_->fail_at_put = blobs_->puts + 3;
    const auto failed = world->world().save(tile, pages);
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, ErrorCode::FileWrite);
    EXPECT_FALSE(world->world().load(tile, {{0, 0}, {2, 2}}));
    EXPECT_FALSE(world->world().commit({.edits = 1})) << "what is half of it must not become durable";
    ASSERT_TRUE(world->world().save(tile, pages));
    EXPECT_TRUE(world->world().commit({.edits = 1}));
    const auto loaded = world->world().load(tile, {{0, 0}, {2, 2}});
    ASSERT_TRUE(loaded);
    ASSERT_EQ(loaded->size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(*(*loaded)[i].codes, *pages[i].codes);
}

TEST_F(WorldInMemory, WritesAgainWhatAFailedCommitMayNotHaveWritten) {
    const auto world = open();
    EditScript script(11);
    ASSERT_TRUE(test::advance(*world, script, 30));
    for (std::uint64_t k = 1;; ++k) {
        blobs_->fail_at_put = blobs_->puts + k;
        if (world->save()) break;
        ASSERT_LT(k, 1000u);
    }
    world->world().abandon();
    blobs_->crash();
    const auto again = open();
    EXPECT_EQ(again->ground().hash(), reference(30).hash());
    EXPECT_EQ(again->world().committed(), 30u);
    EXPECT_EQ(joined(again->world().verify()), "");
}

/// A sync that fails may have lost what was written before it. The next snapshot must not take it for written.
TEST(WorldFolder, WritesPagesAgainThatAFailedSyncLost) {
    FaultFiles disk;
    const ScriptWorld made;
    bool was_lost = false;
    for (std::uint64_t k = 1; !was_lost; ++k) {
        ASSERT_LT(k, 100u) << "no sync of the pages has failed";
        const std::string folder = text("world", k), pages = folder + "/pages-1.tlp";
        auto world = test::open_script_world(made, folder, {.flush = kManual, .files = &disk});
        ASSERT_TRUE(world);
        EditScript script(11);
        ASSERT_TRUE(test::advance(**world, script, 20));
        ASSERT_TRUE((*world)->save());
        ASSERT_TRUE(test::advance(**world, script, 30));
        ASSERT_TRUE((*world)->flush());
        const std::size_t synced_bytes = disk.bytes(pages).size();
        const std::uint64_t syncs = disk.counts().syncs;
        disk.fail_at(k, test::Fault::Once);
        ASSERT_FALSE((*world)->save()) << k;
        if (disk.counts().syncs == syncs) continue;  // a write failed
        std::vector<std::byte> left = disk.bytes(pages);
        ASSERT_GT(left.size(), synced_bytes + 1000);
        std::fill(left.begin() + static_cast<std::ptrdiff_t>(synced_bytes), left.end(), std::byte{0});
        disk.set_bytes(pages, std::move(left));
        was_lost = true;
        const auto saved = (*world)->save();
        ASSERT_TRUE(saved) << saved.error().message;
        EXPECT_EQ(joined((*world)->world().verify()), "");
        world = Error{};
        world = test::open_script_world(made, folder, {.flush = kManual, .files = &disk});
        ASSERT_TRUE(world);
        ReferenceWorld reference(made, 11);
        ASSERT_TRUE(reference.advance_to(30));
        EXPECT_EQ(joined((*world)->reports()), "");
        EXPECT_EQ((*world)->ground().hash(), reference.hash());
        EXPECT_EQ((*world)->world().committed(), 30u);
    }
}

TEST_F(WorldInMemory, ReportsEveryDamagedBlobWhenItIsVerified) {
    live(45, 5);
    const auto world = open();
    EXPECT_EQ(joined(world->world().verify()), "");
    for (const BlobKind kind : {BlobKind::World, BlobKind::DetailPage, BlobKind::CoarsePage, BlobKind::Stroke})
        for (const BlobKey& key : keys(kind)) {
            blobs_->damaged = {key};
            const std::vector<Error> found = world->world().verify();
            ASSERT_EQ(found.size(), 1u) << int(kind) << " " << key.x << " " << key.z << "\n" << joined(found);
            EXPECT_NE(found[0].message.find("memory: offset"), std::string::npos);
            EXPECT_TRUE(blobs_->damaged.contains(key)) << "nothing is changed";
        }
}

// ---------------------------------------------------------------------------------------------------- space

TEST(WorldFolder, GivesOldJournalUpBeforeItComplains) {
    FaultFiles disk;
    ScriptWorld made;
    made.undo_bytes = 0;
    const auto grown = [&](std::uint64_t bound, std::vector<Error>& errors) {
        auto world = test::open_script_world(made, text("world", bound),
                                             {.flush = kManual, .most_disk_bytes = bound, .files = &disk});
        EXPECT_TRUE(world);
        for (int round = 0; round < 8; ++round) {
            for (int i = 0; i < 100; ++i)
                EXPECT_TRUE((*world)->stamp({.centre = {60.0 + i % 7, 60}, .radius_m = 1, .amplitude_m = 0.01}));
            EXPECT_TRUE((*world)->save());
            for (Error& error : (*world)->world().take_errors()) errors.push_back(std::move(error));
        }
        return (*world)->world().size();
    };
    std::vector<Error> errors;
    const WorldFolder::Size free = grown(0, errors);
    EXPECT_GE(free.journal_bytes, 800u * 64);
    EXPECT_EQ(joined(errors), "");
    const std::uint64_t bound = free.live_page_bytes * 2 + 40'000;
    const WorldFolder::Size kept = grown(bound, errors);
    EXPECT_LE(kept.journal_bytes + kept.page_bytes, bound);
    EXPECT_EQ(joined(errors), "");
    (void)grown(100, errors);
    ASSERT_EQ(errors.size(), 1u) << "told once, while it lasts: " << joined(errors);
    EXPECT_NE(errors[0].message.find("most_disk_bytes is 100"), std::string::npos) << errors[0].message;
}

/// The half-made copy goes away by itself; journal that was given up for it would be missed.
TEST(WorldFolder, KeepsItsJournalWhileItIsCompacted) {
    FaultFiles disk;
    const ScriptWorld made;
    std::uint64_t copied = 0;
    std::vector<Error> errors;
    const auto compacted_in_part = [&](std::uint64_t bound) {
        auto world =
            test::open_script_world(made, text("world", bound),
                                    {.flush = kManual, .most_disk_bytes = bound, .files = &disk, .log = {0.1, 4096}});
        EXPECT_TRUE(world);
        EditScript script(11);
        for (std::uint64_t edits = 60; edits <= 240; edits += 60) {
            EXPECT_TRUE(test::advance(**world, script, edits));
            EXPECT_TRUE((*world)->save());
        }
        const std::uint64_t before = (*world)->world().size().page_bytes;
        const auto more = (*world)->world().compact(6'000);
        EXPECT_TRUE(more && *more) << "it has begun, and is not at its end";
        copied = (*world)->world().size().page_bytes - before;
        EXPECT_TRUE((*world)->stamp({.centre = {60, 60}, .radius_m = 0.2, .amplitude_m = 0.01}));
        EXPECT_TRUE((*world)->save());
        errors = (*world)->world().take_errors();
        EXPECT_EQ((*world)->world().first_edit(), 1u);
        return (*world)->world().size();
    };
    const WorldFolder::Size free = compacted_in_part(0);
    ASSERT_GE(copied, 6'000u);
    const WorldFolder::Size kept = compacted_in_part(free.journal_bytes + free.page_bytes - copied);
    EXPECT_EQ(kept.journal_bytes, free.journal_bytes);
    EXPECT_EQ(kept.page_bytes, free.page_bytes);
    EXPECT_EQ(joined(errors), "");
}

}  // namespace
}  // namespace tilth
