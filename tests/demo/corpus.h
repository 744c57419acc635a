// The malformed scenarios of tests/demo/corpus, each with what its first line says is wrong.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace tilth::test {

struct CorpusFile {
    std::filesystem::path path;
    int line = 0;     ///< where the mistake stands
    std::string key;  ///< and in which key
};

/// Every file's first line reads "# expect: LINE KEY".
inline std::vector<CorpusFile> corpus() {
    std::vector<CorpusFile> files;
    for (const auto& entry : std::filesystem::directory_iterator(TILTH_SOURCE_DIR "/tests/demo/corpus")) {
        CorpusFile file{entry.path(), 0, {}};
        std::ifstream in(entry.path());
        std::string first, hash, word;
        std::getline(in, first);
        std::istringstream(first) >> hash >> word >> file.line >> file.key;
        files.push_back(file);
    }
    std::sort(files.begin(), files.end(), [](const CorpusFile& a, const CorpusFile& b) { return a.path < b.path; });
    return files;
}

}  // namespace tilth::test
