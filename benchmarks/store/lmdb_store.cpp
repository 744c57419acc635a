// LMDB as a BlobStore: one database, synchronous commits. For measurement alone.
#include <lmdb.h>

#include <array>
#include <cstring>

#include "store/engines.h"

namespace tilth::bench {
namespace {

constexpr std::size_t kMapBytes = std::size_t{4} << 30;
constexpr std::uint8_t kMarkKind = 0;

/// Bytes that sort as kinds, then x, then z do.
using KeyBytes = std::array<std::uint8_t, 9>;

KeyBytes bytes_of(BlobKey key) {
    KeyBytes bytes{static_cast<std::uint8_t>(key.kind)};
    const std::uint32_t parts[] = {static_cast<std::uint32_t>(key.x) ^ 0x8000'0000u,
                                   static_cast<std::uint32_t>(key.z) ^ 0x8000'0000u};
    for (std::size_t i = 0; i < 8; ++i) bytes[i + 1] = static_cast<std::uint8_t>(parts[i / 4] >> (24 - 8 * (i % 4)));
    return bytes;
}

BlobKey key_of(const KeyBytes& bytes) {
    std::uint32_t parts[2] = {0, 0};
    for (std::size_t i = 0; i < 8; ++i) parts[i / 4] = parts[i / 4] << 8 | bytes[i + 1];
    return {static_cast<BlobKind>(bytes[0]), static_cast<std::int32_t>(parts[0] ^ 0x8000'0000u),
            static_cast<std::int32_t>(parts[1] ^ 0x8000'0000u)};
}

class LmdbStore final : public BlobStore {
public:
    explicit LmdbStore(std::string folder) : folder_(std::move(folder)) {}
    ~LmdbStore() override {
        if (write_ != nullptr) mdb_txn_abort(write_);
        if (env_ != nullptr) mdb_env_close(env_);
    }

    Result<void> open() {
        int status = mdb_env_create(&env_);
        if (status == 0) status = mdb_env_set_mapsize(env_, kMapBytes);
        if (status == 0) status = mdb_env_open(env_, folder_.c_str(), 0, 0644);
        if (status != 0) return failed("open", status);
        if (Result<void> begun = begin(); !begun) return begun;
        status = mdb_dbi_open(write_, nullptr, 0, &dbi_);
        if (status != 0) return failed("dbi", status);
        KeyBytes key{kMarkKind};
        MDB_val key_value{key.size(), key.data()}, value{};
        status = mdb_get(write_, dbi_, &key_value, &value);
        if (status == 0 && value.mv_size == sizeof mark_) std::memcpy(&mark_, value.mv_data, sizeof mark_);
        mdb_txn_commit(write_);
        write_ = nullptr;
        if (status != 0 && status != MDB_NOTFOUND) return failed("mark", status);
        return {};
    }

    Result<std::vector<BlobKey>> keys(BlobKind kind) override {
        std::vector<BlobKey> found;
        const int status = reading([&](MDB_txn* transaction) {
            MDB_cursor* cursor = nullptr;
            int step = mdb_cursor_open(transaction, dbi_, &cursor);
            if (step != 0) return step;
            KeyBytes first{static_cast<std::uint8_t>(kind)};
            MDB_val key{1, first.data()}, value{};
            for (step = mdb_cursor_get(cursor, &key, &value, MDB_SET_RANGE); step == 0;
                 step = mdb_cursor_get(cursor, &key, &value, MDB_NEXT)) {
                KeyBytes bytes{};
                if (key.mv_size != bytes.size()) continue;
                std::memcpy(bytes.data(), key.mv_data, bytes.size());
                if (bytes[0] != static_cast<std::uint8_t>(kind)) break;
                found.push_back(key_of(bytes));
            }
            mdb_cursor_close(cursor);
            return step;
        });
        if (status != 0 && status != MDB_NOTFOUND) return failed("keys", status);
        return found;
    }
    Result<std::optional<std::vector<std::byte>>> get(BlobKey key) override {
        std::optional<std::vector<std::byte>> blob;
        const int status = reading([&](MDB_txn* transaction) {
            KeyBytes bytes = bytes_of(key);
            MDB_val key_value{bytes.size(), bytes.data()}, value{};
            const int step = mdb_get(transaction, dbi_, &key_value, &value);
            const auto* data = static_cast<const std::byte*>(value.mv_data);
            if (step == 0) blob.emplace(data, data + value.mv_size);
            return step;
        });
        if (status != 0 && status != MDB_NOTFOUND) return failed("get", status);
        return blob;
    }
    Result<void> put(BlobKey key, std::span<const std::byte> bytes) override {
        KeyBytes key_bytes = bytes_of(key);
        return put(key_bytes, bytes);
    }
    Result<void> erase(BlobKey key) override {
        if (Result<void> begun = begin(); !begun) return begun;
        KeyBytes bytes = bytes_of(key);
        MDB_val key_value{bytes.size(), bytes.data()};
        const int status = mdb_del(write_, dbi_, &key_value, nullptr);
        if (status != 0 && status != MDB_NOTFOUND) return failed("erase", status);
        return {};
    }
    Result<void> commit(std::uint64_t mark) override {
        KeyBytes key{kMarkKind};
        if (Result<void> set = put(key, std::as_bytes(std::span(&mark, 1))); !set) return set;
        const int status = mdb_txn_commit(write_);
        write_ = nullptr;
        if (status != 0) return failed("commit", status);
        mark_ = mark;
        return {};
    }
    [[nodiscard]] std::uint64_t mark() const override { return mark_; }
    [[nodiscard]] Size size() const override { return {0, bytes_in(folder_)}; }
    /// Pages that are free are used again; giving them back would be a copy of everything, by the host.
    Result<bool> compact(std::uint64_t, bool = false) override { return false; }

private:
    Result<void> begin() {
        if (write_ != nullptr) return {};
        if (const int status = mdb_txn_begin(env_, nullptr, 0, &write_); status != 0) return failed("begin", status);
        return {};
    }
    Result<void> put(KeyBytes& key, std::span<const std::byte> bytes) {
        if (Result<void> begun = begin(); !begun) return begun;
        MDB_val key_value{key.size(), key.data()}, value{bytes.size(), nullptr};
        const int status = mdb_put(write_, dbi_, &key_value, &value, MDB_RESERVE);
        if (status != 0) return failed("put", status);
        std::memcpy(value.mv_data, bytes.data(), bytes.size());
        return {};
    }
    /// In the write transaction where there is one: what was put is seen.
    template <class Work>
    int reading(const Work& work) {
        if (write_ != nullptr) return work(write_);
        MDB_txn* transaction = nullptr;
        if (const int status = mdb_txn_begin(env_, nullptr, MDB_RDONLY, &transaction); status != 0) return status;
        const int status = work(transaction);
        mdb_txn_abort(transaction);
        return status;
    }
    [[nodiscard]] Error failed(const char* what, int status) const {
        return {ErrorCode::FileRead, text(folder_, ": LMDB, ", what, ": ", mdb_strerror(status))};
    }

    std::string folder_;
    MDB_env* env_ = nullptr;
    MDB_dbi dbi_ = 0;
    MDB_txn* write_ = nullptr;
    std::uint64_t mark_ = 0;
};

}  // namespace

Result<OpenStore> open_lmdb(const std::string& folder) {
    auto store = std::make_unique<LmdbStore>(folder);
    if (Result<void> opened = store->open(); !opened) return opened.error();
    return OpenStore{std::move(store)};
}

}  // namespace tilth::bench
