// What a log store should hold, and random work on it.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "support/fault_files.h"
#include "tilth/ground/random_stamps.h"
#include "tilth/store/log_store.h"

namespace tilth::test {

using Bytes = std::vector<std::byte>;
using Blobs = std::map<BlobKey, Bytes>;

inline constexpr std::uint64_t kSalt = 0x1234567890abcdefull;
inline constexpr const char* kFolder = "world";

inline Bytes random_bytes(SplitMix64& random, std::size_t size) {
    Bytes bytes(size);
    for (std::byte& byte : bytes) byte = static_cast<std::byte>(random.next());
    return bytes;
}

inline BlobKey random_key(SplitMix64& random, std::uint64_t keys) {
    const auto number = static_cast<std::int32_t>(random.next() % keys);
    return {static_cast<BlobKind>(1 + number % 5), number / 5 - 2, 1 - number};
}

inline Result<std::unique_ptr<LogStore>> open_store(FileSystem& files, LogStoreReport& report,
                                                    const LogStoreSettings& settings = {}) {
    return LogStore::open(files, kFolder, kSalt, settings, report);
}

/// All blobs that a store lists; fails the test where one cannot be got.
inline Blobs blobs_of(LogStore& store) {
    Blobs blobs;
    for (int kind = 1; kind <= 5; ++kind) {
        const Result<std::vector<BlobKey>> keys = store.keys(static_cast<BlobKind>(kind));
        EXPECT_TRUE(keys.ok());
        EXPECT_TRUE(std::is_sorted((*keys).begin(), (*keys).end()));
        for (const BlobKey& key : *keys) {
            EXPECT_EQ(static_cast<int>(key.kind), kind);
            Result<std::optional<Bytes>> blob = store.get(key);
            EXPECT_TRUE(blob.ok()) << blob.error().message;
            if (blob.ok()) {
                EXPECT_TRUE(blob->has_value());
                blobs[key] = (*blob).value_or(Bytes{});
            }
        }
    }
    return blobs;
}

/// A state that may be found on the disk after a crash.
struct Committed {
    std::uint64_t mark = 0;
    Blobs blobs;
    std::map<BlobKey, std::uint64_t> marks;  ///< of the commits that made them durable
};

/// Works a store at random, and knows what it must hold. Everything may fail; errors must be FileWrite.
class Worker {
public:
    struct Settings {
        std::uint64_t keys = 12;
        std::size_t most_bytes = 700;
        LogStoreSettings store{.most_waste = 0.3, .least_waste_bytes = 1000};
    };
    Worker(FaultFiles& disk, std::uint64_t seed, const Settings& settings)
        : disk_(disk), random_{seed}, settings_(settings) {
        (void)disk.make_folder(kFolder);
        (void)disk.sync_folder("");
        possible_.push_back({});
    }

    /// One operation. Returns whether it succeeded.
    bool step() {
        if (store_ == nullptr) return reopen();
        const std::uint64_t what = random_.next() % 100;
        if (what < 55) return put(random_key(random_, settings_.keys), random_.next() % settings_.most_bytes);
        if (what < 68) return erase(random_key(random_, settings_.keys));
        if (what < 82) return commit();
        if (what < 96) return compact(random_.next() % 2000);
        return reopen();
    }

    bool put(BlobKey key, std::size_t size) {
        const Bytes bytes = random_bytes(random_, size);
        const Result<void> done = store_->put(key, bytes);
        if (done) visible_[key] = bytes, marks_.erase(key);
        return noted(done);
    }
    bool erase(BlobKey key) {
        const Result<void> done = store_->erase(key);
        if (done) visible_.erase(key), marks_.erase(key);
        return noted(done);
    }
    bool commit() {
        Committed next{possible_.front().mark + 1 + random_.next() % 5, visible_, marks_};
        for (const auto& [key, bytes] : visible_) next.marks.try_emplace(key, next.mark);
        possible_.push_back(next);  // from now on a crash may have it
        const Result<void> done = store_->commit(next.mark);
        if (done) {
            possible_ = {next};
            marks_ = next.marks;
        }
        return noted(done);
    }
    bool compact(std::uint64_t most_bytes) {
        const Result<bool> more = store_->compact(most_bytes);
        compactions_ += disk_.exists(std::string(kFolder) + "/pages-2.tlp") ? 1 : 0;
        return noted(more.ok() ? Result<void>() : Result<void>(more.error()));
    }
    bool reopen() {
        store_.reset();
        Result<std::unique_ptr<LogStore>> store = open_store(disk_, report_, settings_.store);
        if (!store) return noted(store.error());
        store_ = *std::move(store);
        expect_undamaged();
        const Committed now = expect_possible(*store_);
        visible_ = now.blobs;
        marks_ = now.marks;
        possible_ = {now};
        return true;
    }

