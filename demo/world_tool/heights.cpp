// export, import, replay: what needs the ground that the world was made on.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "demo/player/region.h"
#include "demo/world_tool/commands.h"
#include "tilth/core/hash.h"
#include "tilth/io/height_file.h"
#include "tilth/io/height_writer.h"
#include "tilth/source/source_spec.h"
#include "tilth/store/rebuild.h"
#include "tilth/store/saved_ground.h"
#include "tilth/store/shape_files.h"

namespace tilth::demo {
namespace {

constexpr std::int64_t kMostTexels = 1LL << 28;  // 1 GiB of floats
constexpr std::int32_t kMostImportSide = 4096;   // of a stamp image
// An import must not shorten the world's undo history.
constexpr std::uint64_t kUndoBytes = std::uint64_t{1} << 40;

Error invalid(std::string message) { return {ErrorCode::InvalidArgument, std::move(message)}; }

/// Opens the world, and prints what opening repaired.
Result<std::unique_ptr<SavedGround>> open_world(const std::string& folder, const std::string& heights) {
    auto ground = ground_of(folder, heights);
    if (!ground) return ground.error();
    auto world =
        SavedGround::open(std::move(*ground), folder, {.flush = {.when = FlushPolicy::When::Manual}}, kUndoBytes);
    if (world)
        for (const Error& report : (*world)->reports()) std::cerr << "tilth-world: " << report.message << std::endl;
    return world;
}

std::string text_of(const StateHash& hash) { return "coarse " + hex16(hash.coarse) + ", detail " + hex16(hash.detail); }

/// A file's heights as two square images: where it has any, and how high they are between `low` and `high`.
struct ImportImages {
    std::int32_t side = 0;
    std::vector<std::uint16_t> mask, values;
};

ImportImages images_of(const HeightSource& file) {
    ImportImages images{.side = std::max(file.width(), file.depth())};
    const std::size_t count = static_cast<std::size_t>(images.side) * static_cast<std::size_t>(images.side);
    images.mask.resize(count);
    images.values.resize(count);
    const double low = file.min_m(), range = std::max(file.max_m() - low, 1e-12);
    for (std::int32_t z = 0; z < file.depth(); ++z)
        for (std::int32_t x = 0; x < file.width(); ++x) {
            const std::size_t at = static_cast<std::size_t>(z) * static_cast<std::size_t>(images.side) + std::size_t(x);
            images.mask[at] = 65535;
            images.values[at] = static_cast<std::uint16_t>(std::lround((file.height_m({x, z}) - low) / range * 65535));
        }
    return images;
}

Result<ShapeId> add_image(ShapeLibrary& shapes, const char* what, std::int32_t side,
                          const std::vector<std::uint16_t>& texels) {
    const std::string name = text("import ", what, " ", hex16(hash_bytes(std::as_bytes(std::span(texels)))));
    if (const auto known = shapes.find(name)) return *known;
    return shapes.add_image(name, side, side, texels);
}

}  // namespace

Result<std::unique_ptr<Ground>> ground_of(const std::string& folder, const std::string& heights) {
    const auto identity = read_identity(system_files(), folder);
    if (!identity) return identity.error();
    const std::string& spec = heights.empty() ? identity->heights : heights;
    if (spec.empty()) return invalid(text("--heights: ", folder, " does not note what it was made on; name it"));
    auto source = is_procedural(spec) ? make_source(spec) : io::read_heights(spec);
    if (!source) return source.error();
    return Ground::create(std::shared_ptr<const HeightSource>(std::move(*source)), identity->settings);
}

Outcome export_heights(const ExportArguments& arguments) {
    const auto world = open_world(arguments.folder, arguments.heights);
    if (!world) return world.error();
    const Ground& ground = (*world)->ground();
    const bool is_fine = arguments.map != MapSelect::Coarse;
    if (arguments.map == MapSelect::Detail && !ground.settings().detail)
        return invalid("--map: this world has no detail");
    const MapGeometry& map = ground.map(is_fine && ground.settings().detail ? MapKind::Detail : MapKind::Coarse);
    const TexelRect rect = texels_in(map.grid, {WorldPos{arguments.region[0], arguments.region[1]},
                                                WorldPos{arguments.region[2], arguments.region[3]}});
    if (rect.empty()) return invalid("--region: no texel of the map lies in it");
    if (rect.count() > kMostTexels)
        return invalid(text("--region: holds ", rect.count(), " texels; allowed: at most ", kMostTexels));
    std::vector<float> values;
    values.reserve(static_cast<std::size_t>(rect.count()));
    for (std::int32_t z = rect.min.z; z < rect.max.z; ++z)
        for (std::int32_t x = rect.min.x; x < rect.max.x; ++x)
            values.push_back(static_cast<float>(ground.height_m(map.grid.world({x, z}), arguments.map)));
    const Result<void> written = io::write_floats(arguments.out, values, rect.width(), rect.depth());
    if (!written) return written.error();
    const WorldPos first = map.grid.world(rect.min);
    std::cout << arguments.out << ": " << rect.width() << " x " << rect.depth() << " heights, the first at (" << first.x
              << ", " << first.z << "), " << map.grid.spacing_m << " m apart\n";
    return true;
}

/// One stroke of two stamps: `set` to the lowest height of the file where it has any, then `max` of that and the
/// heights themselves. Both images lie on the map's texels, so nothing is interpolated.
Outcome import_heights(const ImportArguments& arguments) {
    const auto file = io::read_heights(arguments.file);
    if (!file) return file.error();
    const std::int32_t width = (*file)->width(), depth = (*file)->depth();
    if (width > kMostImportSide || depth > kMostImportSide)
        return invalid(
            text(arguments.file, ": ", width, " x ", depth, " heights; at most ", kMostImportSide, " a side"));
    const auto opened = open_world(arguments.folder, arguments.heights);
    if (!opened) return opened.error();
    SavedGround& world = **opened;
    if (arguments.map == MapKind::Detail && !world.ground().settings().detail)
        return invalid("--map: this world has no detail");
    const GridSpec& grid = world.ground().map(arguments.map).grid;
    const PostPos at = grid.posts({arguments.at[0], arguments.at[1]});
    const double x = std::round(at.x), z = std::round(at.z);
    if (!(x >= 0 && z >= 0 && x + width <= grid.width && z + depth <= grid.depth))
        return invalid(text("--at: ", width, " x ", depth, " texels from (", x, ", ", z,
                            ") on do not lie in the map of ", grid.width, " x ", grid.depth));

    const ImportImages images = images_of(**file);
    const auto mask = add_image(world.shapes(), "mask", images.side, images.mask),
               values = add_image(world.shapes(), "heights", images.side, images.values);
    if (!mask) return mask.error();
    if (!values) return values.error();
    const double half = (images.side - 1) / 2.0, low = (*file)->min_m(), range = (*file)->max_m() - low;
    StampRequest request{
        .shape = *mask,
        .centre = {grid.origin.x + grid.spacing_m * (x + half), grid.origin.z + grid.spacing_m * (z + half)},
        .radius_m = images.side / 2.0 * grid.spacing_m,
        .map = arguments.map == MapKind::Coarse ? MapChoice::Coarse : MapChoice::Detail,
        .rule = StampRule::Set,
        .level_m = low};
    world.begin_stroke();
    if (const auto stamped = world.stamp(request); !stamped) return stamped.error();
    request.shape = *values;
    request.rule = StampRule::Max;
    request.amplitude_m = range;
    if (const auto stamped = world.stamp(request); !stamped) return stamped.error();
    world.end_stroke();
    if (const Result<void> saved = world.save(); !saved) return saved.error();
    std::cout << width << " x " << depth << " heights from " << low << " to " << low + range << " m, in steps of "
              << range / 65535 << " m; one stroke, which can be undone\n";
    return true;
}

Outcome replay(const std::string& folder, const std::string& heights) {
    auto world = open_world(folder, heights);
    if (!world) return world.error();
    WorldFolder& files = (*world)->world();
    const std::uint64_t edits = files.appended();
    std::cout << "pages:   " << text_of((*world)->ground().hash()) << '\n';
    if (files.first_edit() != 1 && edits > 0) {
        std::cerr << "tilth-world: " << folder << ": the journal begins at edit " << files.first_edit()
                  << ", so it cannot be replayed from the beginning" << std::endl;
        return false;
    }
    auto ground = ground_of(folder, heights);
    if (!ground) return ground.error();
    const auto shapes = read_shapes(system_files(), folder, files.identity().salt, (*ground)->shapes());
    if (!shapes) return shapes.error();
    const auto all = edits == 0 ? Result<std::vector<Edit>>(std::vector<Edit>()) : files.read_edits(1, edits);
    if (!all) return all.error();
    // What was undone was never there: a way that shares nothing with that of the pages, which put back what was.
    const std::vector<StampRecord> stamps = stamps_in_effect(*all);
    for (const StampRecord& record : stamps) {
        if (const Result<void> accepted = (*ground)->accept(record); !accepted) return accepted.error();
        (*ground)->apply(record);
    }
    std::cout << "journal: " << text_of((*ground)->hash()) << ", " << edits << " edits, " << stamps.size()
              << " stamps in effect\n";
    const bool is_same = (*ground)->hash() == (*world)->ground().hash();
    std::cout << (is_same ? "the same\n" : "they differ\n");
    return is_same;
}

}  // namespace tilth::demo
