#include "haptics/sensation/SensationReader.h"

#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/JsonLines.h"
#include "haptics/base/text/JsonValue.h"
#include "haptics/base/text/Words.h"
#include "haptics/sensation/SensationClassics.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::haptics
{

namespace
{

using base::JsonValue;

/// Objects and lists: two for each operation of the deepest formula, and those around it.
constexpr std::size_t kMostNesting = 2 * SensationNumber::kMostDepth + 32;
constexpr std::size_t kMostReason = 2000;       // bytes; paths of formulas are long
constexpr std::size_t kMostJumpsOfFrame = 1000; // of a keyframe

double plainNumber(const JsonValue& value)
{
    constexpr double kMost = std::numeric_limits<double>::max();
    return value.number(-kMost, kMost, "a number");
}

double plainNumber(const JsonValue& object, const char* key)
{
    return plainNumber(object.required(key, "a number"));
}

/// Requires an object, whose keys may be any.
const JsonValue& requireObject(const JsonValue& value)
{
    if (!value.json().is_object()) value.wrong("an object in braces");
    return value;
}

JsonValue objectIn(const JsonValue& object, const char* key)
{
    const JsonValue value = object.required(key, "an object in braces");
    return requireObject(value);
}

/// Returns the optional object \a key; null counts as missing.
std::optional<JsonValue> optionalIn(const JsonValue& object, const char* key)
{
    std::optional<JsonValue> value = object.find(key);
    if (!value || value->json().is_null()) return {};
    requireObject(*value);
    return value;
}

/// Returns the index of a text in \a known, which are all that it may be.
template<std::size_t N>
std::size_t chosen(const JsonValue& value, const std::array<const char*, N>& known)
{
    const std::string text = value.string();
    const auto found = std::find(known.begin(), known.end(), text);
    if (found == known.end())
        value.wrong(fmt::format("one of {}{}",
                                fmt::join(known, ", "),
                                base::didYouMean(text, {known.begin(), known.end()})));
    return static_cast<std::size_t>(found - known.begin());
}

/// Returns the index of a variant's name, and requires its parameters.
template<std::size_t N>
std::size_t variant(const JsonValue& value, const std::array<const char*, N>& known)
{
    const JsonValue name = value.required("name", fmt::format("one of {}", fmt::join(known, ", ")));
    objectIn(value, "params");
    return chosen(name, known);
}

/// Reads one file.
class SensationFile
{
public:
    explicit SensationFile(const JsonValue& root) : _root(root) {}

    Sensation read()
    {
        requireObject(_root);
        chosen(_root.required("$DATA_FORMAT", "MidAirHapticsAnimationFileFormat"),
               std::array<const char*, 1>{"MidAirHapticsAnimationFileFormat"});
        constexpr std::array<const char*, 3> kRevisions = {
            "0.1.0-alpha.3", "0.1.0-alpha.2", "0.0.10-alpha.1"};
        chosen(_root.required("$REVISION", fmt::format("one of {}", fmt::join(kRevisions, ", "))),
               kRevisions);
        _sensation.name = _root.required("name", "a text in quotes").string();
        readParameters(objectIn(_root, "user_parameter_definitions"));
        readTransform(objectIn(_root, "pattern_transform"));
        const JsonValue frames = _root.required("keyframes", "a list");
        frames.list("a list", Sensation::kMostKeyframes);
        for (std::size_t i = 0; i < frames.size(); ++i)
            _sensation.keyframes.push_back(keyframe(frames[i]));
        std::stable_sort(_sensation.keyframes.begin(),
                         _sensation.keyframes.end(),
                         [](const SensationKeyframe& a, const SensationKeyframe& b)
                         { return a.time_ms < b.time_ms; });
        return std::move(_sensation);
    }

private:
    void readParameters(const JsonValue& all)
    {
        if (all.json().size() > Sensation::kMostParameters)
            all.fail(fmt::format("has {} parameters; at most {} are possible",
                                 all.json().size(),
                                 Sensation::kMostParameters));
        for (const auto& [name, unused] : all.json().items())
        {
            const JsonValue value = objectIn(all, name.c_str());
            SensationParameter parameter;
            parameter.name = name;
            parameter.standard = plainNumber(value, "default");
            plainNumber(value, "step");
            parameter.low = limit(value, "min");
            parameter.high = limit(value, "max");
            const std::optional<JsonValue> least = value.find("min");
            if (least && parameter.low && parameter.high && *parameter.low > *parameter.high)
                least->wrong("at most max");
            _sensation.parameters.push_back(parameter);
        }
    }

    static std::optional<double> limit(const JsonValue& parameter, const char* key)
    {
        const std::optional<JsonValue> value = parameter.find(key);
        if (!value || value->json().is_null()) return {};
        return plainNumber(*value);
    }

    void readTransform(const JsonValue& value)
    {
        const JsonValue geometry = objectIn(value, "geometric_transforms");
        const JsonValue scale = objectIn(geometry, "scale");
        const JsonValue translate = objectIn(geometry, "translate");
        constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
        for (std::size_t axis = 0; axis < kAxes.size(); ++axis)
        {
            _sensation.transform.scale[axis] = number(scale, kAxes[axis]);
            _sensation.transform.translation_mm[axis] = number(translate, kAxes[axis]);
        }
        _sensation.transform.rotation_deg = number(geometry, "rotation");
        _sensation.intensityFactor = number(value, "intensity_factor");
        _sensation.speed = number(value, "playback_speed");
    }

    SensationKeyframe keyframe(const JsonValue& value)
    {
        constexpr std::array<const char*, 3> kKinds = {"standard", "pause", "stop"};
        using Kind = SensationKeyframe::Kind;
        requireObject(value);
        SensationKeyframe frame;
        frame.kind = std::array<Kind, 3>{
            Kind::STANDARD,
            Kind::PAUSE,
            Kind::STOP}[chosen(value.required("type", "one of standard, pause, stop"), kKinds)];
        frame.time_ms = plainNumber(value, "time");
        if (frame.kind == Kind::STOP) return frame;
        if (frame.kind == Kind::STANDARD)
        {
            const JsonValue coords = objectIn(value, "coords");
            const JsonValue place = objectIn(coords, "coords");
            frame.position_mm = {
                plainNumber(place, "x"), plainNumber(place, "y"), plainNumber(place, "z")};
            frame.positionTransition = transition(coords);
        }
        if (const auto property = optionalIn(value, "brush"))
        {
            frame.brush = brush(objectIn(*property, "brush"));
            frame.brushTransition = transition(*property);
        }
        if (const auto property = optionalIn(value, "intensity"))
        {
            frame.intensity = intensity(objectIn(*property, "intensity"));
            frame.intensityTransition = transition(*property);
        }
        const JsonValue jumps = value.required("cjumps", "a list, if an empty one");
        jumps.list("a list, if an empty one", kMostJumpsOfFrame);
        for (std::size_t i = 0; i < jumps.size(); ++i)
            frame.jumps.push_back(jump(jumps[i]));
        return frame;
    }

    static SensationTransition transition(const JsonValue& property)
    {
        return variant(objectIn(property, "transition"),
                       std::array<const char*, 2>{"linear", "step"}) == 0
                   ? SensationTransition::LINEAR
                   : SensationTransition::STEP;
    }

    SensationBrush brush(const JsonValue& value)
    {
        using Kind = SensationBrush::Kind;
        SensationBrush brush;
        brush.kind = std::array<Kind, 3>{Kind::CIRCLE, Kind::LINE, Kind::LISSAJOUS}[variant(
            value, std::array<const char*, 3>{"circle", "line", "lissajous"})];
        const JsonValue parameters = objectIn(value, "params");
        if (brush.kind == Kind::CIRCLE)
            brush.x_mm = number(parameters, "radius");
        else if (brush.kind == Kind::LINE)
        {
            brush.x_mm = number(parameters, "length");
            number(parameters, "thickness"); // has no effect
        }
        else
        {
            brush.x_mm = number(parameters, "x_scale");
            brush.y_mm = number(parameters, "y_scale");
            brush.a = number(parameters, "a");
            brush.b = number(parameters, "b");
            brush.phase_rad = number(parameters, "d");
        }
        if (brush.kind != Kind::CIRCLE) brush.rotation = number(parameters, "rotation");
        brush.modulation_Hz = number(parameters, "am_freq");
        if (parameters.find("stm_freq")) brush.draw_Hz = number(parameters, "stm_freq");
        return brush;
    }

    SensationIntensity intensity(const JsonValue& value)
    {
        SensationIntensity intensity;
        intensity.isRandom = variant(value, std::array<const char*, 2>{"constant", "random"}) == 1;
        const JsonValue parameters = objectIn(value, "params");
        intensity.low = number(parameters, intensity.isRandom ? "min" : "value");
        if (intensity.isRandom) intensity.high = number(parameters, "max");
        return intensity;
    }

    SensationJump jump(const JsonValue& value)
    {
        using Comparison = SensationJump::Comparison;
        requireObject(value);
        const JsonValue condition = objectIn(value, "condition");
        const JsonValue name = condition.required("parameter", "a text in quotes");
        SensationJump jump;
        jump.parameter = parameter(name);
        jump.comparison = std::array<Comparison, 4>{Comparison::LESS,
                                                    Comparison::LESS_OR_EQUAL,
                                                    Comparison::GREATER,
                                                    Comparison::GREATER_OR_EQUAL}[variant(
            objectIn(condition, "operator"),
            std::array<const char*, 4>{"lt", "lt_eq", "gt", "gt_eq"})];
        jump.value = plainNumber(condition, "value");
        jump.to_ms = plainNumber(value, "jump_to");
        return jump;
    }

    std::size_t parameter(const JsonValue& name)
    {
        const std::string text = name.string();
        try
        {
            return _sensation.usedParameter(text);
        }
        catch (const base::JsonError&)
        {
            throw;
        }
        catch (const base::InputError& error)
        {
            name.fail(error.what());
        }
    }

    SensationNumber number(const JsonValue& object, const char* key)
    {
        return number(object.required(key, "an object with type and value"));
    }

    SensationNumber number(const JsonValue& value)
    {
        if (!value.json().is_object())
            value.wrong("an object with type (f64, param or formula) and value");
        const JsonValue type = value.required("type", "one of f64, param, formula");
        const JsonValue content = value.required("value", "of that type");
        switch (chosen(type, std::array<const char*, 4>{"f64", "param", "formula", "dynamic"}))
        {
        case 0:
            return plainNumber(content);
        case 2:
            return formula(content, 1, value);
        default:
            return SensationNumber::parameter(parameter(content));
        }
    }

    /// \a whole: the number whose formula it is in.
    SensationNumber formula(const JsonValue& value, std::size_t depth, const JsonValue& whole)
    {
        requireObject(value);
        if (depth > SensationNumber::kMostDepth)
            whole.fail(
                fmt::format("is a formula deeper than {} operations", SensationNumber::kMostDepth));
        constexpr std::array<const char*, 7> kKinds = {
            "constant", "parameter", "add", "subtract", "multiply", "divide", "negate"};
        const std::size_t kind = chosen(
            value.required("type", fmt::format("one of {}", fmt::join(kKinds, ", "))), kKinds);
        const JsonValue content = value.required("value", "the operands");
        if (kind == 0) return plainNumber(content);
        if (kind == 1) return SensationNumber::parameter(parameter(content));
        if (kind == 6) return operation(whole, kind, formula(content, depth + 1, whole), 0.0);
        if (!content.isList() || content.size() != 2) content.wrong("a list of two formulas");
        const SensationNumber first = formula(content[0], depth + 1, whole);
        return operation(whole, kind, first, formula(content[1], depth + 1, whole));
    }

    static SensationNumber operation(const JsonValue& value,
                                     std::size_t kind,
                                     const SensationNumber& first,
                                     const SensationNumber& second)
    {
        try
        {
            if (kind == 2) return first + second;
            if (kind == 3) return first - second;
            if (kind == 4) return first * second;
            if (kind == 5) return first / second;
            return -first;
        }
        catch (const base::InputError& error)
        {
            value.fail(error.what());
        }
    }

    JsonValue _root;
    Sensation _sensation;
};

} // namespace

Sensation readSensation(const std::string& text, const std::string& source)
{
    if (text.size() > kMostSensationBytes)
        throw base::InputError(fmt::format(
            "{} has {} bytes; at most {} are possible", source, text.size(), kMostSensationBytes));
    base::requirePlainJson(text, source, kMostNesting);
    const JsonValue::Json json = base::parseJson(text, source);
    try
    {
        return SensationFile(JsonValue(source, json)).read();
    }
    catch (const base::JsonError& error)
    {
        throw base::InputError(fmt::format("{}, line {}: {}",
                                           source,
                                           base::jsonLine(text, error.path),
                                           base::printable(error.reason, kMostReason)));
    }
}

Sensation loadSensation(const std::string& nameOrPath)
{
    if (isClassicSensation(nameOrPath)) return classicSensation(nameOrPath);
    std::error_code ignored;
    if (!std::filesystem::exists(nameOrPath, ignored))
    {
        const std::vector<std::string> known = sensationClassics();
        throw base::InputError(
            fmt::format("sensation '{}': there is no such file, and no sensation of that name{}; "
                        "known are {}, or the path of an .adaptics file",
                        base::printable(nameOrPath),
                        base::didYouMean(nameOrPath.substr(0, nameOrPath.find('?')), known),
                        fmt::join(known, ", ")));
    }
    return readSensation(
        base::readRegularFile(nameOrPath, kMostSensationBytes, "sensation '" + nameOrPath + "' "),
        nameOrPath);
}

} // namespace midair::haptics
