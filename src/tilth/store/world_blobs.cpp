#include "tilth/store/world_blobs.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "tilth/store/page_codec.h"

namespace tilth {
namespace {

constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kRecordBytes = sizeof(StampRecord);  // a record's bytes are its members, in their order
constexpr std::size_t kWaitingBytes = kRecordBytes + 16;
// A part of a stroke is closed when it has this much: far below the 64 MiB that a blob may have.
constexpr std::size_t kPartBytes = 8u << 20;
constexpr std::size_t kPartRecords = kPartBytes / kRecordBytes;
static_assert(std::is_trivially_copyable_v<StampRecord>);

class Writer {
public:
    template <class T>
    void put(T value) {
        static_assert(std::is_integral_v<T>);
        raw(std::as_bytes(std::span(&value, 1)));
    }
    void raw(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
    void sized(std::span<const std::byte> bytes) {
        put(static_cast<std::uint32_t>(bytes.size()));
        raw(bytes);
    }
    [[nodiscard]] std::size_t size() const { return bytes_.size(); }
    [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }
    std::vector<std::byte> take() { return std::move(bytes_); }

private:
    std::vector<std::byte> bytes_;
};

/// Reads what is there; behind the end it gives zeros and remembers.
class Reader {
public:
    explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

    template <class T>
    T get() {
        T value{};
        static_assert(std::is_trivially_copyable_v<T>);
        if (const std::span<const std::byte> found = take(sizeof value); !found.empty())
            std::memcpy(&value, found.data(), sizeof value);
        return value;
    }
    std::span<const std::byte> take(std::size_t size) {
        if (size > bytes_.size()) {
            failed_ = true;
            bytes_ = {};
            return {};
        }
        const std::span<const std::byte> found = bytes_.first(size);
        bytes_ = bytes_.subspan(size);
        return found;
    }
    std::span<const std::byte> sized() { return take(get<std::uint32_t>()); }
    [[nodiscard]] std::size_t left() const { return bytes_.size(); }
    [[nodiscard]] bool failed() const { return failed_; }
    /// Everything was there, and nothing else.
    [[nodiscard]] bool is_complete() const { return !failed_ && bytes_.empty(); }

private:
    std::span<const std::byte> bytes_;
    bool failed_ = false;
};

Error damaged(std::string_view where, std::string_view what) {
    return {ErrorCode::FileFormat, text(where, ": ", what)};
}

Result<void> check_version(std::uint32_t version, std::string_view where) {
    if (version == kVersion) return {};
    return damaged(where, text("is of version ", version, ", which this build does not know (it knows ", kVersion,
                               "); open the world with a newer one"));
}

/// What is written as `encode_records`, a version in front.
std::vector<std::byte> enveloped(std::span<const std::byte> content, std::size_t stride) {
    Writer out;
    out.put(kVersion);
    out.put(std::uint32_t{0});
    out.raw(encode_records(content, stride));
    return out.take();
}

Result<std::vector<std::byte>> unwrapped(std::span<const std::byte> bytes, std::string_view where) {
    Reader in(bytes);
    const auto version = in.get<std::uint32_t>();
    const auto zero = in.get<std::uint32_t>();
    if (in.failed()) return damaged(where, "is too short");
    if (const Result<void> known = check_version(version, where); !known) return known.error();
    if (zero != 0) return damaged(where, "is damaged: its header has bits that mean nothing");
    return decode_records(in.take(in.left()), kMostRawBytes, where);
}

/// A record whose small members mean something; everything else `Ground::accept` checks.
bool is_plausible(const StampRecord& record) {
    return record.map <= MapKind::Detail && record.rule <= StampRule::Smooth && record.negative <= 1 &&
           record.mirror <= 1 && record.reserved == 0;
}

std::span<const std::byte> bytes_of(std::span<const StampRecord> records) { return std::as_bytes(records); }

}  // namespace

Result<std::optional<std::vector<std::byte>>> get_blob(BlobStore& blobs, BlobKey key) {
    auto blob = blobs.get(key);
    return !blob && blob.error().code == ErrorCode::FileRead ? blobs.get(key) : blob;
}

// ---------------------------------------------------------------------------------------------------- counters

std::vector<std::byte> encode_counters(const WorldCounters& counters) {
    Writer out;
    out.put(counters.next_sequence);
    out.put(counters.next_stroke);
    out.put(std::uint64_t{counters.done.size()});
    out.put(std::uint64_t{counters.undone.size()});
    for (const std::vector<std::uint64_t>* list : {&counters.done, &counters.undone})
        for (const std::uint64_t number : *list) out.put(number);
    return enveloped(out.bytes(), sizeof(std::uint64_t));
}

Result<WorldCounters> decode_counters(std::span<const std::byte> bytes, std::string_view where) {
    const auto content = unwrapped(bytes, where);
    if (!content) return content.error();
    Reader in(*content);
    WorldCounters counters{.next_sequence = in.get<std::uint64_t>(), .next_stroke = in.get<std::uint64_t>()};
    const auto done = in.get<std::uint64_t>(), undone = in.get<std::uint64_t>();
    const std::uint64_t numbers = in.left() / sizeof(std::uint64_t);
    if (done > numbers || undone != numbers - done) return damaged(where, "is damaged: its lists are not its length");
    for (std::uint64_t i = 0; i < done; ++i) counters.done.push_back(in.get<std::uint64_t>());
    for (std::uint64_t i = 0; i < undone; ++i) counters.undone.push_back(in.get<std::uint64_t>());
    const auto is_number = [&](std::uint64_t number) { return number > 0 && number < counters.next_stroke; };
    if (!in.is_complete() || counters.next_stroke > kMostStrokeNumber + 1 ||
        !std::ranges::all_of(counters.done, is_number) || !std::ranges::all_of(counters.undone, is_number) ||
        !std::ranges::is_sorted(counters.done, std::ranges::less_equal{}) ||
        !std::ranges::is_sorted(counters.undone, std::ranges::greater_equal{}))
        return damaged(where, "is damaged: its lists of strokes are not in order");
    return counters;
}

// ---------------------------------------------------------------------------------------------------- waiting stamps

std::vector<std::byte> encode_waiting(std::span<const WaitingStamp> stamps) {
    Writer out;
    for (const WaitingStamp& stamp : stamps) {
        out.raw(bytes_of({&stamp.record, 1}));
        out.put(stamp.stroke);
        out.put(stamp.position);
        out.put(std::uint32_t{0});
    }
    return enveloped(out.bytes(), kWaitingBytes);
}

Result<std::vector<WaitingStamp>> decode_waiting(std::span<const std::byte> bytes, std::string_view where) {
    const auto content = unwrapped(bytes, where);
    if (!content) return content.error();
    if (content->size() % kWaitingBytes != 0) return damaged(where, "is damaged: not a whole number of stamps");
    Reader in(*content);
    std::vector<WaitingStamp> stamps(content->size() / kWaitingBytes);
    for (WaitingStamp& stamp : stamps) {
        stamp.record = in.get<StampRecord>();
        stamp.stroke = in.get<std::uint64_t>();
        stamp.position = in.get<std::uint32_t>();
        // What reads its neighbours never waits for one tile alone.
        if (in.get<std::uint32_t>() != 0 || !is_plausible(stamp.record) || stamp.record.map != MapKind::Detail ||
            stamp.record.rule == StampRule::Smooth)
            return damaged(where, "is damaged: a stamp in it makes no sense");
    }
    return stamps;
}

// ---------------------------------------------------------------------------------------------------- strokes

namespace {

struct PartHeader {
    std::uint32_t version = kVersion;
    std::uint32_t part = 0, parts = 0;  ///< `parts` in each, so that a missing one is noticed
    std::uint32_t images = 0;           ///< in this part
    std::uint64_t number = 0;           ///< of the stroke
    std::uint64_t changes = 0;          ///< `Stroke::version`
};
static_assert(sizeof(PartHeader) == 32 && std::is_trivially_copyable_v<PartHeader>);

/// The stroke's images, one after the other, and how many of its records are still to be written.
class PartsWriter {
public:
    PartsWriter(const Stroke& stroke, HeightPrecision precision) : stroke_(stroke), precision_(precision) {}

