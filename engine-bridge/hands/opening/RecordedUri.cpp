#include "engine-bridge/hands/opening/RecordedUri.h"

namespace midair::bridge
{

namespace
{

const std::string kScheme = "recorded:";
const std::string kLoop = "?loop";

} // namespace

std::optional<RecordedUri> RecordedUri::parse(const std::string& uri)
{
    if (uri.compare(0, kScheme.size(), kScheme) != 0) return std::nullopt;
    RecordedUri recorded;
    recorded.file = uri.substr(kScheme.size());
    const std::size_t size = recorded.file.size();
    // A file may have the name "?loop".
    recorded.loops =
        size > kLoop.size() && recorded.file.compare(size - kLoop.size(), kLoop.size(), kLoop) == 0;
    if (recorded.loops) recorded.file.resize(size - kLoop.size());
    return recorded;
}

std::string RecordedUri::text() const
{
    return kScheme + file + (loops ? kLoop : "");
}

} // namespace midair::bridge
