#include "haptics/base/text/MessageLog.h"

#include <algorithm>
#include <atomic>
#include <cctype>
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

} // namespace

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
    const auto count = [this](const auto& isIt)
    { return std::count_if(_all.begin(), _all.end(), isIt); };
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

bool MessageLog::say(Message message)
{
    message.said = nextSaid();
    std::string key = keyOf(message);
    if (Message* known = find(key))
    {
        known->count += message.count;
        known->said = message.said;
        known->text = std::move(message.text);
        return false;
    }
    add(std::move(key), std::move(message), true);
    return true;
}

bool MessageLog::take(const Message& message)
{
    if (message.said == 0) return say(message);
    std::string key = keyOf(message);
    if (Message* known = find(key))
    {
        if (message.said > known->said) known->text = message.text;
        known->said = std::max(known->said, message.said);
        known->count = std::max(known->count, message.count);
        return false;
    }
    add(std::move(key), message, false);
    return true;
}

std::vector<std::string> MessageLog::all() const
{
    std::vector<std::string> texts;
    texts.reserve(_all.size());
    for (const Message& message : _all)
        texts.push_back(message.text);
    return texts;
}

} // namespace midair::base
