#include "haptics/base/text/MessageLog.h"

#include "haptics/base/text/Words.h"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <iterator>
#include <tuple>

namespace midair::base
{

namespace
{

bool isDigit(char c)
{
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

// The end of the number that begins at \a i: digits, points, and an exponent with its sign.
std::size_t endOfNumber(const std::string& text, std::size_t i)
{
    const auto at = [&](std::size_t k) { return k < text.size() ? text[k] : '\0'; };
    for (;; ++i)
    {
        if (isDigit(at(i)) || (at(i) == '.' && isDigit(at(i + 1)))) continue;
        const bool isExponent = at(i) == 'e' && (at(i + 1) == '+' || at(i + 1) == '-');
        if (!isExponent || !isDigit(at(i + 2))) return i;
        ++i; // the sign
    }
}

std::uint64_t nextSaid()
{
    static std::atomic<std::uint64_t> said{0};
    return ++said;
}

bool areAlike(const Message& a, const Message& b)
{
    return a.code == b.code && a.path == b.path;
}

std::string keyOf(const Message& message)
{
    const MessageKind& kind = kindOf(message.code);
    std::string place = message.path + '\n' + kind.name;
    if (kind.isOne) return place;
    const bool begins =
        !message.path.empty() && message.text.compare(0, message.path.size(), message.path) == 0;
    return place + '\n' +
           withoutNumbers(begins ? message.text.substr(message.path.size()) : message.text);
}

/// More places than a scene has messages of; then those where nothing waits begin anew.
constexpr std::size_t kMostPlaces = 1000;

} // namespace

// One line for each code.
// NOLINTNEXTLINE(readability-function-size)
const std::vector<MessageKind>& messageKinds()
{
    using C = MessageCode;
    using S = Severity;
    static const std::vector<MessageKind> all = {
        {C::AIR_TEMPERATURE, "air.temperature", S::WARNING, false},
        {C::ARRAY_DEAD, "array.dead", S::FAULT, true},
        {C::ARRAY_INVALID, "array.invalid", S::FAULT, false},
        {C::ARRAY_READ_AGAIN, "array.reread", S::NOTICE, true},
        {C::ARRAY_REFUSED, "array.refused", S::FAULT, true},
        {C::CALLBACK_THREW, "callback.threw", S::WARNING, false},
        {C::CAP_EARS, "cap.ears", S::NOTICE, true},
        {C::CAP_PRESSURE, "cap.pressure", S::NOTICE, true},
        {C::DEVICE_CAP, "device.cap", S::FAULT, true},
        {C::DEVICE_FAULT, "device.fault", S::FAULT, true},
        {C::DEVICE_HANGS, "device.hangs", S::FAULT, true},
        {C::DEVICE_LOST, "device.lost", S::FAULT, true},
        {C::DEVICE_MUTED, "device.muted", S::NOTICE, true},
        {C::DEVICE_OPEN, "device.open", S::FAULT, true},
        {C::DEVICE_OPENED, "device.opened", S::NOTICE, true},
        {C::DEVICE_REFUSED, "device.refused", S::FAULT, true},
        {C::DEVICE_SLOW, "device.slow", S::NOTICE, true},
        {C::FIELD_FAILED, "field.failed", S::FAULT, false},
        {C::FIELD_REST, "field.rest", S::WARNING, false},
        {C::FIELD_SILENCED, "field.silenced", S::FAULT, true},
        {C::FIELD_UNEVEN, "field.uneven", S::NOTICE, true},
        {C::GRANTS_FILE, "grants.file", S::WARNING, false},
        {C::GRANTS_REFUSED, "grants.refused", S::WARNING, false},
        {C::GRANTS_TRUST, "grants.trust", S::NOTICE, false},
        {C::HANDS_OPEN, "hands.open", S::WARNING, false},
        {C::HANDS_PREDICTION, "hands.prediction", S::WARNING, false},
        {C::HANDS_SOURCE, "hands.source", S::WARNING, false},
        {C::HANDS_THREW, "hands.threw", S::WARNING, false},
        {C::MODULATION_FREQUENCY, "modulation.frequency", S::WARNING, true},
        {C::MODULATION_OVERRIDDEN, "modulation.overridden", S::WARNING, true},
        {C::MODULATION_SUBSETS, "modulation.subsets", S::WARNING, true},
        {C::MONITOR_FAILED, "monitor.failed", S::WARNING, false},
        {C::OBJECT_CAMERA, "object.camera", S::WARNING, true},
        {C::OBJECT_GEOMETRY, "object.geometry", S::WARNING, false},
        {C::OBJECT_HIDDEN, "object.hidden", S::NOTICE, true},
        {C::OBJECT_INVALID, "object.invalid", S::WARNING, false},
        {C::OBJECT_LARGE, "object.large", S::WARNING, true},
        {C::OBJECT_SIDE, "object.side", S::NOTICE, true},
        {C::OBJECT_SMALL, "object.small", S::WARNING, true},
        {C::OBJECT_UNFELT, "object.unfelt", S::WARNING, true},
        {C::OBJECT_UNITS, "object.units", S::WARNING, true},
        {C::OBJECT_UNREACHABLE, "object.unreachable", S::WARNING, true},
        {C::OBJECT_UNTURNED, "object.unturned", S::NOTICE, true},
        {C::OBSTACLE_IDLE, "obstacle.idle", S::NOTICE, true},
        {C::OBSTACLE_INVALID, "obstacle.invalid", S::WARNING, false},
        {C::POINTS_BUDGET, "points.budget", S::WARNING, true},
        {C::POINTS_INVALID, "points.invalid", S::WARNING, false},
        {C::PROPERTY_INVALID, "property.invalid", S::WARNING, false},
        {C::PROPERTY_SILENCED, "property.silenced", S::FAULT, false},
        {C::SCENE_CLOSED, "scene.closed", S::FAULT, true},
        {C::SCENE_EMPTY, "scene.empty", S::WARNING, true},
        {C::SCENE_INCOMPLETE, "scene.incomplete", S::WARNING, true},
        {C::SCENE_INSIDE, "scene.inside", S::NOTICE, false},
        {C::SCENE_LIMIT, "scene.limit", S::FAULT, false},
        {C::SCENE_UNMARKED, "scene.unmarked", S::NOTICE, true},
        {C::SETTINGS_CALIBRATION, "settings.calibration", S::FAULT, true},
        {C::SETTINGS_INVALID, "settings.invalid", S::WARNING, false},
        {C::SETTINGS_LIMITED, "settings.limited", S::WARNING, false},
        {C::SETTINGS_SILENCED, "settings.silenced", S::FAULT, false},
        {C::SOLVER_REFUSED, "solver.refused", S::FAULT, false},
        {C::SOLVER_REPORT, "solver.report", S::NOTICE, false},
        {C::SOLVER_SLOW, "solver.slow", S::WARNING, true},
        {C::VIEWER_SILENT, "viewer.silent", S::FAULT, true},
    };
    return all;
}

// The rows stand in the order of the codes, which a test checks.
const MessageKind& kindOf(MessageCode code)
{
    return messageKinds().at(static_cast<std::size_t>(code));
}

std::string severityName(Severity severity)
{
    return severity == Severity::NOTICE    ? "notice"
           : severity == Severity::WARNING ? "warning"
                                           : "fault";
}

// A number is one only where no word goes on: "board2" is a name.
std::string withoutNumbers(const std::string& text)
{
    std::string bare;
    bool isQuoted = false;
    for (std::size_t i = 0; i < text.size();)
    {
        isQuoted ^= text[i] == '"';
        const char before = i > 0 ? text[i - 1] : ' ';
        const bool inWord = std::isalnum(static_cast<unsigned char>(before)) != 0 || before == '_';
        if (isQuoted || inWord || !isDigit(text[i]))
        {
            bare += text[i++];
            continue;
        }
        bare += '#';
        i = endOfNumber(text, i);
    }
    return bare;
}

Message* MessageLog::find(const std::string& key)
{
    const auto found = std::find(_keys.begin(), _keys.end(), key);
    return found == _keys.end() ? nullptr : &_all[static_cast<std::size_t>(found - _keys.begin())];
}

void MessageLog::erase(std::size_t i)
{
    _keys.erase(_keys.begin() + static_cast<std::ptrdiff_t>(i));
    _all.erase(_all.begin() + static_cast<std::ptrdiff_t>(i));
}

// The one that goes first. A state that lasts is often told only when it begins, so how long ago a
// message was said is the last that counts.
std::size_t MessageLog::leastOfAll() const
{
    const std::vector<Message>* const all = &_all;
    const auto count = [all](const auto& isIt)
    { return std::count_if(all->begin(), all->end(), isIt); };
    const auto rank = [&](const Message& one)
    {
        const bool isAlone = count([&](const Message& other) { return areAlike(other, one); }) == 1;
        const auto ofItsCode = count([&](const Message& other) { return other.code == one.code; });
        return std::make_tuple(
            one.severity() == Severity::FAULT, isAlone, one.severity(), -ofItsCode, one.said);
    };
    std::size_t least = 0;
    auto leastRank = rank(_all[0]);
    for (std::size_t i = 1; i < _all.size(); ++i)
    {
        const auto its = rank(_all[i]);
        if (!(its < leastRank)) continue;
        leastRank = its;
        least = i;
    }
    return least;
}

// Returns false if \a message has no place, since there are faults alone and it is none.
bool MessageLog::makeRoom(const Message& message)
{
    if (_all.size() < kMost) return true;
    const std::size_t least = leastOfAll();
    if (_all[least].severity() == Severity::FAULT && message.severity() != Severity::FAULT)
        return false;
    erase(least);
    return true;
}

void MessageLog::add(std::string key, Message message, bool isCounted)
{
    ++_added;
    std::size_t alike = 0;
    std::size_t oldest = 0;
    for (std::size_t i = 0; i < _all.size(); ++i)
    {
        if (!areAlike(_all[i], message)) continue;
        if (alike++ == 0 || _all[i].said < _all[oldest].said) oldest = i;
    }
    if (alike >= kMostAlike)
    {
        if (isCounted) message.count += _all[oldest].count;
        erase(oldest);
    }
    else if (!makeRoom(message))
        return;
    _keys.push_back(std::move(key));
    _all.push_back(std::move(message));
}

// \a isCounted: it is said once more; else it is one that another log has counted.
bool MessageLog::keep(Message message, bool isCounted)
{
    if (_isForUser) // may contain text from a file
    {
        message.text = printable(message.text);
        message.path = printable(message.path);
    }
    if (isCounted) message.said = nextSaid();
    std::string key = keyOf(message);
    std::optional<Line> line;
    {
        const Lock lock(_mutex);
        if (Message* known = find(key))
        {
            if (message.said > known->said) known->text = std::move(message.text);
            known->said = std::max(known->said, message.said);
            known->count =
                isCounted ? known->count + message.count : std::max(known->count, message.count);
            return false;
        }
        if (_print) line = lineOf(message);
        add(std::move(key), std::move(message), isCounted);
    }
    if (line) _print(*line);
    return true;
}

void MessageLog::sayOfAll(MessageCode code,
                          const std::vector<std::string>& paths,
                          const std::string& what)
{
    if (paths.empty()) return;
    const std::string more =
        paths.size() > 1 ? "; so it is with " + std::to_string(paths.size() - 1) + " more" : "";
    say(about(code, paths.front(), what + more));
}

// What was taken before may be gone from this log, which has a limit, and isn't new for that.
void MessageLog::takeNew(const std::vector<Message>& all)
{
    std::uint64_t newest = 0;
    {
        const Lock lock(_mutex);
        newest = _takenUpTo;
        for (const Message& message : all)
            _takenUpTo = std::max(_takenUpTo, message.said);
    }
    for (const Message& message : all)
        if (message.said == 0 || message.said > newest) take(message);
}

bool MessageLog::begins(const Topic& topic, bool holds)
{
    const Lock lock(_mutex);
    if (holds) return _states.lasting.insert(topic).second;
    _states.lasting.erase(topic);
    return false;
}

void MessageLog::beginLook()
{
    const Lock lock(_mutex);
    _states.now.clear();
}

bool MessageLog::note(const Topic& topic)
{
    const Lock lock(_mutex);
    return _states.now.insert(topic).second && _states.before.count(topic) == 0;
}

void MessageLog::keepNoted(const Topic& topic)
{
    const Lock lock(_mutex);
    if (_states.before.count(topic) > 0) _states.now.insert(topic);
}

void MessageLog::endLook()
{
    const Lock lock(_mutex);
    _states.before.swap(_states.now);
}

std::vector<Message> MessageLog::messages() const
{
    const Lock lock(_mutex);
    return _all;
}

std::vector<std::string> MessageLog::all() const
{
    std::size_t none = 0;
    return newTexts(none);
}

std::vector<std::string> MessageLog::newTexts(std::size_t& told) const
{
    const Lock lock(_mutex);
    const std::size_t fresh = std::min(_added - told, _all.size());
    told = _added;
    std::vector<std::string> texts;
    for (std::size_t i = _all.size() - fresh; i < _all.size(); ++i)
        texts.push_back(_all[i].text);
    return texts;
}

std::size_t MessageLog::added() const
{
    const Lock lock(_mutex);
    return _added;
}

MessageLog::Line MessageLog::lineOf(MessageCode code, Told& told, double now_s)
{
    std::string text = std::exchange(told.newest, {});
    const std::uint64_t before = told.waiting - 1;
    if (before > 0)
        text += " (" + std::to_string(before) + " messages \"" + kindOf(code).name +
                "\" before it are left out here)";
    _lines.waiting -= std::exchange(told.waiting, 0);
    ++told.lines;
    told.last_s = now_s;
    return {kindOf(code).severity, std::move(text)};
}

// None: it waits for printDue().
std::optional<MessageLog::Line> MessageLog::lineOf(const Message& message)
{
    const double now_s = _clock.now_s();
    if (_lines.of.size() >= kMostPlaces)
        for (auto one = _lines.of.begin(); one != _lines.of.end();)
            one = one->second.waiting == 0 ? _lines.of.erase(one) : std::next(one);
    Told& told = _lines.of[{message.code, message.path}];
    ++told.waiting;
    ++_lines.waiting;
    told.newest = message.text;
    if (told.lines >= kFirstLines && now_s < told.last_s + kLinePause_s) return {};
    return lineOf(message.code, told, now_s);
}

void MessageLog::printDue(double now_s)
{
    std::vector<Line> due;
    {
        const Lock lock(_mutex);
        if (_lines.waiting == 0) return;
        for (auto& [place, told] : _lines.of)
            if (told.waiting > 0 && !(now_s < told.last_s + kLinePause_s))
                due.push_back(lineOf(place.first, told, now_s));
    }
    for (const Line& line : due)
        _print(line);
}

} // namespace midair::base
