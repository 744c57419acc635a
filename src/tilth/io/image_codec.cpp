// This file alone is compiled with exceptions: OpenImageIO and the libraries under it may throw (out of memory, damaged
// OpenEXR headers). `guarded` turns what they throw into an `Error`, so nothing leaves this file.
#include "tilth/io/image_codec.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <array>
#include <cstring>
#include <exception>
#include <limits>
#include <new>

#include "tilth/io/container_check.h"
#include "tilth/io/file_bytes.h"

#ifndef __cpp_exceptions
#error "compile this file with -fexceptions: it keeps the exceptions of OpenImageIO from leaving the library"
#endif

namespace tilth::io {
namespace {

template <class Work>
auto guarded(ErrorCode code, const std::string& name, const Work& work) -> decltype(work()) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::OutOfMemory, text(name, ": not enough memory for its samples")};
    } catch (const std::exception& e) {
        return Error{code, text(name, ": ", e.what())};
    } catch (...) {
        return Error{code, text(name, ": unknown failure inside OpenImageIO")};
    }
}

/// OpenImageIO's message as one line, or `otherwise` if it has none.
std::string one_line(std::string message, const char* otherwise) {
    while (!message.empty() && (message.back() == '\n' || message.back() == ' ')) message.pop_back();
    for (char& c : message)
        if (c == '\n') c = ' ';
    return message.empty() ? otherwise : message;
}

/// OpenImageIO's name of the format whose magic number opens `file`, or null.
const char* plugin_for(std::span<const std::byte> file) {
    const auto starts_with = [&](std::string_view magic) {
        return file.size() >= magic.size() && std::memcmp(file.data(), magic.data(), magic.size()) == 0;
    };
    using namespace std::string_view_literals;
    if (starts_with("\x89PNG\r\n\x1a\n"sv)) return "png";
    if (starts_with("\x76\x2f\x31\x01"sv)) return "openexr";
    if (starts_with("II\x2a\0"sv) || starts_with("MM\0\x2a"sv)) return "tiff";
    if (starts_with("II\x2b\0"sv) || starts_with("MM\0\x2b"sv)) return "tiff";  // BigTIFF
    return nullptr;
}

/// Samples' bytes that one byte of a file can stand for, at most.
std::uint64_t best_ratio(const std::string& format, const std::string& compression) {
    if (format == "png") return 1100;  // deflate: 258 bytes in 2 bits, 1 032
    if (compression == "none") return 1;
    if (compression == "zip" || compression == "zips" || compression == "pxr24") return 1100;
    if (compression == "packbits" || compression == "rle") return 64;
    if (compression == "lzw") return 4096;  // a string of at most 3 839 bytes in 12 bits
    return 40000;                           // zstd: 128 KiB in 4 bytes
}

bool sample_type_of(const OIIO::TypeDesc& format, SampleType& type) {
    switch (format.basetype) {
        case OIIO::TypeDesc::UINT8:
            type = SampleType::U8;
            return true;
        case OIIO::TypeDesc::UINT16:
            type = SampleType::U16;
            return true;
        case OIIO::TypeDesc::INT16:
            type = SampleType::I16;
            return true;
        case OIIO::TypeDesc::UINT32:
            type = SampleType::U32;
            return true;
        case OIIO::TypeDesc::HALF:
        case OIIO::TypeDesc::FLOAT:
            type = SampleType::F32;
            return true;
        default:
            return false;
    }
}

OIIO::TypeDesc oiio_type_of(SampleType type) {
    switch (type) {
        case SampleType::U8:
            return OIIO::TypeDesc::UINT8;
        case SampleType::U16:
            return OIIO::TypeDesc::UINT16;
        case SampleType::I16:
            return OIIO::TypeDesc::INT16;
        case SampleType::U32:
            return OIIO::TypeDesc::UINT32;
        case SampleType::F32:
            break;
    }
    return OIIO::TypeDesc::FLOAT;
}

