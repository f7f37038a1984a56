// In the place of the other sources here where OpenXR's headers weren't found: says so to whoever
// asks for hands.

#include "engine-bridge/hands/openxr/OpenXrTracker.h"

namespace midair::bridge
{

bool operator==(const OpenXrOptions& a, const OpenXrOptions& b)
{
    return a.loader == b.loader && a.space == b.space && a.retry_s == b.retry_s;
}

std::shared_ptr<OpenXrTracker> OpenXrTracker::open(const OpenXrOptions& options)
{
    return std::make_shared<OpenXrTracker>(options);
}

OpenXrTracker::OpenXrTracker(const OpenXrOptions& options) : _options(options), _asked()
{
    _condition = "openxr: not in this build; configure it with -DMIDAIR_OPENXR=ON";
    _messages.say({base::MessageCode::HANDS_SOURCE, _condition});
}

OpenXrTracker::~OpenXrTracker() = default;

bool OpenXrTracker::latest(HandFrame&)
{
    return false;
}

bool OpenXrTracker::latestHead(Head&)
{
    return false;
}

void OpenXrTracker::setHorizon(double) {}

void OpenXrTracker::setHeadHorizon(double) {}

std::vector<std::string> OpenXrTracker::messages(std::size_t& told) const
{
    return _messages.newTexts(told);
}

std::string OpenXrTracker::status() const
{
    return _condition;
}

} // namespace midair::bridge
