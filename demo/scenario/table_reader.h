// Takes checked values out of one TOML table; what is missing, wrong, out of range or unknown becomes a `Problem`.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

#include "demo/scenario/problems.h"
#include "tilth/core/vec.h"
#include "tilth/world/grid.h"

namespace tilth::demo {

/// The numbers that a key may have. `text` says so in words, with the unit.
struct Range {
    double low, high;
    bool above = false;  ///< `low` itself is not allowed
    const char* text;
    [[nodiscard]] bool has(double v) const { return (above ? v > low : v >= low) && v <= high; }
};

inline constexpr Range kCoordinate{-1e10, 1e10, false, "a number of metres within 1e10 of zero"};
inline constexpr Range kPositiveLength{0, 1e9, true, "a number of metres above 0, at most 1e9"};
inline constexpr Range kHeight{-1e6, 1e6, false, "a number of metres within 1e6 of zero"};

/// One table and the name that messages give it ("stamp", "[view]").
///
/// Each getter marks its key as known. `optional` forms return nothing when the key is absent or wrong; `required`
/// forms report an absent key and then return a harmless value. `finish` reports keys that nobody asked for.
class TableReader {
public:
    TableReader(const toml::table& table, std::string name, int line, Problems& problems);

    [[nodiscard]] bool has(std::string_view key) const { return table_.contains(key); }
    /// Line of a key's value; of the table if there is no such key.
    [[nodiscard]] int line_of(std::string_view key) const;
    [[nodiscard]] int line() const { return line_; }
    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] Problems& problems() { return problems_; }

    std::optional<double> number(std::string_view key, const Range& range);
    double required_number(std::string_view key, const Range& range);
    std::optional<std::int64_t> integer(std::string_view key, std::int64_t low, std::int64_t high);
    std::optional<bool> boolean(std::string_view key);
    /// Any text without control characters, 1..4 096 bytes.
    std::optional<std::string> string(std::string_view key, std::string_view allowed);
    std::string required_string(std::string_view key, std::string_view allowed);
    /// Index of the text in `allowed`.
    std::optional<std::size_t> choice(std::string_view key, const std::vector<std::string>& allowed);
    /// Indices, at least one, without repetition, ascending.
    std::optional<std::vector<std::size_t>> choices(std::string_view key, const std::vector<std::string>& allowed);
    /// A list of `least`..`most` numbers.
    std::optional<std::vector<double>> numbers(std::string_view key, std::size_t least, std::size_t most,
                                               const Range& range);
    std::optional<WorldPos> position(std::string_view key);
    WorldPos required_position(std::string_view key);
    /// A list of `least`..`most` positions.
    std::optional<std::vector<WorldPos>> positions(std::string_view key, std::size_t least, std::size_t most);
    const toml::table* table(std::string_view key, std::string_view allowed);

    /// Marks a key that the caller reads by itself.
    void known(std::string_view key) { known_.emplace(key); }
    void wrong(std::string_view key, std::string text);
    void missing(std::string_view key, std::string_view allowed);
    /// The key is known to the form, but this build cannot do it.
    void not_yet(std::string_view key, std::string_view what);
    /// A list that has to be empty in this build.
    void empty_list(std::string_view key, std::string_view what);
    void finish();

private:
    const toml::node* take(std::string_view key);
    std::optional<double> number_of(const toml::node& node, std::string_view key, const Range& range);
    std::optional<WorldPos> position_of(const toml::node& node, std::string_view key);
    std::optional<std::string> string_of(const toml::node& node, std::string_view key, std::string_view allowed);

    const toml::table& table_;
    std::string name_;
    int line_;
    Problems& problems_;
    std::set<std::string, std::less<>> known_;
};

/// "a, b or c".
std::string one_of(const std::vector<std::string>& names);

}  // namespace tilth::demo