/// What makes an image unreadable whoever asks for it.
Result<ImageInfo> checked_info(const OIIO::ImageSpec& spec, const std::string& format, std::uint64_t file_bytes,
                               const std::string& name) {
    const auto refused = [&](const auto&... why) { return Error{ErrorCode::FileFormat, text(name, ": ", why...)}; };
    if (spec.width < 1 || spec.height < 1) return refused(spec.width, " x ", spec.height, " texels: it is empty");
    if (spec.width > kMaxImageSide || spec.height > kMaxImageSide)
        return refused(spec.width, " x ", spec.height, " texels: at most ", kMaxImageSide, " a side are allowed");
    if (spec.depth > 1 || spec.deep) return refused("is a volume or a deep image; a flat image is needed");
    if (spec.nchannels < 1 || spec.nchannels > 64) return refused(spec.nchannels, " channels; 1 to 4 make sense");
    if (!spec.channelformats.empty()) return refused("its channels differ in type; store a single channel");

    ImageInfo info;
    info.width = spec.width;
    info.height = spec.height;
    info.channels = spec.nchannels;
    if (!sample_type_of(spec.format, info.type))
        return refused("samples of type ", spec.format.c_str(),
                       "; allowed are 8, 16 or 32-bit unsigned, 16-bit signed, "
                       "half and 32-bit float");
    const int bits = spec.get_int_attribute("oiio:BitsPerSample", static_cast<int>(spec.format.size() * 8));
    if (bits != static_cast<int>(spec.format.size() * 8))
        return refused(bits, " bits a sample; allowed are 8, 16 and 32");
    if (format == "tiff" && spec.get_int_attribute("tiff:PhotometricInterpretation", 1) == 0)
        return refused("grey is inverted (TIFF photometric 'white is zero'); store it with 'black is zero'");

    const std::uint64_t claimed = static_cast<std::uint64_t>(spec.width) * static_cast<std::uint64_t>(spec.height) *
                                  static_cast<std::uint64_t>(spec.nchannels) * spec.format.size();
    const std::string compression{spec.get_string_attribute("compression", "none")};
    const std::uint64_t tile = static_cast<std::uint64_t>(std::max(spec.tile_width, 0)) *
                               static_cast<std::uint64_t>(std::max(spec.tile_height, 0));
    if (claimed / best_ratio(format, compression) > file_bytes)
        return refused("the header claims ", claimed, " bytes of samples (", spec.width, " x ", spec.height, " x ",
                       spec.nchannels, "), more than a file of ", file_bytes, " bytes can hold");
    if (tile > std::uint64_t{kMaxImageSide} * kMaxImageSide)
        return refused("tiles of ", spec.tile_width, " x ", spec.tile_height, " texels; at most ", kMaxImageSide,
                       " a side are allowed");
    info.has_alpha = spec.alpha_channel >= 0;
    info.description = spec.get_string_attribute("ImageDescription", "");
    return info;
}

template <class T>
Result<Image> first_of_equal_channels(const Image& image, const std::string& name) {
    const std::span<const T> samples = image.as<T>();
    const std::size_t channels = static_cast<std::size_t>(image.info.channels);
    const std::size_t texels = samples.size() / channels, row = static_cast<std::size_t>(image.info.width);
    Image grey{image.info, std::vector<std::byte>(texels * sizeof(T))};
    grey.info.channels = 1;
    for (std::size_t i = 0; i < texels; ++i) {
        const T* texel = samples.data() + i * channels;
        for (std::size_t c = 1; c < channels; ++c)
            if (std::memcmp(texel, texel + c, sizeof(T)) != 0)
                return Error{ErrorCode::FileFormat,
                             text(name, ": ", channels, " channels that differ at texel (", i % row, ", ", i / row,
                                  "); heights and stamps need one grey channel, or channels that are all equal")};
        std::memcpy(grey.samples.data() + i * sizeof(T), texel, sizeof(T));
    }
    return grey;
}

Result<Image> decode(std::span<const std::byte> file, const std::string& name, const AcceptImage& accept) {
    const char* plugin = plugin_for(file);
    if (!plugin)
        return Error{ErrorCode::FileFormat,
                     text(name, ": ", file.empty() ? "is empty" : "is not a PNG, TIFF or OpenEXR image",
                          "; these three are read (and .r16, .r32f by their names)")};
    if (const auto wrong = wrong_length(file, kMaxImageSide))
        return Error{ErrorCode::FileFormat, text(name, ": ", *wrong)};
    const auto input = OIIO::ImageInput::create(plugin);
    if (!input)
        return Error{ErrorCode::Unsupported, text(name, ": this OpenImageIO was built without ", plugin, ": ",
                                                  one_line(OIIO::geterror(), "no reason given"))};

    OIIO::Filesystem::IOMemReader memory(file.data(), file.size());
    OIIO::ImageSpec config, spec;
    OIIO::Filesystem::IOProxy* proxy = &memory;
    config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    config.attribute("oiio:UnassociatedAlpha", 1);
    config.attribute("oiio:RawColor", 1);
    if (!input->open(name, spec, config))
        return Error{ErrorCode::FileFormat,
                     text(name, ": cannot be decoded: ", one_line(input->geterror(), "damaged header"))};

    auto info = checked_info(spec, plugin, file.size(), name);
    if (!info) return info.error();
    if (auto welcome = accept(*info); !welcome) return welcome.error();

    Image image{*info, {}};
    image.samples.resize(static_cast<std::size_t>(info->width) * static_cast<std::size_t>(info->height) *
                         static_cast<std::size_t>(info->channels) * bytes_of(info->type));
    if (!input->read_image(0, 0, 0, info->channels, oiio_type_of(info->type), image.samples.data()))
        return Error{ErrorCode::FileFormat,
                     text(name, ": cannot be decoded: ", one_line(input->geterror(), "damaged or truncated"))};
    if (const std::string late = one_line(input->geterror(), ""); !late.empty())
        return Error{ErrorCode::FileFormat, text(name, ": cannot be decoded: ", late)};
    return image;
}

