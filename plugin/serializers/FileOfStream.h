#pragma once

#include <istream>
#include <string>

namespace osgMidair
{

/// Returns the first \a size bytes of \a stream's buffer, and leaves it where it is; empty if it
/// can't be read again.
std::string beginning(std::istream& stream, std::size_t size);
/// The same for all that it holds.
std::string wholeText(std::istream& stream);

/// Returns the name of the file in \a folder that is being read and has the content \a text, by
/// which OSG's readers don't tell serializers; empty if there is none.
std::string openFile(const std::string& folder, const std::string& text);

} // namespace osgMidair
