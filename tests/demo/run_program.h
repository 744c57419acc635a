// Runs a real program and catches what it says.
#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

namespace tilth::test {

struct Ran {
    int status = -1;     ///< exit status; -1 if it died by a signal
    std::string output;  ///< stdout and stderr
    [[nodiscard]] bool says(const std::string& what) const { return output.find(what) != std::string::npos; }
};

/// `arguments` as the shell reads them.
inline Ran run_program(const std::string& program, const std::string& arguments) {
    Ran ran;
    std::FILE* pipe = popen(("'" + program + "' " + arguments + " 2>&1 </dev/null").c_str(), "r");
    if (pipe == nullptr) return ran;
    std::array<char, 4096> part{};
    for (std::size_t n = 0; (n = std::fread(part.data(), 1, part.size(), pipe)) > 0;) ran.output.append(part.data(), n);
    const int status = pclose(pipe);
    if (WIFEXITED(status)) ran.status = WEXITSTATUS(status);
    return ran;
}

inline Ran run_sandbox_program(const std::string& arguments) { return run_program(TILTH_SANDBOX_PROGRAM, arguments); }

}  // namespace tilth::test