    std::vector<std::vector<std::byte>> run() {
        for (std::size_t first = 0; first < stroke_.records.size() || first == 0; first += kPartRecords) {
            const auto all = std::span<const StampRecord>(stroke_.records);
            const auto piece = all.subspan(first, std::min(kPartRecords, all.size() - first));
            if (first > 0) close();
            begin(piece);
        }
        for (const MapKind map : {MapKind::Coarse, MapKind::Detail})
            for (const auto& [page, codes] : stroke_.images(map)) add(map, page, codes.get());
        close();
        for (std::uint32_t i = 0; i < parts_.size(); ++i) {
            headers_[i].part = i;
            headers_[i].parts = static_cast<std::uint32_t>(parts_.size());
            std::memcpy(parts_[i].data(), &headers_[i], sizeof(PartHeader));
        }
        return std::move(parts_);
    }

private:
    void begin(std::span<const StampRecord> records) {
        header_ = {.number = stroke_.number, .changes = stroke_.version};
        out_ = {};
        out_.raw(std::as_bytes(std::span(&header_, 1)));  // written again when everything is known
        out_.sized(encode_records(bytes_of(records), kRecordBytes));
    }
    void add(MapKind map, PageIndex page, const PageCodes* codes) {
        if (out_.size() > kPartBytes) {
            close();
            begin({});
        }
        out_.put(static_cast<std::uint32_t>(map));
        out_.put(page.x);
        out_.put(page.z);
        out_.sized(codes == nullptr ? std::vector<std::byte>() : encode_page(*codes, precision_));
        ++header_.images;
    }
    void close() {
        headers_.push_back(header_);
        parts_.push_back(out_.take());
    }

