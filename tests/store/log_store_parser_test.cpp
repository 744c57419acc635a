// Files that rotted, were cut short or forged: what comes back is what was put, or an error that says where.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>

#include "store/log_store_support.h"
#include "tilth/core/hash.h"
#include "tilth/store/log_format.h"

namespace tilth::test {
namespace {

using namespace log_format;

const std::string kFile = std::string(kFolder) + "/pages-1.tlp";

/// A file of a few dozen commits, and what each of them held.
struct Sample {
    Bytes file;
    std::vector<Committed> commits;
    std::vector<std::uint64_t> ends;  ///< of the commits in the file
};

const Sample& sample() {
    static const Sample made = [] {
        Sample result;
        FaultFiles disk;
        EXPECT_TRUE(disk.make_folder(kFolder).ok());
        LogStoreReport report;
        auto store = open_store(disk, report, {.most_waste = 1});
        SplitMix64 random{77};
        Committed now;
        for (std::uint64_t mark = 10; mark < 40; ++mark) {
            for (std::uint64_t i = random.next() % 6; i > 0; --i) {
                const BlobKey key = random_key(random, 40);
                now.blobs[key] = random_bytes(random, random.next() % 2500);
                now.marks[key] = mark;
                EXPECT_TRUE((*store)->put(key, now.blobs[key]).ok());
            }
            if (const BlobKey key = random_key(random, 40); random.next() % 2 == 0) {
                now.blobs.erase(key), now.marks.erase(key);
                EXPECT_TRUE((*store)->erase(key).ok());
            }
            now.mark = mark;
            EXPECT_TRUE((*store)->commit(mark).ok());
            result.commits.push_back(now);
            result.ends.push_back((*store)->size().disk_bytes);
        }
        result.file = disk.bytes(kFile);
        return result;
    }();
    return made;
}

struct Opened {
    FaultFiles disk;
    LogStoreReport report;
    Result<std::unique_ptr<LogStore>> store = Error{};

