// SPDX-License-Identifier: BSD-3-Clause
#include "model/expression.h"
#include "model/digits.h"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/error.h"
#include "model/names.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

constexpr std::size_t kLongestExpression = 1000;  // [byte]

[[noreturn]] void fail(const std::string& text) { throw Error(ExitCode::model_invalid, text); }

bool is_name_start(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || static_cast<unsigned char>(c) >= 0x80;
}
bool is_name_part(char c) { return is_name_start(c) || is_digit(c); }
bool is_blank(char c) { return c == ' ' || c == '\t'; }

struct Name {
    std::string text;
    bool is_function;  ///< followed by an opening bracket
};

/// End of the name that starts at `at`. A point is part of it before a letter: "front.x".
std::size_t skip_name(std::string_view text, std::size_t at) {
    const auto is_inner_point = [&](std::size_t i) {
        return text[i] == '.' && i + 1 < text.size() && is_name_start(text[i + 1]);
    };
    while (at < text.size() && (is_name_part(text[at]) || is_inner_point(at))) ++at;
    return at;
}

/// End of the number that starts at `at`: its exponent is no name.
std::size_t skip_number(std::string_view text, std::size_t at) {
    while (at < text.size() && (is_digit(text[at]) || text[at] == '.')) ++at;
    if (at >= text.size() || (text[at] != 'e' && text[at] != 'E')) return at;
    std::size_t digit = at + 1;
    if (digit < text.size() && (text[digit] == '+' || text[digit] == '-')) ++digit;
    if (digit >= text.size() || !is_digit(text[digit])) return at;
    while (digit < text.size() && is_digit(text[digit])) ++digit;
    return digit;
}

std::vector<Name> find_names(std::string_view text) {
    std::vector<Name> names;
    for (std::size_t at = 0; at < text.size();) {
        if (is_digit(text[at]) || text[at] == '.') {
            at = skip_number(text, at);
        } else if (is_name_start(text[at])) {
            const std::size_t end = skip_name(text, at);
            std::size_t next = end;
            while (next < text.size() && is_blank(text[next])) ++next;
            names.push_back({std::string(text.substr(at, end - at)), next < text.size() && text[next] == '('});
            at = end;
        } else {
            ++at;
        }
    }
    return names;
}

/// Refuses what muParser would take but no formula needs: assignments, lists, texts.
void check_characters(std::string_view text) {
    constexpr std::string_view kSigns = "+-*/^().,<>=!&|?: \t";
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (!is_name_part(c) && kSigns.find(c) == kSigns.npos)
            fail(fmt::format("{} is not allowed in an expression: {}", quote({&c, 1}), quote(text)));
        const auto is_comparison = [](char other) { return other == '=' || other == '<' || other == '>' || other == '!'; };
        const bool is_single =
            c == '=' && (i == 0 || !is_comparison(text[i - 1])) && (i + 1 == text.size() || text[i + 1] != '=');
        if (is_single) fail(fmt::format("an expression cannot assign, compare with \"==\": {}", quote(text)));
    }
}

void check_size(std::string_view text) {
    if (text.size() > kLongestExpression)
        fail(fmt::format("an expression of {} bytes; at most {} are allowed", text.size(), kLongestExpression));
    int depth = 0;
    for (const char c : text) {
        depth += c == '(' ? 1 : c == ')' ? -1 : 0;
        if (depth > kDeepestBrackets)
            fail(fmt::format("more than {} brackets within each other: {}", kDeepestBrackets, quote(text)));
    }
}

std::vector<std::string> keys(const auto& map) {
    std::vector<std::string> result;
    for (const auto& [key, value] : map) result.push_back(key);
    return result;
}

void check_function(const std::string& name, std::string_view text, const mu::Parser& parser) {
    if (parser.GetFunDef().count(name)) return;
    fail(fmt::format("unknown function {} in {}{}", quote(name), quote(text), suggestion(name, keys(parser.GetFunDef()))));
}

[[noreturn]] void fail_unknown(const std::string& name, std::string_view text, const Constants& constants,
                               const std::string& variable) {
    for (const auto& [constant, value] : constants)
        if (constant.find('-') != constant.npos && text.find(constant) != text.npos)
            fail(fmt::format(
                "parameter {} cannot be used in {}: '-' is minus there; a name in an expression is made of letters, "
                "digits and '_'",
                quote(constant), quote(text)));
    if (constants.contains(name + ".x"))
        fail(fmt::format("{} in {} is a place, not a number: write {}.x, {}.y or {}.z", quote(name), quote(text), name, name,
                         name));
    std::vector<std::string> known = keys(constants);
    known.emplace_back("pi");
    if (!variable.empty()) known.push_back(variable);
    const bool misses_time = name == "t" && variable != "t";
    fail(fmt::format("unknown name {} in {}{}", quote(name), quote(text),
                     misses_time ? "; the time exists in the expression of a load only" : suggestion(name, known)));
}

}  // namespace

