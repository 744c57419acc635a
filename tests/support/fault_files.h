// A disk in memory that fills up, loses power and rots as a test wishes, the same way every time.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tilth/core/result.h"
#include "tilth/store/file_system.h"

namespace tilth::test {

/// What happens at the operation that `fail_at` names.
enum class Fault : std::uint8_t {
    NoSpace,   ///< it fails, a write having left some of its bytes, and so do all that need space, until `make_room`
    Once,      ///< it alone fails, in the same way
    PowerOff,  ///< it may have happened or not, or half; every one behind it fails and does nothing. Then: `crash`
};

/// A `FileSystem` for tests. Nothing of it touches the real disk.
///
///     FaultFiles disk;                            // "" exists; make_folder("world") for more
///     disk.fail_at(k, Fault::NoSpace);            // the k-th operation from now, 1: the next
///     ... use it; errors are FileWrite ...
///     disk.make_room();
///     std::unique_ptr<FaultFiles> after = disk.crash(seed);   // what a power cut now would leave; `disk` goes on
///
/// Operations that count (and can fail): write, sync, truncate, rename, remove, make_folder, sync_folder, and open
/// where it makes a file. So `fail_at(1)`, `fail_at(2)` .. `fail_at(operations of a run without faults)` try every one.
///
/// What a power cut leaves, drawn from the seed:
/// - of a file, what was there at its last `sync`, and of each 512-byte sector written since then the old content or
/// any
///   of the newer ones: nothing, everything, everything up to a moment, or each sector for itself, with the length
///   between the old and the new one. Sectors that the length covers but that were never written hold zeros or rubbish;
/// - of names (made, renamed, removed) what was there at the last `sync_folder`, and each later change or not;
/// - a failed `sync` promises nothing about what was written before it, and a later `sync` makes only good what is
///   written again (Linux: failed pages count as clean).
/// `remove` needs no space, so that NoSpace lets it pass. Locks hold within one FaultFiles; `crash` has none.
/// Thread-safe. Files opened may outlive it.
class FaultFiles final : public FileSystem {
public:
    struct Counts {
        std::uint64_t operations = 0;  ///< all that count
        std::uint64_t reads = 0, read_bytes = 0, most_read_bytes = 0;
        std::uint64_t writes = 0, written_bytes = 0, syncs = 0, folder_syncs = 0;
    };

    FaultFiles() : disk_(std::make_shared<Disk>()) {}

    // Faults.

    void fail_at(std::uint64_t operation, Fault fault, std::uint64_t seed = 1) {
        const std::lock_guard lock(disk_->mutex);
        disk_->fail_at = disk_->counts.operations + operation;
        disk_->fault = fault;
        disk_->random = seed;
    }
    /// There is room again; nothing fails any more.
    void make_room() {
        const std::lock_guard lock(disk_->mutex);
        disk_->fail_at = 0;
        disk_->is_full = disk_->is_off = false;
    }
    /// Has the fault struck?
    [[nodiscard]] bool failed() const {
        const std::lock_guard lock(disk_->mutex);
        return disk_->struck;
    }
    /// From now on a failed `sync` also drops what it did not write: reads have the old content (zeros where there was
    /// none) from then on, until it is written again. So Linux does when it needs the memory.
    void drop_pages_of_failed_syncs() {
        const std::lock_guard lock(disk_->mutex);
        disk_->drops_pages = true;
    }
    /// Reads of this file fail (FileRead) until it is empty again.
    void fail_reads(const std::string& path) {
        const std::lock_guard lock(disk_->mutex);
        disk_->unreadable = path;
    }
    [[nodiscard]] Counts counts() const {
        const std::lock_guard lock(disk_->mutex);
        return disk_->counts;
    }
    [[nodiscard]] std::unique_ptr<FaultFiles> crash(std::uint64_t seed) const;

    // Looking at files and spoiling them; such changes are durable at once. The file must exist.

