#include "tilth/io/height_writer.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "tilth/io/file_bytes.h"
#include "tilth/io/image_codec.h"
#include "tilth/io/raw_sidecar.h"

namespace tilth::io {
namespace {

enum class Ending { Tif, Png, Exr, R16, R32f, Csv, Other };

Ending ending_of(const std::string& path) {
    const std::size_t dot = path.find_last_of("./");
    if (dot == std::string::npos || path[dot] != '.') return Ending::Other;
    std::string ending = path.substr(dot + 1);
    for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if (ending == "tif" || ending == "tiff") return Ending::Tif;
    if (ending == "png") return Ending::Png;
    if (ending == "exr") return Ending::Exr;
    if (ending == "r16") return Ending::R16;
    if (ending == "r32f") return Ending::R32f;
    if (ending == "csv") return Ending::Csv;
    return Ending::Other;
}

Error refusal(const std::string& path, const char* why) {
    return Error{ErrorCode::InvalidArgument, text(path, ": ", why)};
}

std::optional<Error> wrong_count(const std::string& path, std::size_t values, std::int32_t width, std::int32_t depth,
                                 std::int32_t channels) {
    if (width < 1 || depth < 1 || channels < 1)
        return Error{ErrorCode::InvalidArgument,
                     text(path, ": ", width, " x ", depth, " texels of ", channels, " values")};
    const std::size_t needed =
        static_cast<std::size_t>(width) * static_cast<std::size_t>(depth) * static_cast<std::size_t>(channels);
    if (values == needed) return std::nullopt;
    return Error{ErrorCode::InvalidArgument, text(path, ": ", values, " values given, ", width, " x ", depth, " x ",
                                                  channels, " = ", needed, " needed")};
}

ImageInfo info_of(std::int32_t width, std::int32_t depth, std::int32_t channels, SampleType type) {
    ImageInfo info;
    info.width = width;
    info.height = depth;
    info.channels = channels;
    info.type = type;
    return info;
}

/// `values` as little-endian bytes.
template <class T>
std::vector<std::byte> little_endian(std::span<const T> values) {
    std::vector<std::byte> bytes;
    bytes.reserve(values.size() * sizeof(T));
    for (const T value : values)
        for (std::size_t i = 0; i < sizeof(T); ++i) bytes.push_back(static_cast<std::byte>(value >> (8 * i) & 0xff));
    return bytes;
}

/// The sidecar first: a raw file without one is unreadable, a sidecar without its file is an error that says so.
template <class Bits>
Result<void> write_raw(const std::string& path, RawKind kind, const RawSidecar& sidecar, std::span<const Bits> values) {
    const std::string note = sidecar_text(sidecar, kind);
    if (auto done = write_file(sidecar_path(path), std::as_bytes(std::span(note))); !done) return done;
    return write_file(path, little_endian(values));
}

Result<void> write_quantised(const std::string& path, std::span<const float> values, std::int32_t width,
                             std::int32_t depth) {
    for (const float v : values)
        if (!std::isfinite(v)) return refusal(path, ".r16 holds finite heights only; write .tif, .exr or .r32f");
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    const double min_m = *low, range = double{*high} - min_m;
    std::vector<std::uint16_t> steps;
    steps.reserve(values.size());
    for (const float v : values)
        steps.push_back(static_cast<std::uint16_t>(range > 0 ? std::floor((v - min_m) / range * 65535 + 0.5) : 0));
    return write_raw<std::uint16_t>(path, RawKind::R16, {width, depth, false, min_m, *high, std::nullopt}, steps);
}

}  // namespace

Result<void> write_heights_u16(const std::string& path, std::span<const std::uint16_t> values, std::int32_t width,
                               std::int32_t depth, const HeightEncoding& encoding) {
    if (auto wrong = wrong_count(path, values.size(), width, depth, 1)) return *wrong;
    ImageInfo info = info_of(width, depth, 1, SampleType::U16);
    info.description = encoding_text(encoding);
    switch (ending_of(path)) {
        case Ending::Tif:
            return write_image(path, ImageFormat::Tiff, info, std::as_bytes(values));
        case Ending::Png:
            return write_image(path, ImageFormat::Png, info, std::as_bytes(values));
        default:
            return refusal(path, "16-bit heights are written as .tif or .png");
    }
}

Result<void> write_floats(const std::string& path, std::span<const float> values, std::int32_t width,
                          std::int32_t depth, std::int32_t channels) {
    if (auto wrong = wrong_count(path, values.size(), width, depth, channels)) return *wrong;
    const Ending ending = ending_of(path);
    if (channels != 1 && (ending == Ending::R16 || ending == Ending::R32f))
        return refusal(path, "raw files hold one value a texel; write .tif, .exr or .csv");
    const ImageInfo info = info_of(width, depth, channels, SampleType::F32);
    switch (ending) {
        case Ending::Tif:
            return write_image(path, ImageFormat::Tiff, info, std::as_bytes(values));
        case Ending::Exr:
            return write_image(path, ImageFormat::Exr, info, std::as_bytes(values));
        case Ending::R16:
            return write_quantised(path, values, width, depth);
        case Ending::R32f: {
            std::vector<std::uint32_t> bits;
            bits.reserve(values.size());
            for (const float v : values) bits.push_back(std::bit_cast<std::uint32_t>(v));
            return write_raw<std::uint32_t>(path, RawKind::R32f, {width, depth, false, 0, 0, std::nullopt}, bits);
        }
        default:
            return refusal(path, "floats are written as .tif, .exr, .r16 or .r32f (.csv by write_csv)");
    }
}

Result<void> write_codes(const std::string& path, std::span<const std::uint32_t> codes, std::int32_t width,
                         std::int32_t depth) {
    if (auto wrong = wrong_count(path, codes.size(), width, depth, 1)) return *wrong;
    switch (ending_of(path)) {
        case Ending::Tif:
            return write_image(path, ImageFormat::Tiff, info_of(width, depth, 1, SampleType::U32),
                               std::as_bytes(codes));
        case Ending::R16: {
            std::vector<std::uint16_t> high;
            high.reserve(codes.size());
            for (const std::uint32_t code : codes) high.push_back(static_cast<std::uint16_t>(code >> 16));
            return write_raw<std::uint16_t>(path, RawKind::R16, {width, depth, false, 0, 65535, std::nullopt}, high);
        }
        case Ending::Exr:
        case Ending::R32f:
            return refusal(path, "a float holds 24 of a code's 32 bits; write codes as .tif, .r16 or .csv");
        default:
            return refusal(path, "codes are written as .tif or .r16 (.csv by write_csv)");
    }
}

Result<void> write_csv(const std::string& path, const CsvFrame& frame, std::span<const double> values,
                       std::int32_t width, std::int32_t depth, std::int32_t channels) {
    if (auto wrong = wrong_count(path, values.size(), width, depth, channels)) return *wrong;
    if (ending_of(path) != Ending::Csv) return refusal(path, "comma-separated rows are written as .csv");
    auto writer = FileWriter::create(path);
    if (!writer) return writer.error();

    std::string row;
    const auto append = [&row](double value, char end) {
        char digits[32];
        const auto made = std::to_chars(digits, digits + sizeof digits, value, std::chars_format::general,
                                        std::numeric_limits<double>::max_digits10);
        row.append(digits, made.ptr).push_back(end);
    };
    const double* next = values.data();
    for (std::int32_t z = 0; z < depth; ++z) {
        row.clear();
        for (std::int32_t x = 0; x < width; ++x) {
            append(frame.first.x + frame.spacing * x, ',');
            append(frame.first.z + frame.spacing * z, ',');
            for (std::int32_t c = 1; c < channels; ++c) append(*next++, ',');
            append(*next++, '\n');
        }
        writer->write(std::as_bytes(std::span(row)));
    }
    return writer->commit();
}

}  // namespace tilth::io
