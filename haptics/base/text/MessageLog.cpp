#include "haptics/base/text/MessageLog.h"

#include <algorithm>
#include <cctype>

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

void MessageLog::add(std::string key, Message message)
{
    if (_all.size() >= kMost)
    {
        const auto least = std::min_element(_all.begin(),
                                            _all.end(),
                                            [](const Message& a, const Message& b)
                                            { return a.severity() < b.severity(); });
        _keys.erase(_keys.begin() + (least - _all.begin()));
        _all.erase(least);
    }
    ++_added;
    _keys.push_back(std::move(key));
    _all.push_back(std::move(message));
}

bool MessageLog::say(Message message)
{
    std::string key = keyOf(message);
    if (Message* known = find(key))
    {
        known->count += message.count;
        known->text = std::move(message.text);
        return false;
    }
    add(std::move(key), std::move(message));
    return true;
}

bool MessageLog::take(const Message& message)
{
    std::string key = keyOf(message);
    if (Message* known = find(key))
    {
        if (message.count > known->count) known->text = message.text;
        known->count = std::max(known->count, message.count);
        return false;
    }
    add(std::move(key), message);
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
