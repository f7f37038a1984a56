#pragma once

#include <string>

namespace midair::base
{

/// Returns \a text, which may come from a file or another program, for printing: control
/// characters, which a terminal would obey, and characters that hide text or turn its direction are
/// replaced, and it is cut after 300 bytes.
std::string printable(const std::string& text);

} // namespace midair::base