    const Stroke& stroke_;
    HeightPrecision precision_;
    PartHeader header_;
    Writer out_;
    std::vector<PartHeader> headers_;
    std::vector<std::vector<std::byte>> parts_;
};

Result<PartHeader> header_of(Reader& in, std::string_view where) {
    const auto header = in.get<PartHeader>();
    if (in.failed()) return damaged(where, "is too short");
    if (const Result<void> known = check_version(header.version, where); !known) return known.error();
    if (header.part >= header.parts || header.parts > kMostStrokeParts)
        return damaged(where, "is damaged: its parts are not in order");
    return header;
}

Result<void> decode_part(std::span<const std::byte> bytes, std::uint32_t part, std::uint32_t parts, Stroke& stroke,
                         std::string_view where) {
    Reader in(bytes);
    const auto header = header_of(in, where);
    if (!header) return header.error();
    if (header->part != part || header->parts != parts || header->number != stroke.number)
        return damaged(where, "is damaged: its parts do not belong together");
    stroke.version = header->changes;

    const auto records = decode_records(in.sized(), kMostRawBytes, where);
    if (!records) return records.error();
    if (records->size() % kRecordBytes != 0) return damaged(where, "is damaged: not a whole number of stamps");
    Reader stamps(*records);
    while (stamps.left() > 0) {
        const auto record = stamps.get<StampRecord>();
        if (!is_plausible(record)) return damaged(where, "is damaged: a stamp in it makes no sense");
        stroke.records.push_back(record);
    }
    for (std::uint32_t i = 0; i < header->images; ++i) {
        const auto map = in.get<std::uint32_t>();
        const PageIndex page{in.get<std::int32_t>(), in.get<std::int32_t>()};
        const std::span<const std::byte> blob = in.sized();
        if (in.failed() || map > 1 || (map == 0 && blob.empty()))
            return damaged(where, "is damaged: its images end early");
        std::shared_ptr<const PageCodes> codes;
        if (!blob.empty()) {
            auto decoded = decode_page(blob, where);
            if (!decoded) return decoded.error();
            codes = std::move(*decoded);
        }
        stroke.images(static_cast<MapKind>(map))[page] = std::move(codes);
    }
    if (!in.is_complete()) return damaged(where, "is damaged: there are bytes behind its end");
    return {};
}

}  // namespace

std::vector<std::vector<std::byte>> encode_stroke(const Stroke& stroke, HeightPrecision precision) {
    return PartsWriter(stroke, precision).run();
}

Result<std::uint32_t> parts_of_stroke(std::span<const std::byte> first_part, std::string_view where) {
    Reader in(first_part);
    const auto header = header_of(in, where);
    if (!header) return header.error();
    return header->parts;
}

Result<StrokePtr> decode_stroke(std::span<const std::vector<std::byte>> parts, std::uint64_t number,
                                std::string_view where) {
    auto stroke = std::make_shared<Stroke>();
    stroke->number = number;
    for (std::uint32_t i = 0; i < parts.size(); ++i) {
        const Result<void> decoded = decode_part(parts[i], i, static_cast<std::uint32_t>(parts.size()), *stroke, where);
        if (!decoded) return decoded.error();
    }
    if (parts.empty() || stroke->records.empty()) return damaged(where, "is damaged: a stroke without stamps");
    return stroke;
}

}  // namespace tilth
