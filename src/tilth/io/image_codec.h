// PNG, TIFF and OpenEXR images as bytes in memory, decoded and encoded. The only door to OpenImageIO.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tilth/core/result.h"

namespace tilth::io {

/// How one sample lies in memory, in the machine's byte order. Half floats of a file are decoded to `F32`, exactly.
enum class SampleType { U8, U16, I16, U32, F32 };
[[nodiscard]] std::size_t bytes_of(SampleType type);
[[nodiscard]] const char* name_of(SampleType type);  ///< "8-bit unsigned" and so on

/// What the header of an image says.
struct ImageInfo {
    std::int32_t width = 0, height = 0;  ///< texels; row 0 is the first row of the file
    std::int32_t channels = 0;
    bool has_alpha = false;
    SampleType type = SampleType::U8;
    std::string channel;      ///< name of the only channel of an EXR that is written, "Z" for depth; else not used
    std::string description;  ///< TIFF ImageDescription, PNG Description; empty if there is none
};

/// An image, row by row, channels interleaved.
struct Image {
    ImageInfo info;
    std::vector<std::byte> samples;  ///< width * height * channels * bytes_of(type)

    template <class T>
    [[nodiscard]] std::span<const T> as() const {
        return {reinterpret_cast<const T*>(samples.data()), samples.size() / sizeof(T)};
    }
};

/// Says whether an image with such a header is welcome. Called before memory for its samples is taken.
using AcceptImage = std::function<Result<void>(const ImageInfo&)>;

/// Longest side that is ever decoded, texels.
inline constexpr std::int32_t kMaxImageSide = 16384;

/// Largest image file that is ever read: 16 384 x 16 384 floats with room to spare.
inline constexpr std::uint64_t kMaxImageFileBytes = std::uint64_t{1} << 31;

/// Decodes the first image in `file`; the format is told by its first bytes, not by its name. Samples come as they are
/// stored: no colour transform, no scaling, no division by alpha.
/// Refused with `FileFormat`: other formats, damage, sides above `kMaxImageSide`, volumes, deep images, samples of
/// 1-7, 9-15 or 64 bits, inverted grey (TIFF "white is zero"), and headers that claim more samples than a file of this
/// size can hold, whatever its compression. `name` opens every message. Any thread; OpenImageIO may use its own pool.
Result<Image> decode_image(std::span<const std::byte> file, const std::string& name, const AcceptImage& accept);

/// `read_file`, then `decode_image`.
Result<Image> read_image(const std::string& path, const AcceptImage& accept);

/// One channel of an image that must be grey: the image itself if it has one channel, the first of them if it has
/// several that are equal at every texel. Refused with `FileFormat`: an alpha channel, channels that differ (the
/// message names the first such texel).
Result<Image> grey_channel(Image image, const std::string& name);

enum class ImageFormat { Png, Tiff, Exr };

/// Encodes `samples` (as `info` describes them) as a file in memory. PNG: not interlaced, U8 or U16. TIFF:
/// uncompressed, any type. EXR: zip, F32 only. Fails with `Unsupported` if OpenImageIO lacks the format, `FileWrite` if
/// it refuses.
Result<std::vector<std::byte>> encode_image(ImageFormat format, const ImageInfo& info,
                                            std::span<const std::byte> samples, const std::string& name);

/// `encode_image`, then `write_file`.
Result<void> write_image(const std::string& path, ImageFormat format, const ImageInfo& info,
                         std::span<const std::byte> samples);

}  // namespace tilth::io
