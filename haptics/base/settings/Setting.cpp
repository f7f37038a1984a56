#include "haptics/base/settings/SettingText.h"

#include <cctype>

namespace midair::base
{

std::string listOf(const std::vector<Word>& words)
{
    std::vector<std::string> texts;
    texts.reserve(words.size());
    for (const Word& word : words)
        texts.push_back(word.text);
    return fmt::format("{}", fmt::join(texts, ", "));
}

std::string SettingFacts::storedName() const
{
    if (!stored.empty() || name.empty()) return stored;
    std::string capital = name;
    capital[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(capital[0])));
    return capital;
}

bool Range::holds(double value) const
{
    return (value >= low && value <= high && std::isfinite(value)) || (orZero && value == 0.0);
}

std::string Range::text() const
{
    const std::string range = std::isinf(high) ? fmt::format("at least {:g}", low)
                              : low == high    ? fmt::format("{:g}", low)
                                               : fmt::format("{:g} .. {:g}", low, high);
    return (orZero ? "0 or " : "") + range;
}

} // namespace midair::base
