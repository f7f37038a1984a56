#include "haptics/base/text/JsonReader.h"

#include "haptics/base/InputError.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace midair::base
{

namespace
{

// Returns a short value as it is in the file. Long or nested ones are only described: 100,000
// brackets are no help, and writing them out would recurse as deep.
std::string shown(const JsonReader::Json& value)
{
    if (value.is_object()) return "an object";
    if (value.is_array() &&
        (value.size() > 6 ||
         std::any_of(value.begin(), value.end(), [](const auto& v) { return v.is_structured(); })))
        return fmt::format("a list of {}", value.size());
    const std::string text = value.dump(-1, ' ', false, JsonReader::Json::error_handler_t::replace);
    return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

} // namespace

JsonReader::JsonReader(std::string source) : _source(std::move(source)) {}

JsonReader::Json JsonReader::parse(const std::string& text) const
{
    try
    {
        return Json::parse(text);
    }
    catch (const nlohmann::json::exception& error)
    {
        // "[json.exception.parse_error.101] parse error at line 3, column 4: ..."; the number is of
        // no use to a user.
        const std::string what = error.what();
        const std::size_t end = what.find("] ");
        fail("", "not JSON: " + (end == std::string::npos ? what : what.substr(end + 2)));
    }
}

void JsonReader::fail(const std::string& path, const std::string& what) const
{
    throw InputError(fmt::format("{}: {}{}{}", _source, path, path.empty() ? "" : " ", what));
}

void JsonReader::wrong(const std::string& path, const Json& value, const std::string& right) const
{
    fail(path, fmt::format("is {}; it must be {}", shown(value), right));
}

void JsonReader::object(const Json& value,
                        const std::string& path,
                        std::initializer_list<const char*> known) const
{
    if (!value.is_object())
        wrong(path.empty() ? "the whole file" : path, value, "an object in braces");
    for (const auto& item : value.items())
        if (std::find(known.begin(), known.end(), item.key()) == known.end())
            fail(path,
                 fmt::format(
                     "has the unknown key '{}'; known are {}", item.key(), fmt::join(known, ", ")));
}

const JsonReader::Json& JsonReader::required(const Json& parent,
                                             const std::string& path,
                                             const char* key,
                                             const std::string& right) const
{
    const auto found = parent.find(key);
    if (found == parent.end()) fail(path, fmt::format("lacks '{}'; it must be {}", key, right));
    return *found;
}

double JsonReader::number(const Json& value,
                          const std::string& path,
                          double low,
                          double high,
                          const std::string& right) const
{
    if (!value.is_number()) wrong(path, value, right);
    const auto x = value.get<double>();
    if (!std::isfinite(x) || x < low || x > high) wrong(path, value, right);
    return x;
}

int JsonReader::integer(
    const Json& value, const std::string& path, int low, int high, const std::string& right) const
{
    if (!value.is_number_integer()) wrong(path, value, right);
    const auto x = value.get<double>(); // can hold values that do not fit an int
    if (x < low || x > high) wrong(path, value, right);
    return static_cast<int>(x);
}

std::string JsonReader::string(const Json& value, const std::string& path) const
{
    if (!value.is_string()) wrong(path, value, "a text in quotes");
    return value.get<std::string>();
}

const JsonReader::Json&
JsonReader::list(const Json& value, const std::string& path, const std::string& right) const
{
    if (!value.is_array()) wrong(path, value, right);
    return value;
}

Eigen::VectorXd JsonReader::vector(const Json& value,
                                   const std::string& path,
                                   int size,
                                   double limit,
                                   const std::string& right) const
{
    if (!value.is_array() || static_cast<int>(value.size()) != size) wrong(path, value, right);
    Eigen::VectorXd v(size);
    for (int k = 0; k < size; ++k)
    {
        const Json& component = value[static_cast<std::size_t>(k)];
        if (!component.is_number()) wrong(path, value, right);
        v[k] = component.get<double>();
        if (!std::isfinite(v[k]) || std::abs(v[k]) > limit) wrong(path, value, right);
    }
    return v;
}

Eigen::Vector3d JsonReader::direction(const Json& value, const std::string& path) const
{
    const std::string right = "a direction [x, y, z] that is not zero";
    const Eigen::Vector3d v = vector(value, path, 3, 1e100, right);
    const double length = v.norm();
    if (!(length > 1e-100)) wrong(path, value, right);
    // A unit vector stays unchanged to the last bit, so that a saved array is read back equal.
    return std::abs(length - 1.0) < 1e-14 ? v : Eigen::Vector3d(v / length);
}

std::string JsonReader::at(const std::string& path, const char* key)
{
    return path.empty() ? key : path + "." + key;
}

std::string JsonReader::at(const std::string& path, std::size_t index)
{
    return fmt::format("{}[{}]", path, index);
}

} // namespace midair::base
