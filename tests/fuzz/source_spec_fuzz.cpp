// Heights as one line of text: a source with finite heights within its bounds, or an error that quotes the line.
#include <cmath>
#include <cstdlib>
#include <string>

#include "fuzz/fuzz_input.h"
#include "tilth/source/source_spec.h"

namespace tilth::fuzz {
namespace {

void run(Input input) {
    const std::string_view spec = text_of(input.rest());
    // Larger ridges are allowed, and take a second and their four bytes a post.
    const std::size_t size = spec.find("size=");
    const std::string digits(spec.substr(size == spec.npos ? spec.size() : size + 5));
    const unsigned long long posts = size == spec.npos ? kMaxSpecSize : std::strtoull(digits.c_str(), nullptr, 10);
    if (spec.starts_with("ridged") && posts > 99 && posts <= static_cast<unsigned long long>(kMaxSpecSize)) return;
    const bool is_named = is_procedural(spec);
    const Result<std::unique_ptr<HeightSource>> source = make_source(spec);
    if (!source) {
        check(source.error().code == ErrorCode::InvalidArgument, "the line is to blame");
        check(source.error().message.find(spec) != std::string::npos, "an error quotes the line");
        return;
    }
    check(is_named || spec.find(':') == spec.npos, "what makes heights is no path");
    const HeightSource& heights = **source;
    check(heights.width() >= kMinSpecSize && heights.width() <= kMaxSpecSize, "the size is in its range");
    check(heights.depth() == heights.width(), "and square");
    check(std::isfinite(heights.min_m()) && std::isfinite(heights.max_m()) && heights.min_m() <= heights.max_m(),
          "bounds are numbers");
    const double slack = 1e-9 * (std::abs(heights.min_m()) + std::abs(heights.max_m()));
    for (const std::int32_t x : {0, heights.width() / 2, heights.width() - 1})
        for (const std::int32_t z : {0, heights.width() / 3, heights.width() - 1}) {
            const double height_m = heights.height_m({x, z});
            check(height_m >= heights.min_m() - slack && height_m <= heights.max_m() + slack, "heights are in bounds");
        }
}

}  // namespace
}  // namespace tilth::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    tilth::fuzz::run({data, size});
    return 0;
}
