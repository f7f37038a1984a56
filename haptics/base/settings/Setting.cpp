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

std::string SettingFacts::numbers() const
{
    std::string text = range.text() + (unit.empty() ? "" : " " + unit);
    for (const Word& word : named)
        text += fmt::format(", {} ({})", word.text, word.value);
    return text;
}

const Word* wordFor(const std::vector<Word>& words, const std::string& text)
{
    const std::string small = lowerCase(trimmed(text));
    const auto found =
        std::find_if(words.begin(),
                     words.end(),
                     [&](const Word& word)
                     { return lowerCase(word.text) == small || lowerCase(word.stored) == small; });
    return found == words.end() ? nullptr : &*found;
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
