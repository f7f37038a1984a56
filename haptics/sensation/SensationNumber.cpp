#include "haptics/sensation/SensationNumber.h"

#include "haptics/base/InputError.h"
#include "haptics/sensation/SensationValues.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace midair::haptics
{

SensationNumber SensationNumber::parameter(std::size_t index)
{
    SensationNumber number;
    number._terms.push_back({Kind::PARAMETER, 0.0, index});
    return number;
}

void SensationNumber::append(const SensationNumber& other)
{
    if (other._terms.empty())
        _terms.push_back({Kind::CONSTANT, other._value, 0});
    else
        _terms.insert(_terms.end(), other._terms.begin(), other._terms.end());
}

void SensationNumber::require() const
{
    if (_depth > kMostDepth)
        throw base::InputError(fmt::format("is a formula deeper than {} operations", kMostDepth));
    if (_terms.size() > kMostTerms)
        throw base::InputError(fmt::format("is a formula of more than {} terms", kMostTerms));
}

SensationNumber
SensationNumber::joined(const SensationNumber& a, const SensationNumber& b, Kind kind)
{
    SensationNumber number;
    number.append(a);
    number.append(b);
    number._terms.push_back({kind, 0.0, 0});
    number._depth = 1 + std::max(a._depth, b._depth);
    number.require();
    return number;
}

SensationNumber operator+(const SensationNumber& a, const SensationNumber& b)
{
    return SensationNumber::joined(a, b, SensationNumber::Kind::ADD);
}

SensationNumber operator-(const SensationNumber& a, const SensationNumber& b)
{
    return SensationNumber::joined(a, b, SensationNumber::Kind::SUBTRACT);
}

SensationNumber operator*(const SensationNumber& a, const SensationNumber& b)
{
    return SensationNumber::joined(a, b, SensationNumber::Kind::MULTIPLY);
}

SensationNumber operator/(const SensationNumber& a, const SensationNumber& b)
{
    return SensationNumber::joined(a, b, SensationNumber::Kind::DIVIDE);
}

SensationNumber operator-(const SensationNumber& a)
{
    SensationNumber number;
    number.append(a);
    number._terms.push_back({SensationNumber::Kind::NEGATE, 0.0, 0});
    number._depth = 1 + a._depth;
    number.require();
    return number;
}

double SensationNumber::ofTerms(const SensationValues& values) const
{
    // An operator of depth d leaves at most d operands before it, see require().
    std::array<double, kMostDepth + 1> operands; // NOLINT(cppcoreguidelines-pro-type-member-init)
    std::size_t size = 0;
    for (const Term& term : _terms)
    {
        if (term.kind == Kind::CONSTANT || term.kind == Kind::PARAMETER)
        {
            operands[size++] = term.kind == Kind::CONSTANT ? term.value : values[term.index];
            continue;
        }
        double& last = operands[size - 1];
        if (term.kind == Kind::NEGATE)
        {
            last = -last;
            continue;
        }
        double& first = operands[size - 2];
        if (term.kind == Kind::ADD)
            first += last;
        else if (term.kind == Kind::SUBTRACT)
            first -= last;
        else if (term.kind == Kind::MULTIPLY)
            first *= last;
        else
            first /= last;
        --size;
    }
    return operands[0];
}

} // namespace midair::haptics
