#include "engine-bridge/hands/openxr/OpenXrLoan.h"
#include "haptics/base/InputError.h"

#include <osgMidair/XrSession>

#include <utility>

namespace osgMidair
{

class XrSession::Inside : public midair::bridge::OpenXrLoan
{
};

XrSession::XrSession(std::unique_ptr<Inside> inside) : _inside(std::move(inside)) {}

XrSession::~XrSession() = default;

osg::ref_ptr<XrSession> XrSession::open(std::string& error)
{
    try
    {
        return new XrSession(std::make_unique<Inside>());
    }
    catch (const midair::base::InputError& wrong)
    {
        error = wrong.what();
    }
    return nullptr;
}

bool XrSession::lend(const Handles& handles, std::string& error)
{
    try
    {
        _inside->lend(
            {handles.getInstanceProcAddr, handles.instance, handles.session, handles.space},
            midair::bridge::OpenXrSpace::BEST);
        return true;
    }
    catch (const midair::base::InputError& wrong)
    {
        error = wrong.what();
    }
    return false;
}

void XrSession::withdraw()
{
    _inside->withdraw();
}

void XrSession::setDisplayTime(std::int64_t time)
{
    _inside->setDisplayTime(time);
}

void XrSession::setRunning(bool isRunning)
{
    _inside->setRunning(isRunning);
}

void XrSession::recentre()
{
    _inside->tellRecentred();
}

std::string XrSession::getRecentred()
{
    return midair::bridge::OpenXrLending::one().recentred();
}

std::string XrSession::getStatus() const
{
    return _inside->isLent() ? "openxr: " + _inside->runtime() + ", in the program's session"
                             : "openxr: waiting for the program's session";
}

} // namespace osgMidair
