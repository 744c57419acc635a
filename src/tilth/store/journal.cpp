#include "tilth/store/journal.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "tilth/core/log.h"
#include "tilth/store/journal_files.h"
#include "tilth/store/journal_recovery.h"

namespace tilth {
namespace {

using Bytes = std::vector<std::byte>;

/// How long the journal's thread waits before it tries again what failed: a full disk is not asked 200 times a second.
constexpr double kRetryMs = 250;
/// A buffer that grew larger is given back when it is empty.
constexpr std::size_t kKeptBytes = 1u << 20;

void empty(Bytes& bytes) {
    bytes.clear();
    if (bytes.capacity() > kKeptBytes) Bytes().swap(bytes);
}

}  // namespace

// Two locks, always taken in this order. `disk` is held while files are written, for as long as that takes; `state` for
// moments. What both guard is changed with both, and read with either.
//
//     append -> pending -> writing -> file        an entry leaves `writing` when it is durable there
struct Journal::Impl {
    JournalPlace place;
    FlushPolicy policy;

    std::mutex disk;
    std::unique_ptr<JournalWriter> writer;  // disk

    std::mutex state;
    std::condition_variable wake;
    Bytes pending;                         // state: appended since the last attempt
    Bytes writing;                         // both: entries `durable + 1` and on, of an attempt that runs or failed
    std::vector<JournalSegment> segments;  // state: the writer's, as of its last success
    std::uint64_t appended = 0, durable = 0;
    std::vector<Error> errors;
    bool is_failing = false, is_abandoned = false, is_stopping = false;
    std::thread thread;

