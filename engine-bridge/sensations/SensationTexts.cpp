#include "engine-bridge/sensations/SensationTexts.h"

#include "engine-bridge/hands/Hand.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Words.h"
#include "haptics/sensation/Sensation.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

const std::string kHand = "hand:";

/// Returns "place", "surface" and "hand:JOINT" for each joint.
std::vector<std::string> attachments()
{
    std::vector<std::string> all = {"place", "surface"};
    for (int joint = 0; joint < HAND_JOINTS; ++joint)
    {
        std::string name = jointName(joint);
        std::replace(name.begin(), name.end(), ' ', '_');
        all.push_back(kHand + name);
    }
    return all;
}

} // namespace

bool readAttachment(const std::string& text, SensationProperties::Attach& attach, int& joint)
{
    using Attach = SensationProperties::Attach;
    static const std::vector<std::string> known = attachments();
    const auto found = std::find(known.begin(), known.end(), base::trimmed(text));
    if (found == known.end()) return false;
    const auto index = static_cast<int>(found - known.begin());
    attach = index == 0 ? Attach::PLACE : index == 1 ? Attach::SURFACE : Attach::HAND;
    joint = std::max(index - 2, 0);
    return true;
}

std::string problemOfAttachment(const std::string& text)
{
    SensationProperties made;
    if (readAttachment(text, made.attach, made.joint)) return {};
    return fmt::format("attach is \"{}\", should be place, surface, or a joint of a hand: "
                       "hand:palm, hand:index_tip{}",
                       base::printable(text),
                       base::didYouMean(base::trimmed(text), attachments()));
}

std::string readParameters(const std::string& text,
                           std::vector<std::pair<std::string, double>>& values)
{
    std::vector<std::pair<std::string, double>> read;
    std::size_t begin = 0;
    while (begin <= text.size())
    {
        const std::size_t end = std::min(text.find_first_of(";&", begin), text.size());
        const std::string part = base::trimmed(text.substr(begin, end - begin));
        begin = end + 1;
        if (part.empty()) continue;
        const std::size_t equals = part.find('=');
        const std::string name = base::trimmed(part.substr(0, equals));
        double value = 0.0;
        const bool isNumber = equals != std::string::npos && !name.empty() &&
                              base::parseNumber(base::trimmed(part.substr(equals + 1)), value);
        if (!isNumber)
            return fmt::format("parameters has \"{}\", should be NAME=NUMBER, as in strength=0.4; "
                               "size=3",
                               base::printable(part));
        const bool isAgain = std::any_of(
            read.begin(), read.end(), [&name](const auto& one) { return one.first == name; });
        if (isAgain) return fmt::format("parameters has {} twice", base::printable(name));
        if (read.size() >= haptics::Sensation::kMostParameters)
            return fmt::format("parameters has more than {} values",
                               haptics::Sensation::kMostParameters);
        read.emplace_back(name, value);
    }
    values = std::move(read);
    return {};
}

int nextPlays(int last, int now)
{
    constexpr int kMost = 1000000000; // of the property
    const int highest = std::max(last, now);
    return highest < kMost ? highest + 1 : 1;
}

std::string parametersText(const std::vector<std::pair<std::string, double>>& values)
{
    std::string text;
    for (const auto& [name, value] : values)
        text += fmt::format("{}{}={}", text.empty() ? "" : "; ", name, value);
    return text;
}

} // namespace midair::bridge
