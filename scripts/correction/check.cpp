// include/touchcal/correction.hpp against positions that the library computed.
//
//     check ARM.json ARM.csv ...
//
// A row of a table: measured positions, a load or measured torques of joints, true positions.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "touchcal/correction.hpp"

namespace {

int failures = 0;

void check(bool holds, const std::string& what) {
    if (holds) return;
    std::fprintf(stderr, "failed: %s\n", what.c_str());
    ++failures;
}

double most_apart(const std::vector<double>& a, const std::vector<double>& b) {
    double most = a.size() == b.size() ? 0.0 : HUGE_VAL;
    for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
    return most;
}

std::string read(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    check(at != std::string::npos, "the file has " + from);
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

template <typename Call>
bool is_error(const Call& call) {
    try {
        call();
        return false;
    } catch (const touchcal::CorrectionError&) {
        return true;
    }
}

bool is_refused(const std::string& text) {
    return is_error([&] { touchcal::Correction correction(text); });
}

void check_positions(const touchcal::Correction& correction, const std::string& table) {
    const std::size_t n = correction.size();
    const bool is_measured = correction.has_measured_torques();
    const std::size_t carried = is_measured ? n : 6;
    std::istringstream lines(read(table));
    std::string line;
    int rows = 0;
    for (; std::getline(lines, line); ++rows) {
        std::vector<double> numbers;
        std::istringstream cells(line);
        for (std::string cell; std::getline(cells, cell, ',');) numbers.push_back(std::strtod(cell.c_str(), nullptr));
        check(numbers.size() == 2 * n + carried, table + ": numbers of a row");
        if (numbers.size() != 2 * n + carried) return;
        const auto part = [&](std::size_t from) {
            const auto begin = numbers.begin() + static_cast<std::ptrdiff_t>(from);
            return std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(n));
        };
        const auto measured = part(0), expected = part(n + carried);
        if (is_measured) {
            check(most_apart(correction.true_positions(measured, touchcal::Tau{part(n)}), expected) < 1e-12, table + ": tau");
            check(is_error([&] { correction.true_positions(measured); }), table + ": torques are needed");
            check(is_error([&] { correction.commanded_positions(expected); }), table + ": nothing is commanded");
            continue;
        }
        check(is_error([&] { correction.true_positions(measured, touchcal::Tau{measured}); }), table + ": no torques");
        const bool has_backlash = table.find("backlash") != std::string::npos;
        touchcal::Load load{};
        std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(n), 6, load.begin());
        const auto found = correction.true_positions(measured, load);
        check(most_apart(found, expected) < 1e-12, table + ": true positions");
        if (has_backlash) {
            check(is_error([&] { correction.commanded_positions(expected, load); }), table + ": nothing is commanded");
            continue;
        }
        check(most_apart(correction.commanded_positions(expected, load), measured) < 1e-12, table + ": commanded positions");
        check(most_apart(correction.commanded_positions(found, load), measured) < 1e-12, table + ": there and back");
    }
    check(rows > 10, table + ": rows");
    const std::vector<double> in_degrees(n, -90.0);
    check(is_error([&] { correction.true_positions(in_degrees, touchcal::Tau{std::vector<double>(n)}); }), table + ": degrees");
    check(is_error([&] { correction.true_positions(in_degrees); }), table + ": degrees are refused");
    check(is_error([&] { correction.commanded_positions(in_degrees); }), table + ": degrees are not commanded");
    check(is_error([&] { correction.torques(in_degrees); }), table + ": degrees have no torques");
}

void check_refusals(const std::string& text) {
    for (std::size_t length = 0; length + 2 < text.size(); ++length) {
        check(is_refused(text.substr(0, length)), "the first " + std::to_string(length) + " bytes are refused");
    }
    const std::vector<std::pair<std::string, std::string>> mistakes = {
        {"\"schema\": 1", "\"schema\": 2"},         {"\"schema\": 1,", "\"schema\": 1, \"schema\": 1,"},
        {"\"usable\"", "\"not_usable\""},           {"\"usable\"", "\"fine\""},
        {"\"order\":2", "\"order\":1.5"},           {"\"mass_kg\":", "\"mass\":"},
        {"\"sin\":", "\"sin\":0"},                  {"\"sin\":", "\"sin\":1e999,\"was\":"},
        {"\"xyz_m\":[", "\"xyz_m\":[1,"},           {"\"quat_wxyz\":[", "\"quat_wxyz\":[3,0,0,0],\"was\":["},
        {"\"axis\":[", "\"axis\":[0,0,2],\"was\":["}, {"{", "[[[[[[[[[[[[[[[[[[[[{"},
        {"\"gravity_and_load\"", "\"felt\""},
        {"\"revolute\"", "\"fixed\""},              {"\"version\": \"", "\"version\": \"\\x"},
    };
    for (const auto& [from, to] : mistakes) check(is_refused(replaced(text, from, to)), from + " -> " + to + " is refused");
    check(is_refused(text + "{}"), "what follows is refused");
    check(!is_refused(replaced(text, "\"version\": \"", "\"version\": \"\\u00e4\\n")), "escaped characters are read");
    const touchcal::Correction read_anyway(replaced(text, "\"usable\"", "\"not_usable\""), true);
    check(read_anyway.status() == "not_usable", "a result that is not usable can be read");
    try {
        read_anyway.true_positions(std::vector<double>(read_anyway.size() + 1, 0.0));
        check(false, "too many positions are refused");
    } catch (const touchcal::CorrectionError&) {
    }
}

} // namespace

int main(int count, char** arguments) try {
    for (int k = 1; k + 1 < count; k += 2) check_positions(touchcal::Correction::read(arguments[k]), arguments[k + 1]);
    if (count < 3) return 2;
    check_refusals(read(arguments[1]));
    check(is_refused(""), "an empty file is refused");
    return failures == 0 ? 0 : 1;
} catch (const std::exception& error) {
    std::fprintf(stderr, "failed: %s\n", error.what());
    return 1;
}