    Result<void> flush();
    void flush_and_report();
    void run();
    void stop();
};

Result<void> Journal::Impl::flush() {
    const std::lock_guard disk_lock(disk);
    {
        const std::lock_guard lock(state);
        if (is_abandoned)
            return Error{ErrorCode::FileWrite, text(place.folder, ": the journal was abandoned; open the world again")};
        if (writing.empty()) {
            std::swap(writing, pending);
        } else {
            writing.insert(writing.end(), pending.begin(), pending.end());
            empty(pending);
        }
        if (writing.empty()) return {};
    }
    Result<void> written = writer->write(durable + 1, writing);
    const std::lock_guard lock(state);
    is_failing = !written.ok();
    segments = writer->segments();
    if (!written) return written;
    durable += writing.size() / kJournalEntryBytes;
    empty(writing);
    return {};
}

void Journal::Impl::flush_and_report() {
    bool was_failing = false;
    {
        const std::lock_guard lock(state);
        was_failing = is_failing;
    }
    Result<void> flushed = flush();
    if (flushed || was_failing) return;
    const std::lock_guard lock(state);
    if (!is_abandoned) errors.push_back(flushed.error());
}

void Journal::Impl::run() {
    std::unique_lock lock(state);
    while (true) {
        wake.wait(lock, [&] { return is_stopping || appended > durable; });
        const double wait_ms = is_failing ? std::max(policy.interval_ms, kRetryMs) : policy.interval_ms;
        wake.wait_for(lock, std::chrono::duration<double, std::milli>(wait_ms), [&] { return is_stopping; });
        if (is_stopping) return;
        lock.unlock();
        flush_and_report();
        lock.lock();
    }
}

void Journal::Impl::stop() {
    const std::lock_guard lock(state);
    is_stopping = true;
    wake.notify_all();
}

Journal::Journal(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Result<std::unique_ptr<Journal>> Journal::open(FileSystem& files, std::string folder, std::uint64_t salt,
                                               std::uint64_t from, const FlushPolicy& policy, JournalReport& report,
                                               std::vector<Edit>& tail) {
    if (!(policy.interval_ms >= 0.1 && policy.interval_ms <= 60'000))
        return Error{ErrorCode::InvalidArgument, text("interval_ms: ", policy.interval_ms, " is not in 0.1..60000")};
    auto impl = std::make_unique<Impl>();
    impl->place = {.files = &files, .folder = std::move(folder), .salt = salt};
    impl->policy = policy;
    Result<RecoveredJournal> recovered = recover_journal(impl->place, from, report, tail);
    if (!recovered) return recovered.error();
    impl->appended = impl->durable = recovered->last;
    impl->segments = recovered->segments;
    impl->writer =
        std::make_unique<JournalWriter>(impl->place, std::move(recovered->segments), std::move(recovered->tail));
    if (policy.when == FlushPolicy::When::Every) impl->thread = std::thread(&Impl::run, impl.get());
    return std::unique_ptr<Journal>(new Journal(std::move(impl)));
}

Journal::~Journal() {
    impl_->stop();
    if (impl_->thread.joinable()) impl_->thread.join();
    if (impl_->is_abandoned) return;
    if (const Result<void> flushed = impl_->flush(); !flushed)
        log(LogLevel::Error, text(flushed.error().message, "; edits ", impl_->durable + 1, " to ", impl_->appended,
                                  " are lost: the journal was closed before there was room"));
}

std::uint64_t Journal::append(const Edit& edit) {
    Impl& impl = *impl_;
    std::uint64_t number = 0;
    {
        const std::lock_guard lock(impl.state);
        number = ++impl.appended;
        if (impl.is_abandoned) return number;
        const JournalBytes entry = encode_entry(edit, number, impl.place.salt);
        impl.pending.insert(impl.pending.end(), entry.begin(), entry.end());
        if (number == impl.durable + 1) impl.wake.notify_one();  // else the thread knows already
    }
    if (impl.policy.when == FlushPolicy::When::Each) impl.flush_and_report();
    return number;
}

Result<void> Journal::flush() { return impl_->flush(); }

std::uint64_t Journal::appended() const {
    const std::lock_guard lock(impl_->state);
    return impl_->appended;
}

std::uint64_t Journal::durable() const {
    const std::lock_guard lock(impl_->state);
    return impl_->durable;
}

std::vector<Error> Journal::take_errors() {
    const std::lock_guard lock(impl_->state);
    return std::exchange(impl_->errors, {});
}

Result<void> Journal::release(std::uint64_t number, std::uint64_t keep_bytes) {
    const std::lock_guard disk_lock(impl_->disk);
    {
        const std::lock_guard lock(impl_->state);
        if (impl_->is_abandoned) return {};
        number = std::min(number, impl_->durable);
    }
    Result<void> released = impl_->writer->release(number, keep_bytes);
    const std::lock_guard lock(impl_->state);
    impl_->segments = impl_->writer->segments();
    return released;
}

std::uint64_t Journal::first() const {
    const std::lock_guard lock(impl_->state);
    std::uint64_t first = impl_->durable + 1;
    for (auto segment = impl_->segments.rbegin(); segment != impl_->segments.rend(); ++segment) {
        if (segment->end() != first) break;
        first = segment->first;
    }
    return first;
}

Result<std::vector<Edit>> Journal::read(std::uint64_t first, std::uint64_t last) {
    std::vector<JournalSegment> segments;
    Bytes unflushed;
    std::uint64_t durable = 0;
    {
        const std::lock_guard lock(impl_->state);
        if (first < 1 || first > last || last > impl_->appended)
            return Error{ErrorCode::InvalidArgument,
                         text("edits ", first, " to ", last, " are not in 1..", impl_->appended)};
        durable = impl_->durable;
        segments = impl_->segments;
        if (last > durable && !impl_->is_abandoned)
            for (const Bytes* buffer : {&impl_->writing, &impl_->pending})
                unflushed.insert(unflushed.end(), buffer->begin(), buffer->end());
    }
    const JournalPlace& place = impl_->place;
    std::vector<Edit> edits;
    std::uint64_t next = first;
    for (const JournalSegment& segment : segments) {
        if (next < segment.first) break;
        if (next >= segment.end() || next > last) continue;
        const std::string path = place.path(segment.first);
        Result<std::unique_ptr<File>> file = place.files->open(path, OpenMode::Read);
        if (!file) return file.error();
        EntryReader reader(**file, segment.first, place.salt);
        for (; next <= last && next < segment.end(); ++next) {
            const Result<std::optional<Edit>> edit = reader.at(next);
            if (!edit) return edit.error();
            if (!*edit)
                return Error{ErrorCode::FileFormat, text(path, ": offset ", offset_of_entry(segment.first, next),
                                                         ": edit ", next, " is damaged")};
            edits.push_back(**edit);
        }
    }
    for (; next <= last && next > durable; ++next) {
        const std::size_t at = (next - durable - 1) * kJournalEntryBytes;
        if (at + kJournalEntryBytes > unflushed.size()) break;  // abandoned
        const std::span<const std::byte> bytes = unflushed;
        edits.push_back(*decode_entry(bytes.subspan(at).first<kJournalEntryBytes>(), next, place.salt));
    }
    if (next <= last)
        return Error{ErrorCode::NotFound,
                     text(place.folder, ": edit ", next, " is not in the journal any more; it was released or lost")};
    return edits;
}

std::uint64_t Journal::disk_bytes() const {
    const std::lock_guard lock(impl_->state);
    std::uint64_t bytes = 0;
    for (const JournalSegment& segment : impl_->segments) bytes += segment.bytes();
    return bytes;
}

void Journal::abandon() {
    impl_->stop();
    const std::lock_guard disk_lock(impl_->disk);
    const std::lock_guard lock(impl_->state);
    impl_->is_abandoned = true;
    Bytes().swap(impl_->pending);
    Bytes().swap(impl_->writing);
}

}  // namespace tilth