struct Expression::Compiled {
    std::string text;
    mu::Parser parser;
    double argument = 0;

    void define_name(const Name& name, const Constants& constants, const std::string& variable, const Variables& variables) {
        if (name.is_function) return check_function(name.text, text, parser);
        if (const auto known = variables.find(name.text); known != variables.end())
            return parser.DefineVar(name.text, known->second);
        if (name.text == "pi") return parser.DefineConst("pi", std::numbers::pi);
        if (name.text == variable) return parser.DefineVar(variable, &argument);
        const auto found = constants.find(name.text);
        if (found == constants.end()) fail_unknown(name.text, text, constants, variable);
        if (parser.GetFunDef().count(name.text))
            fail(fmt::format("{} in {} is a function; rename the parameter", quote(name.text), quote(text)));
        parser.DefineConst(name.text, found->second);
    }
};

Expression::Expression(std::string_view text, const Constants& constants, const std::string& variable)
    : compiled_(new Compiled) {
    compile(text, constants, variable, {});
}

Expression::Expression(std::string_view text, const Variables& variables) : compiled_(new Compiled) {
    compile(text, {}, {}, variables);
}

void Expression::compile(std::string_view text, const Constants& constants, const std::string& variable,
                         const Variables& variables) {
    check_size(text);
    compiled_->text = normalise_name(text);
    check_characters(compiled_->text);
    mu::Parser& parser = compiled_->parser;
    try {
        parser.ClearConst();
        parser.EnableOptimizer(false);  // where it works out constants, "&&" and "||" take 0.5 for 0
        std::string name_characters = std::string(parser.ValidNameChars()) + '.';
        for (int byte = 0x80; byte <= 0xff; ++byte) name_characters += static_cast<char>(byte);
        parser.DefineNameChars(name_characters.c_str());
        for (const Name& name : find_names(compiled_->text)) compiled_->define_name(name, constants, variable, variables);
        parser.SetExpr(compiled_->text);
        int results = 0;
        parser.Eval(results);  // the first evaluation compiles
        if (results != 1) fail(fmt::format("one value is wanted, not {}: {}", results, quote(text)));
    } catch (const mu::ParserError& error) {
        fail(fmt::format("{}: {}", quote(text), error.GetMsg()));
    }
}

Expression::~Expression() = default;
Expression::Expression(Expression&&) noexcept = default;
Expression& Expression::operator=(Expression&&) noexcept = default;

double Expression::value(double argument) const {
    compiled_->argument = argument;
    return compiled_->parser.Eval();
}

const std::string& Expression::text() const { return compiled_->text; }

double evaluate_expression(std::string_view text, const Constants& constants) {
    const double value = Expression(text, constants).value();
    if (!std::isfinite(value)) fail(fmt::format("the value of {} is not finite", quote("=" + std::string(text))));
    return value;
}

std::vector<std::string> expression_functions() { return keys(mu::Parser().GetFunDef()); }

std::vector<std::string> expression_names(std::string_view text) {
    std::vector<std::string> result;
    for (const Name& name : find_names(normalise_name(text)))
        if (!name.is_function && std::find(result.begin(), result.end(), name.text) == result.end())
            result.push_back(name.text);
    return result;
}

void check_expression_size(std::string_view text) { check_size(text); }

std::string replace_names(std::string_view given, const std::function<std::string(const std::string&)>& replacement) {
    const std::string text = normalise_name(given);
    std::string result;
    for (std::size_t at = 0; at < text.size();) {
        std::size_t end = at + 1;
        if (is_digit(text[at]) || text[at] == '.') {
            end = skip_number(text, at);
        } else if (is_name_start(text[at])) {
            end = skip_name(text, at);
            const std::string name = text.substr(at, end - at), other = replacement(name);
            // A digit or a point beside the name stays apart: "2i" is no number, whatever i is
            const bool is_glued =
                (at > 0 && (is_digit(text[at - 1]) || text[at - 1] == '.')) || (end < text.size() && text[end] == '.');
            result += is_glued && other != name ? " " + other + " " : other;
            at = end;
            continue;
        }
        result += text.substr(at, end - at);
        at = end;
    }
    return result;
}

std::string bare_name(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    const bool is_name = !text.empty() && is_name_start(text.front()) && skip_name(text, 0) == text.size();
    return is_name ? normalise_name(text) : std::string();
}

}  // namespace dttmm::host
