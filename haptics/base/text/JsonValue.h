#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

namespace midair::base
{

/// A value of a JSON text, and where it stands there. What reads it throws InputError for a value
/// that is not as expected: "source: path in the file is VALUE; it must be RIGHT". The text has to
/// outlive it. Private to the library.
class JsonValue
{
public:
    using Json = nlohmann::ordered_json;

    JsonValue(const std::string& source, const Json& json, std::string path = {}) :
        _source(&source),
        _json(&json),
        _path(std::move(path))
    {
    }

    [[noreturn]] void fail(const std::string& what) const;
    [[noreturn]] void wrong(const std::string& right) const;

    /// Requires an object with no other keys than \a known.
    void object(std::initializer_list<const char*> known) const;
    /// The value of \a key in an object; none: it has none.
    std::optional<JsonValue> find(const std::string& key) const;
    /// The same, which has to be there.
    JsonValue required(const std::string& key, const std::string& right) const;

    /// Requires a list of at most \a most entries.
    const JsonValue& list(const std::string& right,
                          std::size_t most = std::numeric_limits<std::size_t>::max()) const;
    bool isList() const { return _json->is_array(); }
    std::size_t size() const { return _json->size(); }
    JsonValue operator[](std::size_t index) const; ///< of a list

    /// Returns a finite number in [low, high].
    double number(double low, double high, const std::string& right) const;
    int integer(int low, int high, const std::string& right) const;
    std::string string() const;
    /// Returns a list of \a size finite numbers, each within -limit .. limit.
    Eigen::VectorXd vector(int size, double limit, const std::string& right) const;
    /// Returns a vector of three numbers that is not zero, normalised.
    Eigen::Vector3d direction() const;

    /// The same of required().
    double number(const char* key, double low, double high, const std::string& right) const
    {
        return required(key, right).number(low, high, right);
    }
    int integer(const char* key, int low, int high, const std::string& right) const
    {
        return required(key, right).integer(low, high, right);
    }

    const Json& json() const { return *_json; }

private:
    const std::string* _source; ///< name of the text in messages, usually the path of a file
    const Json* _json;
    std::string _path;
};

/// Parses \a text. Throws InputError "source: not JSON: ..." with line and column.
JsonValue::Json parseJson(const std::string& text, const std::string& source);

} // namespace midair::base
