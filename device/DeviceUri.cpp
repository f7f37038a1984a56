#include "device/DeviceUri.h"

#include "haptics/base/text/Quantity.h"
#include "haptics/base/text/Words.h"

#include <algorithm>

#include <fmt/format.h>

namespace midair::device
{

namespace
{

constexpr double kMostSeconds = 1e6;

// Returns a hint for numbers with a decimal comma.
std::string withPoint(const std::string& text)
{
    return text.find(',') == std::string::npos ? std::string() : ", with a point and not a comma";
}

} // namespace

DeviceUri::DeviceUri(const std::string& text, const std::string& thing) : _thing(thing), _text(text)
{
    if (text.size() > kMostUriCharacters)
        throw error(fmt::format(
            "has {} characters, should have at most {}", text.size(), kMostUriCharacters));
    const std::size_t colon = text.find(':');
    if (colon == std::string::npos || colon == 0)
        throw error("a " + _thing + " is named SCHEME:PATH?KEY=VALUE, for instance \"sim:\"");
    _scheme = text.substr(0, colon);
    const std::size_t question = text.find('?', colon);
    _path = text.substr(colon + 1, question == std::string::npos ? question : question - colon - 1);
    std::size_t begin = question == std::string::npos ? text.size() : question + 1;
    while (begin < text.size())
    {
        // The value of "to" is a URI, which may contain "&": it takes the rest.
        const bool nested = text.compare(begin, 3, "to=") == 0;
        const std::size_t end = nested ? text.size() : std::min(text.find('&', begin), text.size());
        const std::string part = text.substr(begin, end - begin);
        const std::size_t equals = part.find('=');
        if (equals == std::string::npos || equals == 0 || equals + 1 == part.size())
            throw error("parameter \"" + base::printable(part) + "\" should read KEY=VALUE");
        if (!_parameters.emplace(part.substr(0, equals), part.substr(equals + 1)).second)
            throw error("parameter \"" + base::printable(part.substr(0, equals)) +
                        "\" is there twice");
        begin = end + 1;
    }
}

DeviceError DeviceUri::error(const std::string& what) const
{
    return DeviceError(_thing + " \"" + base::printable(_text) + "\": " + what);
}

std::string DeviceUri::take(const std::string& key)
{
    _known.insert(key);
    const auto found = _parameters.find(key);
    return found == _parameters.end() ? std::string() : found->second;
}

std::string DeviceUri::value(const std::string& key) const
{
    const auto found = _parameters.find(key);
    return found == _parameters.end() ? std::string() : found->second;
}

std::string DeviceUri::takeText(const std::string& key, const std::string& fallback)
{
    const std::string value = take(key);
    return value.empty() ? fallback : value;
}

double DeviceUri::takeNumber(const std::string& key, double fallback, double low, double high)
{
    const std::string text = take(key);
    if (text.empty()) return fallback;
    double value = 0;
    if (!base::parseQuantity(text, "", value) || value < low || value > high)
        throw error(fmt::format("{}={} should be a number from {:g} to {:g}{}",
                                key,
                                base::printable(text),
                                low,
                                high,
                                withPoint(text)));
    return value;
}

double DeviceUri::takeSeconds(const std::string& key, double fallback_s)
{
    const std::string text = take(key);
    if (text.empty()) return fallback_s;
    double value = 0;
    std::string unit;
    const bool hasUnit = base::splitQuantity(text, value, unit) && base::isUnitFor(unit, "s");
    if (!hasUnit || !base::parseQuantity(text, "s", value) || value < 0 || value > kMostSeconds)
        throw error(key + "=" + base::printable(text) +
                    " should be a time such as 2s, 100ms or 20us" + withPoint(text));
    return value;
}

std::map<std::string, std::string> DeviceUri::takeRest()
{
    std::map<std::string, std::string> rest;
    for (const auto& [key, value] : _parameters)
        if (_known.insert(key).second) rest.emplace(key, value);
    return rest;
}

bool DeviceUri::takeFlag(const std::string& key, bool fallback)
{
    const std::string text = take(key);
    if (text.empty()) return fallback;
    if (text == "1" || text == "yes" || text == "true") return true;
    if (text == "0" || text == "no" || text == "false") return false;
    throw error(key + "=" + base::printable(text) + " should be yes or no");
}

void DeviceUri::rejectUnknown() const
{
    for (const auto& parameter : _parameters)
    {
        if (_known.count(parameter.first) != 0) continue;
        const std::string known = _known.empty()
                                      ? fmt::format("\"{}:\" has none", _scheme)
                                      : fmt::format("known are {}", fmt::join(_known, ", "));
        throw error(
            fmt::format("unknown parameter \"{}\"; {}", base::printable(parameter.first), known));
    }
}

void DeviceUri::requirePath(const std::string& what) const
{
    if (_path.empty()) throw error("the name of " + what + " is missing: \"" + _scheme + ":NAME\"");
}

void DeviceUri::rejectPath() const
{
    if (!_path.empty())
        throw error("nothing may stand between \"" + _scheme + ":\" and the parameters, but \"" +
                    base::printable(_path) + "\" does");
}

} // namespace midair::device
