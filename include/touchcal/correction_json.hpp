// The JSON that correction.hpp reads.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <locale>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace touchcal {

// The file is not what it should be, or positions have no correction.
class CorrectionError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

namespace detail {

// A value of JSON.
struct Json {
    enum class Kind { null, boolean, number, text, list, object };
    Kind kind = Kind::null;
    bool boolean = false;
    double number = 0.0;
    std::string text;
    std::vector<Json> list;
    std::map<std::string, Json> object;

    const Json& at(const std::string& key) const {
        const auto found = object.find(key);
        if (kind != Kind::object || found == object.end()) throw CorrectionError("expected an object with \"" + key + "\"");
        return found->second;
    }

    double as_number() const {
        if (kind != Kind::number) throw CorrectionError("expected a number");
        return number;
    }

    const std::string& as_text() const {
        if (kind != Kind::text) throw CorrectionError("expected a text");
        return text;
    }

    const std::vector<Json>& as_list() const {
        if (kind != Kind::list) throw CorrectionError("expected a list");
        return list;
    }

    template <std::size_t N>
    std::array<double, N> as_numbers() const {
        if (as_list().size() != N) throw CorrectionError("expected " + std::to_string(N) + " numbers");
        std::array<double, N> numbers{};
        for (std::size_t k = 0; k < N; ++k) numbers[k] = list[k].as_number();
        return numbers;
    }
};

// Reads JSON as RFC 8259 has it; keys may not repeat.
class JsonReader {
public:
    explicit JsonReader(const std::string& text) : text_(text) {}

    Json read() {
        Json value = read_value(0);
        skip_space();
        if (at_ != text_.size()) fail("the end");
        return value;
    }

private:
    static constexpr int most_levels = 16;

    [[noreturn]] void fail(const std::string& expected) const {
        throw CorrectionError("byte " + std::to_string(at_) + ": expected " + expected);
    }

    char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }

    void skip_space() {
        while (at_ < text_.size() && std::string(" \t\r\n").find(text_[at_]) != std::string::npos) ++at_;
    }

    bool take(const std::string& word) {
        if (text_.compare(at_, word.size(), word) != 0) return false;
        at_ += word.size();
        return true;
    }

    void expect(const std::string& word) {
        skip_space();
        if (!take(word)) fail(word);
    }

    Json read_value(int level) {
        if (level > most_levels) fail("fewer levels");
        skip_space();
        Json value;
        if (peek() == '{') {
            value.kind = Json::Kind::object;
            read_entries('}', [&] {
                skip_space();
                std::string key = read_text();
                expect(":");
                if (!value.object.emplace(std::move(key), read_value(level + 1)).second) fail("distinct keys");
            });
        } else if (peek() == '[') {
            value.kind = Json::Kind::list;
            read_entries(']', [&] { value.list.push_back(read_value(level + 1)); });
        } else if (peek() == '"') {
            value.kind = Json::Kind::text;
            value.text = read_text();
        } else if (take("true") || take("false")) {
            value.kind = Json::Kind::boolean;
            value.boolean = text_[at_ - 2] == 'u';
        } else if (!take("null")) {
            value.kind = Json::Kind::number;
            value.number = read_number();
        }
        return value;
    }

    template <typename Read>
    void read_entries(char end, Read read) {
        ++at_;
        skip_space();
        if (peek() == end) {
            ++at_;
            return;
        }
        while (true) {
            read();
            skip_space();
            if (peek() == end) break;
            expect(",");
        }
        ++at_;
    }

    std::string read_text() {
        if (peek() != '"') fail("a text");
        ++at_;
        std::string text;
        while (peek() != '"') {
            if (at_ >= text_.size() || static_cast<unsigned char>(peek()) < 0x20) fail("the end of the text");
            text += peek() == '\\' ? read_escape() : std::string(1, text_[at_++]);
        }
        ++at_;
        return text;
    }

    // An escaped character in UTF-8; halves of surrogate pairs are kept apart, which names do not need.
    std::string read_escape() {
        static const std::string from = "\"\\/bfnrt", to = "\"\\/\b\f\n\r\t";
        ++at_;
        const char kind = peek();
        ++at_;
        if (const auto k = from.find(kind); kind != '\0' && k != std::string::npos) return std::string(1, to[k]);
        if (kind != 'u') fail("an escaped character");
        unsigned code = 0;
        for (int digit = 0; digit < 4; ++digit, ++at_) {
            const auto value = std::string("0123456789abcdef").find(peek() >= 'A' && peek() <= 'F' ? peek() + 32 : peek());
            if (peek() == '\0' || value == std::string::npos) fail("four hexadecimal digits");
            code = 16 * code + static_cast<unsigned>(value);
        }
        const auto byte = [](unsigned value) { return static_cast<char>(static_cast<unsigned char>(value)); };
        if (code < 0x80) return {byte(code)};
        if (code < 0x800) return {byte(0xC0 | (code >> 6)), byte(0x80 | (code & 0x3F))};
        return {byte(0xE0 | (code >> 12)), byte(0x80 | ((code >> 6) & 0x3F)), byte(0x80 | (code & 0x3F))};
    }

    std::size_t skip_digits() {
        const std::size_t from = at_;
        while (peek() >= '0' && peek() <= '9') ++at_;
        return at_ - from;
    }

    double read_number() {
        const std::size_t from = at_;
        take("-");
        if (peek() == '0') {
            ++at_;
        } else if (skip_digits() == 0) {
            fail("a value");
        }
        if (take(".") && skip_digits() == 0) fail("a digit");
        if (take("e") || take("E")) {
            if (!take("+")) take("-");
            if (skip_digits() == 0) fail("a digit");
        }
        // Of the program's locale nothing is taken: it may have a comma for the point.
        std::istringstream stream(text_.substr(from, at_ - from));
        stream.imbue(std::locale::classic());
        double number = 0.0;
        stream >> number;
        if (stream.fail() || !std::isfinite(number)) fail("a number of double precision");
        return number;
    }

    const std::string& text_;
    std::size_t at_ = 0;
};

} // namespace detail

} // namespace touchcal
