#include "samples/tools/check/Remedy.h"

#include "haptics/base/text/Quantity.h"
#include "haptics/base/text/Words.h"
#include "haptics/points/FittingSize.h"

#include <osgDB/FileNameUtils>
#include <osgDB/Registry>

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

constexpr double kMostSize_m = 0.3; ///< a larger number was perhaps meant in cm or mm

const std::vector<std::string>& placingOptions()
{
    static const std::vector<std::string> kNames = {"size", "position", "rotation", "overlays"};
    return kNames;
}

template<typename Described>
std::vector<std::string> namesOf()
{
    std::vector<std::string> names;
    for (const auto& [name, help] : Described::describe())
        names.push_back(name);
    return names;
}

bool has(const std::vector<std::string>& names, const std::string& name)
{
    return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<std::string> kitOptions()
{
    std::vector<std::string> names = namesOf<osgMidair::HapticSettings>();
    for (const std::string& name : namesOf<osgMidair::HapticProperty>())
        names.push_back(name);
    names.insert(names.end(), placingOptions().begin(), placingOptions().end());
    return names;
}

/// A comma between digits is part of a number.
bool isSeparator(const std::string& text, std::size_t i)
{
    const auto isDigit = [&text](std::size_t at)
    { return at < text.size() && std::isdigit(static_cast<unsigned char>(text[at])) != 0; };
    if (text[i] == ',') return i == 0 || !isDigit(i - 1) || !isDigit(i + 1);
    return text[i] == ';' || text[i] == '\n';
}

bool isBlankAt(const std::string& text, std::size_t i)
{
    return std::isspace(static_cast<unsigned char>(text[i])) != 0;
}

/// Returns the end of the word that begins at \a start; quotes keep a word together.
std::size_t endOfWord(const std::string& text, std::size_t start)
{
    char quote = 0;
    std::size_t end = start;
    for (; end < text.size(); ++end)
    {
        const char c = text[end];
        if (quote)
            quote = c == quote ? '\0' : quote;
        else if (c == '"' || c == '\'')
            quote = c;
        else if (isBlankAt(text, end) || isSeparator(text, end))
            break;
    }
    return end;
}

bool isOfReader(const std::string& name)
{
    for (const auto& reader : osgDB::Registry::instance()->getReaderWriterList())
        for (const auto& [option, help] : reader->supportedOptions())
            if (option.substr(0, option.find_first_of("= <")) == name) return true;
    return false;
}

std::string textOf(const GivenOptions& options)
{
    std::string text;
    for (const GivenOption& one : options)
        text += (text.empty() ? "" : " ") + one.name + (one.name.empty() ? "" : "=") + one.value;
    return text;
}

const GivenOption* find(const GivenOptions& options, const std::string& name)
{
    const auto found = std::find_if(options.begin(),
                                    options.end(),
                                    [&name](const GivenOption& one) { return one.name == name; });
    return found == options.end() ? nullptr : &*found;
}

GivenOptions without(GivenOptions options, const std::string& name)
{
    options.erase(std::remove_if(options.begin(),
                                 options.end(),
                                 [&name](const GivenOption& one) { return one.name == name; }),
                  options.end());
    return options;
}

GivenOptions with(const GivenOptions& options, const std::string& name, const std::string& value)
{
    GivenOptions changed = without(options, name);
    changed.push_back({name, value});
    return changed;
}

/// Makes "size:0.08" to size=0.08.
GivenOptions mended(GivenOptions options)
{
    const std::vector<std::string> known = kitOptions();
    for (GivenOption& one : options)
    {
        const std::size_t colon = one.name.empty() ? one.value.find(':') : std::string::npos;
        if (colon == std::string::npos || !has(known, one.value.substr(0, colon))) continue;
        one.name = one.value.substr(0, colon);
        one.value.erase(0, colon + 1);
    }
    return options;
}

/// Returns the numbers of "0 0 120" in \a unit; none if \a text is something else or has a unit.
std::vector<double> plainNumbers(const std::string& text)
{
    std::vector<double> numbers;
    for (const std::string& word : base::splitAt(base::trimmed(text), ' '))
    {
        double number = 0.0;
        std::string unit;
        if (word.empty()) continue;
        if (!base::splitQuantity(word, number, unit) || !unit.empty()) return {};
        numbers.push_back(number);
    }
    return numbers;
}

/// Returns \a text with the units in which its numbers are lengths of an object in the workspace,
/// if they are not in metres.
std::vector<std::string> inOtherUnits(const std::string& text)
{
    double most = 0.0;
    for (const double number : plainNumbers(text))
        most = std::max(most, std::fabs(number));
    std::vector<std::string> all;
    if (most <= kMostSize_m) return all;
    for (const auto& [unit, length_m] : {std::pair("cm", 1e-2), {"mm", 1e-3}})
        if (most * length_m <= kMostSize_m) all.push_back(text + " " + unit);
    return all;
}

/// Returns the number after \a before in one of the faults of \a result; empty: there is none.
std::string proposedIn(const CheckResult& result, const std::string& before)
{
    for (const CheckedScene& scene : result.scenes)
        for (const CheckedObject& object : scene.objects)
            for (const std::string& fault : object.faults)
            {
                const std::size_t found = fault.find(before);
                if (found == std::string::npos) continue;
                const std::size_t start = found + before.size();
                return fault.substr(start, fault.find_first_of(" ;,", start) - start);
            }
    return {};
}

template<typename Is>
bool anyObject(const CheckResult& result, Is is)
{
    for (const CheckedScene& scene : result.scenes)
        if (std::any_of(scene.objects.begin(), scene.objects.end(), is)) return true;
    return false;
}

/// Collects what could be checked instead.
class Proposals
{
public:
    Proposals(const CheckResult& result, const CheckOptions& options) :
        _result(result),
        _options(options),
        _isPlaced(osgDB::getLowerCaseFileExtension(options.file) == "haptic"),
        _isModel(_isPlaced || !result.wrapped.empty())
    {
    }

    std::vector<CheckOptions> all()
    {
        const GivenOptions given = mended(optionsIn(_options.options));
        if (_isModel && !modelOption(given).empty()) _isPlaced = true;
        add(given);
        addUnits(given);
        addPressures(given);
        if (_isModel) addPlaces(given);
        return std::move(_all);
    }

private:
    void add(const GivenOptions& options)
    {
        CheckOptions one = _options;
        one.options = textOf(options);
        if (_isPlaced && osgDB::getLowerCaseFileExtension(one.file) != "haptic")
            one.file += ".haptic";
        const auto isSame = [&one](const CheckOptions& other)
        { return one.options == other.options && one.file == other.file; };
        const bool isOld =
            one.file == _options.file && optionsIn(one.options) == optionsIn(_options.options);
        if (!isOld && std::none_of(_all.begin(), _all.end(), isSame)) _all.push_back(one);
    }

    /// The whole file in another unit keeps the proportions of its parts.
    void addUnits(const GivenOptions& given)
    {
        for (const char* name : {"size", "position"})
            if (const GivenOption* one = find(given, name))
                for (const std::string& other : inOtherUnits(one->value))
                    add(with(given, name, other));
        const std::string unit = proposedIn(_result, "metresPerUnit be ");
        if (!unit.empty()) add(with(given, "metresPerUnit", unit));
    }

    void addPressures(const GivenOptions& given)
    {
        const GivenOption* pressure = find(given, "pressure");
        if (!pressure) return;
        double number = 0.0;
        std::string unit;
        const bool isNumber = base::splitQuantity(pressure->value, number, unit);
        const bool isMeant =
            unit.empty() ? number > kLargeRelative : base::lowerCase(unit).rfind("pa", 0) == 0;
        if (isNumber && isMeant && unit != "Pa")
            add(with(given, "pressure", fmt::format("{:g} Pa", number)));
        if (isWeak()) add(with(given, "pressure", "4000 Pa"));
    }

    /// A size moves the model to the middle of the array.
    void addPlaces(const GivenOptions& given)
    {
        const bool isElsewhere =
            anyObject(_result,
                      [](const CheckedObject& one)
                      { return one.leftOut.isUnreachable || one.leftOut.outOfWorkspace > 0; });
        const bool isWrong =
            anyObject(_result, [](const CheckedObject& one) { return one.isSizeWrong; });
        if (!isElsewhere && !isWrong && !isWeak()) return;
        _isPlaced = true;
        if (find(given, "position")) add(without(given, "position"));
        const GivenOptions inMiddle = without(given, "position");
        if (isElsewhere && !isWrong && _result.width_m > 0.0 && _result.width_m <= kMostSize_m)
            add(with(inMiddle, "size", fmt::format("{:.3g}", _result.width_m)));
        double size_m = haptics::kFeltBest_m;
        double proposed_m = 0.0;
        if (base::parseQuantity(proposedIn(_result, "size="), "m", proposed_m))
            size_m = std::min(size_m, proposed_m);
        for (const double one_m : {size_m, 0.6 * size_m})
            add(with(inMiddle, "size", fmt::format("{:.3g}", one_m)));
        add(with(with(inMiddle, "size", fmt::format("{:.3g}", size_m)), "metresPerUnit", "1"));
    }

    bool isWeak() const
    {
        return anyObject(_result, [](const CheckedObject& one) { return one.isWeak; });
    }

    const CheckResult& _result;
    const CheckOptions& _options;
    bool _isPlaced; ///< FILE.haptic
    bool _isModel;  ///< not a scene with an array of its own
    std::vector<CheckOptions> _all;
};

} // namespace

