// SQLite as a BlobStore: one table in WAL mode. For measurement alone.
#include <sqlite3.h>

#include <cstring>

#include "store/engines.h"

namespace tilth::bench {
namespace {

class SqliteStore final : public BlobStore {
public:
    explicit SqliteStore(std::string path) : path_(std::move(path)) {}
    ~SqliteStore() override {
        for (sqlite3_stmt* statement : {keys_, get_, put_, erase_, set_mark_}) sqlite3_finalize(statement);
        sqlite3_close(db_);
    }

    Result<void> open(Synchronous synchronous) {
        if (sqlite3_open(path_.c_str(), &db_) != SQLITE_OK) return failed("open");
        const char* durable =
            synchronous == Synchronous::Full ? "PRAGMA synchronous=FULL" : "PRAGMA synchronous=NORMAL";
        for (const char* sql :
             {"PRAGMA journal_mode=WAL", durable,
              "CREATE TABLE IF NOT EXISTS blobs(kind INT, x INT, z INT, bytes BLOB, PRIMARY KEY(kind, x, z))",
              "CREATE TABLE IF NOT EXISTS mark(id INTEGER PRIMARY KEY, mark INT)"})
            if (sqlite3_exec(db_, sql, nullptr, nullptr, nullptr) != SQLITE_OK) return failed(sql);
        const auto prepare = [&](const char* sql, sqlite3_stmt** made) {
            return sqlite3_prepare_v3(db_, sql, -1, SQLITE_PREPARE_PERSISTENT, made, nullptr) == SQLITE_OK;
        };
        sqlite3_stmt* read_mark = nullptr;
        if (!prepare("SELECT x, z FROM blobs WHERE kind=? ORDER BY x, z", &keys_) ||
            !prepare("SELECT bytes FROM blobs WHERE kind=? AND x=? AND z=?", &get_) ||
            !prepare("INSERT OR REPLACE INTO blobs VALUES(?, ?, ?, ?)", &put_) ||
            !prepare("DELETE FROM blobs WHERE kind=? AND x=? AND z=?", &erase_) ||
            !prepare("INSERT OR REPLACE INTO mark VALUES(1, ?)", &set_mark_) ||
            !prepare("SELECT mark FROM mark", &read_mark))
            return failed("prepare");
        const int step = sqlite3_step(read_mark);
        if (step == SQLITE_ROW) mark_ = static_cast<std::uint64_t>(sqlite3_column_int64(read_mark, 0));
        sqlite3_finalize(read_mark);
        if (step != SQLITE_ROW && step != SQLITE_DONE) return failed("mark");
        return {};
    }

    Result<std::vector<BlobKey>> keys(BlobKind kind) override {
        std::vector<BlobKey> found;
        sqlite3_reset(keys_);
        sqlite3_bind_int(keys_, 1, static_cast<int>(kind));
        int step = SQLITE_DONE;
        while ((step = sqlite3_step(keys_)) == SQLITE_ROW)
            found.push_back({kind, sqlite3_column_int(keys_, 0), sqlite3_column_int(keys_, 1)});
        sqlite3_reset(keys_);
        if (step != SQLITE_DONE) return failed("keys");
        return found;
    }
    Result<std::optional<std::vector<std::byte>>> get(BlobKey key) override {
        bind(get_, key);
        const int step = sqlite3_step(get_);
        std::optional<std::vector<std::byte>> blob;
        if (step == SQLITE_ROW) {
            const auto* bytes = static_cast<const std::byte*>(sqlite3_column_blob(get_, 0));
            blob.emplace(bytes, bytes + sqlite3_column_bytes(get_, 0));
        }
        sqlite3_reset(get_);
        if (step != SQLITE_ROW && step != SQLITE_DONE) return failed("get");
        return blob;
    }
    Result<void> put(BlobKey key, std::span<const std::byte> bytes) override {
        if (Result<void> begun = begin(); !begun) return begun;
        bind(put_, key);
        sqlite3_bind_blob(put_, 4, bytes.data(), static_cast<int>(bytes.size()), SQLITE_STATIC);
        return run(put_);
    }
    Result<void> erase(BlobKey key) override {
        if (Result<void> begun = begin(); !begun) return begun;
        bind(erase_, key);
        return run(erase_);
    }
    Result<void> commit(std::uint64_t mark) override {
        if (Result<void> begun = begin(); !begun) return begun;
        sqlite3_reset(set_mark_);
        sqlite3_bind_int64(set_mark_, 1, static_cast<std::int64_t>(mark));
        if (Result<void> set = run(set_mark_); !set) return set;
        if (sqlite3_exec(db_, "COMMIT", nullptr, nullptr, nullptr) != SQLITE_OK) return failed("commit");
        in_transaction_ = false;
        mark_ = mark;
        return {};
    }
    [[nodiscard]] std::uint64_t mark() const override { return mark_; }
    [[nodiscard]] Size size() const override { return {0, bytes_in(std::filesystem::path(path_).parent_path())}; }
    Result<bool> compact(std::uint64_t, bool = false) override {
        for (const char* sql : {"VACUUM", "PRAGMA wal_checkpoint(TRUNCATE)"})
            if (sqlite3_exec(db_, sql, nullptr, nullptr, nullptr) != SQLITE_OK) return failed(sql);
        return false;
    }

private:
    static void bind(sqlite3_stmt* statement, BlobKey key) {
        sqlite3_reset(statement);
        sqlite3_bind_int(statement, 1, static_cast<int>(key.kind));
        sqlite3_bind_int(statement, 2, key.x);
        sqlite3_bind_int(statement, 3, key.z);
    }
    Result<void> begin() {
        if (in_transaction_) return {};
        if (sqlite3_exec(db_, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr) != SQLITE_OK) return failed("begin");
        in_transaction_ = true;
        return {};
    }
    Result<void> run(sqlite3_stmt* statement) {
        const int step = sqlite3_step(statement);
        sqlite3_reset(statement);
        if (step != SQLITE_DONE) return failed("step");
        return {};
    }
    [[nodiscard]] Error failed(const char* what) const {
        return {ErrorCode::FileRead, text(path_, ": SQLite, ", what, ": ", sqlite3_errmsg(db_))};
    }

    std::string path_;
    sqlite3* db_ = nullptr;
    sqlite3_stmt *keys_ = nullptr, *get_ = nullptr, *put_ = nullptr, *erase_ = nullptr, *set_mark_ = nullptr;
    bool in_transaction_ = false;
    std::uint64_t mark_ = 0;
};

}  // namespace

Result<OpenStore> open_sqlite(const std::string& folder, Synchronous synchronous) {
    auto store = std::make_unique<SqliteStore>(folder + "/world.db");
    if (Result<void> opened = store->open(synchronous); !opened) return opened.error();
    return OpenStore{std::move(store)};
}

}  // namespace tilth::bench
