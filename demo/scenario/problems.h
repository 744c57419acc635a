// What is wrong with a scenario, collected so that one run reports everything.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace tilth::demo {

/// One mistake: where it stands, which key, what is wrong and what is allowed.
struct Problem {
    int line = 1;
    std::string key;
    std::string text;
};

/// Mistakes of one file.
class Problems {
public:
    void add(int line, std::string key, std::string text) {
        list_.push_back({std::max(line, 1), std::move(key), std::move(text)});
    }
    [[nodiscard]] bool empty() const { return list_.empty(); }
    [[nodiscard]] const std::vector<Problem>& list() const { return list_; }

    /// "FILE:LINE: key: text", a line for each, in the file's order.
    [[nodiscard]] std::string report(const std::string& file) const {
        std::vector<Problem> sorted = list_;
        std::stable_sort(sorted.begin(), sorted.end(),
                         [](const Problem& a, const Problem& b) { return a.line < b.line; });
        std::string out;
        for (const Problem& p : sorted)
            out += file + ":" + std::to_string(p.line) + ": " + p.key + ": " + p.text + "\n";
        return out;
    }

private:
    std::vector<Problem> list_;
};

}  // namespace tilth::demo
