#pragma once

#include "haptics/base/InputError.h"

#include <Eigen/Core>

#include <cstddef>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

namespace midair::base
{

/// Error in a value of a JSON text. what() is "source: path reason".
class JsonError : public InputError
{
public:
    JsonError(const std::string& source, std::string itsPath, std::string itsReason);

    const std::string path;   ///< of the value, as in JsonValue; empty: the whole text
    const std::string reason; ///< path and problem, without the source
};

/// A value of a JSON text and its path. Accessors throw JsonError for unexpected values: "source:
/// path in the file is VALUE; it must be RIGHT". The text must outlive it. Private to the library.
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

    /// Requires an object whose keys are all in \a known.
    void object(std::initializer_list<const char*> known) const;
    /// Returns the value of \a key in an object, or none.
    std::optional<JsonValue> find(const std::string& key) const;
    /// Like find(), but the key must exist.
    JsonValue required(const std::string& key, const std::string& right) const;

    /// Requires a list of at most \a most entries.
    const JsonValue& list(const std::string& right,
                          std::size_t most = std::numeric_limits<std::size_t>::max()) const;
    bool isList() const { return _json->is_array(); }
    std::size_t size() const { return _json->size(); }
    JsonValue operator[](std::size_t index) const; ///< element of a list

    /// Returns a finite number in [low, high].
    double number(double low, double high, const std::string& right) const;
    int integer(int low, int high, const std::string& right) const;
    std::string string() const;
    /// Returns a list of \a size finite numbers, each within -limit .. limit.
    Eigen::VectorXd vector(int size, double limit, const std::string& right) const;
    /// Returns a non-zero vector of three numbers, normalised.
    Eigen::Vector3d direction() const;

    /// number() of required().
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
    const std::string* _source; ///< name of the text in messages, usually a file path
    const Json* _json;
    std::string _path;
};

/// Parses \a text. Throws InputError "source: not JSON: ..." with line and column.
JsonValue::Json parseJson(const std::string& text, const std::string& source);

} // namespace midair::base
