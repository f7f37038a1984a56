#pragma once

#include <cstddef>
#include <string>

namespace midair::base
{

/// Returns the line, from 1, of the value at \a path (as in JsonError) of a JSON text: that of its
/// key, or where an element of a list begins. 1 if there is none.
std::size_t jsonLine(const std::string& text, const std::string& path);

/// Throws InputError, with the line, for a JSON text that nests deeper than \a mostDepth, or has a
/// key twice in an object. Texts that aren't JSON pass: parseJson() names what is wrong.
void requirePlainJson(const std::string& text, const std::string& source, std::size_t mostDepth);

} // namespace midair::base
