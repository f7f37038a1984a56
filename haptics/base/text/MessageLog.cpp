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

// Returns the end of the number that begins at \a i: digits, points, and an exponent with its sign.
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

/// Program-wide counter: increases when a message is sent or ends.
std::atomic<std::uint64_t>& changesOfAll()
{
    static std::atomic<std::uint64_t> changes{0};
    return changes;
}

bool contains(const std::vector<std::string>& keys, const std::string& key)
{
    return std::find(keys.begin(), keys.end(), key) != keys.end();
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

/// Maximum number of code and path pairs, more than a scene has; above it, those without waiting
/// messages are forgotten.
constexpr std::size_t kMostPlaces = 1000;

} // namespace

// One line for each code.
// NOLINTNEXTLINE(readability-function-size)
const std::vector<MessageKind>& messageKinds()
{
    using C = MessageCode;
    using S = Severity;
    using L = Lasts;
    static const std::vector<MessageKind> all = {
        {C::AIR_TEMPERATURE, "air.temperature", S::WARNING, L::STATE, false},
        {C::ARRAY_DEAD, "array.dead", S::FAULT, L::STATE, true},
        {C::ARRAY_INVALID, "array.invalid", S::FAULT, L::STATE, false},
        {C::ARRAY_READ_AGAIN, "array.reread", S::NOTICE, L::MOMENT, true},
        {C::ARRAY_REFUSED, "array.refused", S::FAULT, L::STATE, true},
        {C::CALLBACK_THREW, "callback.threw", S::WARNING, L::MOMENT, false},
        {C::CAP_EARS, "cap.ears", S::NOTICE, L::FIELD, true},
        {C::CAP_PRESSURE, "cap.pressure", S::NOTICE, L::FIELD, true},
        {C::DEVICE_CAP, "device.cap", S::FAULT, L::STATE, true},
        {C::DEVICE_FAULT, "device.fault", S::FAULT, L::STATE, true},
        {C::DEVICE_HANGS, "device.hangs", S::FAULT, L::STATE, true},
        {C::DEVICE_LOST, "device.lost", S::FAULT, L::STATE, true},
        {C::DEVICE_MUTED, "device.muted", S::NOTICE, L::STATE, true},
        {C::DEVICE_OPEN, "device.open", S::FAULT, L::STATE, true},
        {C::DEVICE_OPENED, "device.opened", S::NOTICE, L::MOMENT, true},
        {C::DEVICE_REFUSED, "device.refused", S::FAULT, L::STATE, true},
        {C::DEVICE_SLOW, "device.slow", S::NOTICE, L::FIELD, true},
        {C::DISPLAY_HEAD, "display.head", S::WARNING, L::STATE, true},
        {C::DISPLAY_VIEW, "display.view", S::WARNING, L::STATE, false},
        {C::FIELD_FAILED, "field.failed", S::FAULT, L::FIELD, false},
        {C::FIELD_FAINT, "field.faint", S::WARNING, L::STATE, true},
        {C::FIELD_REST, "field.rest", S::WARNING, L::FIELD, false},
        {C::FIELD_SILENCED, "field.silenced", S::FAULT, L::FIELD, true},
        {C::FIELD_UNEVEN, "field.uneven", S::NOTICE, L::FIELD, true},
        {C::GRANTS_FILE, "grants.file", S::WARNING, L::STATE, false},
        {C::GRANTS_REFUSED, "grants.refused", S::WARNING, L::STATE, false},
        {C::GRANTS_TRUST, "grants.trust", S::NOTICE, L::STATE, false},
        {C::HANDS_OPEN, "hands.open", S::WARNING, L::STATE, false},
        {C::HANDS_PREDICTION, "hands.prediction", S::WARNING, L::MOMENT, false},
        {C::HANDS_SOURCE, "hands.source", S::WARNING, L::STATE, false},
        {C::HANDS_THREW, "hands.threw", S::WARNING, L::STATE, false},
        {C::MODULATION_FREQUENCY, "modulation.frequency", S::WARNING, L::FIELD, true},
        {C::MODULATION_OVERRIDDEN, "modulation.overridden", S::WARNING, L::FIELD, true},
        {C::MODULATION_SUBSETS, "modulation.subsets", S::WARNING, L::FIELD, true},
        {C::MONITOR_FAILED, "monitor.failed", S::WARNING, L::STATE, false},
        {C::OBJECT_CAMERA, "object.camera", S::WARNING, L::STATE, true},
        {C::OBJECT_GEOMETRY, "object.geometry", S::WARNING, L::STATE, false},
        {C::OBJECT_HIDDEN, "object.hidden", S::NOTICE, L::STATE, true},
        {C::OBJECT_INVALID, "object.invalid", S::WARNING, L::STATE, false},
        {C::OBJECT_LARGE, "object.large", S::WARNING, L::STATE, true},
        {C::OBJECT_SIDE, "object.side", S::NOTICE, L::STATE, true},
        {C::OBJECT_SMALL, "object.small", S::WARNING, L::STATE, true},
        {C::OBJECT_UNFELT, "object.unfelt", S::WARNING, L::STATE, true},
        {C::OBJECT_UNITS, "object.units", S::WARNING, L::STATE, true},
        {C::OBJECT_UNREACHABLE, "object.unreachable", S::WARNING, L::STATE, true},
        {C::OBJECT_UNTURNED, "object.unturned", S::NOTICE, L::STATE, true},
        {C::OBSTACLE_IDLE, "obstacle.idle", S::NOTICE, L::STATE, true},
        {C::OBSTACLE_INVALID, "obstacle.invalid", S::WARNING, L::STATE, false},
        {C::POINTS_BUDGET, "points.budget", S::WARNING, L::STATE, true},
        {C::POINTS_INVALID, "points.invalid", S::WARNING, L::STATE, false},
        {C::PROPERTY_INVALID, "property.invalid", S::WARNING, L::STATE, false},
        {C::PROPERTY_SILENCED, "property.silenced", S::FAULT, L::STATE, false},
        {C::REFLECTOR_INVALID, "reflector.invalid", S::WARNING, L::STATE, false},
        {C::REFLECTOR_LIMITED, "reflector.limited", S::WARNING, L::STATE, false},
        {C::REFLECTOR_SOLVED, "reflector.solved", S::NOTICE, L::STATE, true},
        {C::SCENE_CLOSED, "scene.closed", S::FAULT, L::FIELD, true},
        {C::SCENE_EMPTY, "scene.empty", S::WARNING, L::STATE, true},
        {C::SCENE_INCOMPLETE, "scene.incomplete", S::WARNING, L::STATE, true},
        {C::SCENE_INSIDE, "scene.inside", S::NOTICE, L::STATE, false},
        {C::SCENE_LIMIT, "scene.limit", S::FAULT, L::STATE, false},
        {C::SCENE_UNMARKED, "scene.unmarked", S::NOTICE, L::STATE, true},
        {C::SENSATION_LIMITED, "sensation.limited", S::WARNING, L::STATE, false},
        {C::SETTINGS_CALIBRATION, "settings.calibration", S::FAULT, L::STATE, true},
        {C::SETTINGS_INVALID, "settings.invalid", S::WARNING, L::STATE, false},
        {C::SETTINGS_LIMITED, "settings.limited", S::WARNING, L::STATE, false},
        {C::SETTINGS_SILENCED, "settings.silenced", S::FAULT, L::STATE, false},
        {C::SOLVER_REFUSED, "solver.refused", S::FAULT, L::FIELD, false},
        {C::SOLVER_REPORT, "solver.report", S::NOTICE, L::FIELD, false},
        {C::SOLVER_SLOW, "solver.slow", S::WARNING, L::STATE, true},
        {C::SOLVER_UNKNOWN, "solver.unknown", S::FAULT, L::FIELD, true},
        {C::VIEWER_SILENT, "viewer.silent", S::FAULT, L::STATE, true},
    };
    return all;
}

