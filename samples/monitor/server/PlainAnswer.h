#pragma once

#include <string>

namespace midair::samples
{

/// Returns a whole HTTP answer of one line of text, for requests that don't come as far as
/// PageServer.
std::string plainAnswer(int status, const std::string& text);

} // namespace midair::samples