    [[nodiscard]] std::vector<std::string> paths() const {
        const std::lock_guard lock(disk_->mutex);
        std::vector<std::string> found;
        for (const auto& [path, node] : disk_->names)
            if (!node->is_folder) found.push_back(path);
        return found;
    }
    [[nodiscard]] std::vector<std::byte> bytes(const std::string& path) const {
        const std::lock_guard lock(disk_->mutex);
        return disk_->names.at(path)->live;
    }
    /// Makes the file if need be.
    void set_bytes(const std::string& path, std::vector<std::byte> bytes) {
        const std::lock_guard lock(disk_->mutex);
        std::shared_ptr<Node>& node = disk_->names[path];
        if (node == nullptr) node = std::make_shared<Node>();
        *node = Node{.live = bytes, .durable = bytes};
        disk_->durable_names[path] = node;
    }
    /// Bits are numbered from the lowest of byte 0.
    void flip_bit(const std::string& path, std::uint64_t bit) {
        std::vector<std::byte> content = bytes(path);
        content.at(bit / 8) ^= std::byte{static_cast<unsigned char>(1u << (bit % 8))};
        set_bytes(path, std::move(content));
    }
    void cut(const std::string& path, std::uint64_t size) {
        std::vector<std::byte> content = bytes(path);
        content.resize(size);
        set_bytes(path, std::move(content));
    }

    // FileSystem.

    Result<std::unique_ptr<File>> open(const std::string& path, OpenMode mode) override;
    bool exists(const std::string& path) override {
        const std::lock_guard lock(disk_->mutex);
        return disk_->names.contains(clean(path));
    }
    Result<void> make_folder(const std::string& path) override;
    Result<std::vector<std::string>> list(const std::string& folder) override;
    Result<void> rename(const std::string& from, const std::string& to) override;
    Result<void> remove(const std::string& path) override;
    Result<void> sync_folder(const std::string& folder) override;
    Result<std::unique_ptr<FileLock>> lock(const std::string& path) override;

private:
    static constexpr std::size_t kSector = 512;
    using Sector = std::array<std::byte, kSector>;
    template <class T>
    using Versions = std::vector<std::pair<std::uint64_t, T>>;  ///< with the operation that made them

    struct Node {
        bool is_folder = false;
        std::vector<std::byte> live = {}, durable = {};
        std::map<std::uint64_t, Versions<Sector>> dirty = {};  ///< sectors written since the last sync
        std::set<std::uint64_t> unsure = {};                   ///< of those: a sync failed, and they count as clean
        Versions<std::uint64_t> sizes = {};
    };
    using Names = std::map<std::string, std::shared_ptr<Node>>;
    struct NameChange {
        std::uint64_t operation;
        std::string path;
        std::shared_ptr<Node> node;  ///< nullptr: removed
        std::string gone;            ///< a rename: the name that goes with it
    };
    struct Disk {
        std::mutex mutex;
        Names names, durable_names;
        std::vector<NameChange> changes;
        std::set<std::string> locks;
        Counts counts;
        std::uint64_t fail_at = 0, random = 1;
        Fault fault = Fault::NoSpace;
        bool is_full = false, is_off = false, struck = false;
        bool drops_pages = false;
        std::string unreadable;

        std::uint64_t next(std::uint64_t bound) { return draw(random, bound); }
        /// Counts an operation. True: it fails.
        bool fails(bool needs_space = true) {
            ++counts.operations;
            if (is_off || (is_full && needs_space)) return true;
            if (fail_at == 0 || counts.operations < fail_at) return false;
            if (fault == Fault::NoSpace && !needs_space) return false;
            struck = true, fail_at = 0;
            is_full = fault == Fault::NoSpace;
            if (fault == Fault::PowerOff) is_off = true, half_done = true;
            return true;
        }
        bool half_done = false;  ///< the operation at hand is the one during which the power went
        bool takes_effect() { return std::exchange(half_done, false); }

