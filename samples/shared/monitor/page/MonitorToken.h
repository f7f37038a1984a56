#pragma once

#include <string>

namespace midair::samples
{

constexpr std::size_t kFewestTokenCharacters = 16;
constexpr std::size_t kMostTokenCharacters = 256;

/// Returns a token of 128 random bits, as 32 hexadecimal digits. Throws std::runtime_error if the
/// system has no random numbers.
std::string newToken();

/// Returns the token in the first line of \a path. A file that is missing is made, with a new token
/// and for its owner alone. Throws std::runtime_error that names the file if others may read it, or
/// if there is no token of 16 to 256 letters, digits, '-', '.', '_' or '~' in it.
std::string tokenOfFile(const std::string& path);

/// Compares in a time that depends on \a wanted's length alone, so that nobody finds the token
/// letter by letter.
bool isSameToken(const std::string& given, const std::string& wanted);

/// Returns who \a name, percent-encoded as a browser sends it, and \a peer are, in a line: "Anna
/// (192.168.1.7)". Of the name at most 40 bytes are taken, without control characters.
std::string operatorName(const std::string& name, const std::string& peer);

} // namespace midair::samples