// The rows are in the order of the codes, which a test checks.
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

// A number counts only if no word continues it: "board2" is a name.
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

// Index of the message to evict. A lasting state is often reported only when it begins, so age is
// the last criterion.
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

// Returns false if \a message has no room, because all others are faults and it is not.
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
    message.number = _added;
    _keys.push_back(std::move(key));
    _all.push_back(std::move(message));
}

void MessageLog::makePrintable(Message& message) const
{
    if (!_isForUser) return; // may contain text from a file
    message.text = printable(message.text);
    message.path = printable(message.path);
}

// \a isCounted: it is sent again; otherwise another log has counted it.
bool MessageLog::keep(Message message, bool isCounted)
{
    makePrintable(message);
    message.changed = ++changesOfAll();
    if (isCounted)
    {
        message.said = message.changed;
        message.isActive = message.isActive || kindOf(message.code).lasts != Lasts::MOMENT;
        message.since_s = _clock.now_s();
        message.until_s = 0.0;
    }
    std::string key = keyOf(message);
    std::optional<Line> line;
    {
        const Lock lock(_mutex);
        if (Message* known = find(key))
        {
            message.count =
                isCounted ? known->count + message.count : std::max(known->count, message.count);
            if (message.said <= known->said)
                known->count = message.count;
            else
                renew(*known, std::move(message));
            return false;
        }
        if (_print) line = lineOf(message);
        add(std::move(key), std::move(message), isCounted);
    }
    if (line) _print(*line);
    return true;
}

