// Which filter before zstd, and which level? Every candidate on the same pages, in turn, page by page set; the row of
// `encode_page` is what the library does (with its checksum, which the candidates lack). The floor is a copy of the
// page.
#include <zstd.h>

#include <array>
#include <cstring>
#include <map>

#include "store/sample_pages.h"
#include "store/store_timing.h"
#include "tilth/core/hash.h"
#include "tilth/store/page_codec.h"

namespace tilth::bench {
namespace {

constexpr std::size_t kPages = 64;
constexpr int kRounds = 15;
constexpr auto kN = static_cast<std::size_t>(kPageTexels);
constexpr std::size_t kTexels = kN * kN;
constexpr std::size_t kPageBytes = sizeof(PageCodes);

enum class Predict { None, Row, Column, Gradient };

/// What is taken from each code before its bytes are sorted into planes.
struct Filter {
    const char* name;
    Predict predict = Predict::None;
    bool zigzag = false;    ///< small negative differences get small bytes
    std::size_t plane = 1;  ///< bytes of a plane: 1, 2, or 4 for none
};

void predict_to(const PageCodes& codes, Predict predict, PageCodes& out) {
    for (std::size_t z = 0; z < kN; ++z) {
        std::array<std::uint32_t, kN + 1> down{};  // one before the row is zero
        for (std::size_t x = 0; x < kN; ++x) {
            const bool vertical = z > 0 && (predict == Predict::Column || predict == Predict::Gradient);
            down[x + 1] = codes[z * kN + x] - (vertical ? codes[(z - 1) * kN + x] : 0);
        }
        if (predict == Predict::Row && z > 0) down[0] = codes[(z - 1) * kN];
        const bool horizontal = predict == Predict::Row || predict == Predict::Gradient;
        for (std::size_t x = 0; x < kN; ++x) out[z * kN + x] = down[x + 1] - (horizontal ? down[x] : 0);
    }
}

void predict_back(PageCodes& codes, Predict predict) {
    for (std::size_t z = 0; z < kN; ++z) {
        std::uint32_t* row = codes.data() + z * kN;
        if (predict == Predict::Row && z > 0) row[0] += codes[(z - 1) * kN];
        if (predict == Predict::Row || predict == Predict::Gradient)
            for (std::size_t x = 1; x < kN; ++x) row[x] += row[x - 1];
        if (z > 0 && (predict == Predict::Column || predict == Predict::Gradient))
            for (std::size_t x = 0; x < kN; ++x) row[x] += row[x - kN];
    }
}

template <std::size_t kBytes>
void spread(const PageCodes& words, std::size_t kept, std::byte* out) {
    for (std::size_t b = 0; b < kept; b += kBytes)
        for (std::size_t i = 0; i < kTexels; ++i) {
            const std::uint32_t part = words[i] >> (8 * b);
            std::memcpy(out + b * kTexels + i * kBytes, &part, kBytes);
        }
}

template <std::size_t kBytes>
void gather(const std::byte* in, std::size_t kept, PageCodes& words) {
    words.fill(0);
    for (std::size_t b = 0; b < kept; b += kBytes)
        for (std::size_t i = 0; i < kTexels; ++i) {
            std::uint32_t part = 0;
            std::memcpy(&part, in + b * kTexels + i * kBytes, kBytes);
            words[i] |= part << (8 * b);
        }
}

/// `kept`: bytes of a code, from the top; 2 with bits16.
void filter(const PageCodes& codes, const Filter& f, std::size_t kept, std::byte* out) {
    PageCodes words;
    predict_to(codes, f.predict, words);
    const unsigned unused = kept == 2 ? 16 : 0;  // differences of multiples of 2^16 are such too
    if (f.zigzag)
        for (std::uint32_t& word : words) word = (word << 1) ^ (((0 - (word >> 31)) >> unused) << unused);
    if (unused != 0)
        for (std::uint32_t& word : words) word >>= unused;
    switch (std::min(f.plane, kept)) {
        case 1:
            return spread<1>(words, kept, out);
        case 2:
            return spread<2>(words, kept, out);
        default:
            return spread<4>(words, kept, out);
    }
}

void unfilter(const std::byte* in, const Filter& f, std::size_t kept, PageCodes& codes) {
    switch (std::min(f.plane, kept)) {
        case 1:
            gather<1>(in, kept, codes);
            break;
        case 2:
            gather<2>(in, kept, codes);
            break;
        default:
            gather<4>(in, kept, codes);
    }
    if (f.zigzag)
        for (std::uint32_t& word : codes) word = (word >> 1) ^ (0 - (word & 1));
    if (kept == 2)
        for (std::uint32_t& word : codes) word <<= 16;
    predict_back(codes, f.predict);
}

constexpr Filter kFilters[] = {
    {"words", Predict::None, false, 4},
    {"halves", Predict::None, false, 2},
    {"bytes", Predict::None, false, 1},
    {"row+bytes", Predict::Row, false, 1},
    {"column+bytes", Predict::Column, false, 1},
    {"gradient+bytes", Predict::Gradient, false, 1},
    {"row+zigzag+bytes", Predict::Row, true, 1},
    {"column+zigzag+bytes", Predict::Column, true, 1},
    {"gradient+zigzag+bytes", Predict::Gradient, true, 1},
    {"gradient+zigzag+halves", Predict::Gradient, true, 2},
};
constexpr int kLevels[] = {1, 3};
constexpr std::size_t kCandidates = std::size(kFilters) * std::size(kLevels) + 1;  // the last is the library's own

struct Measured {
    std::array<Timed, kCandidates> encode, decode;
    std::array<double, kCandidates> bytes{};
    std::array<std::vector<double>, kCandidates> sizes;
    Timed copy;
    std::uint64_t hash = 0;
};

/// A candidate without what the library adds.
class Candidates {
public:
    Candidates() : compress_(ZSTD_createCCtx()), expand_(ZSTD_createDCtx()) {}
    ~Candidates() { ZSTD_freeCCtx(compress_), ZSTD_freeDCtx(expand_); }
    Candidates(const Candidates&) = delete;
    Candidates& operator=(const Candidates&) = delete;

