#include "tilth/io/stamp_image_file.h"

#include "tilth/io/image_codec.h"

namespace tilth::io {
namespace {

Result<void> accept_stamp(const ImageInfo& info, bool allow_8bit, const std::string& path) {
    if (info.width > kMaxStampSide || info.height > kMaxStampSide)
        return Error{ErrorCode::FileFormat, text(path, ": ", info.width, " x ", info.height,
                                                 " texels; a stamp has at most ", kMaxStampSide, " a side")};
    if (info.type == SampleType::U8 && !allow_8bit)
        return Error{
            ErrorCode::FileFormat,
            text(path, ": 8-bit samples: 256 weights make steps; use 16-bit grey, or allow 8 bits explicitly")};
    if (info.type != SampleType::U16 && info.type != SampleType::U8)
        return Error{ErrorCode::FileFormat,
                     text(path, ": ", name_of(info.type), " samples; a stamp is 16-bit unsigned grey")};
    return {};
}

}  // namespace

Result<StampImageData> read_stamp_image(const std::string& path, const StampImageOptions& options) {
    auto image = read_image(path, [&](const ImageInfo& info) { return accept_stamp(info, options.allow_8bit, path); });
    if (!image) return image.error();
    auto grey = grey_channel(std::move(*image), path);
    if (!grey) return grey.error();

    StampImageData stamp{grey->info.width, grey->info.height, {}};
    if (grey->info.type == SampleType::U8) {
        for (const std::uint8_t v : grey->as<std::uint8_t>())
            stamp.texels.push_back(static_cast<std::uint16_t>(v * 257));
    } else {
        const std::span<const std::uint16_t> texels = grey->as<std::uint16_t>();
        stamp.texels.assign(texels.begin(), texels.end());
    }
    return stamp;
}

}  // namespace tilth::io
