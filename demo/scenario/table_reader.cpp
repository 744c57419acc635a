#include "demo/scenario/table_reader.h"

#include <cmath>

#include "tilth/core/result.h"

namespace tilth::demo {

namespace {

int line_in(const toml::source_region& source) { return static_cast<int>(source.begin.line); }

std::string type_text(const toml::node& node) {
    switch (node.type()) {
        case toml::node_type::table:
            return "a table";
        case toml::node_type::array:
            return "a list";
        case toml::node_type::string:
            return "text";
        case toml::node_type::integer:
            return "an integer";
        case toml::node_type::floating_point:
            return "a number";
        case toml::node_type::boolean:
            return "true or false";
        default:
            return "a date or time";
    }
}

std::string is_a(const toml::node& node, std::string_view allowed) {
    return text("is ", type_text(node), "; allowed: ", allowed);
}

/// Text from the file goes to a terminal: no control characters, no page-long values.
std::string quoted(std::string_view value) {
    std::string out = "'";
    for (const char c : value.substr(0, 80)) out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
    return out + (value.size() > 80 ? "...'" : "'");
}

}  // namespace

std::string one_of(const std::vector<std::string>& names) {
    std::string out;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (i > 0) out += i + 1 == names.size() ? " or " : ", ";
        out += names[i];
    }
    return out;
}

TableReader::TableReader(const toml::table& table, std::string name, int line, Problems& problems)
    : table_(table), name_(std::move(name)), line_(line), problems_(problems) {}

int TableReader::line_of(std::string_view key) const {
    const toml::node* node = table_.get(key);
    return node != nullptr && node->source().begin.line > 0 ? line_in(node->source()) : line_;
}

const toml::node* TableReader::take(std::string_view key) {
    known_.emplace(key);
    return table_.get(key);
}

void TableReader::wrong(std::string_view key, std::string text) {
    problems_.add(line_of(key), std::string(key), std::move(text));
}

void TableReader::missing(std::string_view key, std::string_view allowed) {
    problems_.add(line_, std::string(key), text("missing in ", name_, "; allowed: ", allowed));
}

void TableReader::not_yet(std::string_view key, std::string_view what) {
    if (take(key) != nullptr) wrong(key, text("this build does not have ", what, " yet; leave the key out"));
}

void TableReader::empty_list(std::string_view key, std::string_view what) {
    const toml::node* node = take(key);
    if (node == nullptr) return;
    if (!node->is_array())
        wrong(key, is_a(*node, "a list of names"));
    else if (!node->as_array()->empty())
        wrong(key, text("this build does not have ", what, " yet; allowed: the empty list"));
}

std::optional<double> TableReader::number_of(const toml::node& node, std::string_view key, const Range& range) {
    const std::optional<double> value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value) {
        problems_.add(line_in(node.source()), std::string(key), is_a(node, range.text));
        return {};
    }
    if (!std::isfinite(*value) || !range.has(*value)) {
        problems_.add(line_in(node.source()), std::string(key), text("is ", *value, "; allowed: ", range.text));
        return {};
    }
    return value;
}

std::optional<double> TableReader::number(std::string_view key, const Range& range) {
    const toml::node* node = take(key);
    return node == nullptr ? std::nullopt : number_of(*node, key, range);
}

double TableReader::required_number(std::string_view key, const Range& range) {
    if (!has(key)) missing(key, range.text);
    return number(key, range).value_or(range.has(1) ? 1 : range.high);
}

std::optional<std::int64_t> TableReader::integer(std::string_view key, std::int64_t low, std::int64_t high) {
    const toml::node* node = take(key);
    if (node == nullptr) return {};
    const std::string allowed = text("an integer from ", low, " to ", high);
    if (!node->is_integer()) {
        wrong(key, is_a(*node, allowed));
        return {};
    }
    const std::int64_t value = *node->value<std::int64_t>();
    if (value < low || value > high) {
        wrong(key, text("is ", value, "; allowed: ", allowed));
        return {};
    }
    return value;
}

std::optional<bool> TableReader::boolean(std::string_view key) {
    const toml::node* node = take(key);
    if (node == nullptr) return {};
    if (!node->is_boolean()) {
        wrong(key, is_a(*node, "true or false"));
        return {};
    }
    return node->value<bool>();
}

std::optional<std::string> TableReader::string_of(const toml::node& node, std::string_view key,
                                                  std::string_view allowed) {
    if (!node.is_string()) {
        problems_.add(line_in(node.source()), std::string(key), is_a(node, allowed));
        return {};
    }
    std::string value = *node.value<std::string>();
    const bool control =
        std::any_of(value.begin(), value.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; });
    if (value.empty() || value.size() > 4096 || control) {
        problems_.add(
            line_in(node.source()), std::string(key),
            text("is ", value.empty() ? "empty" : "too long or has control characters", "; allowed: ", allowed));
        return {};
    }
    return value;
}

std::optional<std::string> TableReader::string(std::string_view key, std::string_view allowed) {
    const toml::node* node = take(key);
    return node == nullptr ? std::nullopt : string_of(*node, key, allowed);
}

