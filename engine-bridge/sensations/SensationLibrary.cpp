#include "engine-bridge/sensations/SensationLibrary.h"

#include "engine-bridge/sensations/SensationTexts.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Words.h"
#include "haptics/sensation/SensationReader.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

bool isPatternText(const std::string& text)
{
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    return begin != std::string::npos && text[begin] == '{';
}

std::int64_t changedAt(const std::string& text)
{
    std::error_code error;
    const auto time = std::filesystem::last_write_time(text, error);
    return error ? 0 : static_cast<std::int64_t>(time.time_since_epoch().count());
}

haptics::Sensation made(const std::string& text)
{
    if (!isPatternText(text)) return haptics::loadSensation(base::trimmed(text));
    if (text.size() > haptics::kMostSensationBytes)
        throw base::InputError(fmt::format("a sensation's text has {} bytes, should be at most {}",
                                           text.size(),
                                           haptics::kMostSensationBytes));
    return haptics::readSensation(text, "the sensation's text");
}

} // namespace

std::shared_ptr<const haptics::Sensation> SensationLibrary::get(const std::string& text,
                                                                std::string& problem)
{
    const std::int64_t changed = isPatternText(text) ? 0 : changedAt(text);
    const base::Lock lock(_mutex);
    ++_uses;
    const auto known = _read.find(text);
    if (known == _read.end() && _read.size() >= kMost)
        _read.erase(std::min_element(_read.begin(),
                                     _read.end(),
                                     [](const auto& a, const auto& b)
                                     { return a.second.used < b.second.used; }));
    if (known == _read.end() || known->second.changed != changed)
    {
        Read read;
        read.changed = changed;
        try
        {
            read.pattern = std::make_shared<const haptics::Sensation>(made(text));
        }
        catch (const base::InputError& error)
        {
            read.problem = error.what();
        }
        _read[text] = std::move(read);
    }
    Read& read = _read[text];
    read.used = _uses;
    problem = read.problem;
    return read.pattern;
}

SensationLibrary& sensationLibrary()
{
    static SensationLibrary library;
    return library;
}

MadeSensation sensationOf(const ObjectSettings& settings)
{
    using Trigger = SensationProperties::Trigger;
    MadeSensation made;
    if (base::trimmed(settings.sensation).empty()) return made;
    SensationProperties& p = made.properties;
    p.isMeant = true;
    p.pattern = sensationLibrary().get(settings.sensation, made.problem);
    readAttachment(settings.attach, p.attach, p.joint);
    p.trigger = static_cast<Trigger>(settings.trigger);
    static_assert(int(ObjectSettings::TOUCH_END) == int(Trigger::TOUCH_END), "in one order");
    p.speed = settings.sensationSpeed;
    p.seed = settings.seed;
    p.plays = settings.plays;
    readParameters(settings.parameters, p.parameters);
    if (!p.pattern) return made;
    const haptics::Sensation& pattern = *p.pattern;
    for (const auto& [name, value] : p.parameters)
    {
        if (pattern.parameterIndex(name) < pattern.parameters.size()) continue;
        std::vector<std::string> names;
        for (const haptics::SensationParameter& one : pattern.parameters)
            names.push_back(one.name);
        made.problem =
            fmt::format("its sensation has no parameter {}{}{}",
                        base::printable(name),
                        base::didYouMean(name, names),
                        names.empty() ? "" : fmt::format("; it has {}", fmt::join(names, ", ")));
        break;
    }
    return made;
}

} // namespace midair::bridge
