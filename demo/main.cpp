#include "demo/arguments.h"
#include "demo/sandbox.h"

#include <exception>
#include <iostream>

int main(int argc, char** argv) {
    try {
        const auto parsed = tilth::demo::parse_arguments(argc, argv);
        return parsed.exit_status ? *parsed.exit_status : tilth::demo::run_sandbox(parsed.arguments);
    } catch (const std::exception& error) {
        std::cerr << "tilth-sandbox: " << error.what() << std::endl;
        return 2;
    }
}
