// Journal entries: what is taken for one is exactly what would be written of it, and nothing else is.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "fuzz/fuzz_input.h"
#include "tilth/store/journal_entry.h"
#include "tilth/store/journal_files.h"

namespace tilth::fuzz {
namespace {

void seal(JournalBytes& bytes, std::uint64_t number, std::uint64_t salt) {
    const auto sum =
        static_cast<std::uint32_t>(XXH3_64bits_withSeed(bytes.data(), 60, salt + number * 11400714819323198485ull));
    std::memcpy(bytes.data() + 60, &sum, 4);
}

void run(Input input) {
    const bool is_sealed = input.flag();
    const std::uint64_t number = input.any_number(), salt = input.any_number();
    JournalBytes bytes{};
    std::ranges::copy(input.piece(bytes.size()), bytes.begin());
    if (is_sealed) seal(bytes, number, salt);
    if (const std::optional<Edit> edit = decode_entry(bytes, number, salt)) {
        check(encode_entry(*edit, number, salt) == bytes, "an entry is written as it was read");
        check(!decode_entry(bytes, number + 1, salt), "an entry is none at another place");
    }

    // What is left over is a segment's header, and a name.
    const std::span<const std::byte> rest = input.rest();
    Bytes header = copy_of(rest);
    if (is_sealed && header.size() >= kJournalHeaderBytes) {
        const std::uint64_t sum = XXH3_64bits(header.data(), 56);
        std::memcpy(header.data() + 56, &sum, 8);
    }
    const Result<bool> checked = check_journal_header(header, number, salt, "journal");
    if (checked && *checked) {
        Bytes same = copy_of(encode_journal_header(number, salt));
        header.resize(same.size());
        for (const std::size_t zero : {12, 13, 14, 15})  // written as 0, and not read
            header[zero] = {};
        for (std::size_t zero = 32; zero < 64; ++zero) header[zero] = same[zero] = {};
        check(header == same, "a header that is good is the segment's");
    }
    if (const std::optional<std::uint64_t> first = number_of_segment(text_of(rest)))
        check(name_of_segment(*first) == text_of(rest), "a segment has one name");
}

}  // namespace
}  // namespace tilth::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    tilth::fuzz::run({data, size});
    return 0;
}
