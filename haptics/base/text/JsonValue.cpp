#include "haptics/base/text/JsonValue.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::base
{

namespace
{

// Returns a short value as in the file. Long or nested ones are only described: 100,000 brackets
// are no help, and printing them would recurse as deep.
std::string shown(const JsonValue::Json& value)
{
    if (value.is_object()) return "an object";
    if (value.is_array() &&
        (value.size() > 6 ||
         std::any_of(value.begin(), value.end(), [](const auto& v) { return v.is_structured(); })))
        return fmt::format("a list of {}", value.size());
    const std::string text = value.dump(-1, ' ', false, JsonValue::Json::error_handler_t::replace);
    return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

} // namespace

JsonError::JsonError(const std::string& source, std::string itsPath, std::string itsReason) :
    InputError(source + ": " + itsReason),
    path(std::move(itsPath)),
    reason(std::move(itsReason))
{
}

JsonValue::Json parseJson(const std::string& text, const std::string& source)
{
    try
    {
        return JsonValue::Json::parse(text);
    }
    catch (const nlohmann::json::exception& error)
    {
        // "[json.exception.parse_error.101] parse error at line 3, column 4: ..."; the number is of
        // no use to a user.
        const std::string what = error.what();
        const std::size_t end = what.find("] ");
        throw InputError(source +
                         ": not JSON: " + (end == std::string::npos ? what : what.substr(end + 2)));
    }
}

void JsonValue::fail(const std::string& what) const
{
    throw JsonError(*_source, _path, _path.empty() ? what : _path + " " + what);
}

void JsonValue::wrong(const std::string& right) const
{
    fail(fmt::format(
        "{}is {}; it must be {}", _path.empty() ? "the whole file " : "", shown(*_json), right));
}

void JsonValue::object(std::initializer_list<const char*> known) const
{
    if (!_json->is_object()) wrong("an object in braces");
    for (const auto& item : _json->items())
        if (std::find(known.begin(), known.end(), item.key()) == known.end())
            fail(fmt::format(
                "has the unknown key '{}'; known are {}", item.key(), fmt::join(known, ", ")));
}

std::optional<JsonValue> JsonValue::find(const std::string& key) const
{
    const auto found = _json->find(key);
    if (found == _json->end()) return {};
    return JsonValue(*_source, *found, _path.empty() ? key : _path + "." + key);
}

JsonValue JsonValue::required(const std::string& key, const std::string& right) const
{
    const std::optional<JsonValue> found = find(key);
    if (!found) fail(fmt::format("lacks '{}'; it must be {}", key, right));
    return *found;
}

const JsonValue& JsonValue::list(const std::string& right, std::size_t most) const
{
    if (!_json->is_array()) wrong(right);
    if (size() > most) fail(fmt::format("has {} entries; at most {} are possible", size(), most));
    return *this;
}

JsonValue JsonValue::operator[](std::size_t index) const
{
    return JsonValue(*_source, (*_json)[index], fmt::format("{}[{}]", _path, index));
}

double JsonValue::number(double low, double high, const std::string& right) const
{
    if (!_json->is_number()) wrong(right);
    const auto x = _json->get<double>();
    if (!std::isfinite(x) || x < low || x > high) wrong(right);
    return x;
}

int JsonValue::integer(int low, int high, const std::string& right) const
{
    if (!_json->is_number_integer()) wrong(right);
    const auto x = _json->get<double>(); // can hold values that do not fit an int
    if (x < low || x > high) wrong(right);
    return static_cast<int>(x);
}

std::string JsonValue::string() const
{
    if (!_json->is_string()) wrong("a text in quotes");
    return _json->get<std::string>();
}

Eigen::VectorXd JsonValue::vector(int size, double limit, const std::string& right) const
{
    if (!_json->is_array() || static_cast<int>(_json->size()) != size) wrong(right);
    Eigen::VectorXd v(size);
    for (int k = 0; k < size; ++k)
    {
        const Json& component = (*_json)[static_cast<std::size_t>(k)];
        if (!component.is_number()) wrong(right);
        v[k] = component.get<double>();
        if (!std::isfinite(v[k]) || std::abs(v[k]) > limit) wrong(right);
    }
    return v;
}

Eigen::Vector3d JsonValue::direction() const
{
    const std::string right = "a direction [x, y, z] that is not zero";
    const Eigen::Vector3d v = vector(3, 1e100, right);
    const double length = v.norm();
    if (!(length > 1e-100)) wrong(right);
    // A unit vector stays unchanged to the last bit, so that a saved array is read back equal.
    return std::abs(length - 1.0) < 1e-14 ? v : Eigen::Vector3d(v / length);
}

} // namespace midair::base
