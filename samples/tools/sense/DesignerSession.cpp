#include "samples/tools/sense/DesignerSession.h"

#include "haptics/base/InputError.h"
#include "haptics/base/text/JsonLines.h"
#include "haptics/base/text/Words.h"
#include "haptics/sensation/SensationReader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

using base::InputError;

const std::string kSource = "message"; // JsonValue keeps a pointer to it
constexpr std::size_t kMostNesting = 16;
constexpr std::size_t kMostToldOnce = 64;
constexpr double kMostTime_ms = 1e12;
constexpr std::size_t kMostShown = 500; // bytes of a sentence
constexpr double kLatency_ms = 50.0;    // of a start

/// What ends playing, as nobody knows any more what is wanted.
bool endsPlaying(const std::string& name)
{
    return name.empty() || name == "update_pattern" || name == "update_playstart";
}

} // namespace

DesignerSession::DesignerSession(SenseOutput& output,
                                 std::function<void(const std::string&)> tell) :
    _output(output),
    _tell(std::move(tell))
{
}

DesignerSession::Command DesignerSession::commandOf(const std::string& name)
{
    static const std::array<std::pair<const char*, Command>, 8> kCommands = {{
        {"update_pattern", &DesignerSession::setPattern},
        {"update_playstart", &DesignerSession::setStart},
        {"update_parameters", &DesignerSession::setParameters},
        {"update_tracking", &DesignerSession::setTracking},
        {"user_parameter", &DesignerSession::setUserParameter},
        {"user_parameters", &DesignerSession::setUserParameters},
        {"parameter_time", &DesignerSession::setTime},
        {"geo_transform_matrix", &DesignerSession::setTransform},
    }};
    const auto* const found = std::find_if(
        kCommands.begin(), kCommands.end(), [&](const auto& one) { return one.first == name; });
    return found == kCommands.end() ? nullptr : found->second;
}

std::string DesignerSession::take(const std::string& message, double now_s)
{
    std::string name;
    try
    {
        if (message.size() > kMostBytes)
            throw InputError(fmt::format(
                "message: has {} bytes; at most {} are possible", message.size(), kMostBytes));
        base::requirePlainJson(message, kSource, kMostNesting);
        const Value::Json json = base::parseJson(message, kSource);
        const Value value(kSource, json);
        if (!json.is_object()) throw InputError("message: isn't an object with cmd and data");
        const std::string given = value.required("cmd", "the name of a command").string();
        if (commandOf(given) == nullptr)
        {
            tellOnce(fmt::format("the command \"{}\" isn't known, and is ignored",
                                 base::printable(given, 60)));
            return {};
        }
        name = given;
        if (name != "update_pattern" && message.size() > kMostOtherBytes)
            value.fail(fmt::format(
                "{} has {} bytes; at most {} are possible", name, message.size(), kMostOtherBytes));
        const Value data = value.required("data", "an object in braces");
        if (!data.json().is_object()) data.wrong("an object in braces");
        (this->*commandOf(name))(data, now_s);
        return {};
    }
    catch (const base::JsonError& error)
    {
        return refuse(error.what(), endsPlaying(name));
    }
    catch (const InputError& error) // the reader's, or the output's
    {
        return refuse(error.what(), true);
    }
}

std::string DesignerSession::refuse(const std::string& what, bool ends)
{
    if (ends)
    {
        _owesStop = _owesStop || isPlaying();
        _sentFrom_ms.reset(); // nobody knows what the output has
        end();
    }
    const std::string shown = base::printable(what, kMostShown);
    tell(shown);
    return errorMessage(shown);
}

void DesignerSession::setPattern(const Value& data, double now_s)
{
    std::string json = data.required("pattern_json", "the text of a pattern").string();
    try
    {
        _sensation = std::make_shared<const haptics::Sensation>(
            haptics::readSensation(json, "the Designer's pattern"));
    }
    catch (const InputError&)
    {
        _sensation = nullptr;
        throw;
    }
    _json = std::move(json);
    _sentFrom_ms.reset();
    if (!isPlaying()) return;
    sampleUntil(now_s);
    _player->replace(
        std::make_shared<const haptics::Sensation>(patternFrom(*_sensation, _course.begin_ms)));
    send(_course.begin_ms);
    sendParameters(now_s);
}

void DesignerSession::setStart(const Value& data, double now_s)
{
    const double start =
        data.number("playstart", -1e15, 1e15, "ms since 1970, or 0 to end playing");
    _owesStop = false;
    if (start == 0.0) return end();
    const double offset_ms = data.number(
        "playstart_offset", -kMostTime_ms, kMostTime_ms, "ms from now on to the pattern's time 0");
    if (!_sensation) throw InputError("message: update_playstart: there is no pattern to play");
    // The Designer means the time that it shows; what was sent since delays the start.
    const double begin_ms = -offset_ms;
    begin(std::abs(begin_ms - _time_ms) <= kLatency_ms ? _time_ms : begin_ms, now_s);
}

void DesignerSession::setParameters(const Value& data, double now_s)
{
    const Value all = data.required("evaluator_params", "an object in braces");
    if (!all.json().is_object()) all.wrong("an object in braces");
    const double time_ms = all.number("time", -kMostTime_ms, kMostTime_ms, "a time, ms");
    DesignerParameters parameters =
        parametersIn(all.required("user_parameters", "an object of numbers"));
    Eigen::Matrix4d transform = Eigen::Matrix4d::Identity();
    if (const auto given = all.find("geometric_transform"); given && !given->json().is_null())
        transform = transformIn(*given);
    _time_ms = time_ms;
    _parameters = std::move(parameters);
    place(transform);
    sendParameters(now_s);
}

