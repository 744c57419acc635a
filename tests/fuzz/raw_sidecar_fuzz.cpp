// The sidecar of a raw file: what is read is written and read again as the same.
#include <cmath>

#include "fuzz/fuzz_input.h"
#include "tilth/io/raw_sidecar.h"

namespace tilth::fuzz {
namespace {

bool is_same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

void run(Input input) {
    const std::string_view content = text_of(input.rest());
    (void)io::raw_kind_of(content);
    for (const io::RawKind kind : {io::RawKind::R16, io::RawKind::R32f}) {
        const Result<io::RawSidecar> read = io::parse_sidecar(content, kind, "name.txt");
        if (!read) {
            check(read.error().code == ErrorCode::FileFormat && read.error().message.starts_with("name.txt"),
                  "an error says where");
            continue;
        }
        check(read->width >= 1 && read->width <= 16384 && read->depth >= 1 && read->depth <= 16384, "sides in range");
        check(std::isfinite(read->min_m) && std::isfinite(read->max_m), "heights are numbers");
        const Result<io::RawSidecar> again = io::parse_sidecar(io::sidecar_text(*read, kind), kind, "name.txt");
        check(again.ok() && again->width == read->width && again->depth == read->depth &&
                  again->big_endian == read->big_endian && again->min_m == read->min_m && again->max_m == read->max_m &&
                  again->no_data.has_value() == read->no_data.has_value() &&
                  is_same(again->no_data.value_or(0), read->no_data.value_or(0)),
              "a sidecar comes back");
    }
}

}  // namespace
}  // namespace tilth::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    tilth::fuzz::run({data, size});
    return 0;
}
