#include "tilth/io/png.h"

#include "tilth/io/image_codec.h"

namespace tilth::io {
namespace {

Result<void> write_picture(const std::string& path, ImageFormat format, std::int32_t width, std::int32_t height,
                           std::int32_t channels, SampleType type, std::span<const std::byte> samples) {
    const char* ending = format == ImageFormat::Png ? ".png" : ".exr";
    if (!path.ends_with(ending))
        return Error{ErrorCode::InvalidArgument, text(path, ": the name of this picture must end in ", ending)};
    ImageInfo info;
    info.width = width;
    info.height = height;
    info.channels = channels;
    info.type = type;
    info.has_alpha = channels == 4;
    if (format == ImageFormat::Exr) info.channel = "Z";
    const std::size_t needed = width < 1 || height < 1
                                   ? 0
                                   : static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                                         static_cast<std::size_t>(channels) * bytes_of(type);
    if (needed == 0 || samples.size() != needed)
        return Error{ErrorCode::InvalidArgument, text(path, ": ", samples.size(), " bytes given for ", width, " x ",
                                                      height, " pixels, ", needed, " needed")};
    return write_image(path, format, info, samples);
}

}  // namespace

Result<void> write_png_rgb8(const std::string& path, std::int32_t width, std::int32_t height,
                            std::span<const std::uint8_t> pixels) {
    return write_picture(path, ImageFormat::Png, width, height, 3, SampleType::U8, std::as_bytes(pixels));
}

Result<void> write_png_rgba8(const std::string& path, std::int32_t width, std::int32_t height,
                             std::span<const std::uint8_t> pixels) {
    return write_picture(path, ImageFormat::Png, width, height, 4, SampleType::U8, std::as_bytes(pixels));
}

Result<void> write_depth_exr(const std::string& path, std::int32_t width, std::int32_t height,
                             std::span<const float> depth) {
    return write_picture(path, ImageFormat::Exr, width, height, 1, SampleType::F32, std::as_bytes(depth));
}

Result<Rgb8Picture> read_png_rgb8(const std::string& path) {
    auto image = read_image(path, [&path](const ImageInfo& info) -> Result<void> {
        if (info.type == SampleType::U8 && (info.channels == 3 || info.channels == 4)) return {};
        return Error{ErrorCode::FileFormat, text(path, ": ", info.channels, " channels of ", name_of(info.type),
                                                 " samples; an 8-bit RGB or RGBA picture is needed")};
    });
    if (!image) return image.error();
    Rgb8Picture picture{image->info.width, image->info.height, {}};
    const std::span<const std::uint8_t> samples = image->as<std::uint8_t>();
    const std::size_t channels = static_cast<std::size_t>(image->info.channels);
    picture.pixels.reserve(samples.size() / channels * 3);
    for (std::size_t i = 0; i < samples.size(); i += channels)
        picture.pixels.insert(picture.pixels.end(), {samples[i], samples[i + 1], samples[i + 2]});
    return picture;
}

}  // namespace tilth::io
