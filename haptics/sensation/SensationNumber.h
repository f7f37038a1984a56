#pragma once

#include <cstddef>
#include <vector>

namespace midair::haptics
{

class SensationValues;

/// A number of a pattern: a constant, a parameter, or a formula of both with + - * / and negation.
/// Division by 0 gives infinity or NaN.
class SensationNumber
{
public:
    /// Deepest formula, and most terms of one, so that evaluating it has a bound.
    static constexpr std::size_t kMostDepth = 64;
    static constexpr std::size_t kMostTerms = 1000;

    SensationNumber(double value = 0.0) : _value(value) {} // NOLINT(google-explicit-constructor)
    /// The value of the parameter at \a index of the pattern's parameters.
    static SensationNumber parameter(std::size_t index);

    /// Formulas. They throw InputError for one that is deeper than kMostDepth or has more than
    /// kMostTerms terms.
    friend SensationNumber operator+(const SensationNumber& a, const SensationNumber& b);
    friend SensationNumber operator-(const SensationNumber& a, const SensationNumber& b);
    friend SensationNumber operator*(const SensationNumber& a, const SensationNumber& b);
    friend SensationNumber operator/(const SensationNumber& a, const SensationNumber& b);
    friend SensationNumber operator-(const SensationNumber& a);

    /// Returns the value for these parameters. Doesn't allocate.
    double at(const SensationValues& values) const
    {
        return _terms.empty() ? _value : ofTerms(values);
    }

private:
    enum class Kind
    {
        CONSTANT,
        PARAMETER,
        ADD,
        SUBTRACT,
        MULTIPLY,
        DIVIDE,
        NEGATE
    };
    /// Terms are in postfix order: operands before their operator.
    struct Term
    {
        Kind kind;
        double value;      ///< of a constant
        std::size_t index; ///< of a parameter
    };

    static SensationNumber joined(const SensationNumber& a, const SensationNumber& b, Kind kind);
    void append(const SensationNumber& other);
    void require() const;
    double ofTerms(const SensationValues& values) const;

    double _value;            ///< of a constant; without terms
    std::size_t _depth = 1;   ///< of the formula's tree; a constant has 1
    std::vector<Term> _terms; ///< empty: a constant
};

} // namespace midair::haptics