void DesignerSession::setTracking(const Value& data, double)
{
    const Value enabled = data.required("enabled", "true or false");
    if (!enabled.json().is_boolean()) enabled.wrong("true or false");
    _output.setTracking(enabled.json().get<bool>());
}

void DesignerSession::setUserParameter(const Value& data, double now_s)
{
    const std::string name = data.required("name", "a text in quotes").string();
    const double value = data.number("value", -1e12, 1e12, "a number within -1e12 .. 1e12");
    if (_parameters.size() >= kMostDesignerParameters && _parameters.count(name) == 0)
        data.fail(fmt::format("is one of more than {} parameters", kMostDesignerParameters));
    _parameters[name] = value;
    sendParameters(now_s);
}

void DesignerSession::setUserParameters(const Value& data, double now_s)
{
    _parameters = parametersIn(data.required("user_parameters", "an object of numbers"));
    sendParameters(now_s);
}

void DesignerSession::setTime(const Value& data, double)
{
    _time_ms = data.number("time", -kMostTime_ms, kMostTime_ms, "a time, ms");
}

void DesignerSession::setTransform(const Value& data, double)
{
    place(transformIn(data.required("transform", "4 rows of 4 numbers")));
}

void DesignerSession::place(const Eigen::Matrix4d& transform)
{
    if (transform == _transform) return;
    _output.setTransform(transform);
    _transform = transform;
}

void DesignerSession::begin(double begin_ms, double now_s)
{
    send(begin_ms);
    _player = std::make_unique<haptics::SensationPlayer>(
        std::make_shared<const haptics::Sensation>(patternFrom(*_sensation, begin_ms)));
    _course = {now_s, begin_ms, 0.0};
    _samples.clear();
    sendParameters(now_s);
    _output.begin();
}

void DesignerSession::send(double begin_ms)
{
    if (_sentFrom_ms == begin_ms) return;
    _sentFrom_ms.reset();
    _output.setSensation(patternFrom(_json, begin_ms));
    _sentFrom_ms = begin_ms;
}

void DesignerSession::sendParameters(double now_s)
{
    if (!isPlaying()) return;                   // begin() sends them
    if (_course.next > 0.0) sampleUntil(now_s); // with the parameters before
    haptics::SensationValues values(_player->sensation());
    for (const auto& [name, value] : _parameters)
        values.set(name, value);
    _player->values() = values;
    _output.setParameters(valuesOf(values));
}

std::string DesignerSession::update(double now_s)
{
    if (!isPlaying())
    {
        if (!_owesStop) return {};
        _owesStop = false;
        DesignerSample last;
        last.pattern_ms = _time_ms;
        last.isStopped = true;
        return playbackUpdate({last});
    }
    sampleUntil(now_s);
    if (_samples.empty()) return {};
    std::string message = playbackUpdate({_samples.begin(), _samples.end()});
    if (_samples.front().isStopped) end();
    _samples.clear();
    return message;
}

std::string DesignerSession::tracking()
{
    const std::optional<SenseHand> hand = _output.hand();
    const bool isNews = std::exchange(_showsHand, hand.has_value()) || hand;
    return isNews ? trackingData(hand) : std::string();
}

void DesignerSession::sampleUntil(double now_s)
{
    const double passed_ms = 1e3 * (now_s - _course.start_s);
    const double end = std::floor(passed_ms / kSample_ms + 1e-6) + 1.0;
    _course.next = std::max(_course.next, end - static_cast<double>(kMostSamples));
    for (; _course.next < end; ++_course.next)
    {
        const double time_ms = kSample_ms * _course.next;
        const haptics::SensationSample sample = _player->sampleAt(time_ms);
        tellProblems(sample);
        _samples.push_back(told(sample, time_ms));
        if (_samples.size() > kMostSamples) _samples.pop_front();
    }
}

DesignerSample DesignerSession::told(const haptics::SensationSample& sample, double time_ms) const
{
    const Eigen::Vector3d& at_mm = sample.position_mm;
    DesignerSample one;
    one.position_mm =
        _transform.topLeftCorner<3, 3>() * at_mm + 1e3 * _transform.topRightCorner<3, 1>();
    one.intensity = sample.intensity;
    one.pattern_ms = sample.patternTime_ms + _course.begin_ms;
    one.offset_ms = sample.patternTime_ms - time_ms;
    one.isStopped = sample.isStopped;
    return one;
}

void DesignerSession::tellProblems(const haptics::SensationSample& sample)
{
    if (!sample.isFinite) tellOnce("a formula gives NaN or infinity; these samples are silent");
    if (sample.isLimited)
        tellOnce("the pattern asks for intensities outside 0 .. 1; they are limited");
}

void DesignerSession::end()
{
    _player.reset();
    _samples.clear();
    _output.end();
}

void DesignerSession::reset()
{
    end();
    try
    {
        place(Eigen::Matrix4d::Identity());
        _output.setTracking(false);
    }
    catch (const InputError& error)
    {
        tell(error.what());
    }
    _owesStop = _showsHand = false;
    _sensation = nullptr;
    _json.clear();
    _sentFrom_ms.reset();
    _parameters.clear();
    _time_ms = 0.0;
    _lastTold.clear();
    _toldOnce.clear();
}

void DesignerSession::tell(const std::string& what)
{
    if (what == _lastTold) return;
    _lastTold = what;
    _tell(what);
}

void DesignerSession::tellOnce(const std::string& what)
{
    if (_toldOnce.size() < kMostToldOnce && _toldOnce.insert(what).second) _tell(what);
}

} // namespace midair::samples
