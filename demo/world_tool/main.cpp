// tilth-world: looks into worlds on disk, checks them, brings heights out and in.
#include <CLI/CLI.hpp>
#include <functional>
#include <iostream>

#include "demo/world_tool/commands.h"

namespace tilth::demo {
namespace {

int run(int argc, const char* const* argv) {
    CLI::App app("tilth-world: worlds on disk", "tilth-world");
    app.require_subcommand(1);
    app.footer("Exit status: 0 all well, 1 something is wrong with the world or differs, 2 it could not be done.");
    std::string folder, heights;
    std::function<Outcome()> command;
    const auto add = [&](const char* name, const char* what, std::function<Outcome()> action) {
        CLI::App* const added = app.add_subcommand(name, what);
        added->add_option("FOLDER", folder, "of the world")->required();
        added->callback([&command, action = std::move(action)] { command = action; });
        return added;
    };
    const auto with_heights = [&](CLI::App* command_app) {
        command_app->add_option(
            "--heights", heights,
            "what the world was made on: a file, or ridged:..., flat:..., hill:...; else what it notes");
        return command_app;
    };
    add("info", "prints what the world is and has", [&] { return print_info(folder); });
    add("verify", "reads everything and tells what is damaged, with file and offset", [&] { return verify(folder); });
    add("compact", "gives disk space back", [&] { return compact(folder); });
    with_heights(add("replay", "does the whole journal again and compares the result with the pages",
                     [&] { return replay(folder, heights); }));

    ExportArguments exporting;
    ImportArguments importing;
    std::string map = "sum";
    CLI::App* const out = with_heights(add("export", "writes a rectangle of heights, metres, as a TIFF of floats", [&] {
        exporting.folder = folder;
        exporting.heights = heights;
        exporting.map = map == "sum" ? MapSelect::Sum : map == "coarse" ? MapSelect::Coarse : MapSelect::Detail;
        return export_heights(exporting);
    }));
    out->add_option("--region", exporting.region, "x0 z0 x1 z1, metres")->required();
    out->add_option("--map", map, "coarse, detail, or their sum at the detail map's texels")
        ->check(CLI::IsMember({"coarse", "detail", "sum"}));
    out->add_option("--out", exporting.out, "the file to write, .tif")->required();

    CLI::App* const in = with_heights(add("import", "sets the heights of a rectangle to those of a file", [&] {
        importing.folder = folder;
        importing.heights = heights;
        importing.map = map == "detail" ? MapKind::Detail : MapKind::Coarse;
        return import_heights(importing);
    }));
    in->add_option("FILE", importing.file, "heights as a TIFF, PNG, EXR, .r16 or .r32f; at most 4096 x 4096")
        ->required();
    in->add_option("--map", map, "coarse, or detail (offsets from undisturbed ground, within 8 m)")
        ->check(CLI::IsMember({"coarse", "detail"}))
        ->required();
    in->add_option("--at", importing.at, "x z of the file's first texel, metres")->required();
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    const Outcome outcome = command();
    if (!outcome) std::cerr << "tilth-world: " << outcome.error().message << std::endl;
    return !outcome ? 2 : *outcome ? 0 : 1;
}

}  // namespace
}  // namespace tilth::demo

int main(int argc, char** argv) {
    try {
        return tilth::demo::run(argc, argv);
    } catch (const std::exception& error) {
        std::cerr << "tilth-world: " << error.what() << std::endl;
        return 2;
    }
}
