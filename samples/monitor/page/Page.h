#pragma once

#include <string>

namespace midair::samples
{

/// Returns the operator's page (page.html), whose script and style have \a nonce.
std::string pageHtml(const std::string& nonce);

} // namespace midair::samples
