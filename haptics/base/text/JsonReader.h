#pragma once

#include <Eigen/Core>

#include <initializer_list>
#include <string>

#include <nlohmann/json.hpp>

namespace midair::base
{

/// Reads values from a JSON text. Throws InputError for a value that is not as expected: "source:
/// path in the file is VALUE; it must be RIGHT". Private to the library.
class JsonReader
{
public:
    using Json = nlohmann::ordered_json;

    /// \a source: name of the text in messages, usually the path of a file.
    explicit JsonReader(std::string source);

    /// Throws InputError "not JSON: ..." with line and column.
    Json parse(const std::string& text) const;

    [[noreturn]] void fail(const std::string& path, const std::string& what) const;
    [[noreturn]] void
    wrong(const std::string& path, const Json& value, const std::string& right) const;

    /// Requires an object with no other keys than \a known.
    void object(const Json& value,
                const std::string& path,
                std::initializer_list<const char*> known) const;
    const Json& required(const Json& parent,
                         const std::string& path,
                         const char* key,
                         const std::string& right) const;
    /// Returns a finite number in [low, high].
    double number(const Json& value,
                  const std::string& path,
                  double low,
                  double high,
                  const std::string& right) const;
    int integer(const Json& value,
                const std::string& path,
                int low,
                int high,
                const std::string& right) const;
    std::string string(const Json& value, const std::string& path) const;
    const Json& list(const Json& value, const std::string& path, const std::string& right) const;

    /// Returns a list of \a size finite numbers, each within -limit .. limit.
    Eigen::VectorXd vector(const Json& value,
                           const std::string& path,
                           int size,
                           double limit,
                           const std::string& right) const;
    /// Returns a vector of three numbers that is not zero, normalised.
    Eigen::Vector3d direction(const Json& value, const std::string& path) const;

    static std::string at(const std::string& path, const char* key);
    static std::string at(const std::string& path, std::size_t index);

private:
    std::string _source;
};

} // namespace midair::base
