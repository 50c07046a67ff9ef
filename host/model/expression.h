// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace dttmm::host {

/// The names an expression may use, with their values [SI].
using Constants = std::map<std::string, double, std::less<>>;

/// A formula over named constants, pi and, if asked for, one variable, as the time t [s]; compiled once. Operators + - * /
/// ^, comparisons,
/// && || and a ? b : c; functions sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh log (natural) ln log2
/// log10 exp sqrt sign rint abs sum avg min max. At most 1000 bytes and 30 brackets within each other.
/// A name in it is letters of any script, digits and '_': '-' is always minus. A station's coordinate has a point: front.x.
class Expression {
public:
    /// `text` is what follows the "=". Throws Error(model_invalid), quoting it, if it is no formula or uses an unknown name.
    /// The variable counts before a constant of its name; empty: there is none.
    Expression(std::string_view text, const Constants& constants, const std::string& variable = {});
    /// Of several variables: each value() reads them where they stand, which must outlive this.
    using Variables = std::map<std::string, double*, std::less<>>;
    Expression(std::string_view text, const Variables& variables);
    ~Expression();
    Expression(Expression&&) noexcept;
    Expression& operator=(Expression&&) noexcept;

    /// Never allocates; may be non-finite. One thread at a time.
    double value(double argument = 0) const;

    const std::string& text() const;

private:
    struct Compiled;
    void compile(std::string_view text, const Constants& constants, const std::string& variable, const Variables& variables);
    std::unique_ptr<Compiled> compiled_;
};

/// Value of a formula without time. Throws Error(model_invalid) like Expression, and if the value is not finite.
double evaluate_expression(std::string_view text, const Constants& constants);

/// The functions that an expression may use.
std::vector<std::string> expression_functions();

/// The names in an expression that are not functions, each once; pi and t too.
std::vector<std::string> expression_names(std::string_view text);

inline constexpr int kDeepestBrackets = 30;  ///< within each other in an expression

/// Throws Error(model_invalid) for an expression that is longer, or has more brackets within each other, than allowed.
void check_expression_size(std::string_view text);

/// The expression with every name in it that is no number put through `replacement`, functions too.
std::string replace_names(std::string_view text, const std::function<std::string(const std::string&)>& replacement);

/// The name that is all there is in `text`; empty if there is more, or something else.
std::string bare_name(std::string_view text);

}  // namespace dttmm::host
