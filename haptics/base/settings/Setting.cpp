#include "haptics/base/settings/SettingText.h"

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

bool Range::holds(double value) const
{
    return (value >= low && value <= high && std::isfinite(value)) || (orZero && value == 0.0);
}

std::string Range::text() const
{
    const std::string range = std::isinf(high) ? fmt::format("at least {:g}", low)
                                               : fmt::format("{:g} .. {:g}", low, high);
    return (orZero ? "0 or " : "") + range;
}

} // namespace midair::base
