// A blob store in memory: commits, crashes and damage without a disk.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/store/blob_store.h"

namespace tilth::test {

/// What a host brings that keeps worlds elsewhere; and what tests spoil.
class MemoryBlobs final : public BlobStore {
public:
    using Bytes = std::vector<std::byte>;

    Result<std::vector<BlobKey>> keys(BlobKind kind) override {
        std::vector<BlobKey> found;
        for (const auto& [key, bytes] : live_)
            if (key.kind == kind) found.push_back(key);
        return found;
    }
    Result<std::optional<Bytes>> get(BlobKey key) override {
        ++gets;
        if (damaged.contains(key))
            return Error{ErrorCode::FileFormat, text("memory: offset ", key.x, ",", key.z, ": is damaged")};
        const auto found = live_.find(key);
        return found == live_.end() ? std::optional<Bytes>() : std::optional<Bytes>(found->second);
    }
    Result<void> put(BlobKey key, std::span<const std::byte> bytes) override {
        if (++puts == fail_at_put) return Error{ErrorCode::FileWrite, "memory: full"};
        live_[key] = Bytes(bytes.begin(), bytes.end());
        damaged.erase(key);
        return {};
    }
    Result<void> erase(BlobKey key) override {
        live_.erase(key);
        damaged.erase(key);
        return {};
    }
    Result<void> commit(std::uint64_t mark) override {
        durable_ = live_;
        mark_ = mark;
        return {};
    }
    [[nodiscard]] std::uint64_t mark() const override { return mark_; }
    [[nodiscard]] Size size() const override {
        std::uint64_t bytes = 0;
        for (const auto& [key, blob] : live_) bytes += blob.size();
        return {bytes, bytes};
    }
    Result<bool> compact(std::uint64_t, bool = false) override { return false; }

    /// What was not committed is gone.
    void crash() { live_ = durable_; }
    [[nodiscard]] bool has(BlobKey key) const { return live_.contains(key); }
    [[nodiscard]] const std::map<BlobKey, Bytes>& durable() const { return durable_; }

    std::set<BlobKey> damaged;
    std::uint64_t gets = 0, puts = 0, fail_at_put = 0;

private:
    std::map<BlobKey, Bytes> live_, durable_;
    std::uint64_t mark_ = 0;
};

}  // namespace tilth::test