Result<std::vector<std::byte>> encode(ImageFormat format, const ImageInfo& info, std::span<const std::byte> samples,
                                      const std::string& name) {
    const std::array<const char*, 3> plugins = {"png", "tiff", "openexr"};
    const char* plugin = plugins[static_cast<std::size_t>(format)];
    const auto output = OIIO::ImageOutput::create(plugin);
    if (!output)
        return Error{ErrorCode::Unsupported, text(name, ": this OpenImageIO was built without ", plugin, ": ",
                                                  one_line(OIIO::geterror(), "no reason given"))};

    std::vector<unsigned char> file;
    OIIO::Filesystem::IOVecOutput memory(file);
    OIIO::Filesystem::IOProxy* proxy = &memory;
    OIIO::ImageSpec spec(info.width, info.height, info.channels, oiio_type_of(info.type));
    spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    spec.attribute("oiio:UnassociatedAlpha", 1);
    spec.attribute("compression", format == ImageFormat::Tiff ? "none" : "zip");
    if (!info.channel.empty()) spec.channelnames = {info.channel};
    if (!info.description.empty()) spec.attribute("ImageDescription", info.description);
    if (!output->open(name, spec) || !output->write_image(spec.format, samples.data()) || !output->close())
        return Error{ErrorCode::FileWrite,
                     text(name, ": cannot be encoded: ", one_line(output->geterror(), "no reason given"))};
    const std::byte* first = reinterpret_cast<const std::byte*>(file.data());
    return std::vector<std::byte>(first, first + file.size());
}

}  // namespace

std::size_t bytes_of(SampleType type) {
    switch (type) {
        case SampleType::U8:
            return 1;
        case SampleType::U16:
        case SampleType::I16:
            return 2;
        case SampleType::U32:
        case SampleType::F32:
            break;
    }
    return 4;
}

const char* name_of(SampleType type) {
    switch (type) {
        case SampleType::U8:
            return "8-bit unsigned";
        case SampleType::U16:
            return "16-bit unsigned";
        case SampleType::I16:
            return "16-bit signed";
        case SampleType::U32:
            return "32-bit unsigned";
        case SampleType::F32:
            break;
    }
    return "float";
}

Result<Image> decode_image(std::span<const std::byte> file, const std::string& name, const AcceptImage& accept) {
    return guarded(ErrorCode::FileFormat, name, [&] { return decode(file, name, accept); });
}

Result<Image> read_image(const std::string& path, const AcceptImage& accept) {
    return guarded(ErrorCode::FileFormat, path, [&]() -> Result<Image> {
        auto file = read_file(path, kMaxImageFileBytes);
        if (!file) return file.error();
        return decode(*file, path, accept);
    });
}

Result<Image> grey_channel(Image image, const std::string& name) {
    if (image.info.has_alpha)
        return Error{ErrorCode::FileFormat, text(name, ": has an alpha channel; heights and stamps are plain grey")};
    if (image.info.channels == 1) return image;
    return guarded(ErrorCode::FileFormat, name, [&]() -> Result<Image> {
        switch (bytes_of(image.info.type)) {
            case 1:
                return first_of_equal_channels<std::uint8_t>(image, name);
            case 2:
                return first_of_equal_channels<std::uint16_t>(image, name);
            default:
                return first_of_equal_channels<std::uint32_t>(image, name);
        }
    });
}

Result<std::vector<std::byte>> encode_image(ImageFormat format, const ImageInfo& info,
                                            std::span<const std::byte> samples, const std::string& name) {
    TILTH_EXPECTS(samples.size() == static_cast<std::size_t>(info.width) * static_cast<std::size_t>(info.height) *
                                        static_cast<std::size_t>(info.channels) * bytes_of(info.type),
                  text(name, ": ", samples.size(), " bytes of samples for ", info.width, " x ", info.height));
    return guarded(ErrorCode::FileWrite, name, [&] { return encode(format, info, samples, name); });
}

Result<void> write_image(const std::string& path, ImageFormat format, const ImageInfo& info,
                         std::span<const std::byte> samples) {
    auto file = encode_image(format, info, samples, path);
    if (!file) return file.error();
    return write_file(path, *file);
}

}  // namespace tilth::io
