#include "tilth/io/height_file.h"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "tilth/io/file_bytes.h"
#include "tilth/io/height_encoding.h"
#include "tilth/io/image_codec.h"
#include "tilth/io/raw_sidecar.h"
#include "tilth/io/tiff_no_data.h"
#include "tilth/source/raster_source.h"

namespace tilth::io {
namespace {

using Source = Result<std::unique_ptr<HeightSource>>;

/// Values as they are stored in a file, with all that turns them into heights.
template <class T>
struct StoredHeights {
    std::int32_t width = 0, depth = 0;
    std::span<const T> values;
    double scale_m = 1, offset_m = 0;
    std::optional<double> no_data;
};

template <class T>
bool is_no_data(T value, double no_data) {
    if constexpr (std::is_floating_point_v<T>) {
        if (std::isnan(no_data)) return std::isnan(value);
        return value == static_cast<T>(no_data);  // the file's text may have more digits than its floats
    } else {
        return static_cast<double>(value) == no_data;
    }
}

template <class T>
Source to_source(const StoredHeights<T>& stored, const HeightFileOptions& options, const std::string& path) {
    std::vector<float> heights_m(stored.values.size());
    std::size_t holes = 0, first_hole = 0;
    for (std::size_t i = 0; i < stored.values.size(); ++i) {
        if (stored.no_data && is_no_data(stored.values[i], *stored.no_data)) {
            if (holes++ == 0) first_hole = i;
            heights_m[i] = static_cast<float>(options.no_data_replacement_m.value_or(0));
        } else {
            heights_m[i] = static_cast<float>(stored.values[i] * stored.scale_m + stored.offset_m);
        }
    }
    if (holes != 0 && !options.no_data_replacement_m) {
        const std::size_t row = static_cast<std::size_t>(stored.width);
        return Error{ErrorCode::FileFormat,
                     text(path, ": ", holes, " of ", stored.values.size(), " posts have no data (value ",
                          *stored.no_data, "), the first at texel (", first_hole % row, ", ", first_hole / row,
                          "); fill them, or give a replacement height")};
    }
    auto raster = RasterSource::create(stored.width, stored.depth, std::move(heights_m), path);
    if (!raster) return raster.error();
    return std::unique_ptr<HeightSource>(std::move(*raster));
}

std::optional<Error> wrong_option(const HeightFileOptions& options, const std::string& path) {
    const auto refuse = [&](const char* what) { return Error{ErrorCode::InvalidArgument, text(path, ": ", what)}; };
    if (options.scale_m && (!std::isfinite(*options.scale_m) || *options.scale_m == 0))
        return refuse("option scale: a finite number other than 0 is needed");
    if (options.offset_m && !std::isfinite(*options.offset_m))
        return refuse("option offset: a finite number is needed");
    if (options.no_data_replacement_m && !std::isfinite(*options.no_data_replacement_m))
        return refuse("option no-data replacement: a finite height is needed");
    return std::nullopt;
}

// ---- raw ----

template <class Bits>
Bits swapped(Bits v) {
    Bits out = 0;
    for (std::size_t i = 0; i < sizeof v; ++i, v = static_cast<Bits>(v >> 8))
        out = static_cast<Bits>(out << 8 | (v & 0xff));
    return out;
}

template <class T, class Bits>
std::vector<T> raw_values(const std::vector<std::byte>& bytes, bool big_endian) {
    static_assert(sizeof(T) == sizeof(Bits));
    const bool swap = big_endian != (std::endian::native == std::endian::big);
    std::vector<T> values(bytes.size() / sizeof(T));
    for (std::size_t i = 0; i < values.size(); ++i) {
        Bits bits = 0;
        std::memcpy(&bits, bytes.data() + i * sizeof(T), sizeof(T));
        values[i] = std::bit_cast<T>(swap ? swapped(bits) : bits);
    }
    return values;
}

Source read_raw(const std::string& path, RawKind kind, const HeightFileOptions& options) {
    constexpr std::uint64_t kLongestSidecar = 64 * 1024;
    if (kind == RawKind::R16 && (options.scale_m || options.offset_m))
        return Error{
            ErrorCode::InvalidArgument,
            text(path, ": options scale and offset do not apply to .r16; set min_m and max_m in ", sidecar_path(path))};
    auto note = read_file(sidecar_path(path), kLongestSidecar);
    if (!note)
        return Error{note.error().code,
                     text(note.error().message, " (a raw file needs this sidecar, see RAW_SIDECAR.md)")};
    auto parsed = parse_sidecar({reinterpret_cast<const char*>(note->data()), note->size()}, kind, sidecar_path(path));
    if (!parsed) return parsed.error();
    const RawSidecar& sidecar = *parsed;

    const std::uint64_t value_bytes = kind == RawKind::R16 ? 2 : 4;
    const std::uint64_t needed =
        static_cast<std::uint64_t>(sidecar.width) * static_cast<std::uint64_t>(sidecar.depth) * value_bytes;
    auto bytes = read_file(path, needed);
    if (!bytes) return bytes.error();
    if (bytes->size() != needed)
        return Error{ErrorCode::FileFormat,
                     text(path, ": has ", bytes->size(), " bytes; width ", sidecar.width, " and depth ", sidecar.depth,
                          " of ", sidecar_path(path), " need ", needed)};

    const std::optional<double> no_data = options.no_data ? options.no_data : sidecar.no_data;
    if (kind == RawKind::R16) {
        const auto values = raw_values<std::uint16_t, std::uint16_t>(*bytes, sidecar.big_endian);
        const double scale_m = (sidecar.max_m - sidecar.min_m) / 65535;
        return to_source<std::uint16_t>({sidecar.width, sidecar.depth, values, scale_m, sidecar.min_m, no_data},
                                        options, path);
    }
    const auto values = raw_values<float, std::uint32_t>(*bytes, sidecar.big_endian);
    return to_source<float>(
        {sidecar.width, sidecar.depth, values, options.scale_m.value_or(1), options.offset_m.value_or(0), no_data},
        options, path);
}

// ---- images ----

Result<void> accept_heights(const ImageInfo& info, bool allow_8bit, const std::string& path) {
    if (info.type == SampleType::U32)
        return Error{ErrorCode::FileFormat,
                     text(path, ": 32-bit integers; heights are 16-bit integers, half or 32-bit floats")};
    if (info.type == SampleType::U8 && !allow_8bit)
        return Error{ErrorCode::FileFormat,
                     text(path,
                          ": 8-bit samples: 256 heights make steps (16 cm over 40 m of relief) that show and are felt; "
                          "use a 16-bit or float image, or allow 8 bits explicitly")};
    if (info.width < 2 || info.height < 2)
        return Error{ErrorCode::InvalidArgument, text(path, ": ", info.width, " x ", info.height,
                                                      " heights; ground needs at least 2 posts along each side")};
    return {};
}

/// The file's own no-data value, if it has one.
Result<std::optional<double>> no_data_of(std::span<const std::byte> file, const std::string& path) {
    const std::optional<std::string> found = gdal_no_data_text(file);
    if (!found) return std::optional<double>{};
    double value = 0;
    const char *first = found->data(), *last = first + found->size();
    if (first != last && *first == '+') ++first;
    const auto [end, problem] = std::from_chars(first, last, value);
    if (problem == std::errc{} && end == last) return std::optional<double>(value);
    return Error{ErrorCode::FileFormat, text(path, ": tag GDAL_NODATA: '", *found, "' is not a number")};
}

Source read_height_image(const std::string& path, const HeightFileOptions& options) {
    auto file = read_file(path, kMaxImageFileBytes);
    if (!file) return file.error();
    auto decoded = decode_image(*file, path,
                                [&](const ImageInfo& info) { return accept_heights(info, options.allow_8bit, path); });
    if (!decoded) return decoded.error();
    auto encoding = encoding_in(decoded->info.description, path);
    if (!encoding) return encoding.error();
    auto file_no_data = no_data_of(*file, path);
    if (!file_no_data) return file_no_data.error();
    auto grey = grey_channel(std::move(*decoded), path);
    if (!grey) return grey.error();
    *file = {};

    const HeightEncoding own = encoding->value_or(HeightEncoding{});
    const auto convert = [&]<class T>(std::span<const T> values) {
        return to_source<T>(
            {grey->info.width, grey->info.height, values, options.scale_m.value_or(own.scale_m),
             options.offset_m.value_or(own.offset_m), options.no_data ? options.no_data : *file_no_data},
            options, path);
    };
    switch (grey->info.type) {
        case SampleType::U8:
            return convert(grey->as<std::uint8_t>());
        case SampleType::U16:
            return convert(grey->as<std::uint16_t>());
        case SampleType::I16:
            return convert(grey->as<std::int16_t>());
        default:
            return convert(grey->as<float>());
    }
}

}  // namespace

Source read_heights(const std::string& path, const HeightFileOptions& options) {
    if (auto wrong = wrong_option(options, path)) return *wrong;
    if (const auto kind = raw_kind_of(path)) return read_raw(path, *kind, options);
    return read_height_image(path, options);
}

}  // namespace tilth::io
