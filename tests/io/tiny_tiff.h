// Uncompressed TIFF and BigTIFF files of one strip, in either byte order, with any tag set to any value: for files that
// no sane writer makes.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace tilth::test {

class TinyTiff {
public:
    /// 16-bit unsigned grey; `samples` are the values, row by row.
    TinyTiff(std::uint32_t width, std::uint32_t height, std::vector<std::uint32_t> samples)
        : samples_(std::move(samples)) {
        numbers_ = {{256, width}, {257, height}, {258, 16}, {259, 1}, {262, 1}, {277, 1}, {278, height}, {339, 1}};
    }

    /// Sets a tag with one number (258 bits, 262 photometric, 277 channels, 339 format: 1 unsigned, 2 signed, 3 float).
    TinyTiff& set(std::uint32_t tag, std::uint32_t value) { return numbers_[tag] = value, *this; }
    TinyTiff& set(std::uint32_t tag, std::string value) { return texts_[tag] = std::move(value), *this; }
    TinyTiff& big_endian() { return big_endian_ = true, *this; }
    TinyTiff& big_tiff() { return big_tiff_ = true, *this; }

    [[nodiscard]] std::string bytes() const {
        const std::size_t word = big_tiff_ ? 8 : 4, entries = numbers_.size() + texts_.size() + 2;
        const std::size_t header = big_tiff_ ? 16 : 8;
        std::size_t free = header + (big_tiff_ ? 8 : 2) + entries * (big_tiff_ ? 20 : 12) + word;

        std::string strip, tail;
        for (const std::uint32_t s : samples_) number(strip, s, numbers_.at(258) / 8);
        const std::size_t strip_at = free;
        free += strip.size();

        // Entries in ascending order of tags, as the format demands.
        std::map<std::uint32_t, std::string> directory;
        for (const auto& [tag, value] : numbers_) directory[tag] = entry(tag, 4, 1, value);
        directory[273] = entry(273, 4, 1, strip_at);
        directory[279] = entry(279, 4, 1, strip.size());
        for (const auto& [tag, value] : texts_) {
            const std::string text = value + '\0';
            if (text.size() <= word) {
                directory[tag] = entry(tag, 2, text.size(), 0);
                directory[tag].replace(big_tiff_ ? 12 : 8, text.size(), text);
            } else {
                directory[tag] = entry(tag, 2, text.size(), free + tail.size());
                tail += text;
            }
        }

        std::string out = big_endian_ ? "MM" : "II";
        number(out, big_tiff_ ? 43 : 42, 2);
        if (big_tiff_) number(out, 8, 2), number(out, 0, 2);
        number(out, header, word);
        number(out, directory.size(), big_tiff_ ? 8 : 2);
        for (const auto& [tag, made] : directory) out += made;
        number(out, 0, word);
        return out + strip + tail;
    }

private:
    void number(std::string& out, std::uint64_t value, std::size_t bytes) const {
        for (std::size_t i = 0; i < bytes; ++i)
            out += static_cast<char>(value >> (8 * (big_endian_ ? bytes - 1 - i : i)) & 0xff);
    }
    /// Type 2 is text, 4 a 32-bit number.
    [[nodiscard]] std::string entry(std::uint32_t tag, std::uint32_t type, std::size_t count,
                                    std::uint64_t value) const {
        const std::size_t word = big_tiff_ ? 8 : 4;
        std::string out;
        number(out, tag, 2);
        number(out, type, 2);
        number(out, count, word);
        if (type == 4 && big_tiff_) {
            number(out, value, 4);
            number(out, 0, 4);
        } else {
            number(out, value, word);
        }
        return out;
    }

    std::vector<std::uint32_t> samples_;
    std::map<std::uint32_t, std::uint32_t> numbers_;
    std::map<std::uint32_t, std::string> texts_;
    bool big_endian_ = false, big_tiff_ = false;
};

}  // namespace tilth::test
