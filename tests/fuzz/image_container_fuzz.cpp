// What is looked up in PNG, OpenEXR and TIFF files before a decoder gets them: no read outside, and an end to it.
#include "fuzz/fuzz_input.h"
#include "tilth/io/container_check.h"
#include "tilth/io/tiff_no_data.h"

namespace tilth::fuzz {
namespace {

void run(Input input) {
    const std::uint8_t how = input.byte();
    Bytes file;
    switch (how % 8) {  // half of the inputs get past the first bytes
        case 0:
            append(file, std::as_bytes(std::span("\x89PNG\r\n\x1a\n", 8)));
            break;
        case 1:
            append(file, std::as_bytes(std::span("\x76\x2f\x31\x01\2\0\0", 8)));
            break;
        case 2:
            append(file, std::as_bytes(std::span("II\x2a", 4)));
            break;
        case 3:
            append(file, std::as_bytes(std::span("MM\0\x2b\0\x8\0", 8)));
            break;
        default:
            break;
    }
    append(file, input.rest());
    const std::int64_t most = how < 128 ? 16384 : 8;
    const std::optional<std::string> wrong = io::wrong_length(file, most);
    check(!wrong || !wrong->empty(), "a problem has words");
    if (const std::optional<std::string> no_data = io::gdal_no_data_text(file)) {
        check(no_data->size() <= 64, "the text is short");
        check(no_data->find_first_of(std::string_view(" \0", 2)) == std::string::npos, "and trimmed");
    }
    // What is in order stays so if more follows, and is not if its last byte is missing.
    if (how % 8 == 0 && !wrong) {
        Bytes longer = file;
        longer.insert(longer.end(), 3, std::byte{0xff});
        check(!io::wrong_length(longer, most), "what follows a PNG is nobody's");
    }
    if (how % 8 == 0 && wrong) {
        file.resize(file.size() - (file.size() > 8 ? 1 : 0));
        check(io::wrong_length(file, most).has_value(), "a broken PNG is not mended by cutting it");
    }
}

}  // namespace
}  // namespace tilth::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    tilth::fuzz::run({data, size});
    return 0;
}
