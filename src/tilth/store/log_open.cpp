#include "tilth/store/log_open.h"

#include <algorithm>
#include <tuple>

namespace tilth {

using namespace log_format;

namespace {

/// The newest commit; of equal ones, which differ in nothing, the file that is in better order, then the newer.
bool is_better(const OpenedLog& a, const OpenedLog& b) {
    const auto rank = [](const OpenedLog& log) {
        return std::tuple(!log.found.is_wreck, log.found.commit.generation, !log.found.was_scanned,
                          log.log->tag().number);
    };
    return rank(a) > rank(b);
}

Result<std::vector<OpenedLog>> read_all(FileSystem& files, const std::string& folder, std::uint64_t salt,
                                        const std::vector<std::string>& names) {
    std::vector<OpenedLog> logs;
    for (const std::string& name : names) {
        const std::optional<std::uint64_t> number = number_of(name);
        if (!number) continue;
        Result<std::unique_ptr<LogFile>> log = LogFile::open(files, folder, {salt, *number});
        if (!log) return log.error();
        Result<RecoveredLog> found = recover_log(**log);
        if (!found) return found.error();
        logs.push_back({*std::move(log), *std::move(found)});
    }
    std::ranges::sort(logs, is_better);
    return logs;
}

/// It does not count, but it is not ours to destroy: nothing can be made of it, or the one that counts is damaged.
Result<void> put_aside(FileSystem& files, const OpenedLog& other, LogStoreReport& report) {
    const std::string& path = other.log->path();
    std::string aside = path + ".damaged";
    for (int i = 2; files.exists(aside); ++i) aside = text(path, ".damaged", i);
    if (Result<void> done = files.rename(path, aside); !done) return done;
    report.damage.insert(report.damage.end(), other.found.damage.begin(), other.found.damage.end());
    const char* why = other.found.is_wreck ? ": at byte 0: no commit can be found in it; it is put aside as "
                                           : ": at byte 0: is older than a file that is damaged; it is put aside as ";
    report.damage.push_back({ErrorCode::FileFormat, text(path, why, aside)});
    report.may_miss_blobs |= other.found.is_wreck;
    return {};
}

Result<void> clear_away(FileSystem& files, const std::string& folder, const std::vector<std::string>& names,
                        const std::vector<OpenedLog>& logs, std::size_t first, LogStoreReport& report) {
    bool is_changed = false;
    const bool is_damaged =
        first == 1 && (logs[0].found.is_past_damage || logs[0].found.is_restored || logs[0].found.may_miss_blobs);
    for (std::size_t i = first; i < logs.size(); ++i) {
        const RecoveredLog& found = logs[i].found;
        const bool is_kept = found.is_wreck || (is_damaged && found.commit.generation != 0);
        Result<void> done = is_kept ? put_aside(files, logs[i], report) : files.remove(logs[i].log->path());
        if (!done) return done;
        is_changed = true;
    }
    for (const std::string& name : names) {
        if (!name.ends_with(kReplacementEnding)) continue;
        if (!number_of(name.substr(0, name.size() - std::string_view(kReplacementEnding).size()))) continue;
        (void)files.remove(folder + "/" + name);  // the rest of a crash; it costs space alone
        is_changed = true;
    }
    if (is_changed) return files.sync_folder(folder);
    return {};
}

/// What was read may be in the system's memory alone, after a crash of the process or a sync that failed: made durable
/// before anybody relies on it. A superblock that points behind the end of a file that was cut short must go before the
/// file grows again; and one that is damaged leaves the commit to be found by its index, until it is written.
Result<void> settle(OpenedLog& opened) {
    RecoveredLog& found = opened.found;
    if (found.commit.generation == 0) return opened.log->sync();
    if (found.is_restored) found.commit.generation = ++found.generation;
    if (found.is_restored || found.is_other_damaged) {
        if (Result<void> done = opened.log->write_superblock(found.commit, found.slot ^ 1); !done) return done;
    }
    return opened.log->write_superblock(found.commit, found.slot);
}

}  // namespace

Result<OpenedLog> open_log(FileSystem& files, const std::string& folder, std::uint64_t salt, LogStoreReport& report) {
    report = {};
    const Result<std::vector<std::string>> names = files.list(folder);
    if (!names) return names.error();
    Result<std::vector<OpenedLog>> logs = read_all(files, folder, salt, *names);
    if (!logs) return logs.error();

    // Before anything is removed: the names that were found may not be durable yet.
    if (Result<void> done = files.sync_folder(folder); !done) return done.error();

    const bool is_new = logs->empty() || logs->front().found.is_wreck;
    if (Result<void> done = clear_away(files, folder, *names, *logs, is_new ? 0 : 1, report); !done)
        return done.error();
    if (is_new) {
        std::uint64_t number = 0;
        for (const OpenedLog& log : *logs) number = std::max(number, log.log->tag().number);
        Result<std::unique_ptr<LogFile>> log = LogFile::create(files, folder, {salt, number + 1});
        if (!log) return log.error();
        return OpenedLog{*std::move(log), {}};
    }

    OpenedLog opened = std::move(logs->front());
    const RecoveredLog& found = opened.found;
    report.damage.insert(report.damage.end(), found.damage.begin(), found.damage.end());
    report.was_scanned = found.was_scanned;
    report.may_miss_blobs |= found.may_miss_blobs;
    report.truncated_bytes = opened.log->end() - std::min(opened.log->end(), found.commit.end);
    if (report.truncated_bytes != 0)
        if (Result<void> done = opened.log->cut(found.commit.end); !done) return done.error();
    if (Result<void> done = settle(opened); !done) return done.error();
    return opened;
}

}  // namespace tilth
