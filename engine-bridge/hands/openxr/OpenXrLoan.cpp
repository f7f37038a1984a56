#include "engine-bridge/hands/openxr/OpenXrLoan.h"

#include "engine-bridge/hands/openxr/OpenXrSession.h"

namespace midair::bridge
{

OpenXrLoan::OpenXrLoan()
{
    const std::string why = OpenXrLending::one().take();
    if (!why.empty()) throw base::InputError("openxr: " + why);
}

OpenXrLoan::~OpenXrLoan()
{
    withdraw();
    OpenXrLending::one().give();
}

void OpenXrLoan::lend(const OpenXrHandles& handles, OpenXrSpace space)
{
    if (!handles.getInstanceProcAddr || !handles.instance || !handles.session)
        throw base::InputError("openxr: lend() needs xrGetInstanceProcAddr, the instance and the "
                               "session; one of them is null");
    withdraw();
    _session = std::make_shared<OpenXrSession>(
        handles, space, [](const std::string& text) { OpenXrLending::one().say(text); });
    OpenXrLending::one().lend(_session.get());
}

void OpenXrLoan::withdraw()
{
    OpenXrLending::one().lend(nullptr);
    _session.reset();
}

std::string OpenXrLoan::runtime() const
{
    return _session ? _session->runtime() : std::string();
}

void OpenXrLoan::setDisplayTime(std::int64_t time)
{
    OpenXrLending::one().use(
        [time](OpenXrSession& session)
        {
            HandFrame shown;
            session.setTime(time);
            session.locateAt(time, shown);
            OpenXrLending::one().show(shown);
        });
}

void OpenXrLoan::setRunning(bool isRunning)
{
    if (_session) _session->setRunning(isRunning);
}

void OpenXrLoan::tellRecentred()
{
    if (_session) _session->tellRecentred();
}

} // namespace midair::bridge