GivenOptions optionsIn(const std::string& text)
{
    GivenOptions all;
    bool isOpen = false; // the next word may belong to the last value
    for (std::size_t i = 0; i < text.size();)
    {
        const bool isEnd = isSeparator(text, i);
        if (isEnd || isBlankAt(text, i))
        {
            isOpen = isOpen && !isEnd;
            ++i;
            continue;
        }
        const std::size_t end = endOfWord(text, i);
        const std::string word = text.substr(i, end - i);
        const std::size_t equals = word.find('=');
        if (equals != std::string::npos && equals > 0)
            all.push_back({word.substr(0, equals), word.substr(equals + 1)});
        else if (isOpen)
            all.back().value += (all.back().value.empty() ? "" : " ") + word;
        else
            all.push_back({"", word});
        isOpen = isOpen || equals != std::string::npos;
        i = end;
    }
    return all;
}

std::string modelOption(const GivenOptions& options)
{
    const std::vector<std::string> settings = namesOf<osgMidair::HapticSettings>();
    const std::vector<std::string> properties = namesOf<osgMidair::HapticProperty>();
    for (const GivenOption& one : options)
        if (has(placingOptions(), one.name) ||
            (has(properties, one.name) && !has(settings, one.name)))
            return one.name + "=" + one.value;
    return {};
}

std::vector<std::string> unknownOptions(const GivenOptions& options)
{
    const std::vector<std::string> known = kitOptions();
    std::vector<std::string> all;
    for (const GivenOption& one : options)
    {
        const std::string& name = one.name.empty() ? one.value : one.name;
        const std::string first = name.substr(0, name.find(':'));
        // The kit tells of its own.
        if (has(known, first) || isOfReader(name)) continue;
        all.push_back("unknown option \"" + name + "\"" + base::didYouMean(first, known));
    }
    return all;
}

std::vector<CheckOptions> remedies(const CheckResult& result, const CheckOptions& options)
{
    return Proposals(result, options).all();
}

std::string commandOf(const CheckOptions& options)
{
    const auto quoted = [](const std::string& text)
    { return text.find_first_of(" '\"$()&;") == std::string::npos ? text : "'" + text + "'"; };
    std::string command = "midair-check " + quoted(options.file);
    if (!options.settings.empty()) command += " --device " + quoted(options.settings);
    if (options.options.empty()) return command;
    const bool hasQuotes = options.options.find_first_of("\"$") != std::string::npos;
    const std::string quote = hasQuotes ? "'" : "\"";
    return command + " -O " + quote + options.options + quote;
}

} // namespace midair::samples