std::string TableReader::required_string(std::string_view key, std::string_view allowed) {
    if (!has(key)) missing(key, allowed);
    return string(key, allowed).value_or("");
}

std::optional<std::size_t> TableReader::choice(std::string_view key, const std::vector<std::string>& allowed) {
    const std::optional<std::string> value = string(key, one_of(allowed));
    if (!value) return {};
    const auto found = std::find(allowed.begin(), allowed.end(), *value);
    if (found == allowed.end()) {
        wrong(key, text("unknown ", quoted(*value), "; allowed: ", one_of(allowed)));
        return {};
    }
    return static_cast<std::size_t>(found - allowed.begin());
}

std::optional<std::vector<std::size_t>> TableReader::choices(std::string_view key,
                                                             const std::vector<std::string>& allowed) {
    const toml::node* node = take(key);
    if (node == nullptr) return {};
    const toml::array* list = node->as_array();
    if (list == nullptr || list->empty()) {
        wrong(key, list == nullptr ? is_a(*node, "a list of " + one_of(allowed))
                                   : text("is an empty list; allowed: at least one of ", one_of(allowed)));
        return {};
    }
    std::set<std::size_t> indices;
    for (const toml::node& entry : *list) {
        const std::optional<std::string> value = string_of(entry, key, one_of(allowed));
        if (!value) continue;
        const auto found = std::find(allowed.begin(), allowed.end(), *value);
        if (found == allowed.end())
            problems_.add(line_in(entry.source()), std::string(key),
                          text("unknown ", quoted(*value), "; allowed: ", one_of(allowed)));
        else
            indices.insert(static_cast<std::size_t>(found - allowed.begin()));
    }
    if (indices.empty()) return {};
    return std::vector<std::size_t>(indices.begin(), indices.end());
}

std::optional<std::vector<double>> TableReader::numbers(std::string_view key, std::size_t least, std::size_t most,
                                                        const Range& range) {
    const toml::node* node = take(key);
    if (node == nullptr) return {};
    const std::string count = least == most ? text(least) : text(least, " to ", most);
    const toml::array* list = node->as_array();
    if (list == nullptr || list->size() < least || list->size() > most) {
        wrong(key, list == nullptr
                       ? is_a(*node, text("a list of ", count, " numbers"))
                       : text("has ", list->size(), " values; allowed: ", count, " numbers, each ", range.text));
        return {};
    }
    std::vector<double> values;
    for (const toml::node& entry : *list)
        if (const auto value = number_of(entry, key, range)) values.push_back(*value);
    if (values.size() != list->size()) return {};
    return values;
}

std::optional<WorldPos> TableReader::position_of(const toml::node& node, std::string_view key) {
    const toml::array* list = node.as_array();
    if (list == nullptr || list->size() != 2) {
        problems_.add(line_in(node.source()), std::string(key), "is not a position; allowed: [x, z] in metres");
        return {};
    }
    const auto x = number_of(*list->get(0), key, kCoordinate), z = number_of(*list->get(1), key, kCoordinate);
    if (!x || !z) return {};
    return WorldPos{*x, *z};
}

std::optional<WorldPos> TableReader::position(std::string_view key) {
    const toml::node* node = take(key);
    return node == nullptr ? std::nullopt : position_of(*node, key);
}

WorldPos TableReader::required_position(std::string_view key) {
    if (!has(key)) missing(key, "[x, z] in metres");
    return position(key).value_or(WorldPos{});
}

std::optional<std::vector<WorldPos>> TableReader::positions(std::string_view key, std::size_t least, std::size_t most) {
    const toml::node* node = take(key);
    if (node == nullptr) return {};
    const toml::array* list = node->as_array();
    if (list == nullptr || list->size() < least || list->size() > most) {
        const std::string count = least == most ? text(least) : text(least, " to ", most);
        wrong(key, text("is not a list of ", count, " positions; allowed: [[x, z], [x, z], ...] in metres"));
        return {};
    }
    std::vector<WorldPos> values;
    for (const toml::node& entry : *list)
        if (const auto value = position_of(entry, key)) values.push_back(*value);
    if (values.size() != list->size()) return {};
    return values;
}

const toml::table* TableReader::table(std::string_view key, std::string_view allowed) {
    const toml::node* node = take(key);
    if (node == nullptr) return nullptr;
    if (!node->is_table()) wrong(key, is_a(*node, allowed));
    return node->as_table();
}

void TableReader::finish() {
    for (const auto& [key, node] : table_) {
        const std::string_view name = key.str();
        if (known_.contains(name)) continue;
        const int at = key.source().begin.line > 0 ? line_in(key.source()) : line_in(node.source());
        std::vector<std::string> allowed(known_.begin(), known_.end());
        std::string clean(name.substr(0, 80));
        for (char& c : clean)
            if (static_cast<unsigned char>(c) < 0x20) c = '?';
        problems_.add(at, clean, text("unknown key in ", name_, "; allowed: ", one_of(allowed)));
    }
}

}  // namespace tilth::demo