    /// What can be seen now, whatever went wrong before.
    void expect_visible() {
        if (store_ == nullptr) return;
        EXPECT_EQ(blobs_of(*store_), visible_);
        for (const auto& [key, bytes] : visible_) {
            const auto mark = marks_.find(key);
            EXPECT_EQ(store_->mark_of(key), mark == marks_.end() ? std::nullopt : std::optional(mark->second));
        }
        std::uint64_t bytes = 0;
        for (const auto& [key, blob] : visible_) bytes += blob.size();
        EXPECT_EQ(store_->size().live_bytes, bytes);
    }
    /// What a power cut now would leave.
    void expect_after_crash(std::uint64_t seed) {
        const std::unique_ptr<FaultFiles> after = disk_.crash(seed);
        (void)after->make_folder(kFolder);
        LogStoreReport report;
        Result<std::unique_ptr<LogStore>> store = open_store(*after, report, settings_.store);
        ASSERT_TRUE(store.ok()) << store.error().message;
        EXPECT_TRUE(report.damage.empty()) << report.damage.front().message;
        EXPECT_FALSE(report.was_scanned || report.may_miss_blobs);
        truncations_ += report.truncated_bytes != 0 ? 1 : 0;
        const Committed now = expect_possible(**store);
        EXPECT_LE(after->paths().size(), 1u);

        // And it works on.
        ASSERT_TRUE((*store)->put({BlobKind::World, 99, 99}, Bytes(30)).ok());
        ASSERT_TRUE((*store)->commit(now.mark + 1).ok());
        store = open_store(*after, report, settings_.store);
        ASSERT_TRUE(store.ok());
        Blobs expected = now.blobs;
        expected[{BlobKind::World, 99, 99}] = Bytes(30);
        EXPECT_EQ(blobs_of(**store), expected);
        EXPECT_EQ(report.truncated_bytes, 0u);
    }

    [[nodiscard]] LogStore& store() { return *store_; }
    [[nodiscard]] bool is_open() const { return store_ != nullptr; }
    [[nodiscard]] const Committed& last() const { return possible_.front(); }
    [[nodiscard]] int compactions() const { return compactions_; }
    /// Crashes that left something behind the last commit.
    [[nodiscard]] int truncations() const { return truncations_; }

private:
    bool noted(const Result<void>& done) {
        if (!done) {
            EXPECT_EQ(done.error().code, ErrorCode::FileWrite) << done.error().message;
            EXPECT_NE(done.error().message.find(kFolder), std::string::npos) << done.error().message;
        }
        return done.ok();
    }
    void expect_undamaged() {
        EXPECT_TRUE(report_.damage.empty()) << report_.damage.front().message;
        EXPECT_FALSE(report_.was_scanned || report_.may_miss_blobs);
    }
    /// The store holds one of the states that are possible; that one is returned.
    Committed expect_possible(LogStore& store) {
        const Blobs blobs = blobs_of(store);
        for (const Committed& state : possible_)
            if (state.mark == store.mark() && state.blobs == blobs) {
                for (const auto& [key, mark] : state.marks) EXPECT_EQ(store.mark_of(key), std::optional(mark));
                return state;
            }
        ADD_FAILURE() << "mark " << store.mark() << " with " << blobs.size() << " blobs; the last commit was "
                      << possible_.front().mark << " with " << possible_.front().blobs.size() << ", and "
                      << possible_.size() - 1 << " that failed since";
        return possible_.front();
    }

    FaultFiles& disk_;
    SplitMix64 random_;
    const Settings settings_;
    std::unique_ptr<LogStore> store_;
    LogStoreReport report_;
    Blobs visible_;
    std::map<BlobKey, std::uint64_t> marks_;  ///< of what is visible and committed
    std::vector<Committed> possible_;         ///< the last commit, and those that failed since
    int compactions_ = 0, truncations_ = 0;
};

}  // namespace tilth::test