        void change_name(const NameChange& change) {
            apply(names, change);
            changes.push_back(change);
        }
        static void apply(Names& to, const NameChange& change) {
            if (!change.gone.empty()) to.erase(change.gone);
            if (change.node == nullptr)
                to.erase(change.path);
            else
                to[change.path] = change.node;
        }
        void write(Node& node, std::uint64_t offset, std::span<const std::byte> bytes) {
            if (bytes.empty()) return;
            if (offset + bytes.size() > node.live.size()) resize(node, offset + bytes.size());
            std::memcpy(node.live.data() + offset, bytes.data(), bytes.size());
            note(node, offset, offset + bytes.size());
        }
        void resize(Node& node, std::uint64_t size) {
            const std::uint64_t old = node.live.size();
            node.live.resize(size);
            node.sizes.emplace_back(counts.operations, size);
            if (size < old) note(node, size, old);  // should it grow again, zeros are there
        }
        static void drop(Node& node, std::uint64_t sector) {
            const std::uint64_t begin = sector * kSector;
            if (begin >= node.live.size()) return;
            const Sector old = content(node.durable, sector);
            std::memcpy(node.live.data() + begin, old.data(), std::min(kSector, node.live.size() - begin));
        }
        void note(Node& node, std::uint64_t first, std::uint64_t last) {
            for (std::uint64_t sector = first / kSector; sector * kSector < last; ++sector) {
                node.dirty[sector].emplace_back(counts.operations, content(node.live, sector));
                node.unsure.erase(sector);
            }
        }
    };
    class OpenFile;
    class HeldLock;

    static std::uint64_t draw(std::uint64_t& state, std::uint64_t bound) {  // SplitMix64
        std::uint64_t z = (state += 0x9e3779b97f4a7c15ull);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return (z ^ (z >> 31)) % std::max<std::uint64_t>(bound, 1);
    }
    static Sector content(const std::vector<std::byte>& bytes, std::uint64_t sector) {
        Sector out{};
        const std::uint64_t begin = sector * kSector;
        if (begin < bytes.size())
            std::memcpy(out.data(), bytes.data() + begin, std::min(kSector, bytes.size() - begin));
        return out;
    }
    static std::string clean(std::string path) {
        while (path.starts_with("./")) path.erase(0, 2);
        while (path.size() > 1 && path.ends_with('/')) path.pop_back();
        return path == "." || path == "/" ? "" : path;
    }
    static std::string folder_of(const std::string& path) {
        const std::size_t slash = path.rfind('/');
        return slash == std::string::npos ? "" : path.substr(0, slash);
    }
    static bool is_folder(Disk& disk, const std::string& path) {
        const auto found = disk.names.find(path);
        return path.empty() || (found != disk.names.end() && found->second->is_folder);
    }
    static Error no_space(const std::string& path) {
        return {ErrorCode::FileWrite, text(path, ": cannot be written: No space left on device (the test says so)")};
    }
    static Error missing(const std::string& path) {
        return {ErrorCode::NotFound, text(path, ": No such file or directory")};
    }

    std::shared_ptr<Disk> disk_;
};

class FaultFiles::OpenFile final : public File {
public:
    OpenFile(std::string path, std::shared_ptr<Disk> disk, std::shared_ptr<Node> node, bool writable)
        : File(std::move(path)), disk_(std::move(disk)), node_(std::move(node)), writable_(writable) {}