// A newer text alone is not a change.
void MessageLog::renew(Message& known, Message message)
{
    if (known.isActive && message.isActive) message.since_s = known.since_s;
    if (known.isActive == message.isActive && known.count == message.count)
        message.changed = known.changed;
    message.number = known.number;
    known = std::move(message);
}

// Messages taken before may be missing here because of the limit, and are not new.
void MessageLog::takeNew(const std::vector<Message>& all)
{
    Taken before;
    {
        const Lock lock(_mutex);
        before.said = _taken.said;
        before.changed = _taken.changed;
        _taken.changed = 0;
        for (const Message& message : all)
        {
            _taken.said = std::max(_taken.said, message.said);
            _taken.changed = std::max(_taken.changed, message.changed);
        }
    }
    for (const Message& message : all)
        if (message.said == 0 || message.said > before.said) take(message);
    const Lock lock(_mutex);
    if (_taken.changed != before.changed || _taken.changed == 0) takeEnds(all);
}

void MessageLog::takeEnds(const std::vector<Message>& all)
{
    std::set<std::string> active;
    for (Message message : all)
    {
        makePrintable(message);
        if (message.isActive || message.said == 0) active.insert(keyOf(message));
    }
    std::vector<std::string> ended;
    std::set_difference(_taken.keys.begin(),
                        _taken.keys.end(),
                        active.begin(),
                        active.end(),
                        std::back_inserter(ended));
    _taken.keys = std::move(active);
    endUnheld(ended);
}

// --- Lasting states ------------------------------------------------------------------------------

void MessageLog::end(Message& message)
{
    if (!message.isActive) return;
    message.isActive = false;
    message.until_s = _clock.now_s();
    message.changed = ++changesOfAll();
}

// A topic or the other log keeps it active.
bool MessageLog::isHeld(const std::string& key) const
{
    const auto holds = [&key](const Topics& topics)
    {
        return std::any_of(topics.begin(),
                           topics.end(),
                           [&](const Topics::value_type& one)
                           { return contains(one.second, key); });
    };
    return holds(_states.lasting) || holds(_states.noted) || holds(_states.fresh) ||
           _taken.keys.count(key) > 0;
}

void MessageLog::endUnheld(const std::vector<std::string>& keys)
{
    for (const std::string& key : keys)
        if (Message* known = isHeld(key) ? nullptr : find(key)) end(*known);
}

void MessageLog::erase(Topics& topics, const Topic& topic)
{
    const auto found = topics.find(topic);
    if (found == topics.end()) return;
    const std::vector<std::string> keys = std::move(found->second);
    topics.erase(found);
    endUnheld(keys);
}

bool MessageLog::begins(const Topic& topic, bool holds)
{
    const Lock lock(_mutex);
    if (holds) return _states.lasting.try_emplace(topic).second;
    erase(_states.lasting, topic);
    return false;
}

void MessageLog::endsOf(std::uint64_t object)
{
    const Lock lock(_mutex);
    std::vector<Topic> ended;
    for (const auto& [topic, keys] : _states.lasting)
        if (topic.object == object) ended.push_back(topic);
    for (const Topic& topic : ended)
        erase(_states.lasting, topic);
}

void MessageLog::link(const Topic& topic, const std::string& key)
{
    const auto isNoted = _states.noted.find(topic);
    std::vector<std::string>& keys = isNoted != _states.noted.end() ? isNoted->second
                                     : _states.now.count(topic) > 0 ? _states.fresh[topic]
                                                                    : _states.lasting[topic];
    if (!contains(keys, key)) keys.push_back(key);
}

