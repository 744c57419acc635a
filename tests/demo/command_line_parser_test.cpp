// The program itself, on bad arguments and bad scenarios: exit status 2 before anything starts, and a message that
// helps.
#include <gtest/gtest.h>

#include "demo/corpus.h"
#include "demo/run_program.h"

namespace tilth::test {
namespace {

struct BadArguments {
    const char* arguments;
    const char* flag;     ///< named in the message
    const char* allowed;  ///< what it offers
};

TEST(CommandLine, BadArgumentsAreRefusedWithFlagAndAllowedValues) {
    const BadArguments cases[] = {
        {"--size 0x0", "--size", "WIDTHxHEIGHT"},
        {"--size 640", "--size", "WIDTHxHEIGHT"},
        {"--size 640x480x3", "--size", "WIDTHxHEIGHT"},
        {"--size 99999999999x2", "--size", "16384"},
        {"--size -640x480", "--size", "WIDTHxHEIGHT"},
        {"--size ' 64x48'", "--size", "WIDTHxHEIGHT"},
        {"--backend paralax", "--backend", "none|parallax|geometry|tessellation|hybrid"},
        {"--backend ''", "--backend", "hybrid"},
        {"--preset ultra", "--preset", "low|medium|high|exact"},
        {"--executor tpu", "--executor", "gpu|cpu|automatic"},
        {"--context wgl", "--context", "egl|osmesa|glfw"},
        {"--precision bits8", "--precision", "bits32|bits16"},
        {"--store ''", "--store", "folder"},
        {"--stamps /no/such/folder", "--stamps", "Directory"},
        {"--shaders /no/such/folder", "--shaders", "Directory"},
        {"--frames many", "--frames", "many"},
        {"--headless", "--headless", "--scenario"},
        {"--scenario", "--scenario", "1 required"},
        {"--no-such-flag", "--no-such-flag", ""},
        {"stray.toml", "stray.toml", ""},
        {"--headless --scenario no_such_file.toml", "no_such_file.toml", "TOML"},
        {"--headless --scenario .", "scenario", "TOML"},
    };
    for (const BadArguments& c : cases) {
        SCOPED_TRACE(c.arguments);
        const Ran ran = run_sandbox_program(c.arguments);
        EXPECT_EQ(ran.status, 2) << ran.output;
        EXPECT_NE(ran.output.find(c.flag), std::string::npos) << ran.output;
        EXPECT_NE(ran.output.find(c.allowed), std::string::npos) << ran.output;
    }
}

TEST(CommandLine, HelpIsNoMistake) {
    const Ran ran = run_sandbox_program("--help");
    EXPECT_EQ(ran.status, 0);
    for (const char* flag : {"--headless", "--scenario", "--size", "--backend", "--preset", "--executor", "--context",
                             "--precision", "--store", "--out", "--stats", "--stamps", "--shaders"})
        EXPECT_NE(ran.output.find(flag), std::string::npos) << flag;
}

TEST(CommandLine, EveryBadScenarioStopsTheProgramAtItsLine) {
    for (const CorpusFile& file : corpus()) {
        SCOPED_TRACE(file.path.filename().string());
        const Ran ran = run_sandbox_program("--headless --scenario '" + file.path.string() + "'");
        EXPECT_EQ(ran.status, 2) << ran.output;
        const std::string start = file.path.string() + ":" + std::to_string(file.line) + ": " + file.key + ": ";
        EXPECT_NE(ran.output.find(start), std::string::npos) << "expected " << start << "\ngot " << ran.output;
    }
}

TEST(CommandLine, AFlagDoesNotExcuseTheFile) {
    const std::string bad = TILTH_SOURCE_DIR "/tests/demo/corpus/size_zero.toml";
    EXPECT_EQ(run_sandbox_program("--headless --size 64x48 --scenario '" + bad + "'").status, 2);
}

}  // namespace
}  // namespace tilth::test
