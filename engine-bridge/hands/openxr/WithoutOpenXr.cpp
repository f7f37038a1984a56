// Replaces the other sources here in builds without OpenXR's headers: reports that hands are not
// available.

#include "engine-bridge/hands/openxr/OpenXrLoan.h"
#include "engine-bridge/hands/openxr/OpenXrTracker.h"
#include "engine-bridge/hands/openxr/OpenXrView.h"
#include "haptics/base/InputError.h"

namespace midair::bridge
{

namespace
{

const std::string kNotBuilt = "openxr: not in this build; configure it with -DMIDAIR_OPENXR=ON";

} // namespace

OpenXrLoan::OpenXrLoan()
{
    throw base::InputError(kNotBuilt);
}

OpenXrLoan::~OpenXrLoan() = default;

void OpenXrLoan::lend(const OpenXrHandles&, OpenXrSpace) {}

void OpenXrLoan::withdraw() {}

std::string OpenXrLoan::runtime() const
{
    return {};
}

void OpenXrLoan::setDisplayTime(std::int64_t) {}

void OpenXrLoan::setRunning(bool) {}

void OpenXrLoan::tellRecentred() {}

class OpenXrView::Inside
{
};

OpenXrView::OpenXrView(const OpenXrOptions&, const Eigen::Isometry3d&)
{
    throw base::InputError(kNotBuilt);
}

OpenXrView::~OpenXrView() = default;

void OpenXrView::begin(const OpenXrGraphics&) {}

void OpenXrView::end() {}

bool OpenXrView::hasSession() const
{
    return false;
}

bool OpenXrView::wait()
{
    return false;
}

bool OpenXrView::mayReturn() const
{
    return false;
}

std::optional<double> OpenXrView::displayTime() const
{
    return {};
}

bool OpenXrView::locate(OpenXrEyes&)
{
    return false;
}

void OpenXrView::beginFrame() {}

std::uint32_t OpenXrView::picture(int)
{
    return 0;
}

std::uint32_t OpenXrView::depth(int)
{
    return 0;
}

void OpenXrView::endFrame(double, double) {}

int OpenXrView::width(int) const
{
    return 0;
}

int OpenXrView::height(int) const
{
    return 0;
}

int OpenXrView::depthFormat() const
{
    return 0;
}

OpenXrBlend OpenXrView::blend() const
{
    return OpenXrBlend::OPAQUE;
}

bool OpenXrView::takeMute()
{
    return false;
}

std::string OpenXrView::runtime() const
{
    return {};
}

std::string OpenXrView::status() const
{
    return kNotBuilt;
}

std::vector<std::string> OpenXrView::messages(std::size_t&) const
{
    return {};
}

bool operator==(const OpenXrOptions& a, const OpenXrOptions& b)
{
    return a.loader == b.loader && a.space == b.space && a.retry_s == b.retry_s;
}

std::shared_ptr<OpenXrTracker> OpenXrTracker::open(const OpenXrOptions& options)
{
    return std::make_shared<OpenXrTracker>(options);
}

OpenXrTracker::OpenXrTracker(const OpenXrOptions& options) : _options(options)
{
    _condition = kNotBuilt;
    _messages.say({base::MessageCode::HANDS_SOURCE, _condition});
}

OpenXrTracker::~OpenXrTracker() = default;

std::shared_ptr<OpenXrAsker> OpenXrTracker::newAsker(bool forHead)
{
    return std::make_shared<OpenXrAsker>(forHead);
}

bool OpenXrTracker::latest(OpenXrAsker&, HandFrame&)
{
    return false;
}

bool OpenXrTracker::latestHead(OpenXrAsker&, Head&)
{
    return false;
}

void OpenXrTracker::setHorizon(OpenXrAsker&, double) {}

std::vector<std::string> OpenXrTracker::messages(std::size_t& told) const
{
    return _messages.newTexts(told);
}

std::string OpenXrTracker::status() const
{
    return _condition;
}

} // namespace midair::bridge