bool MessageLog::say(const Topic& topic, Message message)
{
    makePrintable(message);
    message.isActive = true;
    {
        const Lock lock(_mutex);
        link(topic, keyOf(message));
    }
    return keep(std::move(message), true);
}

void MessageLog::sayOfAll(const std::vector<Topic>& topics, Message first)
{
    if (topics.size() > 1)
        first.text += "; likewise " + std::to_string(topics.size() - 1) + " more";
    makePrintable(first);
    {
        const Lock lock(_mutex);
        for (const Topic& topic : topics)
            link(topic, keyOf(first));
    }
    if (!topics.empty()) say(topics.front(), std::move(first));
}

void MessageLog::sayNow(const Topic& topic, const std::vector<Message>& all)
{
    std::vector<std::string> before;
    {
        const Lock lock(_mutex);
        const auto found = _states.lasting.find(topic);
        if (found != _states.lasting.end()) before = std::move(found->second);
        if (found != _states.lasting.end()) _states.lasting.erase(found);
    }
    for (const Message& message : all)
    {
        Message clean = message;
        makePrintable(clean);
        const std::string key = keyOf(clean);
        if (!contains(before, key))
        {
            say(topic, message);
            continue;
        }
        const Lock lock(_mutex);
        link(topic, key);
        Message* const known = find(key);
        if (!known || known->text == clean.text) continue;
        known->text = std::move(clean.text);
        known->said = ++changesOfAll();
    }
    const Lock lock(_mutex);
    endUnheld(before);
}

void MessageLog::end(MessageCode code)
{
    const Lock lock(_mutex);
    for (std::size_t i = 0; i < _all.size(); ++i)
        if (_all[i].isActive && _all[i].code == code && !isHeld(_keys[i])) end(_all[i]);
}

void MessageLog::endField(std::uint64_t before)
{
    const Lock lock(_mutex);
    for (std::size_t i = 0; i < _all.size(); ++i)
        if (_all[i].isActive && _all[i].said <= before &&
            kindOf(_all[i].code).lasts == Lasts::FIELD && !isHeld(_keys[i]))
            end(_all[i]);
}

std::uint64_t MessageLog::saidNow()
{
    return changesOfAll();
}

void MessageLog::beginLook()
{
    const Lock lock(_mutex);
    _states.now.clear();
}

bool MessageLog::note(const Topic& topic)
{
    const Lock lock(_mutex);
    return _states.now.insert(topic).second && _states.noted.count(topic) == 0;
}

void MessageLog::keepNoted(const Topic& topic)
{
    const Lock lock(_mutex);
    if (_states.noted.count(topic) > 0) _states.now.insert(topic);
}

void MessageLog::endLook()
{
    const Lock lock(_mutex);
    std::vector<std::string> ended;
    const Topics before = std::exchange(_states.noted, {});
    const Topics fresh = std::exchange(_states.fresh, {});
    for (const Topic& topic : _states.now)
        _states.noted[topic];
    for (const Topics* topics : {&before, &fresh})
        for (const auto& [topic, keys] : *topics)
        {
            const auto goesOn = _states.noted.find(topic);
            std::vector<std::string>& to = goesOn == _states.noted.end() ? ended : goesOn->second;
            to.insert(to.end(), keys.begin(), keys.end());
        }
    endUnheld(ended);
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

std::uint64_t MessageLog::changes() const
{
    const Lock lock(_mutex);
    std::uint64_t newest = 0;
    for (const Message& message : _all)
        newest = std::max(newest, message.changed);
    return newest;
}

std::vector<Message> MessageLog::changedSince(std::uint64_t& seen) const
{
    const Lock lock(_mutex);
    std::vector<Message> fresh;
    const std::uint64_t before = seen;
    for (const Message& message : _all)
        if (message.changed > before)
        {
            fresh.push_back(message);
            seen = std::max(seen, message.changed);
        }
    return fresh;
}

void MessageLog::forgetEnded()
{
    const Lock lock(_mutex);
    for (std::size_t i = _all.size(); i-- > 0;)
        if (!_all[i].isActive) erase(i);
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
                "\" before it were left out)";
    _lines.waiting -= std::exchange(told.waiting, 0);
    ++told.lines;
    told.last_s = now_s;
    return {kindOf(code).severity, std::move(text)};
}

// Returns none if it waits for printDue().
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