    explicit Opened(const Bytes& file, const std::string& name = kFile, std::uint64_t salt = kSalt) {
        EXPECT_TRUE(disk.make_folder(kFolder).ok());
        EXPECT_TRUE(disk.sync_folder("").ok());
        disk.set_bytes(name, file);
        store = LogStore::open(disk, kFolder, salt, {}, report);
    }
    /// Nothing that was read, and so nothing that was allocated for it, is larger than the file or a window of the
    /// scan.
    void expect_small_reads(std::size_t file_bytes) const {
        EXPECT_LE(disk.counts().most_read_bytes, std::max<std::size_t>(file_bytes, 64u << 10));
    }
};

/// Every blob of `expected` is got, or its error names file and offset; there is no other. Returns the number of
/// errors.
int expect_blobs(LogStore& store, const Committed& expected, const std::string& file = kFile) {
    int errors = 0;
    std::size_t listed = 0;
    for (int kind = 1; kind <= 5; ++kind) listed += (*store.keys(static_cast<BlobKind>(kind))).size();
    EXPECT_EQ(listed, expected.blobs.size());
    EXPECT_EQ(store.mark(), expected.mark);
    for (const auto& [key, bytes] : expected.blobs) {
        const Result<std::optional<Bytes>> blob = store.get(key);
        if (!blob) {
            ++errors;
            EXPECT_EQ(blob.error().code, ErrorCode::FileFormat);
            EXPECT_NE(blob.error().message.find(file + ": at byte "), std::string::npos) << blob.error().message;
            continue;
        }
        EXPECT_TRUE((*blob).has_value());
        if ((*blob).has_value()) {
            EXPECT_TRUE(**blob == bytes);
        }
        // Known only where an index says so, and then right.
        const std::optional<std::uint64_t> mark = store.mark_of(key);
        EXPECT_TRUE(!mark || *mark == expected.marks.at(key));
    }
    return errors;
}

/// It can be worked on, and is in order then, but for the blobs that are damaged.
void expect_works_on(Opened& opened, const Committed& expected, int errors, const std::string& file = kFile) {
    ASSERT_TRUE((*opened.store)->put({BlobKind::World, 1000, 0}, Bytes(100)).ok());
    ASSERT_TRUE((*opened.store)->commit(1000).ok());
    opened.store = Error{};
    opened.store = LogStore::open(opened.disk, kFolder, kSalt, {}, opened.report);
    ASSERT_TRUE(opened.store.ok());
    Committed next = expected;
    next.mark = 1000;
    next.blobs[{BlobKind::World, 1000, 0}] = Bytes(100);
    next.marks[{BlobKind::World, 1000, 0}] = 1000;
    EXPECT_FALSE(opened.report.was_scanned);
    EXPECT_EQ(expect_blobs(**opened.store, next, file), errors);
}

TEST(LogStoreParser, TheSampleIsInOrder) {
    Opened opened(sample().file);
    ASSERT_TRUE(opened.store.ok());
    EXPECT_TRUE(opened.report.damage.empty());
    EXPECT_EQ(expect_blobs(**opened.store, sample().commits.back()), 0);
    for (const auto& [key, mark] : sample().commits.back().marks)
        EXPECT_EQ((*opened.store)->mark_of(key), std::optional(mark));
}

// One flipped bit anywhere costs at most the blob it is in, and that is said; no commit is lost to it.
TEST(LogStoreParser, OneFlippedBitCostsAtMostOneBlob) {
    const Sample& good = sample();
    SplitMix64 random{1};
    int with_errors = 0, worked_on = 0;
    const auto generation = [&](unsigned slot) {
        return decode_superblock(std::span(good.file).subspan(superblock_offset(slot)), {kSalt, 1}, slot)->generation;
    };
    const std::uint64_t older = superblock_offset(generation(0) < generation(1) ? 0 : 1);
    for (int i = 0; i < 7000; ++i) {
        // Half of them where it hurts: in header, superblocks and the last indexes.
        std::uint64_t bit = random.next() % (good.file.size() * 8);
        if (i % 8 == 1) bit = random.next() % (kHeaderBytes * 8);
        if (i % 8 == 3) bit = superblock_offset(i % 16 == 3 ? 0 : 1) * 8 + random.next() % (kSuperblockBytes * 8);
        if (i % 8 >= 5) bit = (good.file.size() - 1 - random.next() % 4000) * 8 + random.next() % 8;
        Bytes file = good.file;
        file[bit / 8] ^= std::byte{static_cast<unsigned char>(1u << (bit % 8))};
        Opened opened(file);
        ASSERT_TRUE(opened.store.ok()) << "bit " << bit << ": " << opened.store.error().message;
        const int errors = expect_blobs(**opened.store, good.commits.back());
        EXPECT_LE(errors, 1);
        EXPECT_FALSE(opened.report.may_miss_blobs);
        EXPECT_EQ(opened.report.truncated_bytes, 0u);
        // The newer superblock is replaced by the commit's index without a word: so it is after a crash.
        const bool is_reported = opened.report.was_scanned || bit / 8 < kHeaderBytes ||
                                 (bit / 8 >= older && bit / 8 < older + kSuperblockBytes);
        EXPECT_EQ(opened.report.damage.empty(), !is_reported) << "bit " << bit;
        opened.expect_small_reads(file.size());
        if (opened.report.was_scanned || i % 20 == 0) expect_works_on(opened, good.commits.back(), errors), ++worked_on;
        ASSERT_FALSE(testing::Test::HasFailure()) << "bit " << bit << " of byte " << bit / 8;
        with_errors += errors;
    }
    EXPECT_GT(with_errors, 500);
    EXPECT_GT(worked_on, 500);
}

/// A file of few commits, and the last of them.
struct Small {
    std::string name;
    Bytes file;
    Committed last;
};

enum class History { OneCommit, TwoCommits, Compacted };

Small small_file(History history) {
    FaultFiles disk;
    EXPECT_TRUE(disk.make_folder(kFolder).ok());
    LogStoreReport report;
    auto store = open_store(disk, report, {.most_waste = 0, .least_waste_bytes = 0});
    SplitMix64 random{55};
    Small made;
    const auto put = [&](std::int32_t x, std::uint64_t mark) {
        const BlobKey key{BlobKind::DetailPage, x, 0};
        made.last.blobs[key] = random_bytes(random, 20 + random.next() % 300);
        made.last.marks[key] = mark;
        EXPECT_TRUE((*store)->put(key, made.last.blobs[key]).ok());
    };
    for (std::int32_t x = 0; x < 5; ++x) put(x, 100);
    made.last.mark = 100;
    EXPECT_TRUE((*store)->commit(100).ok());
    if (history != History::OneCommit) {
        for (std::int32_t x = 2; x < 7; ++x) put(x, 200);
        const BlobKey erased{BlobKind::DetailPage, 0, 0};
        made.last.blobs.erase(erased), made.last.marks.erase(erased);
        EXPECT_TRUE((*store)->erase(erased).ok());
        made.last.mark = 200;
        EXPECT_TRUE((*store)->commit(200).ok());
    }
    if (history == History::Compacted)
        while (*(*store)->compact(1u << 20)) {
        }
    made.name = disk.paths().front();
    made.file = disk.bytes(made.name);
    return made;
}

FileTag tag_of(const Small& small) { return {kSalt, *number_of(small.name.substr(std::string(kFolder).size() + 1))}; }

std::optional<Superblock> superblock_of(const Bytes& file, const FileTag& tag, unsigned slot) {
    return decode_superblock(std::span(file).subspan(superblock_offset(slot)), tag, slot);
}

unsigned newest_slot(const Small& small) {
    const FileTag tag = tag_of(small);
    return superblock_of(small.file, tag, 0)->generation > superblock_of(small.file, tag, 1)->generation ? 0 : 1;
}

struct Place {
    std::uint64_t offset = 0;
    FrameHeader header;
};
std::vector<Place> frames_of(const Small& small) {
    std::vector<Place> frames;
    for (std::uint64_t at = kFirstFrame; at < small.file.size(); at += frames.back().header.bytes())
        frames.push_back({at, *decode_frame_header(std::span(small.file).subspan(at), tag_of(small), at)});
    return frames;
}

void flip(Bytes& file, std::uint64_t at) { file[at] ^= std::byte{0x10}; }

// Both at once: any byte of any superblock, and any blob. What was committed stays so, but for that blob.
TEST(LogStoreParser, ADamagedSuperblockAndADamagedBlobCostThatBlobAlone) {
    for (const History history : {History::OneCommit, History::TwoCommits, History::Compacted}) {
        const Small good = small_file(history);
        int costly = 0;
        for (const Place& frame : frames_of(good)) {
            if (frame.header.type == FrameType::Index) continue;
            for (const unsigned slot : {0u, 1u})
                for (std::uint64_t byte = 0; byte < kSuperblockBytes; ++byte) {
                    Bytes file = good.file;
                    flip(file, superblock_offset(slot) + byte);
                    // By turns in the frame's header and in its payload.
                    flip(file, frame.offset + (byte % 2 == 0 || frame.header.length == 0 ? byte / 2 % kFrameHeaderBytes
                                                                                         : kFrameHeaderBytes + 3));
                    Opened opened(file, good.name);
                    ASSERT_TRUE(opened.store.ok()) << opened.store.error().message;
                    EXPECT_EQ(opened.report.truncated_bytes, 0u);
                    // The newest superblock is made again without a word where all that it stood for is sound.
                    const bool is_silent = slot == newest_slot(good) &&
                                           frame.offset < superblock_of(good.file, tag_of(good), slot ^ 1)->end;
                    EXPECT_EQ(opened.report.damage.empty(), is_silent);
                    EXPECT_FALSE(opened.report.may_miss_blobs);
                    const int errors = expect_blobs(**opened.store, good.last, good.name);
                    EXPECT_LE(errors, 1);
                    costly += errors;
                    if (errors == 1) {
                        EXPECT_FALSE((*opened.store)->get(frame.header.key).ok());
                    }
                    for (const unsigned now : {0u, 1u})
                        EXPECT_TRUE(superblock_of(opened.disk.bytes(good.name), tag_of(good), now)) << "not repaired";
                    expect_works_on(opened, good.last, errors, good.name);
                    ASSERT_FALSE(testing::Test::HasFailure())
                        << "history " << static_cast<int>(history) << ", slot " << slot << ", byte " << byte
                        << ", frame at " << frame.offset;
                }
        }
        EXPECT_EQ(costly, static_cast<int>(good.last.blobs.size() * 2 * kSuperblockBytes));
    }
}

// Without its index there is no telling what a commit had: nothing of the file is destroyed.
TEST(LogStoreParser, ADamagedSuperblockAndADamagedIndexOfTheOnlyCommitPutTheFileAside) {
    for (const History history : {History::OneCommit, History::Compacted}) {
        const Small good = small_file(history);
        Bytes file = good.file;
        flip(file, superblock_offset(newest_slot(good)) + 9);
        for (const Place& frame : frames_of(good))
            if (frame.header.type == FrameType::Index) flip(file, frame.offset + kFrameHeaderBytes);
        Opened opened(file, good.name);
        ASSERT_TRUE(opened.store.ok());
        EXPECT_EQ((*opened.store)->mark(), 0u);
        EXPECT_TRUE(opened.report.may_miss_blobs);
        EXPECT_FALSE(opened.report.damage.empty());
        EXPECT_EQ(opened.disk.bytes(good.name + ".damaged"), file);
    }
}

// A file that was compacted away is back, and its successor is in a bad way: the one counts, the other is kept.
TEST(LogStoreParser, AnOlderFileIsKeptWhereTheNewestIsDamaged) {
    const Small old = small_file(History::TwoCommits), good = small_file(History::Compacted);
    ASSERT_NE(old.name, good.name);
    Bytes file = good.file;
    flip(file, superblock_offset(newest_slot(good)) + 9);
    flip(file, frames_of(good)[1].offset + kFrameHeaderBytes);
    FaultFiles disk;
    ASSERT_TRUE(disk.make_folder(kFolder).ok());
    disk.set_bytes(old.name, old.file);
    disk.set_bytes(good.name, file);
    LogStoreReport report;
    auto store = open_store(disk, report);
    ASSERT_TRUE(store.ok());
    EXPECT_EQ(expect_blobs(**store, good.last, good.name), 1);
    EXPECT_FALSE(report.may_miss_blobs);
    EXPECT_EQ(disk.paths(), (std::vector<std::string>{old.name + ".damaged", good.name}));
    EXPECT_EQ(disk.bytes(old.name + ".damaged"), old.file);
}

TEST(LogStoreParser, CutShortAnywhereItIsAsOfACommitThatItHas) {
    const Sample& good = sample();
    SplitMix64 random{2};
    for (int i = 0; i < 2500; ++i) {
        const std::uint64_t size = i < 300 ? i * 50 : random.next() % good.file.size();
        Bytes file = good.file;
        file.resize(size);
        Opened opened(file);
        const auto after = std::ranges::upper_bound(good.ends, size);
        Committed expected;
        if (after != good.ends.begin())
            expected = good.commits[static_cast<std::size_t>(after - good.ends.begin() - 1)];
        ASSERT_TRUE(opened.store.ok()) << size << ": " << opened.store.error().message;
        EXPECT_EQ(expect_blobs(**opened.store, expected), 0);
        EXPECT_FALSE(opened.report.damage.empty());
        EXPECT_NE(opened.report.damage.front().message.find(kFile + ": at byte "), std::string::npos);
        EXPECT_TRUE(opened.report.was_scanned || expected.mark == 0);
        EXPECT_EQ(opened.report.may_miss_blobs, expected.mark == 0);
        // What could not be read is put aside, not destroyed.
        if (expected.mark == 0) {
            EXPECT_EQ(opened.disk.bytes(kFile + ".damaged"), file);
        } else {
            expect_works_on(opened, expected, 0);
        }
        opened.expect_small_reads(std::max<std::size_t>(file.size(), kFirstFrame));
        ASSERT_FALSE(testing::Test::HasFailure()) << "cut at " << size;
    }
}

// Cut short, worked on, and the power goes before the next commit: superblocks that point behind the old end are back.
TEST(LogStoreParser, StaleSuperblocksOfACutFileAreNotBelieved) {
    const Sample& good = sample();
    const std::size_t kept = 12;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        Bytes file = good.file;
        file.resize(good.ends[kept] + seed * 7);
        Opened opened(file);
        ASSERT_TRUE(opened.store.ok());
        SplitMix64 random{seed};
        for (int i = 0; i < 60; ++i)
            ASSERT_TRUE((*opened.store)->put({BlobKind::DetailPage, i, 3}, random_bytes(random, 30'000)).ok());
        const std::unique_ptr<FaultFiles> after = opened.disk.crash(seed);
        ASSERT_GT(after->bytes(kFile).size(), 0u);
        LogStoreReport report;
        auto store = open_store(*after, report);
        ASSERT_TRUE(store.ok());
        EXPECT_EQ(expect_blobs(**store, good.commits[kept]), 0);
        EXPECT_FALSE(report.was_scanned);
    }
}

// Many places at once: whatever is got was put once; what is missing or old is reported.
TEST(LogStoreParser, ManyDamagedPlacesAreReported) {
    const Sample& good = sample();
    SplitMix64 random{3};
    for (int i = 0; i < 1500; ++i) {
        Bytes file = good.file;
        for (std::uint64_t flips = 2 + random.next() % 30; flips > 0; --flips)
            file[random.next() % file.size()] ^= static_cast<std::byte>(1 + random.next() % 255);
        if (random.next() % 2 == 0) {  // a block of the disk is gone
            const std::size_t begin = random.next() % (file.size() / 512) * 512;
            const std::size_t end = std::min(file.size(), begin + 512 * (1 + random.next() % 16));
            std::fill(file.begin() + static_cast<std::ptrdiff_t>(begin),
                      file.begin() + static_cast<std::ptrdiff_t>(end), std::byte{});
        }
        Opened opened(file);
        opened.expect_small_reads(file.size());
        if (!opened.store.ok()) {
            EXPECT_NE(opened.store.error().message.find(kFile), std::string::npos);
            continue;
        }
        const Committed& last = good.commits.back();
        for (const auto& [key, bytes] : last.blobs) {
            const Result<std::optional<Bytes>> blob = (*opened.store)->get(key);
            if (!blob.ok()) {
                EXPECT_NE(blob.error().message.find(": at byte "), std::string::npos);
            } else if (!(*blob).has_value() || **blob != bytes) {
                EXPECT_TRUE(opened.report.may_miss_blobs || (*opened.store)->mark() < last.mark);
                EXPECT_FALSE(opened.report.damage.empty());
                const bool was_put = std::ranges::any_of(good.commits, [&](const Committed& commit) {
                    const auto old = commit.blobs.find(key);
                    return old != commit.blobs.end() && (*blob).has_value() && old->second == **blob;
                });
                EXPECT_TRUE(was_put || !(*blob).has_value());
            }
        }
        ASSERT_FALSE(testing::Test::HasFailure()) << "round " << i;
    }
}

TEST(LogStoreParser, LostIndexesCostNoBlob) {
    const Sample& good = sample();
    // Both superblocks, and then every index as well, the last commit's apart: its payload tells which commit it is.
    Bytes file = good.file;
    for (const unsigned slot : {0u, 1u}) file[superblock_offset(slot) + 20] ^= std::byte{1};
    {
        Opened opened(file);
        ASSERT_TRUE(opened.store.ok());
        EXPECT_TRUE(opened.report.was_scanned);
        EXPECT_FALSE(opened.report.may_miss_blobs);
        EXPECT_EQ(expect_blobs(**opened.store, good.commits.back()), 0);
        expect_works_on(opened, good.commits.back(), 0);
    }
    const FileTag tag{kSalt, 1};
    int damaged = 0;
    for (std::uint64_t at = kFirstFrame; at < file.size();) {
        const auto header = decode_frame_header(std::span(file).subspan(at), tag, at);
        ASSERT_TRUE(header.has_value());
        if (header->type == FrameType::Index && at + header->bytes() < file.size())
            file[at + kFrameHeaderBytes] ^= std::byte{1}, ++damaged;
        at += header->bytes();
    }
    ASSERT_GT(damaged, 20);
    Opened opened(file);
    ASSERT_TRUE(opened.store.ok());
    EXPECT_EQ(expect_blobs(**opened.store, good.commits.back()), 0);
    expect_works_on(opened, good.commits.back(), 0);
}

TEST(LogStoreParser, ForeignNewerAndOtherWorldsFilesAreRefusedUntouched) {
    const Sample& good = sample();
    const auto expect_refused = [](const Bytes& file, const std::string& name, std::uint64_t salt, const char* why) {
        Opened opened(file, name, salt);
        ASSERT_FALSE(opened.store.ok()) << why;
        EXPECT_EQ(opened.store.error().code, ErrorCode::FileFormat);
        EXPECT_NE(opened.store.error().message.find(name), std::string::npos);
        EXPECT_NE(opened.store.error().message.find(why), std::string::npos) << opened.store.error().message;
        EXPECT_EQ(opened.disk.bytes(name), file);
        EXPECT_EQ(opened.disk.counts().writes, 0u);
    };
    expect_refused(good.file, kFile, kSalt + 1, "another world");
    expect_refused(good.file, std::string(kFolder) + "/pages-2.tlp", kSalt, "another of its files");

    Bytes newer = good.file;
    newer[8] = std::byte{2};
    const std::uint64_t hash = hash_bytes(std::span(newer).first(32));
    std::memcpy(newer.data() + 32, &hash, sizeof hash);
    expect_refused(newer, kFile, kSalt, "newer version");

    SplitMix64 random{9};
    expect_refused(random_bytes(random, 50'000), kFile, kSalt, "no file of ours");
    expect_refused(random_bytes(random, 100), kFile, kSalt, "no file of ours");
    // A header whose magic rotted is no reason: the rest says whose it is.
    Bytes rotten = good.file;
    rotten[0] ^= std::byte{4};
    Opened opened(rotten);
    ASSERT_TRUE(opened.store.ok());
    EXPECT_EQ(expect_blobs(**opened.store, good.commits.back()), 0);
    expect_works_on(opened, good.commits.back(), 0);
    EXPECT_TRUE(opened.report.damage.empty()) << "the header was written again";
}

/// The most memory that this process ever used.
std::uint64_t peak_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

// Checksums that fit, sizes that do not: nothing is allocated, nothing is believed.
TEST(LogStoreParser, ForgedSizesAreRefused) {
    const std::uint64_t peak = peak_bytes();
    const FileTag tag{kSalt, 1};
    const auto file_with = [&](const FrameHeader& header, Bytes payload, const Superblock& superblock) {
        Bytes file = encode_empty_file(tag);
        FrameHeader hashed = header;
        hashed.payload_hash = hash_bytes(payload);
        const FrameHeaderBytes bytes = encode_frame_header(hashed, tag, kFirstFrame);
        file.insert(file.end(), bytes.begin(), bytes.end());
        file.insert(file.end(), payload.begin(), payload.end());
        const SuperblockBytes commit = encode_superblock(superblock, tag, 1);
        std::ranges::copy(commit, file.begin() + static_cast<std::ptrdiff_t>(superblock_offset(1)));
        return file;
    };
    const auto expect_nothing = [](const Bytes& file) {
        Opened opened(file);
        ASSERT_TRUE(opened.store.ok());
        EXPECT_FALSE(opened.report.damage.empty());
        for (int kind = 1; kind <= 5; ++kind)
            EXPECT_TRUE((*(*opened.store)->keys(static_cast<BlobKind>(kind))).empty());
        opened.expect_small_reads(file.size());
    };
    Index index{.generation = 1, .mark = 5};
    const Bytes sound = encode_index(index);
    const auto commit_of = [](std::size_t payload) {
        return Superblock{1, 5, kFirstFrame, kFirstFrame + kFrameHeaderBytes + payload, 0};
    };
    const FrameHeader header{.type = FrameType::Index, .length = static_cast<std::uint32_t>(sound.size())};
    {
        Opened opened(file_with(header, sound, commit_of(sound.size())));  // so far it is right
        ASSERT_TRUE(opened.store.ok());
        EXPECT_TRUE(opened.report.damage.empty());
        EXPECT_EQ((*opened.store)->mark(), 5u);
    }
    for (const std::uint64_t far : {~std::uint64_t{0}, ~std::uint64_t{0} - 20, std::uint64_t{1} << 63}) {
        expect_nothing(file_with(header, sound, {1, 5, far, commit_of(sound.size()).end, 0}));
        expect_nothing(file_with(header, sound, {1, 5, kFirstFrame, far, 0}));
        expect_nothing(file_with(header, sound, {1, 5, far, far, 0}));
    }
    FrameHeader huge = header;
    huge.length = 0xffffffffu;
    expect_nothing(file_with(huge, sound, commit_of(sound.size())));
    for (const std::size_t field : {std::size_t{16}, std::size_t{24}, std::size_t{32}, std::size_t{36}})
        for (const std::uint32_t value : {0x7fffffffu, 0xffffffffu}) {
            Bytes payload = sound;
            std::memcpy(payload.data() + field, &value, sizeof value);
            expect_nothing(file_with(header, payload, commit_of(sound.size())));
        }
    const Entry wrong[] = {{kFirstFrame, 1, 0xffffffffu},
                           {~std::uint64_t{0} - 30, 1, 20},
                           {0, 1, 20},
                           {kFirstFrame + (1u << 30), 1, 20},
                           {kFirstFrame, 1, 1},
                           {kFirstFrame - 1, 1, 0},
                           {kFirstFrame, 1, (64u << 20) + 1}};
    for (const Entry& entry : wrong) {
        index.added = {{{BlobKind::DetailPage, 1, 1}, entry}};
        const Bytes payload = encode_index(index);
        FrameHeader of_it = header;
        of_it.length = static_cast<std::uint32_t>(payload.size());
        Superblock commit = commit_of(payload.size());
        commit.blobs = 1;
        expect_nothing(file_with(of_it, payload, commit));
    }
    EXPECT_LT(peak_bytes(), peak + (512u << 20)) << "4 GiB were asked for, and given";
}

TEST(LogStoreParser, ALaterFileWithoutACommitIsTheRestOfACrash) {
    const Sample& good = sample();
    for (const bool has_frames : {false, true}) {
        FaultFiles disk;
        ASSERT_TRUE(disk.make_folder(kFolder).ok());
        disk.set_bytes(kFile, good.file);
        Bytes rest = encode_empty_file({kSalt, 2});
        if (has_frames) {
            const FrameHeader header{.type = FrameType::Blob, .key = {BlobKind::World, 0, 0}, .length = 100};
            const FrameHeaderBytes bytes = encode_frame_header(header, {kSalt, 2}, kFirstFrame);
            rest.insert(rest.end(), bytes.begin(), bytes.end());
            rest.resize(rest.size() + 60);
        }
        disk.set_bytes("world/pages-2.tlp", rest);
        disk.set_bytes("world/pages-3.tlp.new", Bytes(100));
        disk.set_bytes("world/pages-3.tlp.notes", Bytes(100));
        LogStoreReport report;
        auto store = open_store(disk, report);
        ASSERT_TRUE(store.ok());
        EXPECT_EQ(expect_blobs(**store, good.commits.back()), 0);
        EXPECT_TRUE(report.damage.empty());
        EXPECT_EQ(disk.paths(), (std::vector<std::string>{kFile, "world/pages-3.tlp.notes"}));
    }
}

TEST(LogStoreParser, UnreadableIsNotTakenForDamaged) {
    const Sample& good = sample();
    FaultFiles disk;
    ASSERT_TRUE(disk.make_folder(kFolder).ok());
    disk.set_bytes(kFile, good.file);
    disk.fail_reads(kFile);
    LogStoreReport report;
    const auto store = open_store(disk, report);
    ASSERT_FALSE(store.ok());
    EXPECT_EQ(store.error().code, ErrorCode::FileRead);
    EXPECT_EQ(disk.bytes(kFile), good.file);
}

}  // namespace
}  // namespace tilth::test