    Result<std::size_t> read(std::uint64_t offset, std::span<std::byte> out) override {
        const std::lock_guard lock(disk_->mutex);
        ++disk_->counts.reads;
        disk_->counts.most_read_bytes = std::max<std::uint64_t>(disk_->counts.most_read_bytes, out.size());
        if (!disk_->unreadable.empty() && clean(path()) == disk_->unreadable)
            return Error{ErrorCode::FileRead, text(path(), ": cannot be read: Input/output error (the test says so)")};
        if (out.empty() || offset >= node_->live.size()) return std::size_t{0};
        const std::size_t count = std::min<std::uint64_t>(out.size(), node_->live.size() - offset);
        std::memcpy(out.data(), node_->live.data() + offset, count);
        disk_->counts.read_bytes += count;
        return count;
    }
    Result<void> write(std::uint64_t offset, std::span<const std::byte> bytes) override {
        TILTH_ASSERT(writable_, "a file opened for reading is written");
        const std::lock_guard lock(disk_->mutex);
        ++disk_->counts.writes;
        if (disk_->fails()) {
            if (disk_->takes_effect())
                disk_->write(*node_, offset, bytes);
            else if (!disk_->is_off)
                disk_->write(*node_, offset, bytes.first(disk_->next(bytes.size() + 1)));
            return no_space(path());
        }
        disk_->counts.written_bytes += bytes.size();
        disk_->write(*node_, offset, bytes);
        return {};
    }
    Result<void> sync() override {
        const std::lock_guard lock(disk_->mutex);
        ++disk_->counts.syncs;
        if (disk_->fails()) {
            disk_->takes_effect();  // the crash draws how much of it was
            if (!disk_->is_off)
                for (const auto& [sector, versions] : node_->dirty) {
                    node_->unsure.insert(sector);
                    if (disk_->drops_pages) disk_->drop(*node_, sector);
                }
            return no_space(path());
        }
        node_->durable.resize(node_->live.size());
        for (auto at = node_->dirty.begin(); at != node_->dirty.end();) {
            if (node_->unsure.contains(at->first)) {
                ++at;
                continue;
            }
            const std::uint64_t begin = at->first * kSector;
            const Sector now = content(node_->live, at->first);
            if (begin < node_->durable.size())
                std::memcpy(node_->durable.data() + begin, now.data(),
                            std::min(kSector, node_->durable.size() - begin));
            at = node_->dirty.erase(at);
        }
        node_->sizes.clear();
        return {};
    }
    Result<void> truncate(std::uint64_t size) override {
        TILTH_ASSERT(writable_, "a file opened for reading is truncated");
        const std::lock_guard lock(disk_->mutex);
        if (disk_->fails()) {
            if (disk_->takes_effect()) disk_->resize(*node_, size);
            return no_space(path());
        }
        disk_->resize(*node_, size);
        return {};
    }
    Result<std::uint64_t> size() override {
        const std::lock_guard lock(disk_->mutex);
        return std::uint64_t{node_->live.size()};
    }

private:
    std::shared_ptr<Disk> disk_;
    std::shared_ptr<Node> node_;
    bool writable_;
};

class FaultFiles::HeldLock final : public FileLock {
public:
    HeldLock(std::shared_ptr<Disk> disk, std::string path) : disk_(std::move(disk)), path_(std::move(path)) {}
    ~HeldLock() override {
        const std::lock_guard lock(disk_->mutex);
        disk_->locks.erase(path_);
    }

private:
    std::shared_ptr<Disk> disk_;
    std::string path_;
};

inline Result<std::unique_ptr<File>> FaultFiles::open(const std::string& path, OpenMode mode) {
    const std::string name = clean(path);
    const std::lock_guard lock(disk_->mutex);
    auto found = disk_->names.find(name);
    if (found == disk_->names.end()) {
        if (mode != OpenMode::Create || !is_folder(*disk_, folder_of(name))) return missing(path);
        const bool fails = disk_->fails();
        if (!fails || disk_->takes_effect())
            disk_->change_name({disk_->counts.operations, name, std::make_shared<Node>(), ""});
        if (fails) return no_space(path);
        found = disk_->names.find(name);
    }
    if (found->second->is_folder) return Error{ErrorCode::FileRead, text(path, ": Is a directory")};
    return std::unique_ptr<File>(std::make_unique<OpenFile>(path, disk_, found->second, mode != OpenMode::Read));
}

inline Result<void> FaultFiles::make_folder(const std::string& path) {
    const std::string name = clean(path);
    const std::lock_guard lock(disk_->mutex);
    if (is_folder(*disk_, name)) return {};
    if (!is_folder(*disk_, folder_of(name))) return missing(path);
    const bool fails = disk_->fails();
    auto node = std::make_shared<Node>();
    node->is_folder = true;
    if (!fails || disk_->takes_effect()) disk_->change_name({disk_->counts.operations, name, node, ""});
    if (fails) return no_space(path);
    return {};
}

inline Result<std::vector<std::string>> FaultFiles::list(const std::string& folder) {
    const std::string name = clean(folder);
    const std::lock_guard lock(disk_->mutex);
    if (!is_folder(*disk_, name)) return missing(folder);
    std::vector<std::string> found;
    for (const auto& [path, node] : disk_->names)
        if (!node->is_folder && folder_of(path) == name)
            found.push_back(path.substr(name.empty() ? 0 : name.size() + 1));
    return found;
}

inline Result<void> FaultFiles::rename(const std::string& from, const std::string& to) {
    const std::lock_guard lock(disk_->mutex);
    const auto found = disk_->names.find(clean(from));
    if (found == disk_->names.end() || !is_folder(*disk_, folder_of(clean(to)))) return missing(from);
    const NameChange change{disk_->counts.operations + 1, clean(to), found->second, clean(from)};
    const bool fails = disk_->fails();
    if (!fails || disk_->takes_effect()) disk_->change_name(change);
    if (fails) return no_space(to);
    return {};
}

inline Result<void> FaultFiles::remove(const std::string& path) {
    const std::lock_guard lock(disk_->mutex);
    if (!disk_->names.contains(clean(path))) return {};
    const bool fails = disk_->fails(false);
    if (!fails || disk_->takes_effect()) disk_->change_name({disk_->counts.operations, clean(path), nullptr, ""});
    if (fails) return no_space(path);
    return {};
}

inline Result<void> FaultFiles::sync_folder(const std::string& folder) {
    const std::string name = clean(folder);
    const std::lock_guard lock(disk_->mutex);
    if (!is_folder(*disk_, name)) return missing(folder);
    ++disk_->counts.folder_syncs;
    if (disk_->fails()) {
        disk_->takes_effect();
        return no_space(folder);
    }
    std::vector<NameChange> others;
    for (NameChange& change : disk_->changes) {
        if (folder_of(change.path) == name)
            Disk::apply(disk_->durable_names, change);
        else
            others.push_back(std::move(change));
    }
    disk_->changes = std::move(others);
    return {};
}

inline Result<std::unique_ptr<FileLock>> FaultFiles::lock(const std::string& path) {
    {
        Result<std::unique_ptr<File>> made = open(path, OpenMode::Create);
        if (!made) return made.error();
    }
    const std::lock_guard lock(disk_->mutex);
    if (!disk_->locks.insert(clean(path)).second)
        return Error{ErrorCode::Locked, text(path, ": is locked: the world is open elsewhere")};
    return std::unique_ptr<FileLock>(std::make_unique<HeldLock>(disk_, clean(path)));
}

inline std::unique_ptr<FaultFiles> FaultFiles::crash(std::uint64_t seed) const {
    const std::lock_guard lock(disk_->mutex);
    auto after = std::make_unique<FaultFiles>();
    std::uint64_t state = seed * 2 + 1;
    // 0: what was synced alone; 1: everything; 2: everything up to a moment; 3 and more: each for itself.
    const std::uint64_t mode = draw(state, 6);
    const std::uint64_t end = disk_->counts.operations + 1;
    const std::uint64_t moment = mode == 0 ? 0 : mode == 1 ? end : end - draw(state, std::min<std::uint64_t>(end, 8));
    const bool each_for_itself = mode >= 3;
    const bool rubbish = draw(state, 2) == 1;
    const auto happened = [&](std::uint64_t operation) {
        // What the moment itself falls into is torn.
        if (each_for_itself || (operation == moment && mode == 2)) return draw(state, 2) == 1;
        return operation <= moment;
    };

    Names names = disk_->durable_names;
    for (const NameChange& change : disk_->changes)
        if (happened(change.operation)) Disk::apply(names, change);

    std::map<const Node*, std::shared_ptr<Node>> copies;
    for (const auto& [path, node] : names) {
        const std::string folder = folder_of(path);
        if (!folder.empty() && !after->disk_->names.contains(folder)) continue;  // it went with its folder
        std::shared_ptr<Node>& copy = copies[node.get()];
        if (copy == nullptr) {
            copy = std::make_shared<Node>();
            copy->is_folder = node->is_folder;
            std::uint64_t size = node->durable.size();
            for (const auto& [operation, later] : node->sizes)
                if (happened(operation)) size = later;
            copy->live = node->durable;
            copy->live.resize(size);
            if (rubbish)
                for (std::uint64_t i = node->durable.size(); i < size; ++i)
                    copy->live[i] = std::byte{static_cast<unsigned char>(draw(state, 256))};
            for (const auto& [sector, versions] : node->dirty) {
                std::optional<Sector> now;
                for (const auto& [operation, version] : versions)
                    if (happened(operation)) now = version;
                const std::uint64_t begin = sector * kSector;
                if (now && begin < size)
                    std::memcpy(copy->live.data() + begin, now->data(), std::min<std::uint64_t>(kSector, size - begin));
            }
            copy->durable = copy->live;
        }
        after->disk_->names[path] = copy;
    }
    after->disk_->durable_names = after->disk_->names;
    return after;
}

}  // namespace tilth::test
