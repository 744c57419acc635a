#include "demo/world/stamp_folder.h"

#include <algorithm>
#include <filesystem>

#include "tilth/io/stamp_image_file.h"

namespace tilth::demo {

std::vector<std::string> stamp_names(const std::string& folder) {
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error))
        if (entry.path().extension() == ".png") names.push_back(entry.path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

std::vector<std::string> shape_names(const std::string& folder) {
    std::vector<std::string> names{"gaussian", "cone", "paraboloid", "cosine", "crater", "disc"};
    for (std::string& name : stamp_names(folder)) names.push_back(std::move(name));
    return names;
}

Result<void> add_stamps(const std::string& folder, ShapeLibrary& library) {
    for (const std::string& name : stamp_names(folder)) {
        const auto image = io::read_stamp_image((std::filesystem::path(folder) / (name + ".png")).string());
        if (!image) return image.error();
        if (const auto id = library.add_image(name, image->width, image->height, image->texels); !id) return id.error();
    }
    return {};
}

}  // namespace tilth::demo