    std::vector<std::byte> encode(const PageCodes& codes, const Filter& f, int level, std::size_t kept) {
        filter(codes, f, kept, planes_.data());
        std::vector<std::byte> out(ZSTD_compressBound(kTexels * kept));
        out.resize(ZSTD_compressCCtx(compress_, out.data(), out.size(), planes_.data(), kTexels * kept, level));
        return out;
    }
    void decode(std::span<const std::byte> bytes, const Filter& f, std::size_t kept, PageCodes& codes) {
        ZSTD_decompressDCtx(expand_, planes_.data(), planes_.size(), bytes.data(), bytes.size());
        unfilter(planes_.data(), f, kept, codes);
    }

private:
    ZSTD_CCtx* compress_;
    ZSTD_DCtx* expand_;
    std::array<std::byte, kPageBytes> planes_{};
};

Measured measure(SampleKind kind, HeightPrecision precision) {
    const std::vector<Page> pages = sample_pages(kind, precision, kPages);
    const std::size_t kept = precision == HeightPrecision::bits16 ? 2 : 4;
    Candidates candidates;
    Measured measured;
    PageCodes codes;
    for (int round = 0; round < kRounds; ++round)
        for (std::size_t c = 0; c < kCandidates; ++c) {
            const bool own = c + 1 == kCandidates;
            const Filter& f = kFilters[own ? 0 : c / std::size(kLevels)];
            const int level = kLevels[c % std::size(kLevels)];
            std::vector<std::vector<std::byte>> blobs(pages.size());
            std::uint64_t wrong = 0;
            const auto encode = [&] {
                for (std::size_t i = 0; i < pages.size(); ++i)
                    blobs[i] = own ? encode_page(*pages[i].codes, precision)
                                   : candidates.encode(*pages[i].codes, f, level, kept);
            };
            const auto decode = [&] {
                for (const std::vector<std::byte>& blob : blobs) {
                    if (own)
                        codes = *value(decode_page(blob, "page"));
                    else
                        candidates.decode(blob, f, kept, codes);
                    benchmark::DoNotOptimize(codes.data());
                }
            };
            measured.encode[c].run(encode);
            measured.decode[c].run(decode);
            if (round > 0) continue;
            for (std::size_t i = 0; i < pages.size(); ++i) {
                measured.bytes[c] += static_cast<double>(blobs[i].size()) / static_cast<double>(pages.size());
                if (!own) candidates.decode(blobs[i], f, kept, codes);
                if (own) codes = *value(decode_page(blobs[i], "page"));
                wrong += codes != *pages[i].codes;
            }
            if (wrong > 0)
                std::fprintf(stderr, "tilth-bench: candidate %zu: %llu pages came back as others\n", c,
                             static_cast<unsigned long long>(wrong)),
                    std::exit(1);
        }
    for (int round = 0; round < kRounds; ++round)
        measured.copy.run([&] {
            for (const Page& page : pages) {
                codes = *page.codes;
                benchmark::DoNotOptimize(codes.data());
                benchmark::ClobberMemory();
            }
        });
    StateHasher hasher;
    for (const Page& page : pages) hasher.add_u32(*page.codes);
    measured.hash = hasher.digest();
    return measured;
}

const Measured& measured(SampleKind kind, HeightPrecision precision) {
    static std::map<std::pair<SampleKind, HeightPrecision>, Measured> all;
    const auto key = std::pair(kind, precision);
    if (!all.contains(key)) all[key] = measure(kind, precision);
    return all[key];
}

void codec(benchmark::State& state, std::size_t c, HeightPrecision precision) {
    const auto kind = static_cast<SampleKind>(state.range(0));
    const Measured& all = measured(kind, precision);
    for (auto _ : state) state.SetIterationTime(all.encode[c].cpu().p50 / 1e3);
    const double us = 1e3 / static_cast<double>(kPages),
                 raw = precision == HeightPrecision::bits16 ? kPageBytes / 2.0 : kPageBytes;
    state.counters["bytes_per_page"] = all.bytes[c];
    state.counters["times_smaller"] = raw / all.bytes[c];
    state.counters["encode_p50_us"] = all.encode[c].cpu().p50 * us;
    state.counters["encode_p95_us"] = all.encode[c].cpu().p95 * us;
    state.counters["decode_p50_us"] = all.decode[c].cpu().p50 * us;
    state.counters["decode_p95_us"] = all.decode[c].cpu().p95 * us;
    state.counters["copy_p50_us"] = all.copy.cpu().p50 * us;
    report_hash(state, all.hash);
}

const bool kRegistered = [] {
    for (const HeightPrecision precision : {HeightPrecision::bits32, HeightPrecision::bits16})
        for (int kind = 0; kind <= static_cast<int>(SampleKind::Uniform); ++kind)
            for (std::size_t c = 0; c < kCandidates; ++c) {
                const bool own = c + 1 == kCandidates;
                std::string name = text("codec/", name_of(static_cast<SampleKind>(kind)),
                                        precision == HeightPrecision::bits16 ? "/bits16/" : "/bits32/");
                name += own ? "encode_page"
                            : text(kFilters[c / std::size(kLevels)].name, "/zstd-", kLevels[c % std::size(kLevels)]);
                benchmark::RegisterBenchmark(name.c_str(), codec, c, precision)
                    ->Arg(kind)
                    ->UseManualTime()
                    ->Iterations(1)
                    ->Unit(benchmark::kMicrosecond);
            }
    return true;
}();

}  // namespace
}  // namespace tilth::bench
